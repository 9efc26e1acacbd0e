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

# Smallest cosine between a normal of a region and the mean normal for a plane chart of the region.
MIN_COSINE = 0.5


class Web(NamedTuple):
    """The points in contact and their neighbours, with triangles between their feet."""

    inp: AreaInput
    """Area input of these points alone, those in contact first."""
    topology: Topology
    clusters: IntArray
    """(n_c,) regions, joined over neighbours at rest."""


def web_of(inp: AreaInput, graph: Graph, bridge: float) -> Web:
    """Return Delaunay triangles between feet, each region in a chart of its own.

    Points of the result are those in contact, then their neighbours out of contact with a foot;
    `clusters` are the regions (n_c,) of the former.

    The chart is the plane normal to the mean normal if every normal of the region is within 60° of
    it, whatever seams, borders and poles lie inside. A region that bends farther is laid out in
    (u, v), scaled to lengths and unrolled over a seam, patch by patch.

    Triangles with a side that is long by `without_bridges` are left out, and so are charts of fewer
    than three points, or of points on a line. Neighbours out of contact belong to the region of the
    nearest point in contact, from whose foot theirs is continued.
    """
    from scipy.spatial import Delaunay, QhullError

    label = regions(graph, inp.rows, inp.points)
    ring, start = _ring_around(inp, graph)
    ring_feet = empty_projection(len(ring))
    if len(ring):
        patch, uv = inp.feet.patch[start], inp.feet.uv[start]
        inp.body.surface.track(np.ascontiguousarray(inp.points[ring]), patch, uv, ring_feet)
    has_foot = np.flatnonzero(np.isfinite(ring_feet.point).all(axis=1))
    feet = stacked(inp.feet, rows_of(ring_feet, has_foot))
    region = np.concatenate([label, label[start[has_foot]]])
    facets = [np.zeros((0, 3), np.int32)]
    for rows, chart in _charts(inp.exact, feet, region):
        if len(rows) < 3:
            continue
        try:
            triangles = Delaunay(chart).simplices.astype(np.int32)
        except QhullError:  # all points on a line
            continue
        facets.append(rows[without_bridges(feet.point[rows], triangles, bridge)])
    points = np.concatenate([inp.points[inp.rows], inp.points[ring[has_foot]]])
    topology = topology_of(np.concatenate(facets).astype(np.int32), len(points))
    touching = np.arange(len(inp.rows), dtype=np.int32)
    return Web(inp._replace(rows=touching, points=points, prepared=None), topology, label)


def _ring_around(inp: AreaInput, graph: Graph) -> tuple[IntArray, IntArray]:
    """Return the points (f,) out of contact next to ones in contact, and the nearest (f,) to each.

    The former are rows of all points, ascending; the nearest are indices among the points in
    contact. Points that are not finite do not count.
    """
    place = np.full(len(inp.points), -1, np.int32)
    place[inp.rows] = np.arange(len(inp.rows))
    count = np.diff(graph.first)[inp.rows]
    touching = np.repeat(np.arange(len(inp.rows)), count)
    shift = np.arange(len(touching)) - np.repeat(np.cumsum(count) - count, count)
    neighbour = graph.neighbour[graph.first[inp.rows][touching] + shift]
    is_free = (place[neighbour] < 0) & np.isfinite(inp.points[neighbour]).all(axis=1)
    touching, neighbour = touching[is_free], neighbour[is_free]
    distance = np.linalg.norm(inp.points[inp.rows[touching]] - inp.points[neighbour], axis=1)
    order = np.lexsort((touching, distance, neighbour))
    ring, first = np.unique(neighbour[order], return_index=True)
    return ring.astype(np.int32), touching[order][first].astype(np.int32)


def _charts(
    body: Faces, feet: Projection, region: IntArray
) -> Iterator[tuple[IntArray, FloatArray]]:
    """Yield for each region, or part of one, its rows and their coordinates (k, 2) in a chart.

    The chart is a plane if the cosines of normals with their mean are above `MIN_COSINE`; else
    there is one for each patch, by (u, v) times the mean |S_u| and |S_v|.
    """
    for k in range(int(region.max(initial=-1)) + 1):
        rows = np.flatnonzero(region == k).astype(np.int32)
        normal = feet.normal[rows]
        mean = normal.mean(axis=0)
        size = length(mean)
        if size > 0.0 and product(normal, mean).min() > MIN_COSINE * size:
            plane_axes = principal_axes(mean[None, :])[1][1:]
            yield rows, product(feet.point[rows], plane_axes.T)
            continue
        for index in np.unique(feet.patch[rows]):
            on_patch = rows[feet.patch[rows] == index]
            patch = patch_of(body, int(index))
            d = patch.surface.derivatives(feet.uv[on_patch], 1)
            scale = np.linalg.norm([d[:, 1, 0], d[:, 0, 1]], axis=2).mean(axis=1)
            yield on_patch, unrolled(feet.uv[on_patch], patch.periods) * scale


def without_bridges(points: FloatArray, triangles: IntArray, bridge: float) -> IntArray:
    """Return those `triangles` (k, 3) of points (n, 3) that have no long side.

    A side is long above `bridge` times the least local spacing of the triangle's corners, the
    distance to the third neighbour (the last of fewer).
    """
    from scipy.spatial import cKDTree

    spacing = cKDTree(points).query(points, k=min(4, len(points)))[0][:, -1]
    p = points[triangles]
    longest = np.linalg.norm(p - np.roll(p, -1, axis=1), axis=2).max(axis=1)
    short: IntArray = triangles[longest <= bridge * spacing[triangles].min(axis=1)]
    return short
