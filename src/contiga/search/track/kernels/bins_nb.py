"""Rows in the order of their elements: the input and the results of lanes.

Rows of one element lie anywhere among the points. One pass over all rows copies the input of each
to a record, one cache line, and another pass copies the results from the records. The lanes process
the records in the order of the elements, and prefetch the next block while they work on one: no
other data is accessed at random.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import BRANCH_EVENT, FACE, OK, TO_SEARCH
from contiga.elements.kernels.element_nb import span, span_density
from contiga.jit import inlined, inner
from contiga.jit.prefetch import LINE, prefetch
from contiga.search.track.kernels.lanes_nb import (
    FLAG,
    FOOT,
    GAP,
    N_LANES,
    NORMAL,
    PATCH,
    PLACE,
    PROVED,
    ROW_BEFORE,
    ROW_NOW,
    ROW_START,
)
from contiga.search.track.track_records import FeetBefore

PREFETCH_ROWS = 16
"""Number of rows by which prefetches run ahead."""
MAX_CACHED_PATCHES = 100
"""Number of patches above which their tables do not stay in the cache."""


@inner(linked=False)
def order_rows(element, counts):
    """Return the rows in the order of their elements, and blocks (n, 3) of at most N_LANES rows.

    A block is (element, first, end): order[first:end] are rows of that element. Rows of element −1
    are left out. `counts` (elements,) are the numbers of rows of each element, and become the ends
    of its rows in the order.
    """
    n_elements, total, n_blocks = counts.shape[0], 0, 0
    for e in range(n_elements):
        count = counts[e]
        counts[e] = total
        total += count
        n_blocks += (count + N_LANES - 1) // N_LANES
    order = np.empty(total, np.int32)
    n = element.shape[0]
    for i in range(n):
        if i + PREFETCH_ROWS < n:
            upcoming = element[i + PREFETCH_ROWS]
            if upcoming >= 0:
                prefetch(order, counts[upcoming], 0)
        e = element[i]
        if e >= 0:
            order[counts[e]] = i
            counts[e] += 1
    blocks = np.empty((n_blocks, 3), np.int64)
    b, start = 0, 0
    for e in range(n_elements):
        for first in range(start, counts[e], N_LANES):
            blocks[b, 0] = e
            blocks[b, 1] = first
            blocks[b, 2] = min(first + N_LANES, counts[e])
            b += 1
        start = counts[e]
    return order, blocks


@inlined()
def _previous_point(previous_points, feet, k):
    """Return the previous position (x, y, z) of point k, given or from its foot; NaN if unknown.

    `feet` are `FeetBefore`; if they have no rows, the point is in `previous_points`. A tracked foot
    held at a border keeps the surface normal, which does not lead to the point: only feet with the
    status OK or BRANCH_EVENT count.
    """
    status, foot, gap, normal = feet.status, feet.point, feet.gap, feet.normal
    if gap.shape[0] == 0:
        return previous_points[k, 0], previous_points[k, 1], previous_points[k, 2]
    if status[k] != OK and status[k] != BRANCH_EVENT:
        return math.nan, math.nan, math.nan
    return (
        foot[k, 0] + gap[k] * normal[k, 0],
        foot[k, 1] + gap[k] * normal[k, 1],
        foot[k, 2] + gap[k] * normal[k, 2],
    )


@inlined()
def _feet_of_chunk(feet, first, last):
    """Return the previous feet of the rows of a chunk as `FeetBefore`, without rows if not given.

    They are taken out of the record once, not in every pass of a loop.
    """
    rows = feet.gap.shape[0]
    a, b = min(first, rows), min(last, rows)
    return FeetBefore(feet.status[a:b], feet.point[a:b], feet.gap[a:b], feet.normal[a:b])


@inner(linked=False)
def fill_records(tables, path, starts, chunk, records):
    """Write the input of lanes for the rows of a `Chunk` to `records`.

    Returns the element of each row, −1 if it has no foot to start from (then its flag in `records`
    is TO_SEARCH), and the number of rows of each element. The other arguments are the same as for
    `track_lanes`.
    """
    first, last = chunk.first, chunk.last
    n = last - first
    previous_points, points = path.before[first:last], path.now[first:last]
    feet = _feet_of_chunk(path.feet, first, last)
    patch, uv = starts.patch[first:last], starts.uv[first:last]
    proves = has_previous(path)
    patches, breaks = tables.grid.patches, tables.grid.breaks
    element = np.empty(n, np.int32)
    counts = np.zeros(tables.elements.table.shape[0], np.int64)
    current_patch, start, u0, u1, v0, v1 = np.int32(-1), 0, 0, 0, 0, 0
    in_u = in_v = 0.0
    has_many_patches = patches.shape[0] > MAX_CACHED_PATCHES
    for i in range(n):
        if i + PREFETCH_ROWS < n:
            prefetch(patches, patch[i + PREFETCH_ROWS], 0)
            upcoming = patch[i + PREFETCH_ROWS // 2]
            if has_many_patches and upcoming >= 0:
                prefetch(counts, patches[upcoming]["first"], 0)
                prefetch(breaks, patches[upcoming]["u"][0], 0)
                prefetch(breaks, patches[upcoming]["v"][0], 0)
        if patch[i] < 0:
            element[i] = -1
            records[i, FLAG] = TO_SEARCH
            continue
        if patch[i] != current_patch:
            current_patch = patch[i]
            row = patches[current_patch]
            start, u0, u1, v0, v1 = row["first"], row["u"][0], row["u"][1], row["v"][0], row["v"][1]
            in_u, in_v = span_density(breaks, u0, u1), span_density(breaks, v0, v1)
        u, v = span(breaks, u0, u1, in_u, uv[i, 0]), span(breaks, v0, v1, in_v, uv[i, 1])
        e = start + (u - u0) * (v1 - v0 - 1) + v - v0
        counts[e] += 1
        element[i] = e
        for c in range(3):
            records[i, ROW_NOW + c] = points[i, c]
        if proves:
            x, y, z = _previous_point(previous_points, feet, i)
            records[i, ROW_BEFORE] = x
            records[i, ROW_BEFORE + 1] = y
            records[i, ROW_BEFORE + 2] = z
        for c in range(2):
            records[i, ROW_START + c] = uv[i, c]
    return element, counts


@inner()
def has_previous(path):
    """Return whether the previous points of `path` are known."""
    return path.before.shape[0] > 0 or path.feet.gap.shape[0] > 0


@inner()
def prefetch_rows(records, order, first, last, offset):
    """Prefetch a cache line of each record of the rows order[first:last]."""
    for i in range(first, min(last, order.shape[0])):
        prefetch(records, order[i], offset)


@inner(linked=False)
def collect_rows(records, path, starts, chunk, pending, m, out):
    """Write the results of the rows of a chunk to `out`; list unfinished rows in `pending`.

    Unfinished rows are flagged, or unproved although the previous points are known; flagged rows
    are not written to `out`. Unfinished rows go behind the first m of `pending`; their new number
    is returned. Each row is read before it is written, so that `out` may contain the starts.
    """
    first, last = chunk.first, chunk.last
    previous_points, feet = path.before[first:last], _feet_of_chunk(path.feet, first, last)
    last_patch, last_uv = starts.patch[first:last], starts.uv[first:last]
    proves = has_previous(path)
    patch, gap, feature = out.patch[first:last], out.gap[first:last], out.feature[first:last]
    uv, point, normal = out.uv[first:last], out.point[first:last], out.normal[first:last]
    status, certified = out.status[first:last], out.certified[first:last]
    rows, flags, previous, current_patch, place = (
        pending.rows,
        pending.flags,
        pending.before,
        pending.patch,
        pending.uv,
    )
    for i in range(last - first):
        prefetch(records, i + PREFETCH_ROWS, 0)
        prefetch(records, i + PREFETCH_ROWS, LINE)
        flag, proved = int(records[i, FLAG]), int(records[i, PROVED])
        if flag != 0 or (proves and proved == 0):
            rows[m], flags[m] = first + i, flag
            current_patch[m] = last_patch[i]
            for c in range(2):
                place[m, c] = last_uv[i, c]
            if proves:
                previous[m, 0], previous[m, 1], previous[m, 2] = _previous_point(
                    previous_points, feet, i
                )
            m += 1
        if flag != 0:
            continue
        patch[i] = int(records[i, PATCH])
        for c in range(2):
            uv[i, c] = records[i, PLACE + c]
        gap[i] = records[i, GAP]
        for c in range(3):
            point[i, c] = records[i, FOOT + c]
            normal[i, c] = records[i, NORMAL + c]
        feature[i] = FACE
        status[i] = OK
        certified[i] = proved
    return m
