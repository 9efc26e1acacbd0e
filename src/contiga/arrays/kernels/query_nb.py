"""Kernels that searches of splines and of triangles share: blank rows, and the lengths of paths."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import NO_HIT, NOT_FINITE
from contiga.jit import inner, kernel

ROUNDING = 8.0 * 2.220446049250313e-16
"""Share of the coordinates and the body's size below which lengths are rounding."""

NOT_ALIKE = -2
"""In place of a patch: arrays of other rows than each other, or other columns than feet have."""


@kernel()
def highest_patch(patch, uv, point, normal, gap, feature, status, certified):
    """The highest patch that feet lie on, -1 where there is none, or NOT_ALIKE."""
    n = patch.shape[0]
    if uv.shape[0] != n or point.shape[0] != n or normal.shape[0] != n or gap.shape[0] != n:
        return NOT_ALIKE
    if feature.shape[0] != n or status.shape[0] != n or certified.shape[0] != n:
        return NOT_ALIKE
    if uv.shape[1] != 2 or point.shape[1] != 3 or normal.shape[1] != 3:
        return NOT_ALIKE
    highest = np.int32(-1)
    for i in range(n):
        highest = max(highest, patch[i])
    return highest


@inner()
def blank_foot(out, k, status):
    """Row k of `out` for a point without a foot."""
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
    """Row i of `out` for a path that enters nowhere."""
    out.patch[i] = -1
    out.fraction[i] = math.nan
    out.uv[i] = math.nan
    out.point[i] = math.nan
    out.status[i] = status


@inner()
def direction(p, q):
    """Length of p → q and its direction, without squares that vanish or overflow."""
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
    """Rounding error, a length, of distances measured along p → q past a body of this size."""
    most = 0.0
    for c in range(3):
        most = max(most, abs(p[c]), abs(q[c]))
    return ROUNDING * (most + size)


@inner()
def begin_path(out, i, p, q, size):
    """Blank row i of `out` for the path p → q: its length, its direction, its `slack_of`.

    The length is zero where there is nothing to look for; the row's status says why.
    """
    length, d = direction(p, q)
    if not (math.isfinite(p[0] + p[1] + p[2] + length) and math.isfinite(q[0] + q[1] + q[2])):
        blank_hit(out, i, NOT_FINITE)
        return 0.0, d, 0.0
    blank_hit(out, i, NO_HIT)
    return length, d, slack_of(p, q, size)
