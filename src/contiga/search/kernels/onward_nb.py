"""Where Newton's method goes on when it leaves an element.

In its patch parameters go on; beyond it, over smooth sides, one after the other where it leaves by
a corner or over a sliver, they do along a side, and across it they are stretched by what a
parameter is long on either side. The place is a start, and nothing rests on it.
"""

from __future__ import annotations

from contiga.num.codes import SMOOTH
from contiga.num.jit import inner
from contiga.search.kernels.one_foot_nb import may_go_on, parameters_of
from contiga.search.kernels.part_nb import part_of

HOPS = 3
"""Sides gone over at most."""
FARTHEST = 0.5
"""How far beyond a side a place may lie to be gone on with, in elements, its own or the other."""


@inner(error_model="numpy")
def _length(tables, e, s, t, axis):
    """About how long element e is along an axis, next to (s, t)."""
    box = tables.elements.table[e]["box"]
    return tables.rings[e, part_of(s, t)]["speed"][axis] * (box[2 * axis + 1] - box[2 * axis])


@inner(error_model="numpy")
def _over(tables, e, s, t):
    """The place (s, t), beyond element e, seen from the element over the side it is farthest
    beyond; element −1 where that is not smooth, or it is too far."""
    by_s = abs(s) > abs(t)
    off, along, axis = (abs(s) - 0.5, t, 0) if by_s else (abs(t) - 0.5, s, 1)
    side = 2 * axis + (1 if (s if by_s else t) > 0.0 else 0)
    own = tables.elements.table[e]
    if own["kind"][side] != SMOOTH:
        return -1, s, t
    n, there = own["neighbour"][side], own["neighbour_side"][side]
    x = -along if own["flip"][side] == 1 else along
    edge = -0.5 if there & 1 == 0 else 0.5
    x0, y0 = (edge, x) if there < 2 else (x, edge)
    depth = off * _length(tables, e, s, t, axis) / _length(tables, n, x0, y0, there >> 1)
    if not (off <= FARTHEST or depth <= FARTHEST):
        return -1, s, t
    inside = edge + (depth if there & 1 == 0 else -depth)
    return (n, inside, x) if there < 2 else (n, x, inside)


@inner(linked=False, error_model="numpy")
def onward(tables, e, s, t):
    """(patch, (u, v)) to go on from where (s, t) lies beyond element e; patch −1 where nowhere."""
    row = tables.elements.table[e]
    if may_go_on(tables.elements, e, s, t):
        return row["patch"], parameters_of(row["box"], (s, t))
    for _ in range(HOPS):
        e, s, t = _over(tables, e, s, t)
        if e < 0:
            break
        if abs(s) <= 0.5 and abs(t) <= 0.5:
            row = tables.elements.table[e]
            return row["patch"], parameters_of(row["box"], (s, t))
    return -1, (s, t)
