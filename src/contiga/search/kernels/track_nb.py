"""Tracking whole: chunks of points, each from binning to the certificates of its feet.

All that a chunk reads and writes stays in the cache of the core that has it, a thread takes the
next chunk where one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.num.codes import BRANCH_EVENT, MAX_ITERATIONS
from contiga.num.jit import inner, kernel
from contiga.search.kernels.bins_nb import GO_ON
from contiga.search.kernels.branch_nb import certify_rows
from contiga.search.kernels.follow_nb import EVENT, follow_rows
from contiga.search.kernels.nearest_nb import project_global
from contiga.search.kernels.project_nb import project_tracked, track_lanes


@inner(linked=False)
def _feet(tables, path, starts, results, first, last):
    """Feet of points first … last: in lanes, in lanes of the next element, then one by one."""
    patch, _ = starts
    points = path[1]
    out, back = results
    track_lanes(tables, path, starts, 0, results, first, last)
    rows = np.empty(last - first, np.int32)
    lost = n = gone_on = 0
    for k in range(first, last):
        if back[k] == GO_ON:
            gone_on += 1
    if gone_on > 0:
        track_lanes(tables, path, starts, GO_ON, results, first, last)
    for k in range(first, last):
        if back[k] != 0:
            rows[n] = k
            n += 1
    project_tracked(tables, points, starts, rows, out, 0, n)
    for k in range(first, last):
        if patch[k] < 0:
            rows[lost] = k
            lost += 1
    _closest(tables, points, rows, lost, out)


@inner(linked=False)
def _closest(tables, points, rows, n, out):
    """Closest points of points[rows[:n]]."""
    project_global(tables, points, rows, np.full(n, math.inf), out, 0, n)


@inner(linked=False)
def _certificates(tables, path, starts, results, first, last):
    """Certificates of the feet of points[first:last]; where a branch ends the closest points."""
    before, points = path
    out, back = results
    certify_rows(tables, points, before, starts, results, first, last)
    rows = np.empty(last - first, np.int32)
    n = ended = 0
    for k in range(first, last):
        if back[k] != 0:
            rows[n] = k
            n += 1
    follow_rows(tables, path, starts, rows, results, 0, n)
    for k in range(first, last):
        if back[k] == EVENT:
            rows[ended] = k
            ended += 1
    _closest(tables, points, rows, ended, out)
    for i in range(ended):
        if out.status[rows[i]] != MAX_ITERATIONS:
            out.status[rows[i]] = BRANCH_EVENT


@kernel()
def track_chunks(tables, path, starts, size, results, start, stop):
    """Track the chunks start … stop of `size` points each.

    `path` is (points before, points now), the first without rows where nothing is to be certified,
    `starts` (patch, uv), `results` (projection, flags); flags are zeros.
    """
    before, points = path
    for c in range(start, stop):
        first, last = c * size, min((c + 1) * size, points.shape[0])
        _feet(tables, path, starts, results, first, last)
        if before.shape[0] > 0:
            _certificates(tables, path, starts, results, first, last)
