"""Tracking in lanes: the rows of a chunk, from their binning to their quick certificates."""

from __future__ import annotations

from contiga.arrays.codes import CUT, GENERAL, OUT, RATIONAL_CUBIC, TO_WALK
from contiga.jit import inner, kernel
from contiga.jit.block import SIZE
from contiga.jit.prefetch import LINE, prefetch
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.part_nb import PARTS
from contiga.search.closest.kernels.newton_nb import ACTIVE, DONE, LEFT, ROUNDS
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.track.kernels.bins_nb import ask_for, fetch_rows, hand_rows, order_rows, tells
from contiga.search.track.kernels.lane_proof_nb import NUMBERS, load_surroundings, prove_lanes
from contiga.search.track.kernels.lanes_nb import (
    FLAG,
    LANE_NUMBERS,
    LANES,
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
    new_lanes,
    newton_polynomial,
    newton_rational,
    start_lanes,
    unload,
)
from contiga.search.track.kernels.mixed_lanes_nb import (
    FEW,
    go_on,
    is_whole_about,
    new_queue,
    wait,
    wait_beyond,
)
from contiga.search.track.track_records import Block, OrderedRows

RING_LINES = PARTS * PARTS * NUMBERS * SIZE // LINE
"""Lines of the memory of what is kept of the surroundings of an element's parts."""


@inner()
def _room(tables, proves, queue, waiting, records):
    """Process waiting rows until the queue has room; return how many are left in it."""
    while waiting == LANES:
        waiting = go_on(tables, proves, queue, waiting, records)
    return waiting


@inner(linked=False)
def _wait(tables, proves, block, rows, queue, waiting):
    """Have the rows of a `Block` wait; answers how many wait then. `rows` are `OrderedRows`."""
    records, order = rows.records, rows.order
    for i in range(block.first, block.last):
        waiting = _room(tables, proves, queue, waiting, records)
        wait(tables, block.element, records, order[i], queue, waiting)
        waiting += 1
    return waiting


@inner(linked=False)
def _wait_beyond(tables, proves, block, lanes, rows, queue, waiting):
    """Have the rows of a `Block` wait that have left its element; answers how many wait then.

    `rows` are `OrderedRows`.
    """
    records, order = rows.records, rows.order
    e, first, last = block.element, block.first, block.last
    # Listed without a choice: which rows have left is as random as the points.
    gone, n = stack_int64(LANES), 0
    for i in range(last - first):
        gone[n] = i
        n += lanes[i // WIDE, ROW_STATE * WIDE + i % WIDE] == LEFT
    for j in range(n):
        i = gone[j]
        waiting = _room(tables, proves, queue, waiting, records)
        wait_beyond(tables, e, lanes[i // WIDE], i % WIDE, order[first + i], queue, waiting)
        waiting += 1
    return waiting


@inner(linked=False)
def _see_to_trims(tables, block, lanes, rows):
    """Flag the feet of a block that are trimmed away, and clear proofs that a trim invalidates."""
    records, order = rows.records, rows.order
    elements = tables.elements
    e, first, last = block.element, block.first, block.last
    patch = elements.table[e]["patch"]
    cut = elements.table[e]["trim"] == CUT
    trimmed = tables.trims.trimmed[patch] != 0
    for i in range(first, last):
        bank, l, row = lanes[(i - first) // WIDE], (i - first) % WIDE, order[i]
        s, t = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
        if bank[ROW_STATE * WIDE + l] != DONE:
            continue
        if cut and not in_face(elements, tables.trims, e, s, t):
            records[row, FLAG] = TO_WALK
        elif trimmed and records[row, PROVED] != 0.0:
            records[row, PROVED] = 1.0 if is_whole_about(tables, patch, bank, l) else 0.0


@inner()
def _ask_for_next(neighbourhoods, blocks, b, half):
    """Ask for half of the surroundings kept of the next block's element, if that is another one."""
    if b + 1 < blocks.shape[0] and blocks[b + 1, 0] != blocks[b, 0]:
        for line in range(half * RING_LINES // 2, (half + 1) * RING_LINES // 2):
            prefetch(neighbourhoods, blocks[b + 1, 0], line * LINE)


@inner(linked=False)
def _project_blocks(tables, proves, records, order, blocks):
    """Feet of the rows of all blocks, with their quick certificates.

    A row is flagged, to be done one by one, when it does not descend, or its element is trimmed
    away at the foot or of too high a degree, or left over other than smooth sides.
    """
    elements = tables.elements
    lanes, element = new_lanes(ROWS), scratch(LANE_NUMBERS)
    queue, waiting = new_queue(), 0
    last, rows = -1, OrderedRows(records, order)
    for b in range(blocks.shape[0]):
        e, first, end = blocks[b, 0], blocks[b, 1], blocks[b, 2]
        form, trim = elements.table[e]["form"], elements.table[e]["trim"]
        if form == GENERAL or trim == OUT:
            for i in range(first, end):
                records[order[i], FLAG] = TO_WALK
            continue
        alone = (end - first) % WIDE
        if 0 < alone < FEW:
            few = Block(e, end - alone, end)
            waiting = _wait(tables, proves, few, rows, queue, waiting)
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
        block = Block(e, first, end)
        if trim == CUT or tables.trims.trimmed[elements.table[e]["patch"]] != 0:
            _see_to_trims(tables, block, lanes, rows)
        if lanes_in(LEFT, lanes, banks) > 0:
            waiting = _wait_beyond(tables, proves, block, lanes, rows, queue, waiting)
    while waiting > 0:
        waiting = go_on(tables, proves, queue, waiting, records)


@kernel()
def track_lanes(tables, path, starts, chunk, records, left, m, out):
    """Fast tracking of the rows of a `Chunk` in lanes, each in the element of its start.

    `path` is a `Path`, `starts` are `SurfacePlaces`, `left` is `Left`, `records` is a table of as
    many rows as the chunk or more to work in. The feet are in `out`, which may be
    what was started from. Returns how many rows are left to do, m of them from before: see
    `fetch_rows`. Without neighbourhoods in the tables no foot is proved.
    """
    element, counts = hand_rows(tables, path, starts, chunk, records)
    order, blocks = order_rows(element, counts)
    proves = tells(path) and tables.neighbourhoods.shape[0] > 0
    _project_blocks(tables, proves, records, order, blocks)
    return fetch_rows(records, path, starts, chunk, left, m, out)
