"""The quick certificate (`branch_nb`) of many feet of one element at once, as Newton's method has
left them in its lanes (`lanes_nb`).

By the bounds kept around each foot, and for a start in the surroundings of the same patch: nearly
all feet of small steps. Ways over a pole or a joint are left to be tried one by one.
"""

from __future__ import annotations

import math

from contiga.num.block import bits_of, read_anew, turn
from contiga.num.jit import inlined, inner
from contiga.num.scratch import scratch
from contiga.search.kernels.branch_nb import ball_radius, seen_from
from contiga.search.kernels.lanes_nb import (
    BOX,
    FOOT,
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
    TOLD,
    WIDE,
    below,
    columns_from,
)
from contiga.search.kernels.newton_nb import DONE
from contiga.search.kernels.part_nb import PARTS, part_of

# Rows of what is kept around a foot, as the record of a ring holds it.
CURVATURE, ROOM, SPEED, WIDTH, BLOCK, ENDS = 0, 2, 3, 5, 7, 11
KEPT = 12
NUMBERS = 13
"""Of a record."""


@inner()
def load_surroundings(rings, e, lanes, banks):
    """What is kept around the feet of so many banks of lanes of element e into these."""
    for b in range(banks):
        bank = lanes[b]
        for l in range(0, WIDE, 4):
            records = (
                _record(e, bank, l),
                _record(e, bank, l + 1),
                _record(e, bank, l + 2),
                _record(e, bank, l + 3),
            )
            for c in range(0, KEPT, 4):
                turn(rings, below(records, c), bank, columns_from(ROW_KEPT + c, l))


@inlined()
def _record(e, bank, l):
    """Where the record of what is kept around the foot of lane l begins."""
    part = part_of(bank[ROW_S * WIDE + l], bank[ROW_T * WIDE + l])
    return NUMBERS * (e * PARTS * PARTS + part)


@inlined()
def _three(bank, row, l):
    n = WIDE
    return bank[row * n + l], bank[(row + 1) * n + l], bank[(row + 2) * n + l]


@inner(linked=False)
def prove_lanes(lanes, banks, told, tolerance):
    """Radii of balls that prove the feet of so many banks of lanes, or 0.

    Trims are left to be looked at.
    """
    n = WIDE
    own = scratch(TOLD)
    for k in range(banks):
        bank = lanes[k]
        read_anew(told, own, TOLD)
        for l in range(WIDE):
            first, kept = ROW_FOUND * n + l, ROW_KEPT * n + l
            u, v = bank[first + PLACE * n], bank[first + (PLACE + 1) * n]
            foot = _three(bank, ROW_FOUND + FOOT, l)
            normal = _three(bank, ROW_FOUND + NORMAL, l)
            a, b = _three(bank, ROW_BEFORE, l), _three(bank, ROW_NOW, l)
            seen = seen_from(foot, normal, a, b, tolerance)
            u0, v0 = bank[ROW_START * n + l], bank[(ROW_START + 1) * n + l]
            around = (
                (bank[kept + BLOCK * n] <= u0)
                & (u0 <= bank[kept + (BLOCK + 1) * n])
                & (bank[kept + (BLOCK + 2) * n] <= v0)
                & (v0 <= bank[kept + (BLOCK + 3) * n])
            )
            way = abs(u0 - u) * bank[kept + SPEED * n] + abs(v0 - v) * bank[kept + (SPEED + 1) * n]
            way = way if around else math.inf
            width_u, width_v = bank[kept + WIDTH * n], bank[kept + (WIDTH + 1) * n]
            off_0, off_1 = (u - own[BOX]) * width_u, (own[BOX + 4] - u) * width_u
            off_2, off_3 = (v - own[BOX + 1]) * width_v, (own[BOX + 5] - v) * width_v
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
