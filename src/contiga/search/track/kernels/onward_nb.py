"""Continue Newton's method in the next element when it leaves one.

Within the patch the parameters continue. Beyond it the point crosses smooth sides, several in turn
at a corner or over a sliver: along a side the parameter continues, across it it is scaled by the
ratio of the speeds on both sides. The place is only a start; no proof depends on it.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import SMOOTH
from contiga.elements.kernels.element_nb import evaluate, locate
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.one_foot_nb import may_continue, parameters_of

MAX_SIDES = 3
"""Largest number of sides crossed."""
MAX_OVERSHOOT = 0.5
"""Largest distance of a place beyond a side, in lengths of the element or of its neighbour."""


@inner(error_model="numpy")
def _speed(elements, e, place, axis, h):
    """Return the length of the derivative of element e along an axis at place = (s, t)."""
    evaluate(elements, e, place[0], place[1], h)
    return math.sqrt(h[0, 1 + axis] ** 2 + h[1, 1 + axis] ** 2 + h[2, 1 + axis] ** 2)


@inner(error_model="numpy")
def side_beyond(s, t):
    """Return the side that (s, t) is farthest beyond, the distance, and the place along the side.

    The distance, in local parameters, is negative inside the element.
    """
    if abs(s) > abs(t):
        return (1 if s > 0.0 else 0), abs(s) - 0.5, t
    return (3 if t > 0.0 else 2), abs(t) - 0.5, s


@inner(error_model="numpy")
def across_side(element, side, along):
    """Return (s, t), in the element across a side, of the place `along` this side of `element`."""
    x = -along if element["flip"][side] == 1 else along
    return side_point(element["neighbour_side"][side], x)


@inner(linked=False, error_model="numpy")
def next_element(tables, e, s, t):
    """Return (element, (u, v)) of a place (s, t) beyond element e; element −1 if there is none.

    With −1 the pair has no meaning. At most `MAX_SIDES` smooth sides are crossed, each by at most
    `MAX_OVERSHOOT` of one of the two elements; within the patch the parameters decide.
    """
    elements, table = tables.elements, tables.elements.table
    row = table[e]
    side, _, _ = side_beyond(s, t)
    neighbour = row["neighbour"][side]
    # Test the nearest neighbour first: most faces of many are one element, left over any side.
    is_same_patch = neighbour >= 0 and table[neighbour]["patch"] == row["patch"]
    if is_same_patch and may_continue(elements, e, s, t):
        u, v = parameters_of(row["box"], (s, t))
        return locate(tables.grid, row["patch"], u, v)[0], (u, v)
    h = scratch(4, 6)
    for _ in range(MAX_SIDES):
        side, overshoot, along = side_beyond(s, t)
        row = table[e]
        if row["kind"][side] != SMOOTH:
            break
        n, side_there = row["neighbour"][side], row["neighbour_side"][side]
        # Clamped to the side: beyond a corner the derivatives may have any value.
        on_side = min(max(along, -0.5), 0.5)
        depth = overshoot * _speed(elements, e, side_point(side, on_side), side >> 1, h)
        depth /= _speed(elements, n, across_side(row, side, on_side), side_there >> 1, h)
        if not (overshoot <= MAX_OVERSHOOT or depth <= MAX_OVERSHOOT):
            break
        e, (s, t) = n, across_side(row, side, along)
        inward = depth if side_there & 1 == 0 else -depth
        s, t = (s + inward, t) if side_there < 2 else (s, t + inward)
        if abs(s) <= 0.5 and abs(t) <= 0.5:
            row = table[e]
            box, (u, v) = row["box"], parameters_of(row["box"], (s, t))
            # On the upper sides the next element begins.
            if not (box[0] <= u < box[1] and box[2] <= v < box[3]):
                e = locate(tables.grid, row["patch"], u, v)[0]
            return e, (u, v)
    return -1, (s, t)
