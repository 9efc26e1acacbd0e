"""Find which triangles of a mesh meet where: welded vertices, neighbours, fans, rings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import NO_TRIANGLE
from contiga.records import FloatArray, IntArray
from contiga.triangles.triangle_arrays import TriangleArrays

FLAT = 1e-12
"""Triangles lower than this share of their longest side have no area."""

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


class Topology(NamedTuple):
    """The connections of the triangles of a mesh that have an area, each once."""

    points: FloatArray
    """(v, 3) welded vertices."""
    kept: Ints
    """(m,) triangles of the mesh."""
    twin: Ints
    """By triangle of the mesh its row in `kept`, that of its twin, or −1 without area."""
    vertex: IntArray
    """(m, 3) welded vertices of the triangles kept."""
    neighbour: IntArray
    """(m, 3) row across the edge from corner k to k + 1; −1 none, −2 − fan where more meet."""
    fan_first: IntArray
    fan: IntArray
    ring_first: IntArray
    ring: IntArray
    turned: int
    """Edges at which two triangles face opposite ways."""
    crowded: int
    """Edges at which more than two triangles meet."""
    back_to_back: Ints
    """(k, 2) triangles of the mesh with the same corners that face opposite ways."""


def _one_after_another(fans: list[Ints]) -> tuple[IntArray, IntArray]:
    """Return where each of some rows begins, and all of them in one."""
    first = np.concatenate([[0], np.cumsum([len(fan) for fan in fans])])
    return first.astype(np.int32), np.concatenate([np.zeros(0, np.int64), *fans]).astype(np.int32)


def topology_of(mesh: TriangleArrays) -> Topology:
    """Triangles joined where their corners are the same points, whatever their indices.

    Triangles without area take no part; what they join stays joined (a fan). Of triangles with the
    same corners in the same sense the first counts.
    """
    points, corners = welded(mesh)
    flat = is_flat(mesh)
    unique, twin_of = _without_twins(corners)
    flat_rows = unique[flat[unique]]
    kept = unique[~flat[unique]]
    row = np.full(len(corners), -1, np.int64)
    row[kept] = np.arange(len(kept))
    twin = np.where(flat, -1, row[twin_of])
    vertex = corners[kept]
    half = _HalfEdges.of(np.concatenate([vertex, corners[flat_rows]]), len(points))
    neighbour, fans = half.neighbours(len(kept))
    outer = _around_flat(half, len(kept), neighbour, fans) if len(flat_rows) else []
    first, ring = _rings(vertex, corners[flat_rows], outer, len(points))
    return Topology(
        points,
        kept,
        twin,
        vertex.astype(np.int32),
        neighbour.reshape(-1, 3).astype(np.int32),
        *_one_after_another(fans),
        first,
        ring,
        half.turned(len(kept)),
        sum(len(group) > 2 for group in half.crowded),
        kept[_back_to_back(vertex)],
    )


def welded(mesh: TriangleArrays) -> tuple[FloatArray, Ints]:
    """Points that triangles use, each once, and the triangles' corners among them."""
    used, corners = np.unique(mesh.triangles, return_inverse=True)
    points = mesh.vertices[used] + 0.0  # −0 and 0 are one place
    order = np.lexsort(points.T)
    sorted_points = points[order]
    new = np.ones(len(points), bool)
    new[1:] = (sorted_points[1:] != sorted_points[:-1]).any(axis=1)
    if new.all():
        return points, corners.reshape(-1, 3).astype(np.int64)
    # Each place is spoken for by the first vertex there, so that the order stays the mesh's.
    group = np.cumsum(new) - 1
    speaker = np.minimum.reduceat(order, np.flatnonzero(new))
    number = np.empty(len(points), np.int64)
    number[order] = speaker[group]
    kept, place = np.unique(number, return_inverse=True)
    return points[kept], place[corners].reshape(-1, 3).astype(np.int64)


def is_flat(mesh: TriangleArrays) -> Bools:
    """Return (m,) triangles whose corners lie on a line or in a point."""
    p = mesh.corners()
    longest = np.max([np.square(p[:, i] - p[:, i - 1]).sum(axis=1) for i in range(3)], axis=0)
    flat: Bools = ~(2.0 * mesh.areas() > FLAT * longest)
    return flat


