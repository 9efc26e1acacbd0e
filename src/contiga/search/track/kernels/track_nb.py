"""Complete tracking: chunks of points in lanes, from binning to quick certificates; then the stages
for the other rows (`PendingRows`).

The lanes finish most rows. The data of a chunk stay in the cache of its core, a thread takes the
next chunk when one is done, and a few points cost one call.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import (
    BRANCH_EVENT,
    CUT,
    FACE,
    GENERAL,
    HAS_ENDED,
    MAX_ITERATIONS,
    NOT_FINITE,
    OK,
    OUT,
    RATIONAL_CUBIC,
    TO_SEARCH,
    TO_WALK,
)
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.block import SIZE
from contiga.jit.prefetch import LINE, prefetch
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.part_nb import N_PARTS
from contiga.search.closest.kernels.foot_nb import tracked_foot
from contiga.search.closest.kernels.local_nb import expand
from contiga.search.closest.kernels.nearest_nb import project_global
from contiga.search.closest.kernels.newton_nb import ACTIVE, DONE, LEFT, ROUNDS
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.track.kernels.bins_nb import (
    collect_rows,
    fill_records,
    has_previous,
    order_rows,
    prefetch_rows,
)
from contiga.search.track.kernels.lanes_nb import (
    BANK_WIDTH,
    ELEMENT_SIZE,
    FLAG,
    N_LANES,
    NEIGHBOURHOOD_SIZE,
    PROVED,
    ROW_S,
    ROW_STATE,
    ROW_T,
    ROWS,
    fill_element,
    finish_polynomial,
    finish_rational,
    lanes_in,
    load,
    load_neighbourhoods,
    new_lanes,
    newton_polynomial,
    newton_rational,
    prove_lanes,
    start_lanes,
    unload,
)
from contiga.search.track.kernels.mixed_lanes_nb import (
    MIN_ROWS,
    enqueue,
    enqueue_left,
    is_untrimmed_ball,
    new_queue,
    process_queue,
)
from contiga.search.track.track_records import Chunk

NEIGHBOURHOOD_LINES = N_PARTS * N_PARTS * NEIGHBOURHOOD_SIZE * SIZE // LINE
"""Cache lines of the neighbourhoods of an element's parts."""
POLE_RATIO = 1e-12
"""Ratio of |S_s|² and |S_t|² below which, near a pole, f consists of rounding."""
CURVATURE_TOL = 1e-12
"""Curvature of f that counts as zero; it is 1 far from focal points."""


@inner()
def _make_room(tables, proves, queue, waiting, records):
    """Process waiting rows until the queue has room; return the number of rows still waiting."""
    while waiting == N_LANES:
        waiting = process_queue(tables, proves, queue, waiting, records)
    return waiting


