"""Tracking whole: chunks of points, each from binning to the certificates of its feet.

All that a chunk reads and writes stays in the cache of the core that has it, a thread takes the
next chunk where one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel
from contiga.num.codes import BRANCH_EVENT, MAX_ITERATIONS
from contiga.search.kernels.bins_nb import tells
from contiga.search.kernels.branch_nb import certify_rows
from contiga.search.kernels.follow_nb import EVENT, follow_rows
from contiga.search.kernels.lanes_nb import LOST
from contiga.search.kernels.nearest_nb import project_global
from contiga.search.kernels.project_nb import project_tracked, track_lanes


@inner(linked=False)
def _closest(tables, points, rest, flag, out):
    """Closest points of the rows of `rest` that have the flag; returns these."""
    rows, flags = rest[0], rest[1]
    n = 0
    for own in flags:
        n += own == flag
    chosen = np.empty(n, np.int32)
    n = 0
    for j in range(rows.shape[0]):
        if flags[j] == flag:
            chosen[n] = rows[j]
            n += 1
    project_global(tables, points, chosen, np.full(n, math.inf), out, 0, n)
    return chosen


@kernel()
def track_chunks(tables, path, starts, size, records, out, start, stop):
    """Track the chunks start … stop of `size` points each: in lanes, then by careful walks.

    The arguments are those of `track_lanes`.
    """
    points = path[1]
    for c in range(start, stop):
        chunk = c * size, min((c + 1) * size, points.shape[0])
        rest = track_lanes(tables, path, starts, chunk, records, out)
        project_tracked(tables, points, rest, out)
        _closest(tables, points, rest, LOST, out)
        if not tells(path):
            continue
        certify_rows(tables, points, rest, out)
        follow_rows(tables, points, rest, out)
        for k in _closest(tables, points, rest, EVENT, out):
            if out.status[k] != MAX_ITERATIONS:
                out.status[k] = BRANCH_EVENT
