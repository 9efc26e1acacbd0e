"""Lanes of an element each: feet that have left their element, and those of elements that have few.

Each lane has the coefficients of its own element beside its data, so feet of any elements share a
vector. They wait until a block of lanes is full: by itself a foot that goes over an edge takes as
long as eight that do not.
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
from contiga.search.certify.kernels.branch_nb import is_whole, way_beyond
from contiga.search.certify.kernels.part_nb import part_of
from contiga.search.closest.kernels.newton_nb import (
    ACTIVE,
    DONE,
    GIVEN_BACK,
    LEFT,
    ROUNDS,
    polynomial_at,
    weight_at,
)
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.track.kernels.lanes_nb import (
    FLAG,
    LANE_NUMBERS,
    LANES,
    NUMBERS,
    NUMBERS_HANDED,
    ORIGIN,
    PLACE,
    PROVED,
    ROW_F,
    ROW_FOUND,
    ROW_KEPT,
    ROW_RADIUS,
    ROW_S,
    ROW_START,
    ROW_STATE,
    ROW_T,
    ROWS,
    WIDE,
    WIDTH,
    below,
    columns_from,
    fill_place,
    finish,
    lanes_in,
    new_lanes,
    one_round,
    powers_of,
    prove,
    start,
    surround,
    unload,
    way_around,
)
from contiga.search.track.kernels.onward_nb import across, onward, side_beyond
from contiga.search.track.track_records import Waiting

# Rows of a bank behind those of all lanes: what is read of the element of each, 1 where that is
# rational, and the length of the way from the foot to the start.
ROW_ELEMENT = ROWS
ROW_RATIONAL = ROW_ELEMENT + LANE_NUMBERS
ROW_WAY = ROW_RATIONAL + 1
MIXED_ROWS = ROW_WAY + 1
ROW, BEFORE, NOW = 0, 1, 2
"""Of a lane: the row, the element of its start, the one it is in or −1 where it has left."""
ELEMENT_NUMBERS = 95
CUBIC = ELEMENT_NUMBERS - ORIGIN
"""Numbers of an element's record, and where its coefficients begin."""
HEAD, ALL = 4, 12
"""Lines of an element's record before its coefficients, and of all of it."""
MIN_ROWS = 2
"""Rows of an element below which they wait for those of others to fill a vector."""


@inner()
def new_queue():
    """The `Waiting` of no feet yet."""
    return Waiting(new_lanes(MIXED_ROWS), np.empty((3, LANES), np.int32))


@inner()
def _ask_for_head(table, e):
    for line in range(HEAD):
        prefetch(table, e, line * LINE)


