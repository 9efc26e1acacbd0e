"""The connections of the triangles of a mesh: merged vertices, neighbours, fans, rings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import NO_TRIANGLE
from contiga.records import FloatArray, IntArray
from contiga.triangles.triangle_arrays import TriangleArrays

FLAT = 1e-12
"""Height of a triangle, as a share of its longest side, below which it has no area."""

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


class Topology(NamedTuple):
    """The connections of the triangles of a mesh that have an area, each once."""

    points: FloatArray
    """(v, 3) merged vertices."""
    triangle: Ints
    """(m,) number in the mesh of each of these triangles, ascending."""
    twin: Ints
    """Row in `triangle` of each triangle of the mesh, or of its twin; −1 without area."""
    vertex: IntArray
    """(m, 3) merged vertices of these triangles."""
    neighbour: IntArray
    """(m, 3) row across the edge from corner k to k + 1; −1 for none, −2 − fan for several."""
    fan_first: IntArray
    fan: IntArray
    """fan[fan_first[k] : fan_first[k + 1]] are the triangles that meet at crowded edge k."""
    ring_first: IntArray
    ring: IntArray
    """ring[ring_first[k] : ring_first[k + 1]] are the triangles around vertex k."""
    turned: int
    """Number of edges at which two triangles face opposite ways."""
    crowded: int
    """Number of edges at which more than two triangles meet."""
    back_to_back: Ints
    """(k, 2) triangles of the mesh with the same corners that face opposite ways."""


def topology_of(mesh: TriangleArrays) -> Topology:
    """Return the connections of the triangles of `mesh`, with vertices at one place merged.

    Triangles without area do not count, but the triangles around them stay connected (a fan). Of
    triangles with the same corners in the same sense the first counts. Edges of two triangles make
    them neighbours even if these face opposite ways.
    """
    points, corners = welded(mesh)
    flat = is_flat(mesh)
    # The first triangle of each set of twins: corners from the lowest on, sorted.
    lowest = np.argmin(corners, axis=1)[:, None]
    rotated = np.take_along_axis(corners, (lowest + np.arange(3)) % 3, axis=1)
    order = np.lexsort((rotated[:, 2], rotated[:, 1], rotated[:, 0]))
    is_new = np.ones(len(order), bool)
    is_new[1:] = (rotated[order][1:] != rotated[order][:-1]).any(axis=1)
    first = order[np.flatnonzero(is_new)]  # lexsort is stable, so it has the lowest number
    twin_of = np.empty(len(order), np.int64)
    twin_of[order] = first[np.cumsum(is_new) - 1]
    unique = np.sort(first)
    proper, flat_rows = unique[~flat[unique]], unique[flat[unique]]
    row = np.full(len(corners), -1, np.int64)
    row[proper] = np.arange(len(proper))
    twin = np.where(flat, -1, row[twin_of])
    vertex = corners[proper]
    half = _HalfEdges.of(np.concatenate([vertex, corners[flat_rows]]), len(points))
    neighbour, fans = half.neighbours(len(proper))
    outer = _around_flat(half, len(proper), neighbour, fans) if len(flat_rows) else []
    # The triangles around flat triangles belong to the rings of these triangles' vertices, too.
    owner, triangle = vertex.ravel(), np.repeat(np.arange(len(vertex)), 3)
    pairs = [(v, t) for row, members in zip(corners[flat_rows], outer, strict=True)
             for v in row for t in members]  # fmt: skip
    if pairs:
        rows = np.concatenate([np.stack([owner, triangle], 1), np.array(pairs)])
        owner, triangle = np.unique(rows, axis=0).T
    by_vertex = np.argsort(owner, kind="stable")
    ring_first = np.searchsorted(owner[by_vertex], np.arange(len(points) + 1))
    # Triangles with the same three corners that are no twins are back to back.
    s = np.sort(vertex, axis=1)
    order = np.lexsort((s[:, 2], s[:, 1], s[:, 0]))
    repeats = np.flatnonzero((s[order][1:] == s[order][:-1]).all(axis=1))
    return Topology(
        points,
        proper,
        twin,
        vertex.astype(np.int32),
        neighbour.reshape(-1, 3).astype(np.int32),
        np.concatenate([[0], np.cumsum([len(fan) for fan in fans])]).astype(np.int32),
        np.concatenate([np.zeros(0, np.int64), *fans]).astype(np.int32),
        ring_first.astype(np.int32),
        triangle[by_vertex].astype(np.int32),
        half.turned(len(proper)),
        sum(len(group) > 2 for group in half.crowded),
        proper[np.stack([order[repeats], order[repeats + 1]], axis=1)],
    )


def welded(mesh: TriangleArrays) -> tuple[FloatArray, Ints]:
    """Return the points (v, 3) that triangles use, each place once, and corners (m, 3) among them.

    Only equal coordinates are one place. Points are in the order of the first vertex at each.
    """
    used, corners = np.unique(mesh.triangles, return_inverse=True)
    points = mesh.vertices[used] + 0.0  # −0 and 0 are one place
    order = np.lexsort(points.T)
    sorted_points = points[order]
    is_new = np.ones(len(points), bool)
    is_new[1:] = (sorted_points[1:] != sorted_points[:-1]).any(axis=1)
    if is_new.all():
        return points, corners.reshape(-1, 3).astype(np.int64)
    # The first vertex at a place represents it, so that the order of the mesh is preserved.
    group = np.cumsum(is_new) - 1
    representative = np.minimum.reduceat(order, np.flatnonzero(is_new))
    merged = np.empty(len(points), np.int64)
    merged[order] = representative[group]
    merged_points, row = np.unique(merged, return_inverse=True)
    return points[merged_points], row[corners].reshape(-1, 3).astype(np.int64)


def is_flat(mesh: TriangleArrays) -> Bools:
    """Return (m,) whether a triangle's height is at most `FLAT` of its longest side."""
    p = mesh.corners()
    longest = np.max([np.square(p[:, i] - p[:, i - 1]).sum(axis=1) for i in range(3)], axis=0)
    flat: Bools = ~(2.0 * mesh.areas() > FLAT * longest)
    return flat


