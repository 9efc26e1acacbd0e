"""Triangles turned so that neighbours face the same way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.records import FloatArray, IntArray

Ints = NDArray[np.int64]


def turned_triangles(points: FloatArray, triangles: IntArray, where: str) -> IntArray:
    """Return (m, 3) `triangles` in one sense on each connected piece.

    Pieces join over edges of two triangles whose ends are the same points. An open piece keeps
    the sense of most of its area, a closed one faces outward.

    Raises
    ------
    MeshError
        A piece has one side only.
    """
    m = len(triangles)
    if m == 0:
        return triangles
    first, second, same, single = _joints(points, triangles)
    count, piece, flip = _senses(first, second, same, m)
    if np.any(flip[first] ^ flip[second] != same):
        raise MeshError("a piece of the mesh has one side only", where=where)
    corners = points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = np.einsum("ij,ij->i", corners[:, 0] - corners[:, 0].mean(axis=0), cross)
    is_open = np.zeros(count, bool)
    is_open[piece[single]] = True
    sense = np.where(flip == 1, -1.0, 1.0)
    area = np.bincount(piece, sense * np.linalg.norm(cross, axis=1), minlength=count)
    inside = np.bincount(piece, sense * volume, minlength=count)
    wrong = np.where(is_open, area < 0.0, inside < 0.0)
    flipped = (flip == 1) ^ wrong[piece]
    result = triangles.copy()
    result[flipped] = result[flipped][:, ::-1]
    return result


def _senses(first: Ints, second: Ints, same: Ints, m: int) -> tuple[int, Ints, Ints]:
    """Return how many pieces m triangles form, the piece of each, and 1 where it is to be turned.

    Each piece is walked from its first triangle, over joints first[i], second[i] whose triangles
    run in the same sense where same[i] says 1.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    graph = coo_matrix((np.ones(len(first)), (first, second)), (m, m)).tocsr()
    count, piece = connected_components(graph, directed=False)
    flip = np.full(m, -1)
    pairs = zip(first.tolist(), second.tolist(), strict=True)
    alike = dict(zip(pairs, same.tolist(), strict=True))
    for k in range(count):
        seed = int(np.argmax(piece == k))
        order, parent = breadth_first_order(graph, seed, directed=False)
        flip[seed] = 0
        for t in order[1:].tolist():
            before = int(parent[t])
            flip[t] = flip[before] ^ alike[min(before, t), max(before, t)]
    return count, piece, flip


def _joints(points: FloatArray, triangles: IntArray) -> tuple[Ints, Ints, Ints, NDArray[np.bool_]]:
    """Pairs of triangles over an edge, 1 where they run along it alike, and those on a border."""
    corners = np.unique(points + 0.0, axis=0, return_inverse=True)[1].ravel()[triangles]
    a, b = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    key = np.minimum(a, b).astype(np.int64) * len(points) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    start = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0]))
    size = np.diff(np.append(start, len(order)))
    x, y = order[start[size == 2]], order[start[size == 2] + 1]
    apart = x // 3 != y // 3
    x, y = x[apart], y[apart]
    same = ((a[x] < b[x]) == (a[y] < b[y])).astype(np.int64)
    single = np.zeros(len(triangles), bool)
    single[order[start[size == 1]] // 3] = True
    return x // 3, y // 3, same, single
