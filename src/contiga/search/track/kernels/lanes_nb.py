"""Newton's method on many points of one element at once: the fast path of tracking.

Elements of degree up to three in each direction are stored as bicubics. Points are binned by
element and processed sixteen at a time, in banks as wide as a vector: the coefficients are the same
for all lanes, the lanes' data are contiguous in a bank, and the body of the lane loop has no
branches, so that the compiler makes vector code without gathers of it, if these kernels are
compiled by themselves and not within their callers. The coefficients are copied anew for each bank:
read once before the loop they were all spilled to the stack as vectors, a fifth of a round. Rows
that leave the element continue in lanes with others (`mixed_lanes_nb`); rows that meet an
indefinite Hessian or do not descend are handed to the careful walk.

If requested, the quick certificates (`branch_nb`) of these feet follow, by their neighbourhoods,
for starts in the same patch: nearly all feet of small steps. Paths across a pole or a joint are
tested one by one later.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import TO_WALK
from contiga.jit import inlined, inner
from contiga.jit.block import SIZE, bits_of, reload_numbers, turn
from contiga.jit.prebuilt import kernel_target
from contiga.jit.prefetch import LINE
from contiga.jit.scratch import scratch
from contiga.jit.vectors import numbers_in_vector
from contiga.search.certify.kernels.branch_nb import ball_radius, motion_from
from contiga.search.certify.kernels.part_nb import N_PARTS, part_of
from contiga.search.closest.kernels.newton_nb import (
    ACTIVE,
    DONE,
    foot_record,
    local_place,
    newton_step,
    polynomial_at,
    rational_at,
)

N_LANES = 16
BANK_WIDTH = numbers_in_vector(kernel_target())
"""Lanes of a bank."""
BANKS = N_LANES // BANK_WIDTH
# Rows of a bank, each BANK_WIDTH long. Input of the lanes: the present and the previous point, and
# the start (u, v). Newton's method: the point relative to the element's origin, the place (s, t),
# the smallest squared distance, the state.
ROW_NOW, ROW_BEFORE, ROW_START = 0, 3, 6
N_INPUTS = 8
ROW_X, ROW_S, ROW_T, ROW_F, ROW_STATE = 8, 11, 12, 13, 14
# Results, in the order of their columns in a record; the place is (u, v).
ROW_RESULT = 15
FLAG, PROVED, PLACE, FOOT, NORMAL, GAP, PATCH = 0, 1, 2, 4, 7, 10, 11
N_RESULTS = 12
RECORD_SIZE = 16
"""Numbers of a row's record, two cache lines: the first contains the input, and later results."""
# The proof: the neighbourhood of the foot, and the radius of the ball.
ROW_BOUNDS, ROW_RADIUS = 27, 39
ROWS = 40
# Rows of the neighbourhood of a foot, in the order of its record.
CURVATURE, ROOM, SPEED, WIDTH, BLOCK, ENDS = 0, 2, 3, 5, 7, 11
N_BOUNDS = 12
NEIGHBOURHOOD_SIZE = 13
"""Numbers of the record of a neighbourhood."""
# Data of an element for lanes: coefficients of x, y, z and the weight, sixteen each, its origin,
# the square of the tolerance, u0, v0, the lengths in u and v, u1, v1, the reciprocals of the
# lengths, the patch, and the place about which its powers are expanded.
ORIGIN, TOLERANCE, BOX, SCALE, PATCH_OF, ABOUT = 64, 67, 68, 74, 76, 77
ELEMENT_SIZE = 79


@inlined()
def _three(bank, row, l):
    n = BANK_WIDTH
    return bank[row * n + l], bank[(row + 1) * n + l], bank[(row + 2) * n + l]


@inlined()
def powers_of(bank, l, element, o, k):
    """Return (s, t) of lane l relative to the place about which its element is expanded."""
    s, t = bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l]
    return s - element[o + ABOUT * k], t - element[o + (ABOUT + 1) * k]


