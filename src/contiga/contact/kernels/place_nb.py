"""What is known of points after they have moved, and which of them have to be looked at."""

from __future__ import annotations

import math

from contiga.num.jit import inner, kernel


@inner(error_model="numpy")
def _left(distance, way):
    """What of a distance is left after a way, 0 at least; NaN where both are infinite."""
    rest = distance - way
    return 0.0 if rest <= 0.0 else rest


@kernel(error_model="numpy")
def place(before, now, last, active, found, rows, kinds):
    """Fill `found` for all points; returns how many `rows` touched and how many are near.

    `last` is (patch, uv, near, safe distance) of the last step, `found` (status, safe distance,
    near, uv, way, ignored) of this one, zeros where nothing is said; `rows` are two (n,) lists to
    be filled: those in contact, and free ones that may have come to the surface; `kinds` are the
    statuses of points that are free and that are not finite.
    """
    patch, uv, near, distance = last
    status, safe_distance, found_near, found_uv, ways, ignored = found
    touching = free = 0
    for k in range(now.shape[0]):
        square = 0.0
        for c in range(3):
            d = now[k, c] - before[k, c]
            square += d * d
        way = math.sqrt(square)
        if not way < math.inf:
            way = math.inf
        ways[k] = way
        ignored[k] = distance[k] < 0.0
        found_near[k] = -1
        x, y, z = now[k]
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            status[k] = kinds[1]
            safe_distance[k] = 0.0 if active[k] else math.inf
            continue
        status[k] = kinds[0]
        if patch[k] >= 0:
            safe_distance[k] = _left(distance[k], way)
            rows[0, touching] = k
            touching += 1
        elif active[k]:
            rest = _left(abs(distance[k]), way)
            safe_distance[k] = math.copysign(rest, distance[k])
            found_near[k] = near[k]
            found_uv[k, 0] = uv[k, 0]
            found_uv[k, 1] = uv[k, 1]
            if rest <= 0.0:
                rows[1, free] = k
                free += 1
        else:
            safe_distance[k] = math.inf
    return touching, free
