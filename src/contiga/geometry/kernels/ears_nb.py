"""Triangles between polygons that cross themselves or each other: closed, if not beautiful.

Ears are cut off one by one (Meisters 1975); where none is left the vertex that turns most is cut
off, so that every side of the polygons is a side of exactly one triangle in any case.
"""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel


@kernel()
def one_ring(xy, starts):
    """All polygons as one ring of vertices: each is joined to the ring by a side there and back."""
    ring = np.empty(xy.shape[0] + 2 * (starts.size - 2), np.int64)
    n = starts[1]
    for i in range(n):
        ring[i] = i
    for p in range(1, starts.size - 1):
        a, b = starts[p], starts[p + 1]
        best, at, to = np.inf, 0, a
        for i in range(n):
            for j in range(a, b):
                apart = (xy[ring[i], 0] - xy[j, 0]) ** 2 + (xy[ring[i], 1] - xy[j, 1]) ** 2
                if apart < best:
                    best, at, to = apart, i, j
        more = b - a + 2
        for i in range(n - 1, at, -1):
            ring[i + more] = ring[i]
        for i in range(b - a + 1):
            ring[at + 1 + i] = a + (to - a + i) % (b - a)
        ring[at + more] = ring[at]
        n += more
    return ring


@inner()
def area2(xy, a, b, c):
    """Twice the signed area of abc."""
    return (xy[b, 0] - xy[a, 0]) * (xy[c, 1] - xy[a, 1]) - (xy[b, 1] - xy[a, 1]) * (
        xy[c, 0] - xy[a, 0]
    )


@inner()
def is_empty(xy, ring, after, start, corners):
    """Return whether no other vertex of the ring is in the triangle."""
    a, b, c = corners
    i = after[start]
    while i != start:
        v = ring[i]
        if (
            v != a
            and v != b
            and v != c
            and area2(xy, a, b, v) >= 0.0
            and area2(xy, b, c, v) >= 0.0
            and area2(xy, c, a, v) >= 0.0
        ):
            return False
        i = after[i]
    return True


@kernel()
def ears(xy, ring):
    """Return (n − 2, 3) triangles of a ring of n vertices that runs anticlockwise."""
    n = ring.size
    out = np.empty((max(n - 2, 0), 3), np.int64)
    before = np.arange(n) - 1
    before[0] = n - 1
    after = np.arange(n) + 1
    after[n - 1] = 0
    here, tried, best, most = 0, 0, 0, -np.inf
    for k in range(n - 2):
        tried, best, most = 0, here, -np.inf
        while True:
            corners = (ring[before[here]], ring[here], ring[after[here]])
            area = area2(xy, corners[0], corners[1], corners[2])
            if area > 0.0 and is_empty(xy, ring, after, here, corners):
                break
            if area > most:
                best, most = here, area
            tried += 1
            here = after[here]
            if tried > n - k:
                here = best
                break
        out[k, 0], out[k, 1], out[k, 2] = ring[before[here]], ring[here], ring[after[here]]
        after[before[here]] = after[here]
        before[after[here]] = before[here]
        here = before[here]
    return out
