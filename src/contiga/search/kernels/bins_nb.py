"""Rows in the order of their elements: what lanes are handed of them, and what these find.

Rows of one element lie anywhere among the points. What is read of each is put in one record, a line
of the memory, in one pass from end to end, and what is found is taken out of these in another. The
lanes take the records in the order of the elements, and ask for those of the next block while they
work on one: nothing else goes through the memory at random.
"""

from __future__ import annotations

import numpy as np

from contiga.elements.kernels.element_nb import span, spans_a_length
from contiga.num.codes import FACE, OK
from contiga.num.jit import inner
from contiga.num.prefetch import prefetch
from contiga.search.kernels.lanes_nb import (
    FLAG,
    FOOT,
    GAP,
    LANES,
    LOST,
    NORMAL,
    PATCH,
    PLACE,
    PROVED,
    ROW_BEFORE,
    ROW_NOW,
    ROW_START,
)

AHEAD = 16
"""Rows that are asked for before they are come to."""


@inner()
def _first_places(counts):
    """Turn counts (elements,) into first places; returns where each element's bin starts."""
    n = counts.shape[0]
    start = np.empty(n + 1, np.int64)
    total = 0
    for e in range(n):
        start[e] = total
        here = counts[e]
        counts[e] = total
        total += here
    start[n] = total
    return start


@inner()
def _blocks_of(start):
    """Blocks of at most LANES rows of one element: (n, 3) element, first, one past the last."""
    count = start.shape[0] - 1
    n = 0
    for e in range(count):
        n += (start[e + 1] - start[e] + LANES - 1) // LANES
    blocks = np.empty((n, 3), np.int64)
    b = 0
    for e in range(count):
        for first in range(start[e], start[e + 1], LANES):
            blocks[b, 0] = e
            blocks[b, 1] = first
            blocks[b, 2] = min(first + LANES, start[e + 1])
            b += 1
    return blocks


@inner(linked=False)
def bin_rows(tables, feet):
    """Rows in the order of the elements of their feet, and blocks of these.

    `feet` is (patch, uv); rows without one are left out.
    """
    patch, uv = feet
    n = patch.shape[0]
    patches, breaks = tables.grid.patches, tables.grid.breaks
    element = np.empty(n, np.int32)
    places = np.zeros(tables.elements.table.shape[0], np.int64)
    home, first, u0, u1, v0, v1 = np.int32(-1), 0, 0, 0, 0, 0
    in_u = in_v = 0.0
    for i in range(n):
        if i + AHEAD < n:
            prefetch(patches, patch[i + AHEAD], 0)
        if patch[i] < 0:
            element[i] = -1
            continue
        if patch[i] != home:
            home = patch[i]
            row = patches[home]
            first, u0, u1, v0, v1 = row["first"], row["u"][0], row["u"][1], row["v"][0], row["v"][1]
            in_u, in_v = spans_a_length(breaks, u0, u1), spans_a_length(breaks, v0, v1)
        u, v = span(breaks, u0, u1, in_u, uv[i, 0]), span(breaks, v0, v1, in_v, uv[i, 1])
        e = first + (u - u0) * (v1 - v0 - 1) + v - v0
        places[e] += 1
        element[i] = e
    starts = _first_places(places)
    order = np.empty(starts[starts.shape[0] - 1], np.int32)
    for i in range(n):
        e = element[i]
        if e >= 0:
            order[places[e]] = i
            places[e] += 1
    return order, _blocks_of(starts)


@inner(linked=False)
def hand_rows(path, starts, records):
    """What lanes are handed of rows.

    `path` is (points before, points now), `starts` (patch, uv).
    """
    before, points = path
    patch, uv = starts
    proves = before.shape[0] > 0
    for i in range(patch.shape[0]):
        if patch[i] < 0:
            records[i, FLAG] = LOST
            continue
        for c in range(3):
            records[i, ROW_NOW + c] = points[i, c]
        if proves:
            for c in range(3):
                records[i, ROW_BEFORE + c] = before[i, c]
        for c in range(2):
            records[i, ROW_START + c] = uv[i, c]


@inner()
def ask_for(records, order, first, last, offset):
    """Ask for a line of the memory of each record of the rows order[first:last]."""
    for i in range(first, min(last, order.shape[0])):
        prefetch(records, order[i], offset)


@inner(linked=False)
def fetch_rows(records, n, first, results):
    """What was found of n rows, into `results` = (projection, from its row `first` on; flags)."""
    out, back = results
    last = first + n
    # Taken out of their record once: within the loop each would be looked for there.
    patch, gap, feature = out.patch[first:last], out.gap[first:last], out.feature[first:last]
    uv, point, normal = out.uv[first:last], out.point[first:last], out.normal[first:last]
    status, certified = out.status[first:last], out.certified[first:last]
    for i in range(n):
        flag = back[i] = int(records[i, FLAG])
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
        certified[i] = int(records[i, PROVED])
