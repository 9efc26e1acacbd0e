"""Rows in the order of their elements: what lanes are handed of them, and what these find.

Rows of one element lie anywhere among the points. What is read of each is put in its place among
those of its element in one pass through memory, and what is found is fetched from there in another:
the lanes go through both from end to end.
"""

from __future__ import annotations

import numpy as np

from contiga.elements.kernels.element_nb import locate
from contiga.num.codes import FACE, OK
from contiga.num.jit import inner
from contiga.num.prefetch import LINE, prefetch
from contiga.search.kernels.lanes_nb import (
    BY_ROW,
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

AHEAD = 16
"""Rows that are asked for before they are come to: 0.4 of the time with many elements."""


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
    """Places of rows in the order of the elements of their feet, and blocks of these.

    `feet` is (patch, uv); rows without one have place −1.
    """
    patch, uv = feet
    n = patch.shape[0]
    patches = tables.grid.patches
    element = np.empty(n, np.int32)
    places = np.zeros(tables.elements.table.shape[0], np.int64)
    for i in range(n):
        if i + AHEAD < n:
            prefetch(patches, patch[i + AHEAD], 0)
        e = np.int32(-1)
        if patch[i] >= 0:
            e = np.int32(locate(tables.grid, patch[i], uv[i, 0], uv[i, 1])[0])
            places[e] += 1
        element[i] = e
    starts = _first_places(places)
    for i in range(n):
        e = element[i]
        if e >= 0:
            element[i] = places[e]
            places[e] += 1
    return element, _blocks_of(starts)


@inner(linked=False)
def hand_rows(place, path, starts, handed):
    """What lanes are handed of rows; `path` is (points before, points now), `starts` (n, 2) uv."""
    before, points = path
    proves = before.shape[0] > 0
    n = place.shape[0]
    for i in range(n):
        if i + AHEAD < n:
            prefetch(handed, place[i + AHEAD], 0)
        at = place[i]
        if at < 0:
            continue
        for c in range(3):
            handed[at, ROW_NOW + c] = points[i, c]
        if proves:
            for c in range(3):
                handed[at, ROW_BEFORE + c] = before[i, c]
        for c in range(2):
            handed[at, ROW_START + c] = starts[i, c]


@inner(linked=False)
def fetch_rows(place, found, first, results):
    """What was found of rows, into `results` = (projection, from its row `first` on; flags)."""
    out, back = results
    n = place.shape[0]
    for i in range(n):
        if i + AHEAD < n:
            prefetch(found, place[i + AHEAD], 0)
            prefetch(found, place[i + AHEAD], LINE)
        at = place[i]
        if at < 0:
            continue
        flag = back[i] = int(found[at, FLAG])
        if flag == BY_ROW:
            continue
        k = first + i
        out.patch[k] = int(found[at, PATCH])
        for c in range(2):
            out.uv[k, c] = found[at, PLACE + c]
        out.gap[k] = found[at, GAP]
        for c in range(3):
            out.point[k, c] = found[at, FOOT + c]
            out.normal[k, c] = found[at, NORMAL + c]
        out.feature[k] = FACE
        out.status[k] = OK
        out.certified[k] = int(found[at, PROVED])
