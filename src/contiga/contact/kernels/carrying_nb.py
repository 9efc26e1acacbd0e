"""What is known of the points in contact before forces: one pass over them."""

from __future__ import annotations

import math

from contiga.jit import inner, kernel


@inner()
def way_of(path, k, c):
    """How far point k has gone along axis c; zero where that is not known."""
    now, before = path
    way = now[k, c] - before[k, c]
    return way if math.isfinite(way) else 0.0


@inner()
def at(rows, k, j):
    """Where row k stands in ascending `rows`, or would, from place j on.

    Asked of ascending rows one after the other, each going on from the last answer.
    """
    while j < rows.shape[0] and rows[j] < k:
        j += 1
    return j


@kernel(error_model="numpy")
def gather(rows, feet, path, last, velocity, dt, out):
    """Fill `out` = (depth, normal, foot, way, old, rate) for the points `rows`, ascending.

    `feet` are those of all points, `path` is (now, before). `last` is (patch, rows, penetration):
    of all points that of their last feet, and of some rows how deep they were. `velocity` (m, 3)
    has no rows where it is not known: then the rate is the change over the step `dt` of old
    contacts, and of new ones the speed of approach.
    """
    depth, normal, foot, way, old, rate = out
    patch, deep = last[0], (last[1], last[2])
    place = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        below = -feet.gap[k]
        depth[i] = 0.0 if below <= 0.0 else below
        old[i] = patch[k] >= 0
        speed = approach = 0.0
        for c in range(3):
            normal[i, c] = feet.normal[k, c]
            foot[i, c] = feet.point[k, c]
            way[i, c] = way_of(path, k, c)
            approach += way[i, c] * normal[i, c]
            if velocity.shape[0] > 0:
                speed += velocity[k, c] * normal[i, c]
        place = at(deep[0], k, place)
        there = place < deep[0].shape[0] and deep[0][place] == k
        if velocity.shape[0] > 0:
            rate[i] = -speed
        elif old[i]:
            rate[i] = (depth[i] - (deep[1][place] if there else 0.0)) / dt
        else:
            rate[i] = -approach / dt
