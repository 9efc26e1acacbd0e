"""The tables that the search on a mesh reads, built once and kept as long as the mesh lives."""

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
from contiga.triangles.topology import topology_of
from contiga.triangles.triangle_arrays import TriangleArrays

RELATIVE_TOLERANCE = 1e-12
"""Length below which two points are one, as a share of the size of the mesh."""


@pass_by_pointer
class Tables(NamedTuple):
    """The kernels' tables of a mesh, and facts about its edges."""

    facets: Facets
    slot: IntArray
    """Slot of each triangle of the mesh; the slot of its twin for a duplicate, −1 without area."""
    closed: bool
    """Whether no edge belongs to one triangle only."""
    turned: int
    """Number of edges at which two triangles face opposite ways."""
    back_to_back: IntArray
    """(k, 2) triangles with the same corners that face opposite ways."""


@once
def tables_of(mesh: TriangleArrays) -> Tables:
    """Return the search tables of `mesh`, built at the first call and kept while the mesh lives.

    Raises
    ------
    MeshError
        The mesh has no triangle with an area.
    """
    if len(mesh.triangles) == 0:
        raise MeshError("a mesh without triangles has no surface", where=mesh.name)
    t = topology_of(mesh)
    if len(t.triangle) == 0:
        raise MeshError(
            "none of the triangles has an area",
            where=mesh.name,
            found=f"{len(mesh.triangles)} triangles",
        )
    p = t.points[t.vertex]
    margin = 4.0 * np.finfo(float).eps * float(np.abs(t.points).max())
    low = np.ascontiguousarray(p.min(axis=1).T) - margin
    high = np.ascontiguousarray(p.max(axis=1).T) + margin
    box, child, order = boxes_nb.build(low, high)
    slot_of = np.empty(len(order), np.int32)
    slot_of[order] = np.arange(len(order), dtype=np.int32)
    vertex, p = t.vertex[order], p[order]
    neighbour = t.neighbour[order]
    is_joined = neighbour >= 0
    neighbour[is_joined] = slot_of[neighbour[is_joined]]
    neighbour[neighbour < NO_TRIANGLE] -= len(t.points)  # fans follow the vertices in `around`
    link = np.zeros((len(order), 8), np.int32)
    link[:, NEIGHBOUR:VERTICES], link[:, VERTICES:TRIANGLE] = neighbour, vertex
    link[:, TRIANGLE] = t.triangle[order]
    normal = unit_normals(p)
    # Duals: (P − a)·g1 and (P − a)·g2 are the coordinates of P along the sides at the corner a.
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    g1, g2 = np.cross(e2, normal), np.cross(normal, e1)
    g1 /= (g1 * e1).sum(axis=1, keepdims=True)
    g2 /= (g2 * e2).sum(axis=1, keepdims=True)
    shape = np.concatenate([p[:, 0], g1, g2, normal, p[:, 1], p[:, 2]], axis=1)
    corner = np.zeros((len(t.points), 4))
    corner[:, :3] = vertex_normals(p, vertex, normal, len(t.points))
    is_open = neighbour == NO_TRIANGLE
    corner[vertex[is_open], 3] = 1.0
    corner[np.roll(vertex, -1, axis=1)[is_open], 3] = 1.0
    size = length(np.ptp(t.points, axis=0))
    facets = Facets(
        np.ascontiguousarray(shape),
        link,
        corner,
        np.concatenate([t.ring_first, t.ring_first[-1] + t.fan_first[1:]]),
        slot_of[np.concatenate([t.ring, t.fan])],
        box,
        child,
        np.array([size, RELATIVE_TOLERANCE * size]),
    )
    slot = np.where(t.twin >= 0, slot_of[np.maximum(t.twin, 0)], -1).astype(np.int32)
    return Tables(facets, slot, not is_open.any(), t.turned, t.back_to_back.astype(np.int32))


def unit_normals(p: FloatArray) -> FloatArray:
    """Return (m, 3) unit normals of triangles (m, 3, 3) with an area.

    A normal is the cross product at the corner between the two shorter sides, where it loses least,
    made perpendicular to the longest side: the remaining error on a sliver rotates the normal about
    that side, along which heights are measured.
    """
    sides = np.roll(p, -1, axis=1) - p
    longest_side = np.argmax(np.square(sides).sum(axis=2), axis=1)[:, None, None]
    first = np.take_along_axis(sides, (longest_side + 1) % 3, axis=1)[:, 0]
    second = np.take_along_axis(sides, (longest_side + 2) % 3, axis=1)[:, 0]
    cross = np.cross(first, second)
    normal = cross / np.linalg.norm(cross, axis=1, keepdims=True)
    longest = np.take_along_axis(sides, longest_side, axis=1)[:, 0]
    longest = longest / np.linalg.norm(longest, axis=1, keepdims=True)
    normal -= (normal * longest).sum(axis=1, keepdims=True) * longest
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def vertex_normals(p: FloatArray, vertex: np.ndarray, normal: FloatArray, count: int) -> FloatArray:
    """Return unit sums (count, 3) of the normals around vertices, weighted by angles.

    `p` (m, 3, 3) are the corners of triangles, `vertex` (m, 3) their vertices, `normal` (m, 3) the
    unit normals. The sum is zero for a vertex of no triangle, or if it vanishes.
    """
    total = np.zeros((count, 3))
    for k in range(3):
        a, b = p[:, k - 2] - p[:, k], p[:, k - 1] - p[:, k]
        across = np.linalg.norm(np.cross(a, b), axis=1)
        angle = np.arctan2(across, (a * b).sum(axis=1))
        for c in range(3):
            total[:, c] += np.bincount(vertex[:, k], angle * normal[:, c], minlength=count)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.divide(total, length, out=np.zeros_like(total), where=length > 0.0)
