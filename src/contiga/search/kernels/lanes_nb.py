"""Newton's method on many points of one element at once: the fast lane of tracking.

Elements of degree up to three in each direction are kept as bicubics. Points are binned by
element and taken sixteen at a time, in banks of as many as a vector holds: the coefficients are the
same for all lanes, the lanes' data lie one after the other in a bank, and the body of the lane loop
has no branches, so the compiler turns it into vector code without gathers: as long as these kernels
are compiled by themselves, and not within their callers. Coefficients are read anew for each bank,
where they are needed: read before the loop they were all written to the stack, whole vectors of
each, a fifth of a round. Lanes that want to leave the element go on from there by themselves; those
that meet an indefinite Hessian or do not descend are handed back, and the careful walk takes them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import types

from contiga.num.block import SIZE, read_anew, turn
from contiga.num.jit import inlined, inner, lazy
from contiga.num.prefetch import LINE
from contiga.num.scratch import scratch
from contiga.num.vectors import numbers_in_vector
from contiga.search.kernels.newton_nb import (
    ACTIVE,
    DONE,
    foot_record,
    local_place,
    newton_step,
    polynomial_at,
    rational_at,
)

LANES = 16
WIDE = numbers_in_vector()
"""Lanes of a bank."""
BANKS = LANES // WIDE
# Rows of a bank, each WIDE long, the rest in the order in which they come to be. What lanes are
# handed: the point now and before, and the start (u, v). Newton's method: the point from the
# element's origin, where it is, the square of the distance so far, the state.
ROW_NOW, ROW_BEFORE, ROW_START = 0, 3, 6
HANDED = 8
ROW_X, ROW_S, ROW_T, ROW_F, ROW_STATE = 8, 11, 12, 13, 14
# What is found, in the order of the columns it is handed on in; the place is (u, v).
ROW_FOUND = 15
FLAG, PROVED, PLACE, FOOT, NORMAL, GAP, PATCH = 0, 1, 2, 4, 7, 10, 11
FOUND = 12
# The proof: what is kept around the foot (see `lane_proof_nb`), and the radius of the ball.
ROW_KEPT, ROW_RADIUS = 27, 39
ROWS = 40
BY_ROW = 1
"""Flag of rows that are left to the careful walk."""
# What is told of an element: coefficients of x, y, z and the weight, sixteen each, its origin, the
# square of the tolerance, u0, v0, the lengths in u and v, u1, v1, their reciprocals, the patch.
ORIGIN, TOLERANCE, BOX, SCALE, HOME = 64, 67, 68, 74, 76
TOLD = 77


@inlined()
def _point(bank, l):
    return bank[ROW_X * WIDE + l], bank[(ROW_X + 1) * WIDE + l], bank[(ROW_X + 2) * WIDE + l]


@inlined()
def _round(bank, l, x, y, z, tolerance):
    """One Newton round of lane l, from the derivatives x, y, z of the surface's coordinates."""
    n = WIDE
    place = (bank[ROW_S * n + l], bank[ROW_T * n + l])
    so_far = (bank[ROW_F * n + l], bank[ROW_STATE * n + l])
    s, t, best, state = newton_step(place, so_far, _point(bank, l), x, y, z, tolerance)
    bank[ROW_S * n + l] = s
    bank[ROW_T * n + l] = t
    bank[ROW_F * n + l] = best
    bank[ROW_STATE * n + l] = state


@inlined()
def _finish(bank, l, told, x, y, z):
    """What is found of lane l; it is given back if it misses by more than tolerated."""
    n, first = WIDE, ROW_FOUND * WIDE + l
    s, t, state = bank[ROW_S * n + l], bank[ROW_T * n + l], bank[ROW_STATE * n + l]
    n_x, n_y, n_z, gap, now = foot_record(_point(bank, l), state, x, y, z, told[TOLERANCE])
    bank[ROW_STATE * n + l] = now
    bank[first + FLAG * n] = 0.0 if now == DONE else float(BY_ROW)
    bank[first + PROVED * n] = 0.0
    bank[first + PLACE * n] = told[BOX] + (s + 0.5) * told[BOX + 2]
    bank[first + (PLACE + 1) * n] = told[BOX + 1] + (t + 0.5) * told[BOX + 3]
    bank[first + FOOT * n] = x[0] + told[ORIGIN]
    bank[first + (FOOT + 1) * n] = y[0] + told[ORIGIN + 1]
    bank[first + (FOOT + 2) * n] = z[0] + told[ORIGIN + 2]
    bank[first + NORMAL * n] = n_x
    bank[first + (NORMAL + 1) * n] = n_y
    bank[first + (NORMAL + 2) * n] = n_z
    bank[first + GAP * n] = gap
    bank[first + PATCH * n] = told[HOME]


