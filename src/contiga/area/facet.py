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
from contiga.records import FloatArray, IntArray, stacked

# Facets, and cut facets on the master, below which a second thread does not pay.
FACETS = 4096
PIECES = 1024


@dataclass(frozen=True)
class FacetArea:
    """Contact area as the part of every facet in contact, shared among its corners.

    A facet with corners in contact and corners that are not is cut where the signed gap, linear
    on the facet, is zero (marching triangles). The gap of a corner that is not in contact is the
    distance to the foot continued from its nearest neighbour in contact, so that it belongs to
    the same sheet of the surface. Where the foot leaves the surface over a border, the cut is
    there. The error is of second order in the size of the facets; holes and hollows of the region
    are found as they are.

    Parameters
    ----------
    on : "slave": the area of the facets' parts as they lie now. "master": the area of their images
        on the master, the feet of all their points. What the contact type asks for if omitted:
        the master's for type "master", else the slave's.

    Raises
    ------
    InputError
        A side that is not known; at a contact, a slave without facets.

    Notes
    -----
    A node is given the integral of its linear shape function over the parts; nodes out of contact
    hand theirs to the other corners of the facet. The areas add up to that of the region.
    Clusters are the nodes in contact that facets join. The image on the master is measured in
    space, from the feet and their normals: seams, borders of patches and poles do not show. Where
    normals at two corners are more than a right angle apart it is torn, and the plane triangle of
    the feet is measured. A slave's corner that lies inside without being in contact (one that
    began inside, in a search by intersection) leaves each end of an edge its half.

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
        """The facets that meet at each point."""
        if rest.facets is None or len(rest.facets) == 0:
            raise InputError(
                "the slave has no facets to measure",
                where="area",
                allowed="a slave with facets",
                remedy="Use CloudArea(), NodalArea(value) or HullArea() for a cloud",
            )
        return topology_of(rest.facets, len(rest.points))

    def measure(self, inp: AreaInput) -> Areas:
        """Areas of the points in contact, by the parts of their facets."""
        return measure_facets(inp, inp.prepared, self.on or inp.on)

    def outlines(self, inp: AreaInput) -> Outlines:
        """Return where contact ends, on the side that is measured."""
        return facet_outlines(inp, inp.prepared, self.on or inp.on)


def measure_facets(inp: AreaInput, topology: Topology, on: str) -> Areas:
    """Nodal areas on the slave or the master from the facets of `topology`."""
    n_c = len(inp.rows)
    if n_c == 0:
        return Areas(np.zeros(0), np.zeros(0, np.int32), on)
    place = np.full(len(inp.points), -1, np.int32)
    # What one thread does goes on beside what is cut into ranges for all of them.
    touched = started(touch_nb.touched, n_c, FACETS, topology, inp.rows, place)
    whole, part = touched()
    clusters = started(
        components_nb.facet_components,
        len(whole),
        FACETS,
        whole,
        place[topology.facets[part]],
        n_c,
    )
    numbered = started(parts_of, len(whole), FACETS, inp, topology, part, place)
    share = _whole_shares(inp, whole, on)
    area = np.zeros(n_c)
    gathered = started(facet_area_nb.gather, len(whole), FACETS, whole, share, area)
    parts = numbered()
    areas = _part_areas(inp, parts, on)
    gathered()
    area[parts.inner] += areas
    return Areas(area, clusters(), on)


def _whole_shares(inp: AreaInput, corner: IntArray, on: str) -> FloatArray:
    """Return (m, 3) areas of facets whose corners (m, 3) are all in contact, split to those."""
    share = np.empty((len(corner), 3))
    if on == "slave":
        slave = (inp.rows, inp.points, corner, share)
        run_ranges(facet_area_nb.slave_whole, len(corner), FACETS, *slave)
    elif inp.body.faces is not None:
        feet = (inp.feet.point, inp.feet.normal)
        run_ranges(image_nb.image_whole, len(corner), FACETS, corner, *feet, share)
    else:
        # The image on triangles is measured by the plane triangles between the feet.
        flat = (np.arange(len(inp.rows), dtype=np.int32), inp.feet.point, corner, share)
        run_ranges(facet_area_nb.slave_whole, len(corner), FACETS, *flat)
    return share


def _part_areas(inp: AreaInput, parts: Parts, on: str) -> FloatArray:
    """Return areas (i,) of the parts of facets that contact cuts, at their inner corners."""
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
        slave = (nodes, inp.points, corner, n_i, cut.fraction, share)
        run_ranges(facet_area_nb.slave_pieces, m, FACETS, *slave)
    elif inp.body.faces is None:
        images = (corner, cut.feet.point, corner, n_i, cut.fraction, share)
        run_ranges(facet_area_nb.slave_pieces, m, FACETS, *images)
    else:
        feet = stacked(cut.feet, cut.ends)
        border = np.where(cut.border < 0, -1, cut.border + len(cut.feet.patch))
        master = (corner, feet, n_i, border, cut.fraction, share)
        run_ranges(image_nb.image_pieces, m, PIECES, *master)
    facet_area_nb.gather(corner, share, areas)
    return areas
