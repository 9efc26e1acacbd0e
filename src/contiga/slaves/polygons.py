"""Polygons of more than four corners, split into triangles by cutting ears.

An ear is a corner that turns the polygon's way and has no other corner in its triangle; a polygon
that does not cross itself always has one (Meisters, Polygons have ears, 1975).
"""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray

Triangle = tuple[int, int, int]


def split_polygon(points: FloatArray) -> list[Triangle]:
    """Return the triangles of a polygon, in its sense: each time its first ear is cut off.

    Parameters
    ----------
    points : (k, 3), length, k ≥ 3, in turn; nearly in a plane

    Returns
    -------
    k − 2 triples of 0 … k − 1, the lowest first; a remaining polygon without an ear becomes a fan

    >>> split_polygon(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0]]))
    [(1, 2, 3), (0, 1, 3), (0, 3, 4)]
    """
    # (k, 2) in the plane of the mean normal (Newell), counter-clockwise
    centred = points - points.mean(axis=0)
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flat = centred[:, [(axis + 1) % 3, (axis + 2) % 3]]
    if normal[axis] < 0.0:
        flat = flat[:, ::-1]
    corners = list(range(len(points)))
    triangles: list[Triangle] = []
    while len(corners) > 3:
        ear = next((i for i in range(len(corners)) if _is_ear(flat, corners, i)), None)
        if ear is None:
            break
        a, b, c = corners[ear - 1], corners[ear], corners[(ear + 1) % len(corners)]
        # the lowest corner first, so that an ear does not depend on the order of the search
        turn = min(range(3), key=(a, b, c).__getitem__)
        triangles.append(((a, b, c), (b, c, a), (c, a, b))[turn])
        del corners[ear]
    return triangles + [
        (corners[0], corners[i], corners[i + 1]) for i in range(1, len(corners) - 1)
    ]


def _is_ear(flat: FloatArray, corners: list[int], i: int) -> bool:
    """Return whether corner `i` is strictly convex, with no other corner in or on its triangle."""
    a, b, c = corners[i - 1], corners[i], corners[(i + 1) % len(corners)]
    if _signed_area(flat[a], flat[b], flat[c]) <= 0.0:
        return False
    return not any(
        _signed_area(flat[a], flat[b], p) >= 0.0
        and _signed_area(flat[b], flat[c], p) >= 0.0
        and _signed_area(flat[c], flat[a], p) >= 0.0
        for p in (flat[k] for k in corners if k not in (a, b, c))
    )


def _signed_area(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Return twice the signed area of a triangle, positive counter-clockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
