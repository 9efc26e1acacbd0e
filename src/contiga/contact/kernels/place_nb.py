"""Update the safe distances of moved points, and list the points that the search must examine."""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.kernels.status_nb import FREE, NOT_FINITE
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.rigid.kernels.rigid_nb import to_body

BLOCK = 128
"""Points that are tested together, whether all of them are out of reach."""


@inner(error_model="numpy")
def _remaining(distance, length):
    """Return a distance reduced by a path length, at least 0; NaN if both are infinite."""
    remaining = distance - length
    return 0.0 if remaining <= 0.0 else remaining


@kernel(error_model="numpy")
def place(placing, size, start, stop):
    """Place the points of chunks start … stop of `size`: see `PlacementArrays`."""
    counts = placing.counts
    # As flat arrays: the compiler then vectorises over all coordinates.
    before, now = placing.before.reshape(-1), placing.now.reshape(-1)
    for c in range(start, stop):
        first, past = c * size, min((c + 1) * size, placing.active.shape[0])
        touching, free = _place_chunk(placing, before, now, first, past)
        counts[c, 0] = touching - first
        counts[c, 1] = free - first


@kernel(error_model="numpy")
def move_and_place(placing, p_W, pose, size, start, stop):
    """Place points p_W (n, 3), world axes, as `place` does, after moving them to body axes.

    `now` is filled in chunk by chunk, so that its points are still in the cache when they are
    placed.
    """
    for c in range(start, stop):
        to_body(p_W, pose, placing.now, c * size, min((c + 1) * size, placing.active.shape[0]))
        place(placing, size, c, c + 1)


@inner(error_model="numpy")
def _place_chunk(placing, before, now, start, stop):
    """Place points start … stop of one chunk; return the ends of its two lists.

    `before` and `now` are all points (3 n,). Blocks of points out of reach are not listed: only
    their statuses and safe distances are written.
    """
    last, columns, active = placing.last, placing.columns, placing.active
    touching = free = start
    lengths = scratch(BLOCK)
    for first in range(start, stop, BLOCK):
        last_row = min(first + BLOCK, stop)
        both = before[3 * first : 3 * last_row], now[3 * first : 3 * last_row]
        _path_lengths(both[0], both[1], placing.surface_travel, lengths)
        no_feet = _have_no_feet(last.patch[first:last_row], last.last_patch[first:last_row])
        no_feet = no_feet and _have_no_feet(
            columns.patch[first:last_row], columns.last_patch[first:last_row]
        )
        if no_feet and _are_out_of_reach(
            lengths, last.safe_distance[first:last_row], active[first:last_row]
        ):
            columns.status[first:last_row] = FREE
            distance = last.safe_distance[first:last_row]
            new_distance = columns.safe_distance[first:last_row]
            for k in range(distance.shape[0]):
                new_distance[k] = math.copysign(abs(distance[k]) - lengths[k], distance[k])
        else:
            for k in range(first, last_row):
                touching, free = _place_point(placing, k, lengths[k - first], now, touching, free)
    return touching, free


@inner(error_model="numpy")
def _path_lengths(before, now, surface_travel, lengths):
    """Compute path lengths of points (3 n,) plus the surface's travel; infinite if not finite."""
    for k in range(now.shape[0] // 3):
        x, y = now[3 * k] - before[3 * k], now[3 * k + 1] - before[3 * k + 1]
        z = now[3 * k + 2] - before[3 * k + 2]
        length = math.sqrt(x * x + y * y + z * z) + surface_travel
        lengths[k] = length if length < math.inf else math.inf


@inner()
def _have_no_feet(patch, last_patch):
    """Return whether no point has a patch, of a foot in contact or of its last foot."""
    # The common bits of integers form a negative number if all of them are negative.
    common = np.int32(-1)
    for k in range(patch.shape[0]):
        common &= patch[k] & last_patch[k]
    return common < 0


@inner(error_model="numpy")
def _are_out_of_reach(lengths, distance, active):
    """Return whether all points take part and cannot have reached the surface."""
    n_far = 0
    for k in range(distance.shape[0]):
        n_far += active[k] and abs(distance[k]) - lengths[k] > 0.0
    return n_far == distance.shape[0]


@inner(error_model="numpy")
def _place_point(placing, k, length, now, touching, free):
    """Place one point, and list it if the search must examine it; return the ends of the lists.

    `now` is (3 n,). Points that are not finite, and free ones that do not take part, are not
    listed; free ones that do not take part have an infinite safe distance. Path lengths are written
    for listed points only.
    """
    last, columns, rows = placing.last, placing.columns, placing.rows
    active, distance = placing.active[k], last.safe_distance[k]
    # Reset the row to that of a point without a foot; most rows are so already, and not written.
    had_foot = columns.patch[k] >= 0
    if had_foot:
        columns.patch[k] = columns.feature[k] = -1
        columns.certified[k] = 0
    if had_foot or columns.last_patch[k] >= 0:
        columns.last_patch[k] = -1
        columns.uv[k, 0] = columns.uv[k, 1] = 0.0
    x, y, z = now[3 * k], now[3 * k + 1], now[3 * k + 2]
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        columns.status[k] = NOT_FINITE
        columns.safe_distance[k] = 0.0 if active else math.inf
        return touching, free
    columns.status[k] = FREE
    if last.patch[k] >= 0:
        columns.safe_distance[k] = _remaining(distance, length)
        rows[0, touching] = k
        touching += 1
        placing.path_length[k] = length
        placing.inside_since_start[k] = distance < 0.0
    elif active:
        remaining = _remaining(abs(distance), length)
        columns.safe_distance[k] = math.copysign(remaining, distance)
        if last.last_patch[k] >= 0:
            columns.last_patch[k] = last.last_patch[k]
            columns.uv[k, 0] = last.uv[k, 0]
            columns.uv[k, 1] = last.uv[k, 1]
        if remaining <= 0.0:
            rows[1, free] = k
            free += 1
            placing.path_length[k] = length
            placing.inside_since_start[k] = distance < 0.0
    else:
        columns.safe_distance[k] = math.inf
    return touching, free


@kernel()
def list_touching(first, second, detected, rows):
    """List the points in contact, ascending, in `rows`; return their number.

    `first` and `second` are ascending lists of all examined points, `detected` is a `Detection`: it
    gets the parameters of feet in contact, and zeros for points without a patch.
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
