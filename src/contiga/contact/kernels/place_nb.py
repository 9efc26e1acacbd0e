"""What is known of points after they have moved, and which of them have to be looked at."""

from __future__ import annotations

import math

from contiga.contact.kernels.status_nb import FREE, NOT_FINITE
from contiga.num.jit import inner, kernel


@inner(error_model="numpy")
def _left(distance, way):
    """What of a distance is left after a way, 0 at least; NaN where both are infinite."""
    rest = distance - way
    return 0.0 if rest <= 0.0 else rest


@kernel(error_model="numpy")
def place(path, last, active, found, lists, size, start, stop):
    """Fill `found` for the points of chunks start … stop of `size`.

    `path` is (before, now), `last` (patch, uv, near, safe distance) of the last step, `found`
    (status, safe distance, near, uv, way, ignored) of this one, zeros where nothing is said.
    `lists` is (rows, counts): two (n,) lists that each chunk fills from its own place, of those in
    contact and of free ones that may have come to the surface, and (chunks, 2) how many it has
    listed. Of others, way and ignored are not told.
    """
    rows, counts = lists
    for c in range(start, stop):
        first, past = c * size, min((c + 1) * size, active.shape[0])
        touching, free = _place(path, last, active, found, rows, first, past)
        counts[c, 0] = touching - first
        counts[c, 1] = free - first


@inner(error_model="numpy")
def _place(path, last, active, found, rows, start, stop):
    """One chunk; returns where its lists end."""
    before, now = path
    patch, uv, near, distance = last
    status, safe_distance, found_near, found_uv, ways, ignored = found
    touching = free = start
    for k in range(start, stop):
        square = 0.0
        for c in range(3):
            d = now[k, c] - before[k, c]
            square += d * d
        way = math.sqrt(square)
        if not way < math.inf:
            way = math.inf
        found_near[k] = -1
        x, y, z = now[k]
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            status[k] = NOT_FINITE
            safe_distance[k] = 0.0 if active[k] else math.inf
            continue
        status[k] = FREE
        if patch[k] >= 0:
            safe_distance[k] = _left(distance[k], way)
            rows[0, touching] = k
            touching += 1
            ways[k] = way
            ignored[k] = distance[k] < 0.0
        elif active[k]:
            rest = _left(abs(distance[k]), way)
            safe_distance[k] = math.copysign(rest, distance[k])
            if near[k] >= 0:
                found_near[k] = near[k]
                found_uv[k, 0] = uv[k, 0]
                found_uv[k, 1] = uv[k, 1]
            if rest <= 0.0:
                rows[1, free] = k
                free += 1
                ways[k] = way
                ignored[k] = distance[k] < 0.0
        else:
            safe_distance[k] = math.inf
    return touching, free


@kernel()
def fill_in(patch, foot_uv, uv, start, stop):
    """Write the parameters of feet start … stop, where there is a patch, into `uv`."""
    for k in range(start, stop):
        if patch[k] >= 0:
            uv[k, 0] = foot_uv[k, 0]
            uv[k, 1] = foot_uv[k, 1]
