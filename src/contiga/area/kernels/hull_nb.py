"""Convex hull by Jarvis' march (Inf. Proc. Letters 2, 1973)."""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel


@inner()
def _turn(p, a, b, c):
    return (p[b, 0] - p[a, 0]) * (p[c, 1] - p[a, 1]) - (p[b, 1] - p[a, 1]) * (p[c, 0] - p[a, 0])


@inner()
def _far(p, a, b):
    return (p[b, 0] - p[a, 0]) ** 2 + (p[b, 1] - p[a, 1]) ** 2


@kernel()
def jarvis(p):
    """Corners of the hull of p (n, 2), counter-clockwise from the lowest of the leftmost points.

    One point gives one corner, points on a line its two ends; duplicates and points on a side
    are left out.
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
    at = start
    while count < n:
        corners[count] = at
        count += 1
        end = -1
        for i in range(n):
            if _far(p, at, i) == 0.0:
                continue
            if end < 0:
                end = i
                continue
            turn = _turn(p, at, end, i)
            if turn < 0.0 or (turn == 0.0 and _far(p, at, i) > _far(p, at, end)):
                end = i
        if end < 0 or _far(p, end, start) == 0.0:
            break
        at = end
    return corners[:count].copy()
