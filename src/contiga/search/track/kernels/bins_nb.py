"""Rows in the order of their elements: what lanes are handed of them, and what these find.

Rows of one element lie anywhere among the points. What is read of each is put in one record, a line
of the memory, in one pass from end to end, and what is found is taken out of these in another. The
lanes take the records in the order of the elements, and ask for those of the next block while they
work on one: nothing else goes through the memory at random.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import BRANCH_EVENT, FACE, OK, TO_SEARCH
from contiga.elements.kernels.element_nb import span, spans_a_length
from contiga.jit import inlined, inner
from contiga.jit.prefetch import LINE, prefetch
from contiga.search.track.kernels.lanes_nb import (
    FLAG,
    FOOT,
    GAP,
    LANES,
    NORMAL,
    PATCH,
    PLACE,
    PROVED,
    ROW_BEFORE,
    ROW_NOW,
    ROW_START,
)
from contiga.search.track.track_records import FeetBefore

AHEAD = 16
"""Rows that are asked for before they are come to."""
NEAR_PATCHES = 100
"""Patches above which what is read of them does not stay near."""


@inner(linked=False)
def order_rows(element, counts):
    """Rows in the order of their elements, and blocks (n, 3) of these: element, first, one past the
    last, LANES rows at most.

    Rows of element -1 are left out; `counts` (elements,) are how many rows each has, and become
    where each element's rows end.
    """
    n_elements, total, n_blocks = counts.shape[0], 0, 0
    for e in range(n_elements):
        here = counts[e]
        counts[e] = total
        total += here
        n_blocks += (here + LANES - 1) // LANES
    order = np.empty(total, np.int32)
    n = element.shape[0]
    for i in range(n):
        if i + AHEAD < n:
            soon = element[i + AHEAD]
            if soon >= 0:
                prefetch(order, counts[soon], 0)
        e = element[i]
        if e >= 0:
            order[counts[e]] = i
            counts[e] += 1
    blocks = np.empty((n_blocks, 3), np.int64)
    b, start = 0, 0
    for e in range(n_elements):
        for first in range(start, counts[e], LANES):
            blocks[b, 0] = e
            blocks[b, 1] = first
            blocks[b, 2] = min(first + LANES, counts[e])
            b += 1
        start = counts[e]
    return order, blocks


@inlined()
def _where_it_was(there, feet, k):
    """Return the position of point k before the step, given or from its foot; NaN if unknown.

    `feet` are `FeetBefore`. A tracked foot held at a border has the surface's own normal, which
    does not lead to the point.
    """
    status, foot, gap, normal = feet.status, feet.point, feet.gap, feet.normal
    if gap.shape[0] == 0:
        return there[k, 0], there[k, 1], there[k, 2]
    if status[k] != OK and status[k] != BRANCH_EVENT:
        return math.nan, math.nan, math.nan
    return (
        foot[k, 0] + gap[k] * normal[k, 0],
        foot[k, 1] + gap[k] * normal[k, 1],
        foot[k, 2] + gap[k] * normal[k, 2],
    )


@inlined()
def _of_chunk(feet, first, last):
    """Return the previous places of the rows of a chunk, out of its record.

    Within a loop each would be looked for there.
    """
    rows = feet.gap.shape[0]
    a, b = min(first, rows), min(last, rows)
    return FeetBefore(feet.status[a:b], feet.point[a:b], feet.gap[a:b], feet.normal[a:b])


@inner(linked=False)
def hand_rows(tables, path, starts, chunk, records):
    """Write what lanes are handed of the rows of a `Chunk` into `records`.

    Returns the element of each, -1 where it has no foot to start from, and how many rows each
    element has. The rest as of `track_lanes`.
    """
    first, last = chunk.first, chunk.last
    n = last - first
    there, points = path.before[first:last], path.now[first:last]
    feet = _of_chunk(path.feet, first, last)
    patch, uv = starts.patch[first:last], starts.uv[first:last]
    proves = tells(path)
    patches, breaks = tables.grid.patches, tables.grid.breaks
    element = np.empty(n, np.int32)
    counts = np.zeros(tables.elements.table.shape[0], np.int64)
    home, start, u0, u1, v0, v1 = np.int32(-1), 0, 0, 0, 0, 0
    in_u = in_v = 0.0
    many = patches.shape[0] > NEAR_PATCHES
    for i in range(n):
        if i + AHEAD < n:
            prefetch(patches, patch[i + AHEAD], 0)
            soon = patch[i + AHEAD // 2]
            if many and soon >= 0:
                prefetch(counts, patches[soon]["first"], 0)
                prefetch(breaks, patches[soon]["u"][0], 0)
                prefetch(breaks, patches[soon]["v"][0], 0)
        if patch[i] < 0:
            element[i] = -1
            records[i, FLAG] = TO_SEARCH
            continue
        if patch[i] != home:
            home = patch[i]
            row = patches[home]
            start, u0, u1, v0, v1 = row["first"], row["u"][0], row["u"][1], row["v"][0], row["v"][1]
            in_u, in_v = spans_a_length(breaks, u0, u1), spans_a_length(breaks, v0, v1)
        u, v = span(breaks, u0, u1, in_u, uv[i, 0]), span(breaks, v0, v1, in_v, uv[i, 1])
        e = start + (u - u0) * (v1 - v0 - 1) + v - v0
        counts[e] += 1
        element[i] = e
        for c in range(3):
            records[i, ROW_NOW + c] = points[i, c]
        if proves:
            x, y, z = _where_it_was(there, feet, i)
            records[i, ROW_BEFORE] = x
            records[i, ROW_BEFORE + 1] = y
            records[i, ROW_BEFORE + 2] = z
        for c in range(2):
            records[i, ROW_START + c] = uv[i, c]
    return element, counts


@inner()
def tells(path):
    """Return whether `path` tells where points were."""
    return path.before.shape[0] > 0 or path.feet.gap.shape[0] > 0


@inner()
def ask_for(records, order, first, last, offset):
    """Ask for a line of the memory of each record of the rows order[first:last]."""
    for i in range(first, min(last, order.shape[0])):
        prefetch(records, order[i], offset)


@inner(linked=False)
def fetch_rows(records, path, starts, chunk, left, m, out):
    """Write the results of the rows of a chunk into `out`.

    Rows that are left to do go behind the first m of `left`; returns how many these are then.

    Left are those that are flagged, or not proved though it is told where they were. Each row is
    read before it is written, so `out` may be what was started from.
    """
    first, last = chunk.first, chunk.last
    there, feet = path.before[first:last], _of_chunk(path.feet, first, last)
    last_patch, last_uv = starts.patch[first:last], starts.uv[first:last]
    proves = tells(path)
    patch, gap, feature = out.patch[first:last], out.gap[first:last], out.feature[first:last]
    uv, point, normal = out.uv[first:last], out.point[first:last], out.normal[first:last]
    status, certified = out.status[first:last], out.certified[first:last]
    rows, flags, was, home, place = left.rows, left.flags, left.before, left.patch, left.uv
    for i in range(last - first):
        prefetch(records, i + AHEAD, 0)
        prefetch(records, i + AHEAD, LINE)
        flag, proved = int(records[i, FLAG]), int(records[i, PROVED])
        if flag != 0 or (proves and proved == 0):
            rows[m], flags[m] = first + i, flag
            home[m] = last_patch[i]
            for c in range(2):
                place[m, c] = last_uv[i, c]
            if proves:
                was[m, 0], was[m, 1], was[m, 2] = _where_it_was(there, feet, i)
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
