"""Triangles between the feet of a cloud: for clouds that are no sheet at rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from contiga.area.hull import patch_of, unrolled
from contiga.area.method import AreaInput
from contiga.area.regions import Graph, Topology, regions, topology_of
from contiga.arrays.ordered import length, principal_axes, product
from contiga.geometry.faces import Faces
from contiga.records import (
    FloatArray,
    IntArray,
    Projection,
    empty_projection,
    rows_of,
    stacked,
)

# Cosine of the angle to their mean that no normal of a region exceeds where it is seen from there.
SEEN = 0.5


class Web(NamedTuple):
    """The points in contact and those around them, with triangles between their feet."""

    inp: AreaInput
    """Of these points alone: the ones in contact first."""
    topology: Topology
    clusters: IntArray
    """(n_c,) regions, joined over neighbours at rest."""


def web_of(inp: AreaInput, graph: Graph, bridge: float) -> Web:
    """Delaunay triangles between feet, each region in a chart of its own.

    The chart is the plane across the mean normal where every normal of the region is within 60°
    of it, whatever seams, borders and poles lie inside. A region that bends farther is laid out
    in (u, v), scaled to lengths and unrolled over a seam, patch by patch.

    Triangles with a side longer than `bridge` times the local spacing are left out.
    """
    n_c = len(inp.rows)
    label = regions(graph, inp.rows, inp.points)
    ring, start = _around(inp, graph)
    out = empty_projection(len(ring))
    if len(ring):
        patch, uv = inp.feet.patch[start], inp.feet.uv[start]
        inp.body.surface.track(np.ascontiguousarray(inp.points[ring]), patch, uv, out)
    known = np.flatnonzero(np.isfinite(out.point).all(axis=1))
    feet = stacked(inp.feet, rows_of(out, known))
    region = np.concatenate([label, label[start[known]]])
    facets = [np.zeros((0, 3), np.int32)]
    for rows_in_chart, chart in _charts(inp.exact, feet, region):
        facets.append(rows_in_chart[_triangles(chart, feet.point[rows_in_chart], bridge)])
    points = np.concatenate([inp.points[inp.rows], inp.points[ring[known]]])
    rows = np.arange(n_c, dtype=np.int32)
    corners = np.concatenate(facets).astype(np.int32)
    topology = topology_of(corners, len(points))
    return Web(inp._replace(rows=rows, points=points, prepared=None), topology, label)


def _around(inp: AreaInput, graph: Graph) -> tuple[IntArray, IntArray]:
    """Rows of the points out of contact next to some in contact, and the nearest of those."""
    place = np.full(len(inp.points), -1, np.int32)
    place[inp.rows] = np.arange(len(inp.rows))
    count = np.diff(graph.first)[inp.rows]
    touching = np.repeat(np.arange(len(inp.rows)), count)
    shift = np.arange(len(touching)) - np.repeat(np.cumsum(count) - count, count)
    near = graph.neighbour[graph.first[inp.rows][touching] + shift]
    free = (place[near] < 0) & np.isfinite(inp.points[near]).all(axis=1)
    touching, near = touching[free], near[free]
    way = np.linalg.norm(inp.points[inp.rows[touching]] - inp.points[near], axis=1)
    order = np.lexsort((touching, way, near))
    ring, first = np.unique(near[order], return_index=True)
    return ring.astype(np.int32), touching[order][first].astype(np.int32)


def _charts(
    body: Faces, feet: Projection, region: IntArray
) -> Iterator[tuple[IntArray, FloatArray]]:
    """Yield for each region, or part of one, its points and their places (k, 2) in a chart."""
    for k in range(int(region.max(initial=-1)) + 1):
        rows = np.flatnonzero(region == k).astype(np.int32)
        normal = feet.normal[rows]
        mean = normal.mean(axis=0)
        size = length(mean)
        if size > 0.0 and product(normal, mean).min() > SEEN * size:
            across = principal_axes(mean[None, :])[1][1:]
            yield rows, product(feet.point[rows], across.T)
            continue
        for patch in np.unique(feet.patch[rows]):
            part = rows[feet.patch[rows] == patch]
            yield part, _laid_out(body, feet, part)


def _laid_out(body: Faces, feet: Projection, part: IntArray) -> FloatArray:
    """Return (u, v) of feet on one patch, unrolled, in lengths: times the mean |S_u| and |S_v|."""
    patch = patch_of(body, int(feet.patch[part[0]]))
    d = patch.surface.derivatives(feet.uv[part], 1)
    scale = np.linalg.norm([d[:, 1, 0], d[:, 0, 1]], axis=2).mean(axis=1)
    laid: FloatArray = unrolled(feet.uv[part], patch.periods) * scale
    return laid


def _triangles(chart: FloatArray, points: FloatArray, bridge: float) -> IntArray:
    """Return (m, 3) Delaunay triangles in the chart whose sides in space bridge no gap."""
    from scipy.spatial import Delaunay, QhullError

    none = np.zeros((0, 3), np.int32)
    if len(chart) < 3:
        return none
    try:
        simplices = Delaunay(chart).simplices
    except QhullError:  # all on a line
        return none
    return unbridged(points, simplices.astype(np.int32), bridge)


def unbridged(points: FloatArray, triangles: IntArray, bridge: float) -> IntArray:
    """Return the triangles (m, 3) of points (n, 3) that have no long side.

    A side is long above `bridge` times the local spacing, the distance to the third neighbour.
    """
    from scipy.spatial import cKDTree

    spacing = cKDTree(points).query(points, k=min(4, len(points)))[0][:, -1]
    p = points[triangles]
    side = np.linalg.norm(p - np.roll(p, -1, axis=1), axis=2).max(axis=1)
    kept: IntArray = triangles[side <= bridge * spacing[triangles].min(axis=1)]
    return kept
