"""Newton's method on many points of one element at once: the fast lane of tracking.

Elements of degree up to three in each direction are kept as bicubics. Points are binned by
element and taken sixteen at a time, in banks of as many as a vector holds: the coefficients are the
same for all lanes, the lanes' data lie one after the other in a bank, and the body of the lane loop
has no branches, so the compiler turns it into vector code without gathers: as long as these kernels
are compiled by themselves, and not within their callers. Coefficients are read anew for each bank,
where they are needed: read before the loop they were all written to the stack, whole vectors of
each, a fifth of a round. Rows that want to leave the element go on from there in lanes with others
that do (`mixed_lanes_nb`); those that meet an indefinite Hessian or do not descend are handed back,
and the careful walk takes them.

Where they are asked for, the quick certificates (`branch_nb`) of these feet follow, by the bounds
kept around each, for a start in the surroundings of the same patch: nearly all feet of small steps.
Ways over a pole or a joint are left to be tried one by one.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import TO_WALK
from contiga.jit import inlined, inner
from contiga.jit.block import SIZE, bits_of, read_anew, turn
from contiga.jit.prebuilt import made_for
from contiga.jit.prefetch import LINE
from contiga.jit.scratch import scratch
from contiga.jit.vectors import numbers_in_vector
from contiga.search.certify.kernels.branch_nb import ball_radius, seen_from
from contiga.search.certify.kernels.part_nb import PARTS, part_of
from contiga.search.closest.kernels.newton_nb import (
    ACTIVE,
    DONE,
    foot_record,
    local_place,
    newton_step,
    polynomial_at,
    rational_at,
)

LANES = 16
WIDE = numbers_in_vector(made_for())
"""Lanes of a bank."""
BANKS = LANES // WIDE
# Rows of a bank, each WIDE long, the rest in the order in which they come to be. What lanes are
# handed: the point now and before, and the start (u, v). Newton's method: the point from the
# element's origin, where it is, the square of the distance so far, the state.
ROW_NOW, ROW_BEFORE, ROW_START = 0, 3, 6
NUMBERS_HANDED = 8
ROW_X, ROW_S, ROW_T, ROW_F, ROW_STATE = 8, 11, 12, 13, 14
# What is found, in the order of the columns it is handed on in; the place is (u, v).
ROW_FOUND = 15
FLAG, PROVED, PLACE, FOOT, NORMAL, GAP, PATCH = 0, 1, 2, 4, 7, 10, 11
FOUND = 12
RECORD = 16
"""Numbers of a row's record, two lines of the memory: what is handed is in the first, and what is
found takes its place."""
# The proof: what is kept around the foot, and the radius of the ball.
ROW_KEPT, ROW_RADIUS = 27, 39
ROWS = 40
# Rows of what is kept around a foot, as the record of a neighbourhood holds it.
CURVATURE, ROOM, SPEED, WIDTH, BLOCK, ENDS = 0, 2, 3, 5, 7, 11
KEPT = 12
NUMBERS = 13
"""Of the record of a neighbourhood."""
# What lanes read of an element: coefficients of x, y, z and the weight, sixteen each, its origin,
# the square of the tolerance, u0, v0, the lengths in u and v, u1, v1, their reciprocals, the patch,
# and where its powers are about.
ORIGIN, TOLERANCE, BOX, SCALE, HOME, ABOUT = 64, 67, 68, 74, 76, 77
LANE_NUMBERS = 79


@inlined()
def _three(bank, row, l):
    n = WIDE
    return bank[row * n + l], bank[(row + 1) * n + l], bank[(row + 2) * n + l]


@inlined()
def powers_of(bank, l, element, o, k):
    """Return (s, t) of lane l from where the powers of its element are about."""
    s, t = bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l]
    return s - element[o + ABOUT * k], t - element[o + (ABOUT + 1) * k]


@inlined()
def start(bank, l, place, element, o, k):
    """Set the start of lane l at place = (u, v), in the element whose numbers are every k-th from
    element[o] on."""
    n = WIDE
    bank[ROW_S * n + l] = local_place(place[0], element[o + BOX * k], element[o + SCALE * k])
    bank[ROW_T * n + l] = local_place(
        place[1], element[o + (BOX + 1) * k], element[o + (SCALE + 1) * k]
    )
    for c in range(3):
        bank[(ROW_X + c) * n + l] = bank[(ROW_NOW + c) * n + l] - element[o + (ORIGIN + c) * k]


@inlined()
def one_round(bank, l, x, y, z, tolerance):
    """One Newton round of lane l, from the derivatives x, y, z of the surface's coordinates."""
    n = WIDE
    place = (bank[ROW_S * n + l], bank[ROW_T * n + l])
    so_far = (bank[ROW_F * n + l], bank[ROW_STATE * n + l])
    point = _three(bank, ROW_X, l)
    s, t, best, state = newton_step(place, so_far, point, x, y, z, tolerance)
    bank[ROW_S * n + l] = s
    bank[ROW_T * n + l] = t
    bank[ROW_F * n + l] = best
    bank[ROW_STATE * n + l] = state


