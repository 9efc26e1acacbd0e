"""The quick certificate (`branch_nb`) of many feet of one element at once, as Newton's method has
left them in its lanes (`lanes_nb`).

By the bounds kept around each foot, and for a start in the surroundings of the same patch: nearly
all feet of small steps. Ways over a pole or a joint are left to be tried one by one.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner
from contiga.jit.block import bits_of, read_anew, turn
from contiga.jit.scratch import scratch
from contiga.search.certify.kernels.branch_nb import ball_radius, seen_from
from contiga.search.certify.kernels.part_nb import PARTS, part_of
from contiga.search.closest.kernels.newton_nb import DONE
from contiga.search.track.kernels.lanes_nb import (
    BOX,
    FOOT,
    LANE_NUMBERS,
    NORMAL,
    PLACE,
    PROVED,
    ROW_BEFORE,
    ROW_FOUND,
    ROW_KEPT,
    ROW_NOW,
    ROW_RADIUS,
    ROW_S,
    ROW_START,
    ROW_STATE,
    ROW_T,
    WIDE,
    below,
    columns_from,
)

# Rows of what is kept around a foot, as the record of a neighbourhood holds it.
CURVATURE, ROOM, SPEED, WIDTH, BLOCK, ENDS = 0, 2, 3, 5, 7, 11
KEPT = 12
NUMBERS = 13
"""Of a record."""


@inner()
def load_surroundings(neighbourhoods, e, lanes, banks):
    """What is kept around the feet of so many banks of lanes of element e into these."""
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
    """Offset of the stored neighbourhood of the foot of lane l."""
    part = part_of(bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
    return NUMBERS * (e * PARTS * PARTS + part)


@inlined()
def _three(bank, row, l):
    n = WIDE
    return bank[row * n + l], bank[(row + 1) * n + l], bank[(row + 2) * n + l]


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
