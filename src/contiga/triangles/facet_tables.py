"""Everything the search knows about a mesh, worked out once and kept as long as the mesh lives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import NO_TRIANGLE
from contiga.arrays.once import once
from contiga.arrays.ordered import length
from contiga.errors import MeshError
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.triangles.facets import Facets
from contiga.triangles.kernels import boxes_nb
from contiga.triangles.kernels.facet_nb import NEIGHBOUR, TRIANGLE, VERTICES
from contiga.triangles.topology import Topology, topology_of
from contiga.triangles.triangle_arrays import TriangleArrays

RELATIVE_TOLERANCE = 1e-12
"""Length below which two points are one, relative to the size of the mesh."""


@pass_by_pointer
class Tables(NamedTuple):
    """The kernels' tables, and what else is asked of a mesh."""

    facets: Facets
    slot: IntArray
    """By triangle of the mesh its slot; that of its twin for a duplicate, −1 without area."""
    closed: bool
    """No edge belongs to one triangle only."""
    turned: int
    """Edges at which two triangles face opposite ways."""
    back_to_back: IntArray
    """(k, 2) triangles with the same corners that face opposite ways."""


@once
def tables_of(mesh: TriangleArrays) -> Tables:
    """The search tables of `mesh`, built at the first call.

    Raises
    ------
    MeshError
        The mesh has no triangle with an area.
    """
    if len(mesh.triangles) == 0:
        raise MeshError("a mesh without triangles has no surface", where=mesh.name)
    topology = topology_of(mesh)
    if len(topology.kept) == 0:
        raise MeshError(
            "none of the triangles has an area",
            where=mesh.name,
            found=f"{len(mesh.triangles)} triangles",
        )
    p = topology.points[topology.vertex]
    reach = float(np.abs(topology.points).max())
    margin = 4.0 * np.finfo(float).eps * reach
    low = np.ascontiguousarray(p.min(axis=1).T) - margin
    high = np.ascontiguousarray(p.max(axis=1).T) + margin
    box, child, order = boxes_nb.build(low, high)
    facets, slot = _facets(topology, order, box, child)
    closed = not bool((facets.link[:, :3] == NO_TRIANGLE).any())
    folded = topology.back_to_back.astype(np.int32)
    return Tables(facets, slot, closed, topology.turned, folded)


def _facets(
    t: Topology, order: IntArray, box: FloatArray, child: IntArray
) -> tuple[Facets, IntArray]:
    """The kernels' tables, and the slots of the mesh's triangles."""
    slot_of = np.empty(len(order), np.int32)
    slot_of[order] = np.arange(len(order), dtype=np.int32)
    vertex = t.vertex[order]
    p = t.points[vertex]
    neighbour = t.neighbour[order]
    joined = neighbour >= 0
    neighbour[joined] = slot_of[neighbour[joined]]
    neighbour[neighbour < NO_TRIANGLE] -= len(t.points)  # fans follow the vertices in `around`
    normal = unit_normals(p)
    corner = np.zeros((len(t.points), 4))
    corner[:, :3] = vertex_normals(p, vertex, normal, len(t.points))
    open_edge = neighbour == NO_TRIANGLE
    corner[vertex[open_edge], 3] = 1.0
    corner[np.roll(vertex, -1, axis=1)[open_edge], 3] = 1.0
    shape = np.concatenate([p[:, 0], *_duals(p, normal), normal, p[:, 1], p[:, 2]], axis=1)
    link = np.zeros((len(order), 8), np.int32)
    link[:, NEIGHBOUR:VERTICES], link[:, VERTICES:TRIANGLE] = neighbour, vertex
    link[:, TRIANGLE] = t.kept[order]
    slot = np.where(t.twin >= 0, slot_of[np.maximum(t.twin, 0)], -1).astype(np.int32)
    size = length(np.ptp(t.points, axis=0))
    scale = np.array([size, RELATIVE_TOLERANCE * size])
    around_first = np.concatenate([t.ring_first, t.ring_first[-1] + t.fan_first[1:]])
    around = slot_of[np.concatenate([t.ring, t.fan])]
    return Facets(
        np.ascontiguousarray(shape), link, corner, around_first, around, box, child, scale
    ), slot


def unit_normals(p: FloatArray) -> FloatArray:
    """Return (m, 3) unit normals of triangles (m, 3, 3) with an area.

    Taken at the corner between the two shorter sides, where the cross product loses least, and
    put square to the longest side: what is left of the error on a sliver turns it about that side,
    along which heights are measured.
    """
    sides = np.roll(p, -1, axis=1) - p
    at = np.argmax(np.square(sides).sum(axis=2), axis=1)[:, None, None]
    first = np.take_along_axis(sides, (at + 1) % 3, axis=1)[:, 0]
    second = np.take_along_axis(sides, (at + 2) % 3, axis=1)[:, 0]
    cross = np.cross(first, second)
    normal = cross / np.linalg.norm(cross, axis=1, keepdims=True)
    longest = np.take_along_axis(sides, at, axis=1)[:, 0]
    longest = longest / np.linalg.norm(longest, axis=1, keepdims=True)
    normal -= (normal * longest).sum(axis=1, keepdims=True) * longest
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def _duals(p: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """g1, g2 (m, 3): (P − a)·g1 and (P − a)·g2 are the coordinates along the sides at a."""
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    g1, g2 = np.cross(e2, normal), np.cross(normal, e1)
    return (
        g1 / (g1 * e1).sum(axis=1, keepdims=True),
        g2 / (g2 * e2).sum(axis=1, keepdims=True),
    )


def vertex_normals(p: FloatArray, vertex: np.ndarray, normal: FloatArray, count: int) -> FloatArray:
    """Return unit sums (count, 3) of the normals around vertices, weighted by angles."""
    total = np.zeros((count, 3))
    for k in range(3):
        a, b = p[:, k - 2] - p[:, k], p[:, k - 1] - p[:, k]
        across = np.linalg.norm(np.cross(a, b), axis=1)
        angle = np.arctan2(across, (a * b).sum(axis=1))
        for c in range(3):
            total[:, c] += np.bincount(vertex[:, k], angle * normal[:, c], minlength=count)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.divide(total, length, out=np.zeros_like(total), where=length > 0.0)