@inner(linked=False)
def wait(tables, e, records, row, queue, n):
    """Have a row of element e wait, behind n others."""
    lanes, who = queue.lanes, queue.who
    bank, l = lanes[n // WIDE], n % WIDE
    for c in range(NUMBERS_HANDED):
        bank[c * WIDE + l] = records[row, c]
    for c in range(2):
        bank[(ROW_S + c) * WIDE + l] = records[row, ROW_START + c]
    bank[ROW_F * WIDE + l] = math.inf
    who[ROW, n], who[BEFORE, n], who[NOW, n] = row, e, e
    _ask_for_head(tables.elements.table, e)


@inner()
def wait_beyond(tables, e, bank, l, row, queue, n):
    """Have a row wait that has left element e, behind n others; it was in lane l of a bank."""
    lanes, who = queue.lanes, queue.who
    waiting, k = lanes[n // WIDE], n % WIDE
    for c in range(NUMBERS_HANDED):
        waiting[c * WIDE + k] = bank[c * WIDE + l]
    s, t = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
    waiting[ROW_S * WIDE + k], waiting[ROW_T * WIDE + k] = s, t
    waiting[ROW_F * WIDE + k] = bank[ROW_F * WIDE + l]
    who[ROW, n], who[BEFORE, n], who[NOW, n] = row, e, -1
    # Most leave over one side, and what is beyond has not been read for long.
    here = tables.elements.table[e]
    side, _, along = side_beyond(s, t)
    beyond = here["neighbour"][side]
    if beyond >= 0:
        _ask_for_head(tables.elements.table, beyond)
        s, t = across(here, side, along)
        if tables.neighbourhoods.shape[0] > 0:
            for line in range(2):
                offset = part_of(s, t) * NUMBERS * SIZE + line * LINE
                prefetch(tables.neighbourhoods, beyond, offset)


@inner(linked=False)
def _start(tables, queue, n):
    """The first n lanes start; answers how many banks hold them.

    Lanes beyond are done, and those that have nowhere to start from are given back.
    """
    lanes, who, elements = queue.lanes, queue.who, tables.elements
    table = elements.table
    banks = (n + WIDE - 1) // WIDE
    for i in range(banks * WIDE):
        bank, l, o = lanes[i // WIDE], i % WIDE, ROW_ELEMENT * WIDE + i % WIDE
        place, state = (0.0, 0.0), ACTIVE if i < n else DONE
        if i >= n:
            who[NOW, i] = who[NOW, 0]
        else:
            place = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
            if who[NOW, i] < 0:
                e, there = onward(tables, who[BEFORE, i], place[0], place[1])
                goes_on = e >= 0 and table[e]["form"] != GENERAL and table[e]["trim"] != OUT
                who[NOW, i] = e if goes_on else who[BEFORE, i]
                place, state = there, ACTIVE if goes_on else GIVEN_BACK
        e = who[NOW, i]
        for line in range(HEAD, ALL):
            prefetch(table, e, line * LINE)
        fill_place(elements, e, tables.scale[1] ** 2, bank, o, WIDE)
        bank[ROW_RATIONAL * WIDE + l] = 1.0 if table[e]["form"] == RATIONAL_CUBIC else 0.0
        start(bank, l, place, bank, o, WIDE)
        bank[ROW_STATE * WIDE + l] = state
    for i in range(0, banks * WIDE, 4):
        rows = (
            ELEMENT_NUMBERS * who[NOW, i] + CUBIC,
            ELEMENT_NUMBERS * who[NOW, i + 1] + CUBIC,
            ELEMENT_NUMBERS * who[NOW, i + 2] + CUBIC,
            ELEMENT_NUMBERS * who[NOW, i + 3] + CUBIC,
        )
        for c in range(0, ORIGIN, 4):
            turn(table, below(rows, c), lanes[i // WIDE], columns_from(ROW_ELEMENT + c, i % WIDE))
    return banks


@inlined()
def _chosen(first, a, b):
    """The six numbers of a or of b."""
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
    """Evaluate the coordinates x, y, z where lane l is, in its element, with derivatives."""
    o = ROW_ELEMENT * WIDE + l
    s, t = powers_of(bank, l, bank, o, WIDE)
    x, y, z = polynomial_at(bank, o, WIDE, s, t)
    w = weight_at(bank, o, WIDE, s, t)
    rational = bank[ROW_RATIONAL * WIDE + l] != 0.0
    return (
        _chosen(rational, quotient(x, w), x),
        _chosen(rational, quotient(y, w), y),
        _chosen(rational, quotient(z, w), z),
    )


@inner(linked=False)
def newton_mixed(lanes, banks, tolerance):
    """One round in so many banks of lanes."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(WIDE):
            x, y, z = _derivatives(bank, l)
            one_round(bank, l, x, y, z, tolerance)


@inner(linked=False)
def finish_mixed(lanes, banks):
    """The records of these lanes where they have come to."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(WIDE):
            x, y, z = _derivatives(bank, l)
            finish(bank, l, x, y, z, bank, ROW_ELEMENT * WIDE + l, WIDE)


@inner(linked=False)
def prove_mixed(lanes, banks, tolerance):
    """Radii of balls that prove the feet of these lanes, or 0. Trims are left to be looked at."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(WIDE):
            way = bank[ROW_WAY * WIDE + l]
            prove(bank, l, way, tolerance, bank, ROW_ELEMENT * WIDE + l, WIDE)


@inner(linked=False)
def _prove(tables, queue, n, banks):
    """The quick certificates of the first n feet, in so many banks."""
    lanes, who = queue.lanes, queue.who
    table, neighbourhoods, trimmed = (
        tables.elements.table,
        tables.neighbourhoods,
        tables.trims.trimmed,
    )
    for b in range(banks):
        for l in range(0, WIDE, 4):
            i = b * WIDE + l
            four = (who[NOW, i], who[NOW, i + 1], who[NOW, i + 2], who[NOW, i + 3])
            surround(neighbourhoods, four, lanes[b], l)
    for i in range(n):
        bank, l, last, now = lanes[i // WIDE], i % WIDE, who[BEFORE, i], who[NOW, i]
        patch, other, way = table[now]["patch"], table[last]["patch"], math.inf
        if patch == other:
            way = way_around(bank, l)
        if way == math.inf and trimmed[patch] == 0 and trimmed[other] == 0:
            foot = (now, bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
            u, v, box = (
                bank[ROW_START * WIDE + l],
                bank[(ROW_START + 1) * WIDE + l],
                table[last]["box"],
            )
            begun = (last, place_in(u, box[0], box[1]), place_in(v, box[2], box[3]))
            way = way_beyond(table, neighbourhoods, foot, begun)
        bank[ROW_WAY * WIDE + l] = way
    prove_mixed(lanes, banks, tables.scale[1])
    for i in range(n):
        bank, l, patch = lanes[i // WIDE], i % WIDE, table[who[NOW, i]]["patch"]
        if trimmed[patch] != 0 and bank[(ROW_FOUND + PROVED) * WIDE + l] != 0.0:
            whole = is_whole_about(tables, patch, bank, l)
            bank[(ROW_FOUND + PROVED) * WIDE + l] = 1.0 if whole else 0.0


@inner(linked=False)
def is_whole_about(tables, patch, bank, l):
    """Return whether nothing is trimmed away from the ball about the foot of a lane."""
    r = bank[ROW_RADIUS * WIDE + l]
    uv = (bank[(ROW_FOUND + PLACE) * WIDE + l], bank[(ROW_FOUND + PLACE + 1) * WIDE + l])
    far_u = r / bank[(ROW_KEPT + WIDTH) * WIDE + l]
    return is_whole(tables, patch, uv, far_u, r / bank[(ROW_KEPT + WIDTH + 1) * WIDE + l])


@inner(linked=False)
def go_on(tables, proves, queue, n, records):
    """Feet of the n rows that wait, with their quick certificates, into their records; answers how
    many of them wait then, because they have left the element of their start.

    A row is flagged, to be done one by one, when it leaves another or is given back.
    """
    lanes, who, elements = queue.lanes, queue.who, tables.elements
    is_first = stack_int64(LANES)
    for i in range(n):
        is_first[i] = who[NOW, i] >= 0
    banks = _start(tables, queue, n)
    for _ in range(ROUNDS):
        newton_mixed(lanes, banks, tables.scale[1] ** 2)
        if lanes_in(ACTIVE, lanes, banks) == 0:
            break
    finish_mixed(lanes, banks)
    for i in range(n):
        bank, l, e = lanes[i // WIDE], i % WIDE, who[NOW, i]
        if bank[ROW_STATE * WIDE + l] != DONE or elements.table[e]["trim"] != CUT:
            continue
        s, t = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
        if not in_face(elements, tables.trims, e, s, t):
            bank[ROW_STATE * WIDE + l] = GIVEN_BACK
            bank[(ROW_FOUND + FLAG) * WIDE + l] = TO_WALK
    if proves:
        _prove(tables, queue, n, banks)
    unload(lanes, records, who[ROW], 0, n)
    m = 0
    for i in range(n):
        bank, l = lanes[i // WIDE], i % WIDE
        if is_first[i] != 0 and bank[ROW_STATE * WIDE + l] == LEFT:
            wait_beyond(tables, who[BEFORE, i], bank, l, who[ROW, i], queue, m)
            m += 1
    return m
