"""Tracking whole: chunks of points, each from binning to the certificates of its feet.

All that a chunk reads and writes stays in the cache of the core that has it, a thread takes the
next chunk where one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.num.codes import BRANCH_EVENT, MAX_ITERATIONS, OK
from contiga.num.jit import inner, kernel
from contiga.search.kernels.branch_nb import FOLLOW, certify_rows
from contiga.search.kernels.follow_nb import EVENT, follow_rows
from contiga.search.kernels.lanes_nb import BY_ROW, LOST
from contiga.search.kernels.nearest_nb import project_global
from contiga.search.kernels.project_nb import project_tracked, track_lanes


@inner(linked=False)
def _where_they_were(path, first, last):
    """Points first … last before the step; no rows where that is not told.

    Told by the feet they had: a tracked foot held at a border has the surface's own normal, which
    does not lead to the point.
    """
    before, _, feet = path
    if feet.gap.shape[0] == 0:
        return before[first:last]
    own = np.empty((last - first, 3))
    for i in range(last - first):
        k = first + i
        told = feet.status[k] == OK or feet.status[k] == BRANCH_EVENT
        for c in range(3):
            own[i, c] = math.nan
            if told:
                own[i, c] = feet.point[k, c] + feet.gap[k] * feet.normal[k, c]
    return own


@inner(linked=False)
def _rows_with(flags, flag):
    """Rows that have the flag."""
    n = 0
    for own in flags:
        if own == flag:
            n += 1
    rows = np.empty(n, np.int32)
    n = 0
    for i in range(flags.shape[0]):
        if flags[i] == flag:
            rows[n] = i
            n += 1
    return rows


@inner(linked=False)
def _feet(tables, path, starts, records, results, first):
    """Feet of rows: in lanes, then by careful walks.

    Rows without a foot to start from are flagged LOST.
    """
    out, back = results
    track_lanes(tables, path, starts, records, results, first)
    project_tracked(tables, path[1], starts, _rows_with(back, BY_ROW), out, first)


@inner(linked=False)
def _closest(tables, points, rows, first, out):
    """Closest points of points[first + rows]."""
    n = rows.shape[0]
    for i in range(n):
        rows[i] += first
    project_global(tables, points, rows, np.full(n, math.inf), out, 0, n)


@inner(linked=False)
def _certificates(tables, path, starts, results, first):
    """Certificates of the feet; rows whose branch ends are flagged EVENT."""
    certify_rows(tables, path, starts, results, first)
    follow_rows(tables, path, starts, _rows_with(results[1], FOLLOW), results, first)


@kernel()
def track_chunks(tables, path, starts, size, records, results, start, stop):
    """Track the chunks start … stop of `size` points each.

    `path` is (points before, points now, their feet before): either the first or the last has no
    rows, and neither has any where nothing is to be certified. `starts` are (patch, uv), `records`
    what the lanes of a chunk work in (see `track_lanes`), `results` (projection, flags); flags are
    zeros. The projection may be the one that was started from: each chunk takes what it needs of
    that before it writes.
    """
    points = path[1]
    patch, uv = starts
    out, back = results
    for c in range(start, stop):
        first, last = c * size, min((c + 1) * size, points.shape[0])
        before = _where_they_were(path, first, last)
        own_path = (before, points[first:last])
        own_starts = (patch[first:last].copy(), uv[first:last].copy())
        own = (out, back[first:last])
        out.certified[first:last] = 0
        _feet(tables, own_path, own_starts, records, own, first)
        _closest(tables, points, _rows_with(own[1], LOST), first, out)
        if before.shape[0] == 0:
            continue
        _certificates(tables, own_path, own_starts, own, first)
        ended = _rows_with(own[1], EVENT)
        _closest(tables, points, ended, first, out)
        for k in ended:
            if out.status[k] != MAX_ITERATIONS:
                out.status[k] = BRANCH_EVENT
