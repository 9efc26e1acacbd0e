"""Blank rows and lengths of paths, for searches of splines and of triangles."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import NO_HIT, NOT_FINITE
from contiga.jit import inner, kernel

ROUNDING = 8.0 * 2.220446049250313e-16
"""Share of the coordinates and the body's size below which lengths are rounding."""

BAD_SHAPES = -2
"""Result in place of a patch: the arrays differ in rows, or have other columns than feet."""


@kernel()
def highest_patch(patch, uv, point, normal, gap, feature, status, certified):
    """Return the highest patch of feet (n rows in each array); −1 if there is none.

    It is BAD_SHAPES if the arrays differ in rows, or have not the columns of feet.
    """
    n = patch.shape[0]
    if uv.shape[0] != n or point.shape[0] != n or normal.shape[0] != n or gap.shape[0] != n:
        return BAD_SHAPES
    if feature.shape[0] != n or status.shape[0] != n or certified.shape[0] != n:
        return BAD_SHAPES
    if uv.shape[1] != 2 or point.shape[1] != 3 or normal.shape[1] != 3:
        return BAD_SHAPES
    highest = np.int32(-1)
    for i in range(n):
        highest = max(highest, patch[i])
    return highest


@inner()
def blank_foot(out, k, status):
    """Write row k of `out` for a point without a foot: NaN, −1, not certified, and `status`."""
    out.patch[k] = -1
    out.feature[k] = -1
    out.status[k] = status
    out.certified[k] = 0
    out.gap[k] = math.nan
    for c in range(3):
        out.point[k, c] = math.nan
        out.normal[k, c] = math.nan
    out.uv[k, 0] = math.nan
    out.uv[k, 1] = math.nan


@inner()
def blank_hit(out, i, status):
    """Write row i of `out` for a path without a crossing: NaN, patch −1, and `status`."""
    out.patch[i] = -1
    out.fraction[i] = math.nan
    out.uv[i] = math.nan
    out.point[i] = math.nan
    out.status[i] = status


@inner()
def direction(p, q):
    """Return the length of p → q and its unit vector, without underflow or overflow of squares.

    The vector is zero if p = q. If the difference is not finite, the length is infinite or NaN, and
    the vector zero or NaN.
    """
    d0 = q[0] - p[0]
    d1 = q[1] - p[1]
    d2 = q[2] - p[2]
    largest = max(abs(d0), abs(d1), abs(d2))
    if not (largest > 0.0 and math.isfinite(largest)):
        return largest, (0.0, 0.0, 0.0)
    d0 /= largest
    d1 /= largest
    d2 /= largest
    norm = math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    return largest * norm, (d0 / norm, d1 / norm, d2 / norm)


@inner()
def slack_of(p, q, size):
    """Return the rounding error, length, of distances along p → q near a body of this size."""
    largest = 0.0
    for c in range(3):
        largest = max(largest, abs(p[c]), abs(q[c]))
    return ROUNDING * (largest + size)


@inner()
def begin_path(out, i, p, q, size):
    """Blank row i of `out` for the path p → q; return its length, unit vector and `slack_of`.

    out.status becomes NO_HIT, or NOT_FINITE for a path that is not finite. The length is zero for
    such a path, and if p = q: there is nothing to search.
    """
    length, d = direction(p, q)
    if not (math.isfinite(p[0] + p[1] + p[2] + length) and math.isfinite(q[0] + q[1] + q[2])):
        blank_hit(out, i, NOT_FINITE)
        return 0.0, d, 0.0
    blank_hit(out, i, NO_HIT)
    return length, d, slack_of(p, q, size)
