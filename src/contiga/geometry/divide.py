"""Bisect triangles until no side is longer than a limit, without hanging vertices.

Bisection of longest sides (Rivara, Algorithms for refining triangular grids suitable for adaptive
and multigrid techniques, 1984): a triangle with a side that is cut has its longest one cut first,
so that angles do not get smaller than half of what they were.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import positive
from contiga.errors import InputError
from contiga.records import FloatArray

MAX_TRIANGLES = 40_000_000
"""Largest number of triangles of a mesh."""
_MIN_AREA = 0.1
"""Lower bound of the area of most final triangles, in squares of the longest side."""

Ints = NDArray[np.int64]


def divided(
    points: FloatArray, triangles: NDArray[np.integer], longest: float
) -> tuple[FloatArray, NDArray[np.int32]]:
    """Return points and triangles with no side longer than `longest`; new points follow the old.

    Both are the same if no side is longer; triangles are int32.

    Parameters
    ----------
    points : (n, 3)
    triangles : (m, 3) rows of points; those that share a side share its two points
    longest : length

    Raises
    ------
    InputError
        `longest` is not positive, or needs more than 40 million triangles.

    >>> square = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> finer, cells = divided(np.array(square), np.array([[0, 1, 2], [0, 2, 3]]), 0.8)
    >>> finer[4:].tolist(), len(cells)
    ([[0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]], 8)
    """
    limit = positive(longest, "size")
    cells = np.asarray(triangles, np.int64)
    a, b, c = (points[cells[:, k]] for k in range(3))
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    if area / (_MIN_AREA * limit) / limit + len(cells) > MAX_TRIANGLES:
        raise InputError(
            f"would take more than {MAX_TRIANGLES} triangles",
            where="size",
            found=limit,
            allowed=f"about {np.sqrt(area / (_MIN_AREA * MAX_TRIANGLES)):.3g} or more",
        )
    while True:
        # Side k of a triangle runs from corner k to k + 1; each side of the mesh counts once.
        pairs = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1), axis=-1)
        ends, sides = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        sides = sides.reshape(-1, 3)
        lengths = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
        cut = lengths > limit
        if not cut.any():
            return points, cells.astype(np.int32)
        rank = np.empty(len(ends), np.int64)
        rank[np.argsort(lengths, kind="stable")] = np.arange(len(ends))
        first = rank[sides].argmax(axis=1)
        # A triangle of which any side is cut has its longest one cut, too.
        longest_sides = sides[np.arange(len(sides)), first]
        while True:
            to_cut = longest_sides[cut[sides].any(axis=1)]
            if cut[to_cut].all():
                break
            cut[to_cut] = True
        middle = np.full(len(ends), -1, np.int64)
        middle[cut] = len(points) + np.arange(int(cut.sum()))
        points = np.concatenate([points, points[ends[cut]].mean(axis=1)])
        cells = _bisected(cells, middle[sides], first)


def _bisected(cells: Ints, middle: Ints, first: Ints) -> Ints:
    """Return triangles cut at the `middle` points of sides (−1: none), at side `first` first.

    `cells` and `middle` are (m, 3), `first` is (m,). Triangles without a cut come first.
    """
    turn = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(cells, turn, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, turn, axis=1).T
    uncut = ab < 0
    pieces = [cells[uncut]]
    for (x, y, z), xy in (((b, c, ab), bc), ((c, a, ab), ca)):
        cut_once, cut_twice = ~uncut & (xy < 0), ~uncut & (xy >= 0)
        pieces += [
            np.stack([x, y, z], axis=1)[cut_once],
            np.stack([x, xy, z], axis=1)[cut_twice],
            np.stack([xy, y, z], axis=1)[cut_twice],
        ]
    return np.concatenate(pieces)
