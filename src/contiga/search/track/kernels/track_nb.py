"""Tracking whole: chunks of points in lanes, from their binning to their quick certificates; then
the stages for the rows that these leave (`Left`).

Most rows are done by the first. All that a chunk of it reads and writes stays in the cache of the
core that has it, a thread takes the next chunk where one is done, and a few points cost one call.
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
from contiga.search.certify.kernels.part_nb import PARTS
from contiga.search.closest.kernels.foot_nb import tracked_foot
from contiga.search.closest.kernels.local_nb import expand
from contiga.search.closest.kernels.nearest_nb import project_global
from contiga.search.closest.kernels.newton_nb import ACTIVE, DONE, LEFT, ROUNDS
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.track.kernels.bins_nb import ask_for, fetch_rows, hand_rows, order_rows, tells
from contiga.search.track.kernels.lanes_nb import (
    FLAG,
    LANE_NUMBERS,
    LANES,
    NUMBERS,
    PROVED,
    ROW_S,
    ROW_STATE,
    ROW_T,
    ROWS,
    WIDE,
    fill_element,
    finish_polynomial,
    finish_rational,
    lanes_in,
    load,
    load_surroundings,
    new_lanes,
    newton_polynomial,
    newton_rational,
    prove_lanes,
    start_lanes,
    unload,
)
from contiga.search.track.kernels.mixed_lanes_nb import (
    MIN_ROWS,
    go_on,
    is_whole_about,
    new_queue,
    wait,
    wait_beyond,
)
from contiga.search.track.track_records import Chunk

LINES = PARTS * PARTS * NUMBERS * SIZE // LINE
"""Lines of the memory of what is kept of the surroundings of an element's parts."""
POLAR = 1e-12
"""|S_s|² below this share of |S_t|², or the other way round: so near a pole f is all rounding."""
FLAT = 1e-12
"""Curvature of f, which is 1 far from focal points, that is none."""


@inner()
def _room(tables, proves, queue, waiting, records):
    """Process waiting rows until the queue has room; return how many are left in it."""
    while waiting == LANES:
        waiting = go_on(tables, proves, queue, waiting, records)
    return waiting


