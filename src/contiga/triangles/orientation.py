"""Consistent orientation of triangles: neighbours face the same way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.errors import MeshError
from contiga.records import FloatArray, IntArray

Ints = NDArray[np.int64]


def turned_triangles(points: FloatArray, triangles: IntArray, where: str) -> IntArray:
    """Return a copy of `triangles` (m, 3), reversed where needed for one sense on each piece.

    Pieces are connected over edges of just two triangles; vertices at one place are the same. An
    open piece keeps the sense of most of its area, a closed piece encloses a positive volume.

    Raises
    ------
    MeshError
        A piece has one side only, as a Möbius strip; `where` names the mesh.
    """
    m = len(triangles)
    if m == 0:
        return triangles
    # Half-edges by edge, and the pairs (x, y) of them over edges of two triangles.
    vertices = np.unique(points + 0.0, axis=0, return_inverse=True)[1].ravel()[triangles]
    a, b = vertices.ravel(), np.roll(vertices, -1, axis=1).ravel()
    key = np.minimum(a, b).astype(np.int64) * len(points) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    start = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0]))
    size = np.diff(np.append(start, len(order)))
    x, y = order[start[size == 2]], order[start[size == 2] + 1]
    is_pair = x // 3 != y // 3
    x, y = x[is_pair], y[is_pair]
    first, second = x // 3, y // 3
    is_same_sense = ((a[x] < b[x]) == (a[y] < b[y])).astype(np.int64)
    count, piece, flip = _senses(first, second, is_same_sense, m)
    if np.any(flip[first] ^ flip[second] != is_same_sense):
        raise MeshError("a piece of the mesh has one side only", where=where)
    corners = points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volume = np.einsum("ij,ij->i", corners[:, 0] - corners[:, 0].mean(axis=0), cross)
    is_open = np.zeros(count, bool)
    is_open[piece[order[start[size == 1]] // 3]] = True
    sense = np.where(flip == 1, -1.0, 1.0)
    piece_area = np.bincount(piece, sense * np.linalg.norm(cross, axis=1), minlength=count)
    piece_volume = np.bincount(piece, sense * volume, minlength=count)
    is_wrong = np.where(is_open, piece_area < 0.0, piece_volume < 0.0)
    flipped = (flip == 1) ^ is_wrong[piece]
    result = triangles.copy()
    result[flipped] = result[flipped][:, ::-1]
    return result


def _senses(first: Ints, second: Ints, is_same_sense: Ints, m: int) -> tuple[int, Ints, Ints]:
    """Return the number of connected pieces, the piece (m,) of each triangle, and its flip (m,).

    The flip is 1 for triangles that must be reversed to face like the first of their piece, else 0.
    Each piece is traversed from its first triangle, over the joints of first[i] and
    second[i], whose triangles run along their edge in the same sense if is_same_sense[i] is 1.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    graph = coo_matrix((np.ones(len(first)), (first, second)), (m, m)).tocsr()
    count, piece = connected_components(graph, directed=False)
    flip = np.full(m, -1)
    pairs = zip(first.tolist(), second.tolist(), strict=True)
    is_same = dict(zip(pairs, is_same_sense.tolist(), strict=True))
    for k in range(count):
        seed = int(np.argmax(piece == k))
        order, parent = breadth_first_order(graph, seed, directed=False)
        flip[seed] = 0
        for t in order[1:].tolist():
            p = int(parent[t])
            flip[t] = flip[p] ^ is_same[min(p, t), max(p, t)]
    return count, piece, flip