@inner()
def _prefetch_next(neighbourhoods, blocks, b, half):
    """Prefetch half of the neighbourhoods of the next block's element, if it is another one."""
    if b + 1 < blocks.shape[0] and blocks[b + 1, 0] != blocks[b, 0]:
        for line in range(half * NEIGHBOURHOOD_LINES // 2, (half + 1) * NEIGHBOURHOOD_LINES // 2):
            prefetch(neighbourhoods, blocks[b + 1, 0], line * LINE)


@kernel()
def track_lanes(tables, path, starts, chunk, records, pending, m, out):
    """Track the rows of a `Chunk` in lanes, each in the element of its start.

    `path` is a `Path`, `starts` are `SurfacePlaces`, `pending` is `PendingRows`, `records` is a
    work table with at least as many rows as the chunk. The feet go to `out`, which may contain the
    starts. Returns the number of pending rows, m of them from before: see `collect_rows`.

    A row without a start is flagged TO_SEARCH. A row is flagged TO_WALK if Newton's method does not
    converge, if its element or its foot is trimmed away, if the element's degree is too high, or if
    it leaves over a side that is not smooth, or leaves a second element. Feet are proved only if
    the previous points are known and the tables have neighbourhoods.
    """
    element_of, counts = fill_records(tables, path, starts, chunk, records)
    order, blocks = order_rows(element_of, counts)
    proves = has_previous(path) and tables.neighbourhoods.shape[0] > 0
    elements = tables.elements
    lanes, element = new_lanes(ROWS), scratch(ELEMENT_SIZE)
    queue, waiting = new_queue(), 0
    last, left_lanes = -1, stack_int64(N_LANES)
    for b in range(blocks.shape[0]):
        e, first, end = blocks[b, 0], blocks[b, 1], blocks[b, 2]
        form, trim = elements.table[e]["form"], elements.table[e]["trim"]
        if form == GENERAL or trim == OUT:
            for i in range(first, end):
                records[order[i], FLAG] = TO_WALK
            continue
        n_single = (end - first) % BANK_WIDTH
        if 0 < n_single < MIN_ROWS:
            for i in range(end - n_single, end):
                waiting = _make_room(tables, proves, queue, waiting, records)
                enqueue(tables, e, records, order[i], queue, waiting)
                waiting += 1
            end -= n_single
            if first == end:
                continue
        if e != last:
            fill_element(elements, e, tables.scale[1] ** 2, element)
            last = e
        banks = load(records, order, first, end, lanes)
        # Half a block at a time: with more prefetches under way the lanes wait for their own lines.
        half, next_first = first + N_LANES // 2, blocks[b, 2]
        prefetch_rows(records, order, first, min(half, end), LINE)
        start_lanes(lanes, end - first, element)
        prefetch_rows(records, order, half, end, LINE)
        for k in range(ROUNDS):
            if k == 0:
                prefetch_rows(records, order, next_first, next_first + N_LANES // 2, 0)
            if form == RATIONAL_CUBIC:
                newton_rational(lanes, banks, element)
            else:
                newton_polynomial(lanes, banks, element)
            if lanes_in(ACTIVE, lanes, banks) == 0:
                break
        prefetch_rows(records, order, next_first + N_LANES // 2, next_first + N_LANES, 0)
        if form == RATIONAL_CUBIC:
            finish_rational(lanes, banks, element)
        else:
            finish_polynomial(lanes, banks, element)
        if proves:
            load_neighbourhoods(tables.neighbourhoods, e, lanes, banks)
            _prefetch_next(tables.neighbourhoods, blocks, b, 0)
            prove_lanes(lanes, banks, element, tables.scale[1])
            _prefetch_next(tables.neighbourhoods, blocks, b, 1)
        unload(lanes, records, order, first, end)
        patch = elements.table[e]["patch"]
        trimmed = tables.trims.trimmed[patch] != 0
        # Feet that are trimmed away are flagged, and proofs that a trim invalidates are cleared.
        for i in range(first, end if trim == CUT or trimmed else first):
            bank, l, row = lanes[(i - first) // BANK_WIDTH], (i - first) % BANK_WIDTH, order[i]
            s, t = bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l]
            if bank[ROW_STATE * BANK_WIDTH + l] != DONE:
                continue
            if trim == CUT and not in_face(elements, tables.trims, e, s, t):
                records[row, FLAG] = TO_WALK
            elif trimmed and records[row, PROVED] != 0.0:
                records[row, PROVED] = 1.0 if is_untrimmed_ball(tables, patch, bank, l) else 0.0
        if lanes_in(LEFT, lanes, banks) > 0:
            # Listed without branches: which rows have left is as random as the points.
            n = 0
            for i in range(end - first):
                left_lanes[n] = i
                n += lanes[i // BANK_WIDTH, ROW_STATE * BANK_WIDTH + i % BANK_WIDTH] == LEFT
            for j in range(n):
                i = left_lanes[j]
                waiting = _make_room(tables, proves, queue, waiting, records)
                bank, l = lanes[i // BANK_WIDTH], i % BANK_WIDTH
                enqueue_left(tables, e, bank, l, order[first + i], queue, waiting)
                waiting += 1
    while waiting > 0:
        waiting = process_queue(tables, proves, queue, waiting, records)
    return collect_rows(records, path, starts, chunk, pending, m, out)


@kernel()
def track_chunks(tables, path, starts, size, records, pending, out, chunks):
    """Track a range of chunks of `size` points each in lanes.

    `chunks` is (first, one past the last). Returns the number of pending rows: without a foot, or
    not proved though the previous points are known. The other arguments are the same as for
    `track_lanes`.
    """
    m = 0
    for c in range(chunks[0], chunks[1]):
        chunk = Chunk(c * size, min((c + 1) * size, path.now.shape[0]))
        m = track_lanes(tables, path, starts, chunk, records, pending, m, out)
    return m


@kernel()
def continue_pending(tables, points, pending, m, out):
    """Write feet of the first m pending rows that have none to `out`, by walks and searches.

    Rows whose walk reaches no minimum, because it does not converge or ends on a maximum of the
    distance, get the closest point and the status BRANCH_EVENT; their flags become HAS_ENDED.
    Points that are not finite get blank rows with NOT_FINITE.
    """
    nearest, h = scratch(4), scratch(4, 6)
    rows, flags = pending.rows, pending.flags
    searched, n = np.empty(m, np.int32), 0
    for j in range(m):
        k = rows[j]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if flags[j] == TO_WALK and not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
        elif flags[j] == TO_WALK:
            foot = locate(tables.grid, pending.patch[j], pending.uv[j, 0], pending.uv[j, 1])
            tracked_foot(tables, k, foot, point, out, nearest, h)
            has_ended = out.status[k] == MAX_ITERATIONS
            if out.status[k] == OK and out.feature[k] == FACE:
                # Newton's method that starts on a maximum stays there.
                e, s, t = locate(tables.grid, out.patch[k], out.uv[k, 0], out.uv[k, 1])
                q = expand(tables.elements, e, s, t, point, h)
                a, b = q.square_s, q.square_t
                curvature = min(q.f_ss * b, q.f_ss * q.f_tt - q.f_st * q.f_st)
                has_ended = (
                    a > POLE_RATIO * b and b > POLE_RATIO * a and curvature < -CURVATURE_TOL * a * b
                )
            if has_ended:
                flags[j] = HAS_ENDED
        if flags[j] == TO_SEARCH or flags[j] == HAS_ENDED:
            searched[n] = k
            n += 1
    project_global(tables, points, searched, np.full(n, math.inf), out, 0, n)
    for j in range(m):
        k = rows[j]
        if flags[j] == HAS_ENDED and out.status[k] != MAX_ITERATIONS:
            out.status[k] = BRANCH_EVENT
