"""Polygons of more than four corners, split into triangles by cutting ears.

An ear is a corner that turns the polygon's way and has no other corner in its triangle; a polygon
that does not cross itself always has one (Meisters, Polygons have ears, 1975).
"""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray

Triangle = tuple[int, int, int]


def split_polygon(points: FloatArray) -> list[Triangle]:
    """Triangles of one polygon, in its sense.

    Parameters
    ----------
    points : (k, 3), length, k ≥ 3, in turn; nearly in a plane

    Returns
    -------
    k − 2 triples of 0 … k − 1; a fan of what is left where no ear is found

    >>> split_polygon(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0]]))
    [(1, 2, 3), (0, 1, 3), (0, 3, 4)]
    """
    flat = _in_plane(points)
    left = list(range(len(points)))
    triangles: list[Triangle] = []
    while len(left) > 3:
        place = next((i for i in range(len(left)) if _is_ear(flat, left, i)), None)
        if place is None:
            break
        triangles.append(_around(left, place))
        del left[place]
    return triangles + [(left[0], left[i], left[i + 1]) for i in range(1, len(left) - 1)]


def _in_plane(points: FloatArray) -> FloatArray:
    """Return (k, 2) across the mean normal (Newell), counter-clockwise."""
    away = points - points.mean(axis=0)
    normal = np.cross(away, np.roll(away, -1, axis=0)).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    first, second = (drop + 1) % 3, (drop + 2) % 3
    flat = away[:, [first, second]]
    return flat if normal[drop] >= 0.0 else flat[:, ::-1]


def _around(left: list[int], place: int) -> Triangle:
    a, b, c = left[place - 1], left[place], left[(place + 1) % len(left)]
    # Named from the lowest on, so that the same ear reads the same wherever it was found.
    turn = min(range(3), key=(a, b, c).__getitem__)
    return ((a, b, c), (b, c, a), (c, a, b))[turn]


def _is_ear(flat: FloatArray, left: list[int], place: int) -> bool:
    a, b, c = left[place - 1], left[place], left[(place + 1) % len(left)]
    if _turn(flat[a], flat[b], flat[c]) <= 0.0:
        return False
    others = (flat[i] for i in left if i not in (a, b, c))
    return not any(
        _turn(flat[a], flat[b], p) >= 0.0
        and _turn(flat[b], flat[c], p) >= 0.0
        and _turn(flat[c], flat[a], p) >= 0.0
        for p in others
    )


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