@inlined()
def finish(bank, l, x, y, z, element, o, k):
    """Write what is found of lane l; it is given back if it misses by more than tolerated.

    The numbers of its element are every k-th from element[o] on.
    """
    n, first = WIDE, ROW_FOUND * WIDE + l
    s, t, state = bank[ROW_S * n + l], bank[ROW_T * n + l], bank[ROW_STATE * n + l]
    n_x, n_y, n_z, gap, now = foot_record(
        _three(bank, ROW_X, l), state, x, y, z, element[o + TOLERANCE * k]
    )
    bank[ROW_STATE * n + l] = now
    bank[first + FLAG * n] = 0.0 if now == DONE else float(TO_WALK)
    bank[first + PROVED * n] = 0.0
    bank[first + PLACE * n] = element[o + BOX * k] + (s + 0.5) * element[o + (BOX + 2) * k]
    bank[first + (PLACE + 1) * n] = (
        element[o + (BOX + 1) * k] + (t + 0.5) * element[o + (BOX + 3) * k]
    )
    bank[first + FOOT * n] = x[0] + element[o + ORIGIN * k]
    bank[first + (FOOT + 1) * n] = y[0] + element[o + (ORIGIN + 1) * k]
    bank[first + (FOOT + 2) * n] = z[0] + element[o + (ORIGIN + 2) * k]
    bank[first + NORMAL * n] = n_x
    bank[first + (NORMAL + 1) * n] = n_y
    bank[first + (NORMAL + 2) * n] = n_z
    bank[first + GAP * n] = gap
    bank[first + PATCH * n] = element[o + HOME * k]


@inner()
def fill_place(elements, e, tolerance, element, o, k):
    """Write what lanes read of an element beside its coefficients into every k-th number from
    element[o] on."""
    row = elements.table[e]
    for c in range(3):
        element[o + (ORIGIN + c) * k] = row["origin"][c]
    element[o + TOLERANCE * k] = tolerance
    element[o + HOME * k] = row["patch"]
    for axis in range(2):
        first, last = row["box"][2 * axis], row["box"][2 * axis + 1]
        element[o + (BOX + axis) * k] = first
        element[o + (BOX + 2 + axis) * k] = last - first
        element[o + (BOX + 4 + axis) * k] = last
        element[o + (SCALE + axis) * k] = 1.0 / (last - first)
        element[o + (ABOUT + axis) * k] = row["about"][axis]


@inner()
def fill_element(elements, e, tolerance, element):
    """Write what lanes read of element e into `element`."""
    cubic = elements.table[e]["cubic"]
    for i in range(ORIGIN):
        element[i] = cubic[i]
    fill_place(elements, e, tolerance, element, 0, 1)


