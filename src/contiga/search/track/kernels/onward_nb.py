"""Continue Newton's method in the next element where it leaves one.

In its patch parameters go on; beyond it, over smooth sides, one after the other where it leaves by
a corner or over a sliver, they do along a side, and across it they are stretched by what a
parameter is long on either side. The place is a start, and nothing rests on it.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import SMOOTH
from contiga.elements.kernels.element_nb import evaluate, locate
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.one_foot_nb import may_go_on, parameters_of

HOPS = 3
"""Sides gone over at most."""
FARTHEST = 0.5
"""How far beyond a side a place may lie to be gone on with, in elements, its own or the other."""


@inner(error_model="numpy")
def _speed(elements, e, place, axis, h):
    """Return how fast the surface of element e runs along an axis at place = (s, t), length."""
    evaluate(elements, e, place[0], place[1], h)
    return math.sqrt(h[0, 1 + axis] ** 2 + h[1, 1 + axis] ** 2 + h[2, 1 + axis] ** 2)


@inner(error_model="numpy")
def side_beyond(s, t):
    """The side that (s, t) is farthest beyond, how far, and where along it."""
    if abs(s) > abs(t):
        return (1 if s > 0.0 else 0), abs(s) - 0.5, t
    return (3 if t > 0.0 else 2), abs(t) - 0.5, s


@inner(error_model="numpy")
def across(element, side, along):
    """Return (s, t) in the element across a side, of a place along that of `element`."""
    x = -along if element["flip"][side] == 1 else along
    return side_point(element["neighbour_side"][side], x)


@inner(linked=False, error_model="numpy")
def onward(tables, e, s, t):
    """Return (element, (u, v)) to go on from if (s, t) lies beyond element e; −1 if nowhere."""
    elements, table = tables.elements, tables.elements.table
    row = table[e]
    side, _, _ = side_beyond(s, t)
    beyond = row["neighbour"][side]
    # Asked first: of many faces most are one element, and of four sides any may be gone over.
    same = beyond >= 0 and table[beyond]["patch"] == row["patch"]
    if same and may_go_on(elements, e, s, t):
        u, v = parameters_of(row["box"], (s, t))
        return locate(tables.grid, row["patch"], u, v)[0], (u, v)
    h = scratch(4, 6)
    for _ in range(HOPS):
        side, off, along = side_beyond(s, t)
        row = table[e]
        if row["kind"][side] != SMOOTH:
            break
        n, there = row["neighbour"][side], row["neighbour_side"][side]
        # Not beyond a corner, where what is worked out here may be anything.
        on_side = min(max(along, -0.5), 0.5)
        depth = off * _speed(elements, e, side_point(side, on_side), side >> 1, h)
        depth /= _speed(elements, n, across(row, side, on_side), there >> 1, h)
        if not (off <= FARTHEST or depth <= FARTHEST):
            break
        e, (s, t) = n, across(row, side, along)
        inward = depth if there & 1 == 0 else -depth
        s, t = (s + inward, t) if there < 2 else (s, t + inward)
        if abs(s) <= 0.5 and abs(t) <= 0.5:
            row = table[e]
            box, (u, v) = row["box"], parameters_of(row["box"], (s, t))
            # Not always as simply: where its sides end the next one begins.
            if not (box[0] <= u < box[1] and box[2] <= v < box[3]):
                e = locate(tables.grid, row["patch"], u, v)[0]
            return e, (u, v)
    return -1, (s, t)