class _HalfEdges(NamedTuple):
    """Half-edges of triangles, sorted by edge."""

    owner: Ints
    """(3 t,) half-edges 3·triangle + k, sorted by their edges."""
    start: Ints
    """Rows of `owner` at which the half-edges of each edge start; the end last."""
    forward: Bools
    """(3 t,) whether half-edge 3·triangle + k runs from the lower to the higher vertex."""
    crowded: list[Ints]
    """Half-edges of each edge that has more than two."""

    @classmethod
    def of(cls, corners: Ints, count: int) -> _HalfEdges:
        """Return the half-edges of triangles (t, 3) over `count` vertices, sorted by edge."""
        a = corners.ravel()
        b = np.roll(corners, -1, axis=1).ravel()
        key = np.minimum(a, b) * count + np.maximum(a, b)
        owner = np.argsort(key, kind="stable")
        sorted_key = key[owner]
        new = np.flatnonzero(np.concatenate([[True], sorted_key[1:] != sorted_key[:-1]]))
        start = np.append(new, len(owner))
        crowded_edges = np.flatnonzero(np.diff(start) > 2)
        crowded = [owner[start[g] : start[g + 1]] for g in crowded_edges]
        return cls(owner, start, a < b, crowded)

    def pairs(self) -> tuple[Ints, Ints]:
        """Return the first and the second half-edge (k,) of each of the k edges with just two."""
        first = self.start[:-1][np.diff(self.start) == 2]
        return self.owner[first], self.owner[first + 1]

    def neighbours(self, m: int) -> tuple[Ints, list[Ints]]:
        """Return (3 m,) neighbours of the first m triangles, as `Topology.neighbour`, and the fans.

        Fans are the triangles (ascending) at each crowded edge of the first m alone. Entries across
        an edge with other triangles are not final: `_around_flat` replaces them.
        """
        result = np.full(len(self.owner), NO_TRIANGLE, np.int64)
        a, b = self.pairs()
        result[a] = b // 3
        result[b] = a // 3
        fans: list[Ints] = []
        for group in self.crowded:
            if (group < 3 * m).all():
                result[group] = -2 - len(fans)
                fans.append(np.unique(group // 3))
        return result[: 3 * m], fans

    def turned(self, m: int) -> int:
        """Return the number of edges along which two of the first m triangles run in one sense."""
        a, b = self.pairs()
        is_inner = (a < 3 * m) & (b < 3 * m)
        return int((self.forward[a] == self.forward[b])[is_inner].sum())


def _around_flat(half: _HalfEdges, m: int, neighbour: Ints, fans: list[Ints]) -> list[Ints]:
    """Return, for each flat triangle, the others (ascending) around its patch of flat triangles.

    Patches are flat triangles connected over edges; flat triangles have numbers from m on. Modifies
    `neighbour` and `fans`: several triangles around a patch become a fan, a single triangle has a
    border there.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    n = len(half.owner) // 3 - m
    edge = np.repeat(np.arange(len(half.start) - 1), np.diff(half.start))
    triangle = half.owner // 3
    flat = triangle >= m
    graph = coo_matrix(
        (np.ones(flat.sum()), (triangle[flat] - m, edge[flat])), (n, len(half.start) - 1)
    )
    label = connected_components(graph @ graph.T, directed=False)[1]
    patch_of_edge = np.full(len(half.start) - 1, -1)
    patch_of_edge[edge[flat]] = label[triangle[flat] - m]
    patch = patch_of_edge[edge]
    around: list[Ints] = []
    for k in range(int(label.max()) + 1):
        outer = half.owner[(patch == k) & ~flat]
        members = np.unique(outer // 3)
        around.append(members)
        neighbour[outer] = -2 - len(fans) if len(members) > 1 else NO_TRIANGLE
        if len(members) > 1:
            fans.append(members)
    return [around[k] for k in label]
