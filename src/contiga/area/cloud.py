"""Contact area of a cloud without facets."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple

import numpy as np

from contiga.area.cluster import is_positive
from contiga.area.facet import measure_facets
from contiga.area.feet import Web, unbridged, web_of
from contiga.area.method import AreaInput, Areas, Outlines, Rest, check_side, no_patch
from contiga.area.outline import facet_outlines, no_outlines
from contiga.area.profile import profile_depth
from contiga.area.regions import Graph, Topology, neighbours_of, regions, topology_of
from contiga.arrays.ordered import principal_axes, product
from contiga.errors import InputError
from contiga.masters.protocol import Master
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.slaves.skin import tributary_area

# Triangles with a side longer than this many times the local spacing bridge a gap of the cloud.
BRIDGE = 3.0
# Share of the spread across the best-fit plane below which points count as lying on a line.
LINE = 1e-9


class Prepared(NamedTuple):
    """Triangles between the points of a cloud at rest, and its neighbours."""

    topology: Topology | None
    """None by "feet" and on a line."""
    graph: Graph
    line: bool


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
    points between them, of which each lacks some; a region that bends by more than 60° from its
    mean normal and lies on several patches lacks the strips between those. Nothing reaches beyond
    the outermost points, where a Voronoi cell would reach on without end. Points on a line belong
    to a plane problem: on a body made by `Body.from_profile` each stands for half the way to its
    neighbours in contact, times the depth.

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
    bridge: float = BRIDGE
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
        """The triangles of the cloud at rest."""
        if len(rest.points) < 2:
            raise InputError(
                "one point has no area of its own",
                where="area",
                allowed="two points or more",
                remedy="Use NodalArea(value)",
            )
        graph, line = neighbours_of(rest.points), is_line(rest.points)
        if line and rest.body is not None:
            _depth_of(rest.body)
        if not line and self.by == "feet" and rest.body is not None and rest.body.faces is None:
            raise no_patch()
        if line or self.by == "feet":
            return Prepared(None, graph, line)
        facets = triangles_of(rest.points, self.bridge)
        return Prepared(topology_of(facets, len(rest.points)), graph, line)

    def weights(self, rest: Rest, prepared: Prepared) -> FloatArray | None:
        """Return areas at rest (n,), or None if the slave has none.

        A corner gets a third of each of its triangles, a point of a line half the way to each
        neighbour. Areas by feet are not known at rest.
        """
        topology, graph, line = prepared
        if rest.area is not None:
            return None
        if topology is not None:
            return tributary_area(rest.points, topology.facets)
        if not line or rest.body is None:
            return None
        rows = np.arange(len(rest.points))
        return _along_line(rest.points, rows, graph, _depth_of(rest.body))

    def measure(self, inp: AreaInput) -> Areas:
        """Areas of the points in contact."""
        topology, graph, line = inp.prepared
        on = self.on or inp.on
        if len(inp.rows) == 0:
            return Areas(np.zeros(0), np.zeros(0, np.int32), on)
        if topology is not None:
            return measure_facets(inp, topology, on)
        if not line:
            web = self._web(inp, graph)
            return measure_facets(web.inp, web.topology, on)._replace(clusters=web.clusters)
        clusters = regions(graph, inp.rows, inp.points)
        area = _along_line(inp.points, inp.rows, graph, _depth_of(inp.body))
        return Areas(area, clusters, "slave")

    def outlines(self, inp: AreaInput) -> Outlines:
        """Return where contact ends, as for `FacetArea`; none for points on a line."""
        topology, graph, line = inp.prepared
        if line or len(inp.rows) == 0:
            return no_outlines()
        if topology is not None:
            return facet_outlines(inp, topology, self.on or inp.on)
        web = self._web(inp, graph)
        return facet_outlines(web.inp, web.topology, self.on or inp.on)

    def _web(self, inp: AreaInput, graph: Graph) -> Web:
        kept = {} if inp.kept is None else inp.kept
        if "web" not in kept:
            kept["web"] = web_of(inp, graph, self.bridge)
        web: Web = kept["web"]
        return web


def is_line(points: FloatArray) -> bool:
    """Return whether points (n, 3) lie on a line, or are fewer than three."""
    spread = principal_axes(points - points.mean(axis=0))[0]
    return len(points) < 3 or bool(spread[1] <= LINE * spread[0])


def triangles_of(points: FloatArray, bridge: float) -> IntArray:
    """Return (m, 3) Delaunay triangles of a cloud (n, 3), no line, in its best-fit plane.

    Raises
    ------
    InputError
        Points over one another, seen along the plane's normal.
    """
    from scipy.spatial import Delaunay

    centred = points - points.mean(axis=0)
    axes = principal_axes(centred)[1]
    chart = product(centred, axes[:2].T)
    triangles = Delaunay(chart).simplices.astype(np.int32)
    kept = unbridged(points, triangles, bridge)
    # A cloud seen edge-on or in several sheets makes triangles far longer than its spacing.
    if len(kept) < 0.5 * len(triangles) or 2 * len(np.unique(kept)) < len(points):
        raise InputError(
            "the cloud is not a graph over its best-fit plane",
            where="area",
            found=f"{len(triangles) - len(kept)} of {len(triangles)} triangles bridge its points",
            allowed="a sheet of points",
            remedy='Use CloudArea(by="feet"), NodalArea(value) or HullArea(), or give facets',
        )
    # In the order of their points, as facets of a mesh come: neighbours lie close in memory.
    ordered: IntArray = kept[np.argsort(kept.min(axis=1), kind="stable")]
    return ordered


def _depth_of(body: Master) -> float:
    """Return the width that points on a line stand for."""
    depth = profile_depth(body.faces)
    if depth is None:
        raise InputError(
            "the points lie on a line, the master is no profile",
            where="area",
            allowed="a sheet of points, or a master by Body.from_profile",
            remedy="Use NodalArea(value)",
        )
    return depth


def _along_line(points: FloatArray, rows: IndexArray, graph: Graph, depth: float) -> FloatArray:
    """Half the way from each of `rows` to its neighbours along the line, times the depth."""
    area = np.zeros(len(rows))
    for i, row in enumerate(rows):
        near = graph.neighbour[graph.first[row] : graph.first[row + 1]]
        step = points[near] - points[row]
        way = np.linalg.norm(step, axis=1)
        forward = product(step, step[np.argmin(way)]) > 0.0
        for side in (forward, ~forward):
            if side.any():
                area[i] += 0.5 * depth * way[side].min()
    return area
