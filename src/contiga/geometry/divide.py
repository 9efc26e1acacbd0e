"""Triangles cut until no side is longer than asked for, without hanging vertices.

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
_SLIM = 0.1
"""Area of a triangle that cutting ends with, in squares of the longest side, at least of most."""

Ints = NDArray[np.int64]


def divided(
    points: FloatArray, triangles: NDArray[np.integer], longest: float
) -> tuple[FloatArray, NDArray[np.int32]]:
    """Points and triangles with no side longer than `longest`; new points come behind, in order.

    Parameters
    ----------
    points : (n, 3)
    triangles : (m, 3) rows of points; those that share a side share its two points
    longest : length

    Raises
    ------
    InputError
        It is not positive, or would take more than 40 million triangles.

    >>> square = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> finer, cells = divided(np.array(square), np.array([[0, 1, 2], [0, 2, 3]]), 0.8)
    >>> finer[4:].tolist(), len(cells)
    ([[0.5, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]], 8)
    """
    limit = positive(longest, "size")
    cells = np.asarray(triangles, np.int64)
    _check_number(points, cells, limit)
    while True:
        ends, sides = _sides(cells)
        lengths = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
        cut = lengths > limit
        if not cut.any():
            return points, cells.astype(np.int32)
        rank = np.empty(len(ends), np.int64)
        rank[np.argsort(lengths, kind="stable")] = np.arange(len(ends))
        first = rank[sides].argmax(axis=1)
        _spread(cut, sides, first)
        middle = np.full(len(ends), -1, np.int64)
        middle[cut] = len(points) + np.arange(int(cut.sum()))
        points = np.concatenate([points, points[ends[cut]].mean(axis=1)])
        cells = _halved(cells, middle[sides], first)


def _check_number(points: FloatArray, cells: Ints, limit: float) -> None:
    a, b, c = (points[cells[:, k]] for k in range(3))
    area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
    if area / (_SLIM * limit) / limit + len(cells) > MAX_TRIANGLES:
        raise InputError(
            f"would take more than {MAX_TRIANGLES} triangles",
            where="size",
            found=limit,
            allowed=f"about {np.sqrt(area / (_SLIM * MAX_TRIANGLES)):.3g} or more",
        )


def _sides(cells: Ints) -> tuple[Ints, Ints]:
    """Return the ends (s, 2) of all sides, and the sides (m, 3) of triangles.

    Side k runs from corner k to k + 1.
    """
    both = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1), axis=-1).reshape(-1, 2)
    ends, sides = np.unique(both, axis=0, return_inverse=True)
    return ends, sides.reshape(-1, 3)


def _spread(cut: NDArray[np.bool_], sides: Ints, first: Ints) -> None:
    """Cut the longest side of every triangle of which a side is cut."""
    longest = sides[np.arange(len(sides)), first]
    while True:
        asked = longest[cut[sides].any(axis=1)]
        if cut[asked].all():
            return
        cut[asked] = True


def _halved(cells: Ints, middle: Ints, first: Ints) -> Ints:
    """Triangles cut at the middles of their sides, −1 where there is none; the longest first."""
    turn = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(cells, turn, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, turn, axis=1).T
    whole = ab < 0
    pieces = [cells[whole]]
    for (x, y, z), other in (((b, c, ab), bc), ((c, a, ab), ca)):
        plain, again = ~whole & (other < 0), ~whole & (other >= 0)
        pieces += [
            np.stack([x, y, z], axis=1)[plain],
            np.stack([x, other, z], axis=1)[again],
            np.stack([other, y, z], axis=1)[again],
        ]
    return np.concatenate(pieces)
