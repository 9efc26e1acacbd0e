"""Where Newton's method goes on when it leaves an element.

In its patch parameters go on; beyond it, over smooth sides, one after the other where it leaves by
a corner or over a sliver, they do along a side, and across it they are stretched by what a
parameter is long on either side. The place is a start, and nothing rests on it.
"""

from __future__ import annotations

from contiga.arrays.codes import SMOOTH
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner
from contiga.search.certify.kernels.part_nb import part_of
from contiga.search.closest.kernels.one_foot_nb import may_go_on, parameters_of

HOPS = 3
"""Sides gone over at most."""
FARTHEST = 0.5
"""How far beyond a side a place may lie to be gone on with, in elements, its own or the other."""


@inner(error_model="numpy")
def _length(tables, e, s, t, axis):
    """About how long element e is along an axis, next to (s, t)."""
    box = tables.elements.table[e]["box"]
    return tables.neighbourhoods[e, part_of(s, t)]["speed"][axis] * (
        box[2 * axis + 1] - box[2 * axis]
    )


@inner(error_model="numpy")
def side_beyond(s, t):
    """The side that (s, t) is farthest beyond, how far, and where along it."""
    if abs(s) > abs(t):
        return (1 if s > 0.0 else 0), abs(s) - 0.5, t
    return (3 if t > 0.0 else 2), abs(t) - 0.5, s


@inner(error_model="numpy")
def across(element, side, along):
    """Where a place along a side of the element `element` is in the one across it, (s, t)."""
    there = element["neighbour_side"][side]
    x = -along if element["flip"][side] == 1 else along
    edge = -0.5 if there & 1 == 0 else 0.5
    return (edge, x) if there < 2 else (x, edge)


@inner(error_model="numpy")
def _over(tables, e, s, t):
    """The place (s, t), beyond element e, seen from the element over the side it is farthest
    beyond; element −1 where that is not smooth, or it is too far."""
    side, off, along = side_beyond(s, t)
    axis = side >> 1
    element = tables.elements.table[e]
    if element["kind"][side] != SMOOTH:
        return -1, s, t
    n, there = element["neighbour"][side], element["neighbour_side"][side]
    x0, y0 = across(element, side, along)
    edge, x = (x0, y0) if there < 2 else (y0, x0)
    depth = off * _length(tables, e, s, t, axis) / _length(tables, n, x0, y0, there >> 1)
    if not (off <= FARTHEST or depth <= FARTHEST):
        return -1, s, t
    inside = edge + (depth if there & 1 == 0 else -depth)
    return (n, inside, x) if there < 2 else (n, x, inside)


@inner(linked=False, error_model="numpy")
def onward(tables, e, s, t):
    """(element, (u, v)) to go on from where (s, t) lies beyond element e; −1 where nowhere."""
    table = tables.elements.table
    row = table[e]
    side, _, _ = side_beyond(s, t)
    beyond = row["neighbour"][side]
    # Asked first: of many faces most are one element, and of four sides any may be gone over.
    same = beyond >= 0 and table[beyond]["patch"] == row["patch"]
    if same and may_go_on(tables.elements, e, s, t):
        u, v = parameters_of(row["box"], (s, t))
        return locate(tables.grid, row["patch"], u, v)[0], (u, v)
    for _ in range(HOPS):
        e, s, t = _over(tables, e, s, t)
        if e < 0:
            break
        if abs(s) <= 0.5 and abs(t) <= 0.5:
            row = tables.elements.table[e]
            box, (u, v) = row["box"], parameters_of(row["box"], (s, t))
            # Not always as simply: where its sides end the next one begins.
            if not (box[0] <= u < box[1] and box[2] <= v < box[3]):
                e = locate(tables.grid, row["patch"], u, v)[0]
            return e, (u, v)
    return -1, (s, t)
