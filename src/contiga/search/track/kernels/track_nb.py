"""The stages of tracking: each over the rows that the one before has left to it (`Left`).

Most rows are done by the first. All that a chunk of it reads and writes stays in the cache of the
core that has it, a thread takes the next chunk where one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import (
    BRANCH_EVENT,
    HAS_ENDED,
    MAX_ITERATIONS,
    NOT_FINITE,
    TO_SEARCH,
    TO_WALK,
)
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.foot_nb import tracked_foot
from contiga.search.closest.kernels.nearest_nb import project_global
from contiga.search.track.kernels.project_nb import track_lanes
from contiga.search.track.track_records import Chunk


@kernel()
def track_chunks(tables, path, starts, size, records, left, out, chunks):
    """Track the chunks first … last = `chunks` of `size` points each in lanes.

    Returns how many rows are left, not proved or without a foot. The other arguments are those of
    `track_lanes`.
    """
    m = 0
    for c in range(chunks[0], chunks[1]):
        chunk = Chunk(c * size, min((c + 1) * size, path.now.shape[0]))
        m = track_lanes(tables, path, starts, chunk, records, left, m, out)
    return m


@inner(linked=False)
def _walk(tables, points, left, m, out):
    """Feet of the first m rows left that are TO_WALK, continued by careful walks."""
    h = scratch(4, 6)
    nearest = scratch(4)
    for j in range(m):
        if left.flags[j] != TO_WALK:
            continue
        k = left.rows[j]
        if not math.isfinite(points[k, 0] + points[k, 1] + points[k, 2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        point = (points[k, 0], points[k, 1], points[k, 2])
        foot = locate(tables.grid, left.patch[j], left.uv[j, 0], left.uv[j, 1])
        tracked_foot(tables, k, foot, point, out, nearest, h)


@inner(linked=False)
def _search(tables, points, left, m, flag, out):
    """Closest points of the first m rows left that have the flag; returns these."""
    chosen, n = np.empty(m, np.int32), 0
    for j in range(m):
        if left.flags[j] == flag:
            chosen[n] = left.rows[j]
            n += 1
    project_global(tables, points, chosen, np.full(n, math.inf), out, 0, n)
    return chosen[:n]


@kernel()
def continue_left(tables, points, left, m, out):
    """Feet of the first m rows left that have none yet: walked to, or searched for."""
    _walk(tables, points, left, m, out)
    _search(tables, points, left, m, TO_SEARCH, out)


@kernel()
def end_branches(tables, points, left, m, out):
    """Closest points of the first m rows left whose branch HAS_ENDED; they are BRANCH_EVENTs."""
    for k in _search(tables, points, left, m, HAS_ENDED, out):
        if out.status[k] != MAX_ITERATIONS:
            out.status[k] = BRANCH_EVENT
