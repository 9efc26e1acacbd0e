"""Contact area of a cloud without facets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contiga.area.base import AreaInput, Areas, Outlines, Rest
from contiga.area.facet import measure_facets
from contiga.area.outline import facet_outlines, no_outlines
from contiga.area.profile import profile_depth
from contiga.area.regions import Graph, Topology, neighbours_of, regions, topology_of
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray

# Triangles with a side longer than this many times the local spacing bridge a gap of the cloud.
BRIDGE = 3.0
# Share of the spread across the best-fit plane below which points count as lying on a line.
LINE = 1e-9


class Prepared(NamedTuple):
    """Triangles between the points of a cloud at rest, or its neighbours where it is a line."""

    topology: Topology | None
    graph: Graph


@dataclass(frozen=True)
class CloudArea:
    """Area of a cloud by the Delaunay triangles of its rest positions in the best-fit plane.

    The triangles (the dual of the Voronoi diagram) are made once and then cut where contact ends,
    as `FacetArea` does with the facets of a mesh: of second order in the spacing.

    Parameters
    ----------
    on : as for `FacetArea`
    bridge : triangles with a side longer than `bridge` times the local spacing (the distance to
        the third neighbour) are left out: they span gaps and hollows of the cloud

    Raises
    ------
    InputError
        A `bridge` that is not above 1; at a contact, fewer than two points, or a cloud that the
        best-fit plane does not show from one side only.

    Notes
    -----
    Limits: the cloud at rest must be a graph over its best-fit plane, which a sheet is and a
    closed tube is not. Nothing reaches beyond the outermost points, where a Voronoi cell would
    reach on without end. Points on a line belong to a plane problem: on a body made by
    `Body.from_profile` each stands for half the way to its neighbours in contact, times the depth.
    """

    on: str | None = None
    bridge: float = BRIDGE

    def __post_init__(self) -> None:
        if self.on not in (None, "slave", "master"):
            raise InputError(
                "unknown side to measure the area on",
                where="on",
                found=self.on,
                allowed='"slave", "master", or None',
            )
        if not (np.isfinite(self.bridge) and self.bridge > 1.0):
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
        facets = triangles_of(rest.points, self.bridge)
        topology = None if facets is None else topology_of(facets, len(rest.points))
        return Prepared(topology, neighbours_of(rest.points))

    def measure(self, inp: AreaInput) -> Areas:
        """Areas of the points in contact."""
        topology, graph = inp.prepared
        if topology is not None:
            return measure_facets(inp, topology, self.on or inp.on)
        clusters = regions(graph, inp.rows, inp.points)
        depth = profile_depth(inp.body)
        if depth is None:
            raise InputError(
                "the points lie on a line, the master is no profile",
                where="area",
                allowed="a sheet of points, or a master by Body.from_profile",
            )
        return Areas(_along_line(inp, graph, depth), clusters, "slave")

    def outlines(self, inp: AreaInput) -> Outlines:
        """Where contact ends, as for `FacetArea`; none for points on a line."""
        topology = inp.prepared.topology
        return (
            no_outlines() if topology is None else facet_outlines(inp, topology, self.on or inp.on)
        )


def triangles_of(points: FloatArray, bridge: float = BRIDGE) -> IntArray | None:
    """(m, 3) Delaunay triangles of a cloud (n, 3) in its best-fit plane; None for a line.

    Raises
    ------
    InputError
        Points over one another, seen along the plane's normal.
    """
    from scipy.spatial import Delaunay, cKDTree

    centred = points - points.mean(axis=0)
    _, spread, axes = np.linalg.svd(centred, full_matrices=False)
    if len(points) < 3 or spread[1] <= LINE * spread[0]:
        return None
    chart = centred @ axes[:2].T
    k = min(4, len(points))
    spacing = cKDTree(points).query(points, k=k)[0][:, -1]
    triangles = Delaunay(chart).simplices.astype(np.int32)
    p = points[triangles]
    side = np.linalg.norm(p - np.roll(p, -1, axis=1), axis=2)
    local = spacing[triangles].min(axis=1)
    kept = triangles[side.max(axis=1) <= bridge * local]
    # A cloud seen edge-on or in several sheets makes triangles far longer than its spacing.
    if len(kept) < 0.5 * len(triangles) or 2 * len(np.unique(kept)) < len(points):
        raise InputError(
            "the cloud is no graph over its best-fit plane",
            where="area",
            found=f"{len(triangles) - len(kept)} of {len(triangles)} triangles bridge its points",
            allowed="a sheet of points",
            remedy="Use NodalArea(value) or HullArea(), or give the slave facets",
        )
    return kept


def _along_line(inp: AreaInput, graph: Graph, depth: float) -> FloatArray:
    """Half the way to each neighbour along the line of points, times the depth."""
    area = np.zeros(len(inp.rows))
    for i, row in enumerate(inp.rows):
        near = graph.neighbour[graph.first[row] : graph.first[row + 1]]
        step = inp.points[near] - inp.points[row]
        way = np.linalg.norm(step, axis=1)
        ahead = step @ step[np.argmin(way)] > 0.0
        for side in (ahead, ~ahead):
            if side.any():
                area[i] += 0.5 * depth * way[side].min()
    return area