@inlined()
def start_lane(bank, l, place, element, o, k):
    """Write the start of lane l, at place = (u, v) of its element, to its bank.

    These are (s, t), clipped to the element, and the point relative to the element's origin. The
    data of the element are every k-th number from element[o].
    """
    n = BANK_WIDTH
    bank[ROW_S * n + l] = local_place(place[0], element[o + BOX * k], element[o + SCALE * k])
    bank[ROW_T * n + l] = local_place(
        place[1], element[o + (BOX + 1) * k], element[o + (SCALE + 1) * k]
    )
    for c in range(3):
        bank[(ROW_X + c) * n + l] = bank[(ROW_NOW + c) * n + l] - element[o + (ORIGIN + c) * k]


@inlined()
def newton_round(bank, l, x, y, z, tolerance):
    """Do one Newton round of lane l with the coordinates x, y, z and their derivatives.

    Writes place, smallest squared distance and state by `newton_step` to the bank; a lane that is
    not ACTIVE stays as it is.
    """
    n = BANK_WIDTH
    place = (bank[ROW_S * n + l], bank[ROW_T * n + l])
    progress = (bank[ROW_F * n + l], bank[ROW_STATE * n + l])
    point = _three(bank, ROW_X, l)
    s, t, best, state = newton_step(place, progress, point, x, y, z, tolerance)
    bank[ROW_S * n + l] = s
    bank[ROW_T * n + l] = t
    bank[ROW_F * n + l] = best
    bank[ROW_STATE * n + l] = state


@inlined()
def finish_lane(bank, l, x, y, z, element, o, k):
    """Write the results of lane l to its bank; flag it TO_WALK unless it is DONE.

    A lane whose miss exceeds the tolerance becomes REJECTED first. The numbers of its element are
    every k-th from element[o].
    """
    n, first = BANK_WIDTH, ROW_RESULT * BANK_WIDTH + l
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
    bank[first + PATCH * n] = element[o + PATCH_OF * k]


@inner()
def fill_place(elements, e, tolerance, element, o, k):
    """Write the data of an element, except its coefficients, to `element`.

    They are every k-th number from element[o].
    """
    row = elements.table[e]
    for c in range(3):
        element[o + (ORIGIN + c) * k] = row["origin"][c]
    element[o + TOLERANCE * k] = tolerance
    element[o + PATCH_OF * k] = row["patch"]
    for axis in range(2):
        first, last = row["box"][2 * axis], row["box"][2 * axis + 1]
        element[o + (BOX + axis) * k] = first
        element[o + (BOX + 2 + axis) * k] = last - first
        element[o + (BOX + 4 + axis) * k] = last
        element[o + (SCALE + axis) * k] = 1.0 / (last - first)
        element[o + (ABOUT + axis) * k] = row["about"][axis]


@inner()
def fill_element(elements, e, tolerance, element):
    """Write the data of element e for lanes to `element`."""
    cubic = elements.table[e]["cubic"]
    for i in range(ORIGIN):
        element[i] = cubic[i]
    fill_place(elements, e, tolerance, element, 0, 1)


