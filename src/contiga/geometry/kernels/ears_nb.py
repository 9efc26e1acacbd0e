"""Triangles between polygons that cross themselves or each other: closed, of any shape.

Ears are cut off one by one (Meisters 1975); if there is none, the vertex of the largest area is
cut off, so that every side of the polygons is a side of exactly one triangle in any case.
"""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel


@kernel()
def one_ring(xy, starts):
    """Return one ring, rows of `xy`, of all polygons, joined by sides that it runs along twice.

    Each polygon is joined to the ring so far by the shortest connection of vertices.
    """
    ring = np.empty(xy.shape[0] + 2 * (starts.size - 2), np.int64)
    n = starts[1]
    for i in range(n):
        ring[i] = i
    for p in range(1, starts.size - 1):
        a, b = starts[p], starts[p + 1]
        best, ring_row, start_vertex = np.inf, 0, a
        for i in range(n):
            for j in range(a, b):
                distance = (xy[ring[i], 0] - xy[j, 0]) ** 2 + (xy[ring[i], 1] - xy[j, 1]) ** 2
                if distance < best:
                    best, ring_row, start_vertex = distance, i, j
        n_added = b - a + 2
        for i in range(n - 1, ring_row, -1):
            ring[i + n_added] = ring[i]
        for i in range(b - a + 1):
            ring[ring_row + 1 + i] = a + (start_vertex - a + i) % (b - a)
        ring[ring_row + n_added] = ring[ring_row]
        n += n_added
    return ring


@inner()
def area2(xy, a, b, c):
    """Return twice the signed area of abc, positive anticlockwise."""
    return (xy[b, 0] - xy[a, 0]) * (xy[c, 1] - xy[a, 1]) - (xy[b, 1] - xy[a, 1]) * (
        xy[c, 0] - xy[a, 0]
    )


@inner()
def is_empty(xy, ring, after, start, corners):
    """Return whether no vertex of the ring other than the corners is in or on the triangle."""
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
    """Return (n − 2, 3) triangles, rows of `xy`, of a ring of n vertices that runs anticlockwise.

    The next ear is cut off each time; without one, the vertex with the largest signed area.
    """
    n = ring.size
    out = np.empty((max(n - 2, 0), 3), np.int64)
    before = np.arange(n) - 1
    before[0] = n - 1
    after = np.arange(n) + 1
    after[n - 1] = 0
    tip, n_tried, best, largest_area = 0, 0, 0, -np.inf
    for k in range(n - 2):
        n_tried, best, largest_area = 0, tip, -np.inf
        while True:
            corners = (ring[before[tip]], ring[tip], ring[after[tip]])
            area = area2(xy, corners[0], corners[1], corners[2])
            if area > 0.0 and is_empty(xy, ring, after, tip, corners):
                break
            if area > largest_area:
                best, largest_area = tip, area
            n_tried += 1
            tip = after[tip]
            if n_tried > n - k:
                tip = best
                break
        out[k, 0], out[k, 1], out[k, 2] = ring[before[tip]], ring[tip], ring[after[tip]]
        after[before[tip]] = after[tip]
        before[after[tip]] = before[tip]
        tip = before[tip]
    return out
