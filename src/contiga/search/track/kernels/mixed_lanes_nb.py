"""Lanes of different elements: feet that have left their element, and feet of elements with few.

Each lane has the coefficients of its own element next to its data, so that feet of any elements
share a vector. They wait until a block of lanes is full: by itself a foot that crosses an edge
takes as long as eight that do not.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import CUT, GENERAL, OUT, RATIONAL_CUBIC, TO_WALK
from contiga.elements.kernels.element_nb import place_in, quotient
from contiga.jit import inlined, inner
from contiga.jit.block import SIZE, turn
from contiga.jit.prefetch import LINE, prefetch
from contiga.jit.scratch import stack_int64
from contiga.search.certify.kernels.branch_nb import is_untrimmed, path_across_side
from contiga.search.certify.kernels.part_nb import part_of
from contiga.search.closest.kernels.newton_nb import (
    ACTIVE,
    DONE,
    LEFT,
    REJECTED,
    ROUNDS,
    polynomial_at,
    weight_at,
)
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.track.kernels.lanes_nb import (
    BANK_WIDTH,
    ELEMENT_SIZE,
    FLAG,
    N_INPUTS,
    N_LANES,
    NEIGHBOURHOOD_SIZE,
    ORIGIN,
    PLACE,
    PROVED,
    ROW_BOUNDS,
    ROW_F,
    ROW_RADIUS,
    ROW_RESULT,
    ROW_S,
    ROW_START,
    ROW_STATE,
    ROW_T,
    ROWS,
    WIDTH,
    below,
    columns_from,
    fill_place,
    finish_lane,
    lanes_in,
    load_four_neighbourhoods,
    new_lanes,
    newton_round,
    path_to_start,
    powers_of,
    prove_lane,
    start_lane,
    unload,
)
from contiga.search.track.kernels.onward_nb import across_side, next_element, side_beyond
from contiga.search.track.track_records import Waiting

# Further rows of a bank: the data of the element of each lane, 1 if that is rational, and the bound
# of the path from the foot to the start.
ROW_ELEMENT = ROWS
ROW_RATIONAL = ROW_ELEMENT + ELEMENT_SIZE
ROW_PATH = ROW_RATIONAL + 1
MIXED_ROWS = ROW_PATH + 1
SLOT_ROW, START_ELEMENT, CURRENT_ELEMENT = 0, 1, 2
"""Rows of `slots`: row, element of the start, present element, or −1 if the foot has left it."""
ELEMENT_NUMBERS = 95
CUBIC = ELEMENT_NUMBERS - ORIGIN
"""Numbers of an element's record, and the place where its coefficients begin."""
HEAD_LINES, RECORD_LINES = 4, 12
"""Cache lines of an element's record before its coefficients, and in all."""
MIN_ROWS = 2
"""Number of rows of an element below which they share a vector with rows of others."""


@inner()
def new_queue():
    """Return an empty `Waiting`."""
    return Waiting(new_lanes(MIXED_ROWS), np.empty((3, N_LANES), np.int32))


@inner()
def _prefetch_head(table, e):
    for line in range(HEAD_LINES):
        prefetch(table, e, line * LINE)