@inner()
def new_lanes(rows):
    """Return the lanes of a block, (BANKS, rows * BANK_WIDTH), aligned to a cache line, undefined.

    Vectors across two lines take 4 % of a tracked point.
    """
    n = rows * BANK_WIDTH
    memory = np.empty(BANKS * n + LINE // SIZE)
    start_lane = -memory.ctypes.data % LINE // SIZE
    return memory[start_lane : start_lane + BANKS * n].reshape(BANKS, n)


@inner()
def load(records, order, first, last, lanes):
    """Load the input of the rows order[first:last] into the lanes; lanes beyond repeat the last.

    Returns the number of banks with rows.
    """
    banks = (last - first + BANK_WIDTH - 1) // BANK_WIDTH
    for b in range(banks):
        bank = lanes[b]
        for l in range(0, BANK_WIDTH, 4):
            rows = _records_of(order, first + b * BANK_WIDTH + l, last)
            for c in range(0, N_INPUTS, 4):
                turn(records, below(rows, c), bank, columns_from(c, l))
    return banks


@inner()
def unload(lanes, records, order, first, last):
    """Store the results of the rows order[first:last] in their records."""
    for b in range((last - first + BANK_WIDTH - 1) // BANK_WIDTH):
        bank = lanes[b]
        for l in range(0, BANK_WIDTH, 4):
            at = first + b * BANK_WIDTH + l
            if at < last:
                rows = _records_of(order, at, last)
                for c in range(0, N_RESULTS, 4):
                    turn(bank, columns_from(ROW_RESULT + c, l), records, below(rows, c))


@inner()
def lanes_in(state, lanes, banks):
    """Return the number of lanes of the first banks that are in a state."""
    n = 0
    for b in range(banks):
        bank = lanes[b]
        for l in range(BANK_WIDTH):
            n += bank[ROW_STATE * BANK_WIDTH + l] == state
    return n


@inlined()
def _records_of(order, at, last):
    """Return the offsets of the records of order[at : at + 4]; beyond `last` a row is repeated."""
    end = last - 1
    return (
        RECORD_SIZE * order[min(at, end)],
        RECORD_SIZE * order[min(at + 1, end)],
        RECORD_SIZE * order[min(at + 2, end)],
        RECORD_SIZE * order[min(at + 3, end)],
    )


@inlined()
def below(places, c):
    """Return the four places, each c columns further."""
    return places[0] + c, places[1] + c, places[2] + c, places[3] + c


@inlined()
def columns_from(row, l):
    """Return the places of lane l in four rows of a bank from `row` on."""
    n = BANK_WIDTH
    return row * n + l, (row + 1) * n + l, (row + 2) * n + l, (row + 3) * n + l


@inner(linked=False)
def start_lanes(lanes, n, element):
    """Set the starts of the first n lanes from their input; they are ACTIVE, lanes beyond DONE."""
    copy = scratch(ELEMENT_SIZE)
    for b in range((n + BANK_WIDTH - 1) // BANK_WIDTH):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            u, v = bank[ROW_START * BANK_WIDTH + l], bank[(ROW_START + 1) * BANK_WIDTH + l]
            start_lane(bank, l, (u, v), copy, 0, 1)
            bank[ROW_F * BANK_WIDTH + l] = math.inf
            bank[ROW_STATE * BANK_WIDTH + l] = ACTIVE if b * BANK_WIDTH + l < n else DONE


@inner(linked=False)
def newton_rational(lanes, banks, element):
    """Do one Newton round in the first banks of lanes, whose rational element is `element`."""
    copy = scratch(ELEMENT_SIZE)
    for b in range(banks):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            x, y, z = rational_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            newton_round(bank, l, x, y, z, copy[TOLERANCE])


@inner(linked=False)
def newton_polynomial(lanes, banks, element):
    """Do one Newton round in the first banks of lanes, whose element has no weights."""
    copy = scratch(ELEMENT_SIZE)
    for b in range(banks):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            x, y, z = polynomial_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            newton_round(bank, l, x, y, z, copy[TOLERANCE])


@inner(linked=False)
def finish_rational(lanes, banks, element):
    """Write the results of the lanes at their final places in a rational element."""
    copy = scratch(ELEMENT_SIZE)
    for b in range(banks):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            x, y, z = rational_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            finish_lane(bank, l, x, y, z, copy, 0, 1)


@inner(linked=False)
def finish_polynomial(lanes, banks, element):
    """Write the results of the lanes at their final places in an element without weights."""
    copy = scratch(ELEMENT_SIZE)
    for b in range(banks):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            x, y, z = polynomial_at(copy, 0, 1, *powers_of(bank, l, copy, 0, 1))
            finish_lane(bank, l, x, y, z, copy, 0, 1)


@inner()
def load_neighbourhoods(neighbourhoods, e, lanes, banks):
    """Load the neighbourhoods of the feet, all of element e, into the first banks of lanes."""
    for b in range(banks):
        for l in range(0, BANK_WIDTH, 4):
            load_four_neighbourhoods(neighbourhoods, (e, e, e, e), lanes[b], l)


@inlined()
def load_four_neighbourhoods(neighbourhoods, elements, bank, l):
    """Load the neighbourhoods of four feet in four `elements` into lanes l … l + 3 of a bank."""
    records = (
        _neighbourhood_offset(elements[0], bank, l),
        _neighbourhood_offset(elements[1], bank, l + 1),
        _neighbourhood_offset(elements[2], bank, l + 2),
        _neighbourhood_offset(elements[3], bank, l + 3),
    )
    for c in range(0, N_BOUNDS, 4):
        turn(neighbourhoods, below(records, c), bank, columns_from(ROW_BOUNDS + c, l))


@inlined()
def _neighbourhood_offset(e, bank, l):
    """Return the offset of the neighbourhood, in element e, of the foot of lane l."""
    part = part_of(bank[ROW_S * BANK_WIDTH + l], bank[ROW_T * BANK_WIDTH + l])
    return NEIGHBOURHOOD_SIZE * (e * N_PARTS * N_PARTS + part)


@inlined()
def path_to_start(bank, l):
    """Return an upper bound of the length of the path from the foot of lane l to its start.

    Infinite if the start is outside the neighbourhood of the foot in the same patch.
    """
    n, place, bounds = (
        BANK_WIDTH,
        (ROW_RESULT + PLACE) * BANK_WIDTH + l,
        ROW_BOUNDS * BANK_WIDTH + l,
    )
    u, v = bank[place], bank[place + n]
    u0, v0 = bank[ROW_START * n + l], bank[(ROW_START + 1) * n + l]
    is_around = (
        (bank[bounds + BLOCK * n] <= u0)
        & (u0 <= bank[bounds + (BLOCK + 1) * n])
        & (bank[bounds + (BLOCK + 2) * n] <= v0)
        & (v0 <= bank[bounds + (BLOCK + 3) * n])
    )
    path = abs(u0 - u) * bank[bounds + SPEED * n] + abs(v0 - v) * bank[bounds + (SPEED + 1) * n]
    return path if is_around else math.inf


# Inlined by numba: inlined by LLVM, the loop over the lanes was not vectorised.
@inner(inline="always")
def prove_lane(bank, l, path, tolerance, element, o, k):
    """Write the radius of the ball that proves the foot of lane l, and whether it is proved.

    `path` is an upper bound of the length from the foot to its start; the radius is 0 without a
    proof, or if the lane is not DONE. The numbers of its element are every k-th from element[o].
    """
    n, first, bounds = BANK_WIDTH, ROW_RESULT * BANK_WIDTH + l, ROW_BOUNDS * BANK_WIDTH + l
    u, v = bank[first + PLACE * n], bank[first + (PLACE + 1) * n]
    foot, normal = _three(bank, ROW_RESULT + FOOT, l), _three(bank, ROW_RESULT + NORMAL, l)
    before, now = _three(bank, ROW_BEFORE, l), _three(bank, ROW_NOW, l)
    motion = motion_from(foot, normal, before, now, tolerance)
    width_u, width_v = bank[bounds + WIDTH * n], bank[bounds + (WIDTH + 1) * n]
    off_0, off_1 = (u - element[o + BOX * k]) * width_u, (element[o + (BOX + 4) * k] - u) * width_u
    off_2, off_3 = (
        (v - element[o + (BOX + 1) * k]) * width_v,
        (element[o + (BOX + 5) * k] - v) * width_v,
    )
    ends = bits_of(bank[bounds + ENDS * n])
    off_0 = off_0 if ends & 0xFF else math.inf
    off_1 = off_1 if ends & 0xFF00 else math.inf
    off_2 = off_2 if ends & 0xFF0000 else math.inf
    off_3 = off_3 if ends & 0xFF000000 else math.inf
    margin = min(min(off_0, off_1), min(off_2, off_3))
    curvature = (bank[bounds + CURVATURE * n], bank[bounds + (CURVATURE + 1) * n])
    r = ball_radius(curvature, bank[bounds + ROOM * n], margin, path, motion, tolerance)
    r = r if bank[ROW_STATE * n + l] == DONE else 0.0
    bank[ROW_RADIUS * n + l] = r
    bank[first + PROVED * n] = 1.0 if r > 0.0 else 0.0


@inner(linked=False)
def prove_lanes(lanes, banks, element, tolerance):
    """Write which feet in the first banks of lanes are proved, and the radii of their balls, or 0.

    Trims are not tested.
    """
    copy = scratch(ELEMENT_SIZE)
    for b in range(banks):
        bank = lanes[b]
        reload_numbers(element, copy, ELEMENT_SIZE)
        for l in range(BANK_WIDTH):
            prove_lane(bank, l, path_to_start(bank, l), tolerance, copy, 0, 1)
