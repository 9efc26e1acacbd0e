"""Contact area of a cloud without facets."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple

import numpy as np

from contiga.area.cluster import is_positive
from contiga.area.facet import measure_facets
from contiga.area.feet import Web, web_of, without_bridges
from contiga.area.method import AreaInput, Areas, Outlines, Rest, check_side, no_patch
from contiga.area.outline import facet_outlines, no_outlines
from contiga.area.profile import profile_depth
from contiga.area.regions import Graph, Topology, neighbours_of, regions, topology_of
from contiga.arrays.ordered import principal_axes, product
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.slaves.skin import tributary_area

# Triangles with a side longer than this many local spacings bridge a gap of the cloud.
DEFAULT_BRIDGE = 3.0
# Share of the spread across the best-fit plane below which points count as lying on a line.
LINE_TOL = 1e-9


class Prepared(NamedTuple):
    """The triangles between the points of a cloud at rest, and the neighbours of each point."""

    topology: Topology | None
    """None by "feet" and on a line."""
    graph: Graph
    is_line: bool


@dataclass(frozen=True)
class CloudArea:
    """Area of a cloud by Delaunay triangles between its points, the dual of the Voronoi diagram.

    The triangles are cut where contact ends, as `FacetArea` does with the facets of a mesh: of
    second order in the spacing.

    Parameters
    ----------
    by : "rest": triangles of the rest positions in their best-fit plane, made once. "feet":
        triangles of the feet on the master, of the points in contact and those next to them,
        made anew at every step in a chart of each region; for clouds that are no sheet at rest
    on : as for `FacetArea`
    bridge : triangles with a side longer than `bridge` times the local spacing (the distance to
        the third neighbour) are left out: they span gaps and hollows of the cloud

    Raises
    ------
    InputError
        A `bridge` that is not above 1, an unknown `by` or `on`; at a contact, fewer than two
        points, or by "rest" a cloud that the best-fit plane does not show from one side only.

    Notes
    -----
    Limits by "rest": the cloud at rest must be a graph over its best-fit plane, which a sheet is
    and a closed tube is not. By "feet": two regions fewer than three spacings apart share the
    points between them, so that each lacks some; a region that bends by more than 60° from its
    mean normal and lies on several patches lacks the strips between them. No area reaches beyond
    the outermost points, where Voronoi cells are unbounded. Points on a line belong to a plane
    problem: on a body made by `Body.from_profile` the area of each is half the distance to the
    nearest point on each side, times the depth.

    Examples
    --------
    >>> import contiga as cg
    >>> plane = cg.Body([cg.shapes.plane(width=10.0, length=10.0)])
    >>> cloud = cg.Slave(cg.clouds.sample(cg.shapes.plane(width=2.0, length=1.0), 9, 5))
    >>> contact = cg.Contact(plane, cloud, law=cg.PenaltyLaw(1.0), area=cg.CloudArea())
    >>> state = contact.start(cloud.points + [0.0, 0.0, 1.0])
    >>> round(contact.step(state, cloud.points - [0.0, 0.0, 0.5]).total_area, 9)
    2.0
    """

    on: str | None = None
    _: KW_ONLY
    bridge: float = DEFAULT_BRIDGE
    by: str = "rest"

    def __post_init__(self) -> None:
        if self.by not in ("rest", "feet"):
            raise InputError(
                "unknown positions to take the triangles of",
                where="by",
                found=self.by,
                allowed='"rest", "feet"',
            )
        check_side(self.on)
        if not (is_positive(self.bridge) and self.bridge > 1.0):
            raise InputError(
                "bridge must be above 1", where="bridge", found=self.bridge, allowed="> 1"
            )

    def prepare(self, rest: Rest) -> Prepared:
        """Return the cloud's triangles at rest, None on a line and by "feet", and its neighbours.

        The master is checked only if `rest` has one.

        Raises
        ------
        InputError
            Fewer than two points, a line without a profile as master, a master without patches by
            "feet", and what `triangles_of` refuses.
        """
        if len(rest.points) < 2:
            raise InputError(
                "one point has no area of its own",
                where="area",
                allowed="two points or more",
                remedy="Use NodalArea(value)",
            )
        graph, on_line = neighbours_of(rest.points), is_line(rest.points)
        if rest.body is not None:
            if on_line:
                _profile_depth(rest.body)
            elif self.by == "feet" and rest.body.faces is None:
                raise no_patch()
        if on_line or self.by == "feet":
            return Prepared(None, graph, on_line)
        facets = triangles_of(rest.points, self.bridge)
        return Prepared(topology_of(facets, len(rest.points)), graph, on_line)

    def weights(self, rest: Rest, prepared: Prepared) -> FloatArray | None:
        """Return areas at rest (n,), or None if there are none or the slave has areas of its own.

        A corner gets a third of each of its triangles, a point of a line half the distance to its
        nearest neighbour on each side, times the depth of the profile. There are none by "feet" for
        points that are not on a line, and on a line without a master.
        """
        topology, graph, on_line = prepared
        if rest.area is not None:
            return None
        if topology is not None:
            return tributary_area(rest.points, topology.facets)
        if not on_line or rest.body is None:
            return None
        rows = np.arange(len(rest.points))
        return _line_areas(rest.points, rows, graph, _profile_depth(rest.body))

    def measure(self, inp: AreaInput) -> Areas:
        """Return the areas of the points in contact; on a line they are measured on the slave.

        Regions are joined over facets, or over neighbours by "feet" and on a line.
        """
        topology, graph, on_line = inp.prepared
        on = self.on or inp.on
        if len(inp.rows) == 0:
            return Areas(np.zeros(0), np.zeros(0, np.int32), on)
        if topology is not None:
            return measure_facets(inp, topology, on)
        if not on_line:
            web = self._web(inp, graph)
            return measure_facets(web.inp, web.topology, on)._replace(clusters=web.clusters)
        clusters = regions(graph, inp.rows, inp.points)
        area = _line_areas(inp.points, inp.rows, graph, _profile_depth(inp.body))
        return Areas(area, clusters, "slave")

    def outlines(self, inp: AreaInput) -> Outlines:
        """Return where contact ends, as for `FacetArea`; none for points on a line."""
        topology, graph, on_line = inp.prepared
        if on_line or len(inp.rows) == 0:
            return no_outlines()
        if topology is not None:
            return facet_outlines(inp, topology, self.on or inp.on)
        web = self._web(inp, graph)
        return facet_outlines(web.inp, web.topology, self.on or inp.on)

    def _web(self, inp: AreaInput, graph: Graph) -> Web:
        """Return the triangles between feet, from the cache of `inp` if it has one."""
        cache = {} if inp.kept is None else inp.kept
        if "web" not in cache:
            cache["web"] = web_of(inp, graph, self.bridge)
        web: Web = cache["web"]
        return web


def is_line(points: FloatArray) -> bool:
    """Return whether points (n, 3) lie on a line, by `LINE_TOL`, or are fewer than three."""
    spread = principal_axes(points - points.mean(axis=0))[0]
    return len(points) < 3 or bool(spread[1] <= LINE_TOL * spread[0])


def triangles_of(points: FloatArray, bridge: float) -> IntArray:
    """Return (m, 3) Delaunay triangles of a cloud (n, 3), not a line, in its best-fit plane.

    Triangles that bridge gaps are left out; the others are sorted by their least point.

    Raises
    ------
    InputError
        Points hide one another, seen along the plane's normal: more than half of the triangles
        bridge gaps, or more than half of the points are left without one.
    """
    from scipy.spatial import Delaunay

    centred = points - points.mean(axis=0)
    axes = principal_axes(centred)[1]
    chart = product(centred, axes[:2].T)
    triangles = Delaunay(chart).simplices.astype(np.int32)
    short = without_bridges(points, triangles, bridge)
    # A cloud seen edge-on or in several sheets makes triangles far longer than its spacing.
    if len(short) < 0.5 * len(triangles) or 2 * len(np.unique(short)) < len(points):
        raise InputError(
            "the cloud is not a graph over its best-fit plane",
            where="area",
            found=f"{len(triangles) - len(short)} of {len(triangles)} triangles bridge its points",
            allowed="a sheet of points",
            remedy='Use CloudArea(by="feet"), NodalArea(value) or HullArea(), or give facets',
        )
    # In the order of their points, as the facets of a mesh: neighbours lie close in memory.
    ordered: IntArray = short[np.argsort(short.min(axis=1), kind="stable")]
    return ordered


def _profile_depth(body: Master) -> float:
    """Return the depth of a profile; raise `InputError` for another master."""
    depth = profile_depth(body.faces)
    if depth is None:
        raise InputError(
            "the points lie on a line, the master is no profile",
            where="area",
            allowed="a sheet of points, or a master by Body.from_profile",
            remedy="Use NodalArea(value)",
        )
    return depth


def _line_areas(points: FloatArray, rows: IndexArray, graph: Graph, depth: float) -> FloatArray:
    """Return areas (k,) of `rows` (k,): half the distances to neighbours on a line times `depth`.

    The nearest neighbour on each side counts, in contact or not; a side without any adds nothing.
    """
    area = np.zeros(len(rows))
    for i, row in enumerate(rows):
        neighbours = graph.neighbour[graph.first[row] : graph.first[row + 1]]
        arm = points[neighbours] - points[row]
        distance = np.linalg.norm(arm, axis=1)
        is_ahead = product(arm, arm[np.argmin(distance)]) > 0.0
        for on_side in (is_ahead, ~is_ahead):
            if on_side.any():
                area[i] += 0.5 * depth * distance[on_side].min()
    return area