@inner(linked=False)
def enqueue(tables, e, records, row, queue, n):
    """Add a row of `records` to the queue behind n others; its start (u, v) is in element e.

    The start is copied as it is; `_start_queue` turns it into (s, t).
    """
    lanes, slots = queue.lanes, queue.slots
    bank, l = lanes[n // BANK_WIDTH], n % BANK_WIDTH
    for c in range(N_INPUTS):
        bank[c * BANK_WIDTH + l] = records[row, c]
    for c in range(2):
        bank[(ROW_S + c) * BANK_WIDTH + l] = records[row, ROW_START + c]
    bank[ROW_F * BANK_WIDTH + l] = math.inf
    slots[SLOT_ROW, n], slots[START_ELEMENT, n], slots[CURRENT_ELEMENT, n] = row, e, e
    _prefetch_head(tables.elements.table, e)


@inner()
def enqueue_left(tables, e, bank, l, row, queue, n):
    """Add a row that has left element e to the queue, behind n others, from lane l of a bank.

    Its place stays that of element e; `_start_queue` finds the element in which it continues.
    """
    lanes, slots = queue.lanes, queue.slots
    waiting, k = lanes[n // BANK_WIDTH], n % BANK_WIDTH
    for c in range(N_INPUTS):
        waiting[c * BANK_WIDTH + k] = bank[c * BANK_WIDTH + l]
    s, t = bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l]
    waiting[ROW_S * BANK_WIDTH + k], waiting[ROW_T * BANK_WIDTH + k] = s, t
    waiting[ROW_F * BANK_WIDTH + k] = bank[ROW_F * BANK_WIDTH + l]
    slots[SLOT_ROW, n], slots[START_ELEMENT, n], slots[CURRENT_ELEMENT, n] = row, e, -1
    # Most feet leave over one side, and the neighbour is no longer in the cache.
    row_of_element = tables.elements.table[e]
    side, _, along = side_beyond(s, t)
    beyond = row_of_element["neighbour"][side]
    if beyond >= 0:
        _prefetch_head(tables.elements.table, beyond)
        s, t = across_side(row_of_element, side, along)
        if tables.neighbourhoods.shape[0] > 0:
            for line in range(2):
                offset = part_of(s, t) * NEIGHBOURHOOD_SIZE * SIZE + line * LINE
                prefetch(tables.neighbourhoods, beyond, offset)


@inner(linked=False)
def _start_queue(tables, queue, n):
    """Set the starts of the first n lanes in their present elements; return the number of banks.

    A lane that has left its element continues in the next one (`next_element`); the lane is
    REJECTED if there is no such element, or the element is trimmed away or no cubic. Lanes beyond n
    are DONE.
    """
    lanes, slots, elements = queue.lanes, queue.slots, tables.elements
    table = elements.table
    banks = (n + BANK_WIDTH - 1) // BANK_WIDTH
    for i in range(banks * BANK_WIDTH):
        bank, l, o = (
            lanes[i // BANK_WIDTH],
            i % BANK_WIDTH,
            ROW_ELEMENT * BANK_WIDTH + i % BANK_WIDTH,
        )
        place, state = (0.0, 0.0), ACTIVE if i < n else DONE
        if i >= n:
            slots[CURRENT_ELEMENT, i] = slots[CURRENT_ELEMENT, 0]
        else:
            place = bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l]
            if slots[CURRENT_ELEMENT, i] < 0:
                e, position = next_element(tables, slots[START_ELEMENT, i], place[0], place[1])
                is_usable = e >= 0 and table[e]["form"] != GENERAL and table[e]["trim"] != OUT
                slots[CURRENT_ELEMENT, i] = e if is_usable else slots[START_ELEMENT, i]
                place, state = position, ACTIVE if is_usable else REJECTED
        e = slots[CURRENT_ELEMENT, i]
        for line in range(HEAD_LINES, RECORD_LINES):
            prefetch(table, e, line * LINE)
        fill_place(elements, e, tables.scale[1] ** 2, bank, o, BANK_WIDTH)
        bank[ROW_RATIONAL * BANK_WIDTH + l] = 1.0 if table[e]["form"] == RATIONAL_CUBIC else 0.0
        start_lane(bank, l, place, bank, o, BANK_WIDTH)
        bank[ROW_STATE * BANK_WIDTH + l] = state
    for i in range(0, banks * BANK_WIDTH, 4):
        rows = (
            ELEMENT_NUMBERS * slots[CURRENT_ELEMENT, i] + CUBIC,
            ELEMENT_NUMBERS * slots[CURRENT_ELEMENT, i + 1] + CUBIC,
            ELEMENT_NUMBERS * slots[CURRENT_ELEMENT, i + 2] + CUBIC,
            ELEMENT_NUMBERS * slots[CURRENT_ELEMENT, i + 3] + CUBIC,
        )
        for c in range(0, ORIGIN, 4):
            turn(
                table,
                below(rows, c),
                lanes[i // BANK_WIDTH],
                columns_from(ROW_ELEMENT + c, i % BANK_WIDTH),
            )
    return banks


@inlined()
def _select(first, a, b):
    """Return the six numbers of a or of b."""
    return (
        a[0] if first else b[0],
        a[1] if first else b[1],
        a[2] if first else b[2],
        a[3] if first else b[3],
        a[4] if first else b[4],
        a[5] if first else b[5],
    )


@inlined()
def _derivatives(bank, l):
    """Return the coordinates x, y, z, each with its derivatives, at the place of lane l."""
    o = ROW_ELEMENT * BANK_WIDTH + l
    s, t = powers_of(bank, l, bank, o, BANK_WIDTH)
    x, y, z = polynomial_at(bank, o, BANK_WIDTH, s, t)
    w = weight_at(bank, o, BANK_WIDTH, s, t)
    rational = bank[ROW_RATIONAL * BANK_WIDTH + l] != 0.0
    return (
        _select(rational, quotient(x, w), x),
        _select(rational, quotient(y, w), y),
        _select(rational, quotient(z, w), z),
    )


@inner(linked=False)
def newton_mixed(lanes, banks, tolerance):
    """Do one Newton round in the first banks of lanes, each in the element of its own data."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(BANK_WIDTH):
            x, y, z = _derivatives(bank, l)
            newton_round(bank, l, x, y, z, tolerance)


@inner(linked=False)
def finish_mixed(lanes, banks):
    """Write the results of the first banks of lanes at their final places."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(BANK_WIDTH):
            x, y, z = _derivatives(bank, l)
            finish_lane(bank, l, x, y, z, bank, ROW_ELEMENT * BANK_WIDTH + l, BANK_WIDTH)


@inner(linked=False)
def prove_mixed(lanes, banks, tolerance):
    """Write which feet are proved, and the radii of their balls, or 0. Trims are not tested."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(BANK_WIDTH):
            path = bank[ROW_PATH * BANK_WIDTH + l]
            prove_lane(bank, l, path, tolerance, bank, ROW_ELEMENT * BANK_WIDTH + l, BANK_WIDTH)


@inner(linked=False)
def _prove_queue(tables, queue, n, banks):
    """Write the quick certificates of the first n feet to the first banks of the queue.

    A foot on a trimmed patch needs a ball that is clear of the trims.
    """
    lanes, slots = queue.lanes, queue.slots
    table, neighbourhoods, trimmed = (
        tables.elements.table,
        tables.neighbourhoods,
        tables.trims.trimmed,
    )
    for b in range(banks):
        for l in range(0, BANK_WIDTH, 4):
            i = b * BANK_WIDTH + l
            four = (
                slots[CURRENT_ELEMENT, i],
                slots[CURRENT_ELEMENT, i + 1],
                slots[CURRENT_ELEMENT, i + 2],
                slots[CURRENT_ELEMENT, i + 3],
            )
            load_four_neighbourhoods(neighbourhoods, four, lanes[b], l)
    for i in range(n):
        bank, l, last, now = (
            lanes[i // BANK_WIDTH],
            i % BANK_WIDTH,
            slots[START_ELEMENT, i],
            slots[CURRENT_ELEMENT, i],
        )
        patch, other, path = table[now]["patch"], table[last]["patch"], math.inf
        if patch == other:
            path = path_to_start(bank, l)
        if path == math.inf and trimmed[patch] == 0 and trimmed[other] == 0:
            foot = (now, bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l])
            u, v, box = (
                bank[ROW_START * BANK_WIDTH + l],
                bank[(ROW_START + 1) * BANK_WIDTH + l],
                table[last]["box"],
            )
            start_place = (last, place_in(u, box[0], box[1]), place_in(v, box[2], box[3]))
            path = path_across_side(table, neighbourhoods, foot, start_place)
        bank[ROW_PATH * BANK_WIDTH + l] = path
    prove_mixed(lanes, banks, tables.scale[1])
    for i in range(n):
        bank, l, patch = (
            lanes[i // BANK_WIDTH],
            i % BANK_WIDTH,
            table[slots[CURRENT_ELEMENT, i]]["patch"],
        )
        if trimmed[patch] != 0 and bank[(ROW_RESULT + PROVED) * BANK_WIDTH + l] != 0.0:
            is_clear = is_untrimmed_ball(tables, patch, bank, l)
            bank[(ROW_RESULT + PROVED) * BANK_WIDTH + l] = 1.0 if is_clear else 0.0


@inner(linked=False)
def is_untrimmed_ball(tables, patch, bank, l):
    """Return whether it is certain that nothing is trimmed away in the ball about a lane's foot.

    The (u, v) box that holds the ball is tested, so False does not mean that the ball is trimmed.
    """
    r = bank[ROW_RADIUS * BANK_WIDTH + l]
    uv = (
        bank[(ROW_RESULT + PLACE) * BANK_WIDTH + l],
        bank[(ROW_RESULT + PLACE + 1) * BANK_WIDTH + l],
    )
    half_u = r / bank[(ROW_BOUNDS + WIDTH) * BANK_WIDTH + l]
    return is_untrimmed(
        tables, patch, uv, half_u, r / bank[(ROW_BOUNDS + WIDTH + 1) * BANK_WIDTH + l]
    )


@inner(linked=False)
def process_queue(tables, proves, queue, n, records):
    """Write the feet of the n rows in the queue, with their quick certificates, to their records.

    Returns the number of rows in the queue afterwards: they have left their first element and still
    wait. A row that leaves a second element, is REJECTED, or has its foot trimmed away is flagged
    for the careful walk. Feet are proved only if `proves`.
    """
    lanes, slots, elements = queue.lanes, queue.slots, tables.elements
    is_first = stack_int64(N_LANES)
    for i in range(n):
        is_first[i] = slots[CURRENT_ELEMENT, i] >= 0
    banks = _start_queue(tables, queue, n)
    for _ in range(ROUNDS):
        newton_mixed(lanes, banks, tables.scale[1] ** 2)
        if lanes_in(ACTIVE, lanes, banks) == 0:
            break
    finish_mixed(lanes, banks)
    for i in range(n):
        bank, l, e = lanes[i // BANK_WIDTH], i % BANK_WIDTH, slots[CURRENT_ELEMENT, i]
        if bank[ROW_STATE * BANK_WIDTH + l] != DONE or elements.table[e]["trim"] != CUT:
            continue
        s, t = bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l]
        if not in_face(elements, tables.trims, e, s, t):
            bank[ROW_STATE * BANK_WIDTH + l] = REJECTED
            bank[(ROW_RESULT + FLAG) * BANK_WIDTH + l] = TO_WALK
    if proves:
        _prove_queue(tables, queue, n, banks)
    unload(lanes, records, slots[SLOT_ROW], 0, n)
    m = 0
    for i in range(n):
        bank, l = lanes[i // BANK_WIDTH], i % BANK_WIDTH
        if is_first[i] != 0 and bank[ROW_STATE * BANK_WIDTH + l] == LEFT:
            enqueue_left(tables, slots[START_ELEMENT, i], bank, l, slots[SLOT_ROW, i], queue, m)
            m += 1
    return m