@inner()
def new_lanes(rows):
    """Lanes of a block, (BANKS, rows * WIDE): from a line of the memory on, as vectors across two
    take 4 % of a tracked point."""
    n = rows * WIDE
    memory = np.empty(BANKS * n + LINE // SIZE)
    start = -memory.ctypes.data % LINE // SIZE
    return memory[start : start + BANKS * n].reshape(BANKS, n)


@inner()
def load(records, order, first, last, lanes):
    """Load what is handed of the rows order[first:last] into the lanes; those beyond repeat the
    last.

    Returns how many banks hold rows.
    """
    banks = (last - first + WIDE - 1) // WIDE
    for b in range(banks):
        bank = lanes[b]
        for l in range(0, WIDE, 4):
            rows = _records_of(order, first + b * WIDE + l, last)
            for c in range(0, NUMBERS_HANDED, 4):
                turn(records, below(rows, c), bank, columns_from(c, l))
    return banks


@inner()
def unload(lanes, records, order, first, last):
    """Store what lanes have found of the rows order[first:last] in their records."""
    for b in range((last - first + WIDE - 1) // WIDE):
        bank = lanes[b]
        for l in range(0, WIDE, 4):
            at = first + b * WIDE + l
            if at < last:
                rows = _records_of(order, at, last)
                for c in range(0, FOUND, 4):
                    turn(bank, columns_from(ROW_FOUND + c, l), records, below(rows, c))


@inner()
def lanes_in(state, lanes, banks):
    """Return how many lanes of so many banks are in a state."""
    n = 0
    for b in range(banks):
        bank = lanes[b]
        for l in range(WIDE):
            n += bank[ROW_STATE * WIDE + l] == state
    return n


@inlined()
def _records_of(order, at, last):
    """Return where the records of four rows begin, of those from `at` on and before `last`."""
    end = last - 1
    return (
        RECORD * order[min(at, end)],
        RECORD * order[min(at + 1, end)],
        RECORD * order[min(at + 2, end)],
        RECORD * order[min(at + 3, end)],
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
def start_lanes(lanes, n, element):
    """Set where the first n lanes start, from what they are handed; lanes beyond are done."""
    copy = scratch(LANE_NUMBERS)
    for b in range((n + WIDE - 1) // WIDE):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            u, v = bank[ROW_START * WIDE + l], bank[(ROW_START + 1) * WIDE + l]
            start(bank, l, (u, v), copy, 0, 1)
            bank[ROW_F * WIDE + l] = math.inf
            bank[ROW_STATE * WIDE + l] = ACTIVE if b * WIDE + l < n else DONE


@inner(linked=False)
def newton_rational(lanes, banks, element):
    """One round in so many banks of lanes."""
    copy = scratch(LANE_NUMBERS)
    for b in range(banks):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            x, y, z = rational_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            one_round(bank, l, x, y, z, copy[TOLERANCE])


@inner(linked=False)
def newton_polynomial(lanes, banks, element):
    """Do as `newton_rational`, for elements whose weight is one."""
    copy = scratch(LANE_NUMBERS)
    for b in range(banks):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            x, y, z = polynomial_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            one_round(bank, l, x, y, z, copy[TOLERANCE])


@inner(linked=False)
def finish_rational(lanes, banks, element):
    """The records of these lanes where they have come to."""
    copy = scratch(LANE_NUMBERS)
    for b in range(banks):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            x, y, z = rational_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            finish(bank, l, x, y, z, copy, 0, 1)


@inner(linked=False)
def finish_polynomial(lanes, banks, element):
    """Do as `finish_rational`, for elements whose weight is one."""
    copy = scratch(LANE_NUMBERS)
    for b in range(banks):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            x, y, z = polynomial_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            finish(bank, l, x, y, z, copy, 0, 1)


@inner()
def load_surroundings(neighbourhoods, e, lanes, banks):
    """Load what is kept around the feet of so many banks of lanes of element e into these."""
    for b in range(banks):
        for l in range(0, WIDE, 4):
            surround(neighbourhoods, (e, e, e, e), lanes[b], l)


@inlined()
def surround(neighbourhoods, elements, bank, l):
    """Load the stored neighbourhoods of the feet of lanes l … l + 3, in the given elements."""
    records = (
        _record(elements[0], bank, l),
        _record(elements[1], bank, l + 1),
        _record(elements[2], bank, l + 2),
        _record(elements[3], bank, l + 3),
    )
    for c in range(0, KEPT, 4):
        turn(neighbourhoods, below(records, c), bank, columns_from(ROW_KEPT + c, l))


@inlined()
def _record(e, bank, l):
    """Return the offset of the stored neighbourhood of the foot of lane l."""
    part = part_of(bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
    return NUMBERS * (e * PARTS * PARTS + part)


@inlined()
def way_around(bank, l):
    """Length of the way from the foot of a lane to its start, at most; infinite where that is not
    in the surroundings of the same patch."""
    n, place, kept = WIDE, (ROW_FOUND + PLACE) * WIDE + l, ROW_KEPT * WIDE + l
    u, v = bank[place], bank[place + n]
    u0, v0 = bank[ROW_START * n + l], bank[(ROW_START + 1) * n + l]
    around = (
        (bank[kept + BLOCK * n] <= u0)
        & (u0 <= bank[kept + (BLOCK + 1) * n])
        & (bank[kept + (BLOCK + 2) * n] <= v0)
        & (v0 <= bank[kept + (BLOCK + 3) * n])
    )
    way = abs(u0 - u) * bank[kept + SPEED * n] + abs(v0 - v) * bank[kept + (SPEED + 1) * n]
    return way if around else math.inf


# As numba puts it there: put there by LLVM, the loop over the lanes was no vector code.
@inner(inline="always")
def prove(bank, l, way, tolerance, element, o, k):
    """The ball that proves the foot of lane l with its start at the end of a `way`, or none.

    The numbers of its element are every k-th from element[o] on.
    """
    n, first, kept = WIDE, ROW_FOUND * WIDE + l, ROW_KEPT * WIDE + l
    u, v = bank[first + PLACE * n], bank[first + (PLACE + 1) * n]
    foot, normal = _three(bank, ROW_FOUND + FOOT, l), _three(bank, ROW_FOUND + NORMAL, l)
    before, now = _three(bank, ROW_BEFORE, l), _three(bank, ROW_NOW, l)
    seen = seen_from(foot, normal, before, now, tolerance)
    width_u, width_v = bank[kept + WIDTH * n], bank[kept + (WIDTH + 1) * n]
    off_0, off_1 = (u - element[o + BOX * k]) * width_u, (element[o + (BOX + 4) * k] - u) * width_u
    off_2, off_3 = (
        (v - element[o + (BOX + 1) * k]) * width_v,
        (element[o + (BOX + 5) * k] - v) * width_v,
    )
    ends = bits_of(bank[kept + ENDS * n])
    off_0 = off_0 if ends & 0xFF else math.inf
    off_1 = off_1 if ends & 0xFF00 else math.inf
    off_2 = off_2 if ends & 0xFF0000 else math.inf
    off_3 = off_3 if ends & 0xFF000000 else math.inf
    margin = min(min(off_0, off_1), min(off_2, off_3))
    curvature = (bank[kept + CURVATURE * n], bank[kept + (CURVATURE + 1) * n])
    r = ball_radius(curvature, bank[kept + ROOM * n], margin, way, seen, tolerance)
    r = r if bank[ROW_STATE * n + l] == DONE else 0.0
    bank[ROW_RADIUS * n + l] = r
    bank[first + PROVED * n] = 1.0 if r > 0.0 else 0.0


@inner(linked=False)
def prove_lanes(lanes, banks, element, tolerance):
    """Radii of balls that prove the feet of so many banks of lanes, or 0.

    Trims are left to be looked at.
    """
    copy = scratch(LANE_NUMBERS)
    for b in range(banks):
        bank = lanes[b]
        read_anew(element, copy, LANE_NUMBERS)
        for l in range(WIDE):
            prove(bank, l, way_around(bank, l), tolerance, copy, 0, 1)
