"""The stages of tracking: each over the rows that the one before has left to it (`Left`).

Most rows are done by the first. All that a chunk of it reads and writes stays in the cache of the
core that has it, a thread takes the next chunk where one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import (
    BRANCH_EVENT,
    FACE,
    HAS_ENDED,
    MAX_ITERATIONS,
    NOT_FINITE,
    OK,
    TO_SEARCH,
    TO_WALK,
)
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.certify.kernels.bend_nb import principal
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


@inner()
def _is_minimum(h, gap):
    """Whether f bends up at a foot inside a face, where `h` holds the derivatives of S."""
    bends = principal(h)
    # On a pole curvatures are not seen.
    return not (bends.metric[2] > 0.0 and max(bends.inner * gap, -bends.outer * gap) > 1.0)


@inner(linked=False)
def _walk(tables, points, left, m, out):
    """Feet of the first m rows left that are TO_WALK, continued by careful walks.

    Rows whose walk comes to no minimum are flagged HAS_ENDED.
    """
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
        in_face = out.status[k] == OK and out.feature[k] == FACE
        if out.status[k] == MAX_ITERATIONS or (in_face and not _is_minimum(h, out.gap[k])):
            left.flags[j] = HAS_ENDED


@inner(linked=False)
def _search(tables, points, left, m, out):
    """Closest points of the first m rows left that are TO_SEARCH or whose minimum HAS_ENDED."""
    chosen, n = np.empty(m, np.int32), 0
    for j in range(m):
        if left.flags[j] == TO_SEARCH or left.flags[j] == HAS_ENDED:
            chosen[n] = left.rows[j]
            n += 1
    project_global(tables, points, chosen, np.full(n, math.inf), out, 0, n)
    for j in range(m):
        k = left.rows[j]
        if left.flags[j] == HAS_ENDED and out.status[k] != MAX_ITERATIONS:
            out.status[k] = BRANCH_EVENT


@kernel()
def continue_left(tables, points, left, m, out):
    """Feet of the first m rows left that have none yet: walked to, or searched for."""
    _walk(tables, points, left, m, out)
    _search(tables, points, left, m, out)
