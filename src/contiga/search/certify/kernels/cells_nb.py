"""The cell about a foot, and how it goes on across a side of its element."""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import (
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    bend_bounds,
    principal,
)
from contiga.search.certify.kernels.branch_nb import is_whole
from contiga.search.closest.kernels.around_nb import MOST, around

SNAP = 1e-9
"""A start this close to a side of its element is looked at from beyond it too."""
CELL = 1.3
"""The cell about a foot reaches this many times as far as the ball, for the metric changes."""


@inner(error_model="numpy")
def touched(s, t, far_s, far_t):
    """The side a cell around (s, t) reaches: −1 none, −2 more than one."""
    touched_side = -1
    for side, reached in (
        (0, s - far_s <= -0.5),
        (1, s + far_s >= 0.5),
        (2, t - far_t <= -0.5),
        (3, t + far_t >= 0.5),
    ):
        if reached:
            touched_side = side if touched_side == -1 else -2
    return touched_side


@inner(error_model="numpy")
def cell_about(s, t, far_s, far_t):
    return (
        max(s - far_s, -0.5),
        min(s + far_s, 0.5),
        max(t - far_t, -0.5),
        min(t + far_t, 0.5),
    )


@inner(error_model="numpy")
def _keep(boxes, k, cell):
    """Keep a cell: element, middle s, t, half of it in s, t."""
    boxes[k, 0], boxes[k, 1], boxes[k, 2], boxes[k, 3], boxes[k, 4] = cell


@inner(error_model="numpy")
def _over_side(elements, foot, last, where, bend, work):
    """Bounds of the cell that goes on across a side, into work.beyond; whether they are good.

    Both cells are one strip along the side: `along` is the parameter along it, in which a way no
    longer than r stays within the strip whichever of the cells it runs in. Also returned is the
    length of a way to the start `last` if that is across the side, else −1.
    """
    e, s, t = foot
    side, (r, far_s, far_t) = where
    other, h, boxes = work.beyond, work.derivatives, work.boxes
    n = elements.table[e]["neighbour"][side]
    there = elements.table[e]["neighbour_side"][side]
    sign = -1.0 if elements.table[e]["flip"][side] == 1 else 1.0
    along = sign * (t if side < 2 else s)
    far = far_t if side < 2 else far_s
    middle = sign * (t if side < 2 else s)
    edge = -0.5 if there & 1 == 0 else 0.5
    if there < 2:
        normal_at(elements, n, edge, middle, h)
    else:
        normal_at(elements, n, middle, edge, h)
    width = principal(h).metric[2 if there < 2 else 3]
    if not width > 0.0:
        return False, -1.0
    deep = CELL * r / width
    if not (deep < 1.0 and abs(along) + far < 0.5):
        return False, -1.0
    inner = edge - math.copysign(deep, edge)
    low, high = min(edge, inner), max(edge, inner)
    cell = (along - far, along + far, low, high)
    if there < 2:
        cell = (low, high, along - far, along + far)
    if not bend_bounds(elements, n, cell, other, work.bending_beyond):
        return False, -1.0
    across = other[WIDTH_S if there < 2 else WIDTH_T]
    beside = other[WIDTH_T if there < 2 else WIDTH_S]
    if not (r < deep * across and r < far * beside):
        return False, -1.0
    middle_s = 0.5 * (cell[0] + cell[1])
    middle_t = 0.5 * (cell[2] + cell[3])
    half_s = 0.5 * (cell[1] - cell[0])
    _keep(boxes, 1, (n, middle_s, middle_t, half_s, 0.5 * (cell[3] - cell[2])))
    if last[0] != n:
        return True, -1.0
    depth = abs((last[1] if there < 2 else last[2]) - edge)
    aside = abs((last[2] if there < 2 else last[1]) - along)
    if depth > deep or aside > far:
        return True, -1.0
    first = 0.5 - abs(s if side < 2 else t)
    way = first * bend[SPEED_S if side < 2 else SPEED_T]
    way += depth * other[SPEED_S if there < 2 else SPEED_T]
    return True, way + aside * other[SPEED_T if there < 2 else SPEED_S]


@inner(error_model="numpy")
def cells_about(elements, foot, last, size, side, work):
    """Bounds of the cell about a foot into work.here, and beyond `side` (−1 none) into work.beyond.

    `last` is the start (e, s, t), `size` (r, half the cell in s, in t). Returns the length of a way
    from foot to start in these cells, −1 where there is none or a way of length r may lead out.
    The cells are kept in work.boxes, to be looked at for trims by who knows these.
    """
    e, s, t = foot
    r, far_s, far_t = size
    bend = work.here
    if not bend_bounds(elements, e, cell_about(s, t, far_s, far_t), bend, work.bending):
        return -1.0
    if not (r < far_s * bend[WIDTH_S] and r < far_t * bend[WIDTH_T]):
        return -1.0
    _keep(work.boxes, 0, (e, s, t, far_s, far_t))
    d_s = abs(last[1] - s)
    d_t = abs(last[2] - t)
    inside = last[0] == e and d_s <= far_s and d_t <= far_t
    way = d_s * bend[SPEED_S] + d_t * bend[SPEED_T]
    if side >= 0:
        joined, beyond = _over_side(elements, foot, last, (side, size), bend, work)
        if not joined:
            return -1.0
        if last[0] != e:
            inside = beyond >= 0.0
            way = beyond
    return way if inside else -1.0


@inner(error_model="numpy")
def is_untrimmed(tables, boxes):
    """Whether nothing is trimmed away from the cells kept in `boxes`."""
    for k in range(2):
        e = int(boxes[k, 0])
        if e >= 0 and tables.trims.trimmed[tables.elements.table[e]["patch"]] != 0:
            far = (boxes[k, 3], boxes[k, 4])
            if not whole_around(tables, e, boxes[k, 1], boxes[k, 2], far[0], far[1]):
                return False
    return True


@inner(error_model="numpy")
def whole_around(tables, e, s, t, far_s, far_t):
    """Whether nothing is trimmed away from the cell around (s, t) of element e."""
    box = tables.elements.table[e]["box"]
    far = (far_s * (box[1] - box[0]), far_t * (box[3] - box[2]))
    at = parameters(tables.elements, e, s, t)
    return is_whole(tables, tables.elements.table[e]["patch"], at, far[0], far[1])


@inner()
def _snapped(x):
    return math.copysign(0.5, x) if abs(x) > 0.5 - SNAP else x


@inner(error_model="numpy")
def in_element(elements, foot, e):
    """The same foot as a point of element e, if it stands on or next to a side of that, or else as
    it is; and how far it was moved onto the side, in parameters."""
    _, s0, t0 = foot
    s = _snapped(s0)
    t = _snapped(t0)
    if max(abs(s), abs(t)) < 0.5:
        return foot, 0.0
    list_e = stack_int64(MOST)
    list_st = scratch(MOST, 2)
    for k in range(around(elements, (foot[0], s, t), list_e, list_st)):
        if list_e[k] == e:
            return (e, list_st[k, 0], list_st[k, 1]), abs(s - s0) + abs(t - t0)
    return foot, 0.0