def _without_twins(corners: Ints) -> tuple[Ints, Ints]:
    """Triangles that are the first with their corners and sense, and by triangle which one."""
    turn = np.argmin(corners, axis=1)
    turned = np.take_along_axis(corners, (turn[:, None] + np.arange(3)) % 3, axis=1)
    order = np.lexsort((turned[:, 2], turned[:, 1], turned[:, 0]))
    s = turned[order]
    new = np.ones(len(s), bool)
    new[1:] = (s[1:] != s[:-1]).any(axis=1)
    # lexsort is stable: the first of a group has the lowest number.
    first = order[np.flatnonzero(new)]
    twin = np.empty(len(s), np.int64)
    twin[order] = first[np.cumsum(new) - 1]
    return np.sort(first), twin


def _back_to_back(corners: Ints) -> Ints:
    """Return rows (k, 2) of triangles with the same corners, which turn opposite ways."""
    s = np.sort(corners, axis=1)
    order = np.lexsort((s[:, 2], s[:, 1], s[:, 0]))
    again = np.flatnonzero((s[order][1:] == s[order][:-1]).all(axis=1))
    return np.stack([order[again], order[again + 1]], axis=1)


class _HalfEdges(NamedTuple):
    """Edges of triangles, sorted so that those at the same place follow each other."""

    owner: Ints
    """(3 t,) half-edge 3·triangle + k, sorted."""
    start: Ints
    """Where each edge's half-edges start in `owner`; the end last."""
    forward: Bools
    """(3 t,) by half-edge: from the lower to the higher vertex."""
    crowded: list[Ints]
    """Of edges with more than two half-edges these."""

    @classmethod
    def of(cls, corners: Ints, count: int) -> _HalfEdges:
        a = corners.ravel()
        b = np.roll(corners, -1, axis=1).ravel()
        key = np.minimum(a, b) * count + np.maximum(a, b)
        owner = np.argsort(key, kind="stable")
        sorted_key = key[owner]
        new = np.flatnonzero(np.concatenate([[True], sorted_key[1:] != sorted_key[:-1]]))
        start = np.append(new, len(owner))
        many = np.flatnonzero(np.diff(start) > 2)
        crowded = [owner[start[g] : start[g + 1]] for g in many]
        return cls(owner, start, a < b, crowded)

    def pairs(self) -> tuple[Ints, Ints]:
        """Half-edges of edges that have two."""
        two = self.start[:-1][np.diff(self.start) == 2]
        return self.owner[two], self.owner[two + 1]

    def neighbours(self, m: int) -> tuple[Ints, list[Ints]]:
        """Return (3 m,) neighbours of the first m triangles, and the fans."""
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
        """Edges of the first m triangles whose two triangles run along them in the same sense."""
        a, b = self.pairs()
        inner = (a < 3 * m) & (b < 3 * m)
        return int((self.forward[a] == self.forward[b])[inner].sum())


def _around_flat(half: _HalfEdges, m: int, neighbour: Ints, fans: list[Ints]) -> list[Ints]:
    """Join the triangles around each patch of flat ones; returns by flat triangle its patch's."""
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


def _rings(vertex: Ints, flat: Ints, outer: list[Ints], count: int) -> tuple[IntArray, IntArray]:
    """Triangles around each vertex; around a flat triangle's corner also what it joins."""
    owner = vertex.ravel()
    triangle = np.repeat(np.arange(len(vertex)), 3)
    if len(flat):
        more = [(v, t) for corners, members in zip(flat, outer, strict=True)
                for v in corners for t in members]  # fmt: skip
        if more:
            pairs = np.unique(
                np.concatenate([np.stack([owner, triangle], 1), np.array(more)]), axis=0
            )
            owner, triangle = pairs.T
    order = np.argsort(owner, kind="stable")
    first = np.searchsorted(owner[order], np.arange(count + 1))
    return first.astype(np.int32), triangle[order].astype(np.int32)