@inner()
def _ask_for_next(neighbourhoods, blocks, b, half):
    """Ask for half of the surroundings kept of the next block's element, if that is another one."""
    if b + 1 < blocks.shape[0] and blocks[b + 1, 0] != blocks[b, 0]:
        for line in range(half * LINES // 2, (half + 1) * LINES // 2):
            prefetch(neighbourhoods, blocks[b + 1, 0], line * LINE)


@kernel()
def track_lanes(tables, path, starts, chunk, records, left, m, out):
    """Fast tracking of the rows of a `Chunk` in lanes, each in the element of its start.

    `path` is a `Path`, `starts` are `SurfacePlaces`, `left` is `Left`, `records` is a table of as
    many rows as the chunk or more to work in. The feet are in `out`, which may be what was started
    from. Returns how many rows are left to do, m of them from before: see `fetch_rows`.

    A row is flagged, to be done one by one, when it does not descend, or its element is trimmed
    away at the foot or of too high a degree, or left over other than smooth sides. Feet are proved
    where it is told where points were, and the tables have neighbourhoods.
    """
    element_of, counts = hand_rows(tables, path, starts, chunk, records)
    order, blocks = order_rows(element_of, counts)
    proves = tells(path) and tables.neighbourhoods.shape[0] > 0
    elements = tables.elements
    lanes, element = new_lanes(ROWS), scratch(LANE_NUMBERS)
    queue, waiting = new_queue(), 0
    last, gone = -1, stack_int64(LANES)
    for b in range(blocks.shape[0]):
        e, first, end = blocks[b, 0], blocks[b, 1], blocks[b, 2]
        form, trim = elements.table[e]["form"], elements.table[e]["trim"]
        if form == GENERAL or trim == OUT:
            for i in range(first, end):
                records[order[i], FLAG] = TO_WALK
            continue
        alone = (end - first) % WIDE
        if 0 < alone < MIN_ROWS:
            for i in range(end - alone, end):
                waiting = _room(tables, proves, queue, waiting, records)
                wait(tables, e, records, order[i], queue, waiting)
                waiting += 1
            end -= alone
            if first == end:
                continue
        if e != last:
            fill_element(elements, e, tables.scale[1] ** 2, element)
            last = e
        banks = load(records, order, first, end, lanes)
        # Half a block at a time: where more lines are on their way the lanes wait for theirs.
        half, then = first + LANES // 2, blocks[b, 2]
        ask_for(records, order, first, min(half, end), LINE)
        start_lanes(lanes, end - first, element)
        ask_for(records, order, half, end, LINE)
        for k in range(ROUNDS):
            if k == 0:
                ask_for(records, order, then, then + LANES // 2, 0)
            if form == RATIONAL_CUBIC:
                newton_rational(lanes, banks, element)
            else:
                newton_polynomial(lanes, banks, element)
            if lanes_in(ACTIVE, lanes, banks) == 0:
                break
        ask_for(records, order, then + LANES // 2, then + LANES, 0)
        if form == RATIONAL_CUBIC:
            finish_rational(lanes, banks, element)
        else:
            finish_polynomial(lanes, banks, element)
        if proves:
            load_surroundings(tables.neighbourhoods, e, lanes, banks)
            _ask_for_next(tables.neighbourhoods, blocks, b, 0)
            prove_lanes(lanes, banks, element, tables.scale[1])
            _ask_for_next(tables.neighbourhoods, blocks, b, 1)
        unload(lanes, records, order, first, end)
        patch = elements.table[e]["patch"]
        trimmed = tables.trims.trimmed[patch] != 0
        # Feet that are trimmed away are flagged, and proofs that a trim invalidates are cleared.
        for i in range(first, end if trim == CUT or trimmed else first):
            bank, l, row = lanes[(i - first) // WIDE], (i - first) % WIDE, order[i]
            s, t = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
            if bank[ROW_STATE * WIDE + l] != DONE:
                continue
            if trim == CUT and not in_face(elements, tables.trims, e, s, t):
                records[row, FLAG] = TO_WALK
            elif trimmed and records[row, PROVED] != 0.0:
                records[row, PROVED] = 1.0 if is_whole_about(tables, patch, bank, l) else 0.0
        if lanes_in(LEFT, lanes, banks) > 0:
            # Listed without a choice: which rows have left is as random as the points.
            n = 0
            for i in range(end - first):
                gone[n] = i
                n += lanes[i // WIDE, ROW_STATE * WIDE + i % WIDE] == LEFT
            for j in range(n):
                i = gone[j]
                waiting = _room(tables, proves, queue, waiting, records)
                bank, l = lanes[i // WIDE], i % WIDE
                wait_beyond(tables, e, bank, l, order[first + i], queue, waiting)
                waiting += 1
    while waiting > 0:
        waiting = go_on(tables, proves, queue, waiting, records)
    return fetch_rows(records, path, starts, chunk, left, m, out)


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


@kernel()
def continue_left(tables, points, left, m, out):
    """Feet of the first m rows left that have none yet: walked to, or searched for.

    Rows whose walk comes to no minimum become a BRANCH_EVENT, with the closest point for a foot.
    """
    nearest, h = scratch(4), scratch(4, 6)
    rows, flags = left.rows, left.flags
    chosen, n = np.empty(m, np.int32), 0
    for j in range(m):
        k = rows[j]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if flags[j] == TO_WALK and not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
        elif flags[j] == TO_WALK:
            foot = locate(tables.grid, left.patch[j], left.uv[j, 0], left.uv[j, 1])
            tracked_foot(tables, k, foot, point, out, nearest, h)
            ended = out.status[k] == MAX_ITERATIONS
            if out.status[k] == OK and out.feature[k] == FACE:
                # Where Newton's method starts on a maximum it stays there.
                e, s, t = locate(tables.grid, out.patch[k], out.uv[k, 0], out.uv[k, 1])
                q = expand(tables.elements, e, s, t, point, h)
                a, b = q.square_s, q.square_t
                least = min(q.f_ss * b, q.f_ss * q.f_tt - q.f_st * q.f_st)
                ended = a > POLAR * b and b > POLAR * a and least < -FLAT * a * b
            if ended:
                flags[j] = HAS_ENDED
        if flags[j] == TO_SEARCH or flags[j] == HAS_ENDED:
            chosen[n] = k
            n += 1
    project_global(tables, points, chosen, np.full(n, math.inf), out, 0, n)
    for j in range(m):
        k = rows[j]
        if flags[j] == HAS_ENDED and out.status[k] != MAX_ITERATIONS:
            out.status[k] = BRANCH_EVENT