@inner()
def tell(elements, e, tolerance, told):
    """What lanes are told of element e."""
    own = elements.table[e]
    for i in range(64):
        told[i] = own["cubic"][i]
    for c in range(3):
        told[ORIGIN + c] = own["origin"][c]
    told[TOLERANCE] = tolerance
    told[HOME] = own["patch"]
    for axis in range(2):
        first, last = own["box"][2 * axis], own["box"][2 * axis + 1]
        told[BOX + axis], told[BOX + 2 + axis], told[BOX + 4 + axis] = first, last - first, last
        told[SCALE + axis] = 1.0 / (last - first)


@inner()
def new_lanes():
    """Lanes of a block, (BANKS, ROWS * WIDE): from a line of the memory on, as vectors across two
    take 4 % of a tracked point."""
    n = ROWS * WIDE
    memory = np.empty(BANKS * n + LINE // SIZE)
    start = -memory.ctypes.data % LINE // SIZE
    return memory[start : start + BANKS * n].reshape(BANKS, n)


@inner()
def load(handed, first, last, lanes):
    """Rows first … last of what lanes are handed into the lanes; those beyond repeat the last.

    Returns how many banks hold rows.
    """
    banks = (last - first + WIDE - 1) // WIDE
    for b in range(banks):
        bank = lanes[b]
        for l in range(0, WIDE, 4):
            rows = rows_from(first + b * WIDE + l, last, HANDED)
            for c in range(0, HANDED, 4):
                turn(handed, below(rows, c), bank, columns_from(c, l))
    return banks


@inner()
def unload(lanes, found, first, last):
    """What lanes have found into the rows first … last."""
    for b in range((last - first + WIDE - 1) // WIDE):
        bank = lanes[b]
        for l in range(0, WIDE, 4):
            row = first + b * WIDE + l
            if row < last:
                rows = rows_from(row, last, FOUND)
                for c in range(0, FOUND, 4):
                    turn(bank, columns_from(ROW_FOUND + c, l), found, below(rows, c))


@inlined()
def rows_from(row, last, columns):
    """Places of four rows from `row` on, before `last`, in a table of so many columns."""
    end = last - 1
    return (
        columns * min(row, end),
        columns * min(row + 1, end),
        columns * min(row + 2, end),
        columns * min(row + 3, end),
    )


@inlined()
def below(places, c):
    """Places so many columns on."""
    return places[0] + c, places[1] + c, places[2] + c, places[3] + c


@inlined()
def columns_from(row, l):
    """Places in a bank of four rows from `row` on, of lane l."""
    n = WIDE
    return row * n + l, (row + 1) * n + l, (row + 2) * n + l, (row + 3) * n + l


@inner(linked=False)
def start_lanes(lanes, n, told):
    """Where the first n lanes start, from what they are handed; lanes beyond are done."""
    own = scratch(TOLD)
    for b in range((n + WIDE - 1) // WIDE):
        bank = lanes[b]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            u, v = bank[ROW_START * WIDE + l], bank[(ROW_START + 1) * WIDE + l]
            bank[ROW_S * WIDE + l] = local_place(u, own[BOX], own[SCALE])
            bank[ROW_T * WIDE + l] = local_place(v, own[BOX + 1], own[SCALE + 1])
            for c in range(3):
                bank[(ROW_X + c) * WIDE + l] = bank[(ROW_NOW + c) * WIDE + l] - own[ORIGIN + c]
            bank[ROW_F * WIDE + l] = math.inf
            bank[ROW_STATE * WIDE + l] = ACTIVE if b * WIDE + l < n else DONE


@lazy(types.void)
def newton_rational(lanes, banks, told):
    """One round in so many banks of lanes."""
    own = scratch(TOLD)
    for b in range(banks):
        bank = lanes[b]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            x, y, z = rational_at(own, bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
            _round(bank, l, x, y, z, own[TOLERANCE])


@lazy(types.void)
def newton_polynomial(lanes, banks, told):
    """As `newton_rational`, for elements whose weight is one."""
    own = scratch(TOLD)
    for b in range(banks):
        bank = lanes[b]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            x, y, z = polynomial_at(own, bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
            _round(bank, l, x, y, z, own[TOLERANCE])


@lazy(types.void)
def finish_rational(lanes, banks, told):
    """The records of these lanes where they have come to."""
    own = scratch(TOLD)
    for b in range(banks):
        bank = lanes[b]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            x, y, z = rational_at(own, bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
            _finish(bank, l, own, x, y, z)


@lazy(types.void)
def finish_polynomial(lanes, banks, told):
    """As `finish_rational`, for elements whose weight is one."""
    own = scratch(TOLD)
    for b in range(banks):
        bank = lanes[b]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            x, y, z = polynomial_at(own, bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
            _finish(bank, l, own, x, y, z)
