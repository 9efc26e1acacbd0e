"""Update what is known of points that have moved, and choose those to be looked at."""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.kernels.status_nb import FREE, NOT_FINITE
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.rigid.kernels.rigid_nb import to_body

BLOCK = 128
"""Points that are looked at together, first whether there is anything to be said of any."""


@inner(error_model="numpy")
def _left(distance, way):
    """Return what a way leaves of a distance, 0 at least; NaN where both are infinite."""
    rest = distance - way
    return 0.0 if rest <= 0.0 else rest


@inner()
def _take_back(columns, k):
    """Reset row k to that of a point without a foot.

    Most rows are in that state already, and are not written to.
    """
    if columns.patch[k] >= 0:
        columns.patch[k] = columns.feature[k] = -1
        columns.certified[k] = 0
    elif columns.last_patch[k] < 0:
        return
    columns.last_patch[k] = -1
    columns.uv[k, 0] = columns.uv[k, 1] = 0.0


@kernel(error_model="numpy")
def place(placing, size, start, stop):
    """Place the points of chunks start … stop of `size`, as `Placing` says."""
    counts = placing.counts
    # As numbers in a row: three axes would be looked at one by one.
    before, now = placing.before.reshape(-1), placing.now.reshape(-1)
    for c in range(start, stop):
        first, past = c * size, min((c + 1) * size, placing.active.shape[0])
        touching, free = _place(placing, before, now, first, past)
        counts[c, 0] = touching - first
        counts[c, 1] = free - first


@kernel(error_model="numpy")
def move_and_place(placing, p_W, pose, size, start, stop):
    """Do as `place` for points p_W (n, 3), world axes, that are not in body axes yet.

    `now` is filled in, chunk by chunk: its points are still near by when they are placed.
    """
    for c in range(start, stop):
        to_body(p_W, pose, placing.now, c * size, min((c + 1) * size, placing.active.shape[0]))
        place(placing, size, c, c + 1)


@inner(error_model="numpy")
def _place(placing, before, now, start, stop):
    """Place one chunk of points (3 n,); returns where its lists end."""
    last, columns, active = placing.last, placing.columns, placing.active
    touching = free = start
    ways = scratch(BLOCK)
    for first in range(start, stop, BLOCK):
        past = min(first + BLOCK, stop)
        both = before[3 * first : 3 * past], now[3 * first : 3 * past]
        _ways(both[0], both[1], placing.surface_way, ways)
        none = _are_none(last.patch[first:past], last.last_patch[first:past])
        none = none and _are_none(columns.patch[first:past], columns.last_patch[first:past])
        if none and _are_far(ways, last.safe_distance[first:past], active[first:past]):
            columns.status[first:past] = FREE
            distance, left = last.safe_distance[first:past], columns.safe_distance[first:past]
            _stay(ways, distance, left)
        else:
            for k in range(first, past):
                touching, free = _one(placing, k, ways[k - first], now, touching, free)
    return touching, free


@inner(error_model="numpy")
def _ways(before, now, surface_way, ways):
    """Compute the distances that points (3 n,) have moved, and the surface with them; infinite if
    one is not finite."""
    for k in range(now.shape[0] // 3):
        x, y = now[3 * k] - before[3 * k], now[3 * k + 1] - before[3 * k + 1]
        z = now[3 * k + 2] - before[3 * k + 2]
        way = math.sqrt(x * x + y * y + z * z) + surface_way
        ways[k] = way if way < math.inf else math.inf


@inner()
def _are_none(patch, near):
    """Tell whether no point has a patch, of a foot in contact or near by."""
    # The bits that whole numbers have in common are a number below zero where all of them are.
    common = np.int32(-1)
    for k in range(patch.shape[0]):
        common &= patch[k] & near[k]
    return common < 0


@inner(error_model="numpy")
def _are_far(ways, distance, active):
    """Tell whether all points take part and have gone less far than to where they could touch."""
    far = 0
    for k in range(distance.shape[0]):
        far += active[k] and abs(distance[k]) - ways[k] > 0.0
    return far == distance.shape[0]


@inner(error_model="numpy")
def _stay(ways, distance, left):
    """Reduce the safe distances of points that are far by their ways."""
    for k in range(distance.shape[0]):
        left[k] = math.copysign(abs(distance[k]) - ways[k], distance[k])


@inner(error_model="numpy")
def _one(placing, k, way, now, touching, free):
    """Place one point and list it if the search must look at it; returns where the lists end.

    `now` is (3 n,).
    """
    last, columns, rows = placing.last, placing.columns, placing.rows
    active, distance = placing.active[k], last.safe_distance[k]
    _take_back(columns, k)
    x, y, z = now[3 * k], now[3 * k + 1], now[3 * k + 2]
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        columns.status[k] = NOT_FINITE
        columns.safe_distance[k] = 0.0 if active else math.inf
        return touching, free
    columns.status[k] = FREE
    if last.patch[k] >= 0:
        columns.safe_distance[k] = _left(distance, way)
        rows[0, touching] = k
        touching += 1
        placing.way[k] = way
        placing.ignored[k] = distance < 0.0
    elif active:
        rest = _left(abs(distance), way)
        columns.safe_distance[k] = math.copysign(rest, distance)
        if last.last_patch[k] >= 0:
            columns.last_patch[k] = last.last_patch[k]
            columns.uv[k, 0] = last.uv[k, 0]
            columns.uv[k, 1] = last.uv[k, 1]
        if rest <= 0.0:
            rows[1, free] = k
            free += 1
            placing.way[k] = way
            placing.ignored[k] = distance < 0.0
    else:
        columns.safe_distance[k] = math.inf
    return touching, free


@kernel()
def held(first, second, detected, rows):
    """List the points in contact, ascending, in `rows`; returns how many there are.

    `first` and `second` are ascending lists of all points that have been looked at, `detected` is
    what was `Detected`: of those in contact parameters of the foot are written there, of those
    without a patch zeros.
    """
    feet, uv = detected.feet, detected.uv
    n = i = j = 0
    while i < first.shape[0] or j < second.shape[0]:
        if j == second.shape[0] or (i < first.shape[0] and first[i] < second[j]):
            k = first[i]
            i += 1
        else:
            k = second[j]
            j += 1
        if feet.patch[k] >= 0:
            uv[k, 0] = feet.uv[k, 0]
            uv[k, 1] = feet.uv[k, 1]
            rows[n] = k
            n += 1
        elif detected.last_patch[k] < 0:
            uv[k, 0] = uv[k, 1] = 0.0
    return n
