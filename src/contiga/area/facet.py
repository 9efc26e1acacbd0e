"""Contact area by cutting the slave's facets where contact ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contiga.area.cuts import Parts, cut_parts, parts_of
from contiga.area.kernels import components_nb, facet_area_nb, image_nb, touch_nb
from contiga.area.method import AreaInput, Areas, Outlines, Rest, check_side
from contiga.area.outline import facet_outlines
from contiga.area.regions import Topology, topology_of
from contiga.arrays.threads import run_ranges, started
from contiga.errors import InputError
from contiga.records import FloatArray, stacked

# Numbers of facets, and of cut facets on the master, below which a second thread does not pay.
MIN_FACETS = 4096
MIN_PIECES = 1024


@dataclass(frozen=True)
class FacetArea:
    """Contact area as the part of every facet in contact, shared among its corners.

    A facet with corners in contact and corners that are not is cut where the signed gap, linear
    on the facet, is zero (marching triangles). The gap of a corner that is not in contact is the
    distance to the foot continued from its nearest neighbour in contact, so that it belongs to
    the same sheet of the surface. Where the foot leaves the surface over a border, the cut is
    there. The error is of second order in the size of the facets; holes and hollows of the region
    are resolved.

    Parameters
    ----------
    on : "slave": the area of the facets' parts in their present position. "master": the area of
        their images on the master, the feet of all their points. If omitted, the contact type
        decides: the master's for type "master", else the slave's.

    Raises
    ------
    InputError
        A side that is not known; at a contact, a slave without facets.

    Notes
    -----
    A node receives the integral of its linear shape function over the parts; nodes out of contact
    hand theirs to the other corners of the facet. The areas add up to that of the region.
    Clusters are the nodes in contact that facets join. The image on the master is measured in
    space, from the feet and their normals: seams, borders of patches and poles have no effect.
    Where normals at two corners are more than a right angle apart, the image is torn, and the plane
    triangle of the feet is measured. If a corner lies inside without being in contact (one that
    began inside, in a search by intersection), its edges are cut in the middle.

    Examples
    --------
    The part of a sheet below a plane that cuts through its facets:

    >>> import contiga as cg
    >>> corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]]
    >>> sheet = cg.Slave(corners, [[0, 1, 2, 3]])
    >>> plane = cg.Body([cg.shapes.plane(width=9.0, length=9.0)])
    >>> contact = cg.Contact(plane, sheet, law=cg.PenaltyLaw(1.0), area=cg.FacetArea(on="master"))
    >>> state = contact.start(sheet.points + [0.0, 0.0, 1.0])
    >>> round(contact.step(state, sheet.points - [0.0, 0.0, 0.25]).total_area, 12)
    0.25
    """

    on: str | None = None

    def __post_init__(self) -> None:
        check_side(self.on)

    def prepare(self, rest: Rest) -> Topology:
        """Return the facets at each point; raise `InputError` for a slave without facets."""
        if rest.facets is None or len(rest.facets) == 0:
            raise InputError(
                "the slave has no facets to measure",
                where="area",
                allowed="a slave with facets",
                remedy="Use CloudArea(), NodalArea(value) or HullArea() for a cloud",
            )
        return topology_of(rest.facets, len(rest.points))

    def measure(self, inp: AreaInput) -> Areas:
        """Return the areas of the points in contact, by the parts of their facets in contact."""
        return measure_facets(inp, inp.prepared, self.on or inp.on)

    def outlines(self, inp: AreaInput) -> Outlines:
        """Return where contact ends, on the side that is measured."""
        return facet_outlines(inp, inp.prepared, self.on or inp.on)


def measure_facets(inp: AreaInput, topology: Topology, on: str) -> Areas:
    """Return nodal areas on the slave or the master, `on`, from the facets of `topology`.

    Their regions are joined over facets. Cuts are left in the cache `inp.kept`, for outlines. The
    image on a master of triangles is measured by the plane triangles between the feet.
    """
    n_c = len(inp.rows)
    if n_c == 0:
        return Areas(np.zeros(0), np.zeros(0, np.int32), on)
    place = np.full(len(inp.points), -1, np.int32)
    # Work for one thread is started, and runs while other work is split among all threads.
    whole, part = started(touch_nb.touched, n_c, MIN_FACETS, topology, inp.rows, place)()
    m = len(whole)
    part_corners = place[topology.facets[part]]
    get_clusters = started(components_nb.facet_components, m, MIN_FACETS, whole, part_corners, n_c)
    get_parts = started(parts_of, m, MIN_FACETS, inp, topology, part, place)
    share, feet = np.empty((m, 3)), inp.feet
    if on == "slave":
        args = (inp.rows, inp.points, whole, share)
        run_ranges(facet_area_nb.slave_whole, m, MIN_FACETS, *args)
    elif inp.body.faces is not None:
        run_ranges(image_nb.image_whole, m, MIN_FACETS, whole, feet.point, feet.normal, share)
    else:
        args = (np.arange(n_c, dtype=np.int32), feet.point, whole, share)
        run_ranges(facet_area_nb.slave_whole, m, MIN_FACETS, *args)
    area = np.zeros(n_c)
    wait_for_area = started(facet_area_nb.gather, m, MIN_FACETS, whole, share, area)
    parts = get_parts()
    areas = _cut_facet_areas(inp, parts, on)
    wait_for_area()
    area[parts.inner] += areas
    return Areas(area, get_clusters(), on)


def _cut_facet_areas(inp: AreaInput, parts: Parts, on: str) -> FloatArray:
    """Return areas (i,) in contact of the facets that touch in part, at their inner corners.

    The cuts are left in the cache: `inp.kept["parts"]`.
    """
    nodes, corner = parts.nodes, parts.corner
    n_i, m = len(parts.inner), len(nodes)
    areas = np.zeros(n_i)
    if m == 0:
        return areas
    cut = cut_parts(inp, parts)
    if inp.kept is not None:
        inp.kept["parts"] = parts, cut
    share = np.empty((m, 3))
    if on == "slave":
        args = (nodes, inp.points, corner, n_i, cut.fraction, share)
        run_ranges(facet_area_nb.slave_pieces, m, MIN_FACETS, *args)
    elif inp.body.faces is None:
        args = (corner, cut.feet.point, corner, n_i, cut.fraction, share)
        run_ranges(facet_area_nb.slave_pieces, m, MIN_FACETS, *args)
    else:
        feet = stacked(cut.feet, cut.ends)
        border = np.where(cut.border < 0, -1, cut.border + len(cut.feet.patch))
        image_args = (corner, feet, n_i, border, cut.fraction, share)
        run_ranges(image_nb.image_pieces, m, MIN_PIECES, *image_args)
    facet_area_nb.gather(corner, share, areas)
    return areas
