"""Moments of the volume that triangles enclose: signed tetrahedra over them, in closed form."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def moments(corners: FloatArray) -> FloatArray:
    """Return the moments (10,) ∫ f dV inside of closed triangles (m, 3, 3) with outward normals.

    The functions f are 1, x, y, z, xx, yy, zz, xy, yz, xz, about the origin. For a tetrahedron with
    a corner in the origin, the others a, b, c, s = a + b + c and the volume V = a · (b × c) / 6
    (Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor, 2005): ∫ x = V s / 4 and
    ∫ x x = V (a a + b b + c c + s s) / 20.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    volume = (a * np.cross(b, c)).sum(axis=1) / 6.0
    s = a + b + c
    rows = [volume, *(volume[:, None] * s / 4.0).T]
    for i, j in _PAIRS:
        squares = s[:, i] * s[:, j] + (corners[:, :, i] * corners[:, :, j]).sum(axis=1)
        rows.append(volume * squares / 20.0)
    return np.array([row.sum() for row in rows])
