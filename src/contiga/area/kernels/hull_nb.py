"""Convex hull by Jarvis' march (Inf. Proc. Letters 2, 1973)."""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel


@inner()
def _distance2(p, a, b):
    return (p[b, 0] - p[a, 0]) ** 2 + (p[b, 1] - p[a, 1]) ** 2


@kernel()
def jarvis(p):
    """Return the rows (k,) of p (n, 2) at the corners of its hull, anticlockwise.

    The first is the leftmost. Of several leftmost points it is the lowest. One point gives one
    corner, points on a line the two ends; duplicates and points on a side are left out.
    """
    n = p.shape[0]
    corners = np.empty(n, np.int64)
    if n == 0:
        return corners
    start = 0
    for i in range(1, n):
        if p[i, 0] < p[start, 0] or (p[i, 0] == p[start, 0] and p[i, 1] < p[start, 1]):
            start = i
    count = 0
    last = start
    while count < n:
        corners[count] = last
        count += 1
        end = -1
        for i in range(n):
            if _distance2(p, last, i) == 0.0:
                continue
            if end < 0:
                end = i
                continue
            # Twice the signed area of the triangle last, end, i: positive counter-clockwise.
            turn = (p[end, 0] - p[last, 0]) * (p[i, 1] - p[last, 1]) - (p[end, 1] - p[last, 1]) * (
                p[i, 0] - p[last, 0]
            )
            if turn < 0.0 or (turn == 0.0 and _distance2(p, last, i) > _distance2(p, last, end)):
                end = i
        if end < 0 or _distance2(p, end, start) == 0.0:
            break
        last = end
    return corners[:count].copy()
