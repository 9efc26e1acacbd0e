"""What is known of points after they have moved, and which of them have to be looked at."""

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
    """What of a distance is left after a way, 0 at least; NaN where both are infinite."""
    rest = distance - way
    return 0.0 if rest <= 0.0 else rest


@inner()
def _take_back(near, uv, feet, k):
    """A row as it is of a point of which nothing is known; `feet` are (patch, feature, certified).

    Most rows are so already, and are not written to.
    """
    patch, feature, certified = feet
    if patch[k] >= 0:
        patch[k] = feature[k] = -1
        certified[k] = 0
    elif near[k] < 0:
        return
    near[k] = -1
    uv[k, 0] = uv[k, 1] = 0.0


@kernel(error_model="numpy")
def place(path, last, active, found, lists, size, start, stop):
    """Fill `found` for the points of chunks start … stop of `size`.

    `path` is (before, now), `last` (patch, uv, near, safe distance) of the last step, `found`
    (status, safe distance, near, uv, way, ignored, patch, feature, certified) of this one, where
    what is said of an earlier step is taken back: as in all states, parameters of points without a
    patch are zero. `lists` is (rows, counts): two (n,) lists that each chunk fills from its own
    place, of those in contact and of free ones that may have come to the surface, and (chunks, 2)
    how many it has listed. Of others, way and ignored are not told.
    """
    rows, counts = lists
    before, now = path
    # As numbers in a row: three axes would be looked at one by one.
    path = before.reshape(-1), now.reshape(-1)
    for c in range(start, stop):
        first, past = c * size, min((c + 1) * size, active.shape[0])
        touching, free = _place(path, last, active, found, rows, first, past)
        counts[c, 0] = touching - first
        counts[c, 1] = free - first


@kernel(error_model="numpy")
def move_and_place(path, last, active, found, lists, size, start, stop):
    """The same of points that are not in body axes yet: `path` is (before, now, p_W, X_WB).

    `now` is filled in, chunk by chunk: its points are still near by when they are placed.
    """
    before, now, p_W, pose = path
    for c in range(start, stop):
        to_body(p_W, pose, now, c * size, min((c + 1) * size, active.shape[0]))
        place((before, now), last, active, found, lists, size, c, c + 1)


@inner(error_model="numpy")
def _place(path, last, active, found, rows, start, stop):
    """One chunk; returns where its lists end."""
    before, now = path
    patch, _, near, distance = last
    status, safe_distance, found_near, found_patch = found[0], found[1], found[2], found[6]
    touching = free = start
    ways = scratch(BLOCK)
    for first in range(start, stop, BLOCK):
        past = min(first + BLOCK, stop)
        _ways(before[3 * first : 3 * past], now[3 * first : 3 * past], ways)
        none = _are_none(patch[first:past], near[first:past])
        none = none and _are_none(found_patch[first:past], found_near[first:past])
        if none and _are_far(ways, distance[first:past], active[first:past]):
            status[first:past] = FREE
            _stay(ways, distance[first:past], safe_distance[first:past])
        else:
            for k in range(first, past):
                way = ways[k - first]
                touching, free = _one(k, way, now, last, active, found, rows, touching, free)
    return touching, free


@inner(error_model="numpy")
def _ways(before, now, ways):
    """How far points (3 n,) have gone, infinite where that is not known."""
    for k in range(now.shape[0] // 3):
        x, y = now[3 * k] - before[3 * k], now[3 * k + 1] - before[3 * k + 1]
        z = now[3 * k + 2] - before[3 * k + 2]
        way = math.sqrt(x * x + y * y + z * z)
        ways[k] = way if way < math.inf else math.inf


@inner()
def _are_none(patch, near):
    """Whether no point has a patch, of a foot in contact or near by."""
    # The bits that whole numbers have in common are a number below zero where all of them are.
    common = np.int32(-1)
    for k in range(patch.shape[0]):
        common &= patch[k] & near[k]
    return common < 0


@inner(error_model="numpy")
def _are_far(ways, distance, active):
    """Whether all points take part and are farther than they have gone from where they touch."""
    far = 0
    for k in range(distance.shape[0]):
        far += active[k] and abs(distance[k]) - ways[k] > 0.0
    return far == distance.shape[0]


@inner(error_model="numpy")
def _stay(ways, distance, left):
    """What is left of the distances of points that are far."""
    for k in range(distance.shape[0]):
        left[k] = math.copysign(abs(distance[k]) - ways[k], distance[k])


@inner(error_model="numpy")
def _one(k, way, now, last, active, found, rows, touching, free):
    """One point, listed if it is to be looked at; returns where the lists end.

    `now` is (3 n,).
    """
    patch, uv, near, distance = last
    status, safe_distance, found_near, found_uv, ways, ignored = found[:6]
    _take_back(found_near, found_uv, found[6:], k)
    x, y, z = now[3 * k], now[3 * k + 1], now[3 * k + 2]
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        status[k] = NOT_FINITE
        safe_distance[k] = 0.0 if active[k] else math.inf
        return touching, free
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
def held(lists, patch, foot_uv, known, rows):
    """List the points in contact, ascending, in `rows`; returns how many there are.

    `lists` are two ascending ones of all points that have been looked at, `known` is (near, uv): of
    those in contact parameters of the foot are written there, of those without a patch zeros.
    """
    first, second = lists
    near, uv = known
    n = i = j = 0
    while i < first.shape[0] or j < second.shape[0]:
        if j == second.shape[0] or (i < first.shape[0] and first[i] < second[j]):
            k = first[i]
            i += 1
        else:
            k = second[j]
            j += 1
        if patch[k] >= 0:
            uv[k, 0] = foot_uv[k, 0]
            uv[k, 1] = foot_uv[k, 1]
            rows[n] = k
            n += 1
        elif near[k] < 0:
            uv[k, 0] = uv[k, 1] = 0.0
    return n


@kernel()
def largest(patch):
    """The largest of whole numbers, −1 of none."""
    most = -1
    for k in range(patch.shape[0]):
        most = max(most, patch[k])
    return most
