"""Whether one branch joins two feet: a part of a motion, proved at once.

By the bounds kept around the foot (`_ring_nb`), or by those of a cell about it that is just large
enough. The theorem stands in `_branch_nb`.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.num.jit import inner
from contiga.search._around_nb import MOST, around
from contiga.search._bend_nb import (
    INNER,
    OUTER,
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    bend_bounds,
    principal,
)
from contiga.search._branch_nb import WIDER, by_ring, holds, is_whole, seen_from
from contiga.search._element_nb import parameters
from contiga.search._ring_nb import part_of
from contiga.search._sides_nb import normal_at

SMOOTH = 0
SNAP = 1e-9
"""A start this close to a side of its element is looked at from beyond it too."""
CELL = 1.3
"""The cell about a foot reaches this many times as far as the ball, for the metric changes."""


@inner(error_model="numpy")
def _touched(s, t, far_s, far_t):
    """The side a cell around (s, t) reaches: −1 none, −2 more than one."""
    found = -1
    for side, reached in (
        (0, s - far_s <= -0.5),
        (1, s + far_s >= 0.5),
        (2, t - far_t <= -0.5),
        (3, t + far_t >= 0.5),
    ):
        if reached:
            found = side if found == -1 else -2
    return found


@inner(error_model="numpy")
def _cell(s, t, far_s, far_t):
    return (
        max(s - far_s, -0.5),
        min(s + far_s, 0.5),
        max(t - far_t, -0.5),
        min(t + far_t, 0.5),
    )


@inner(error_model="numpy")
def _by_cell(tables, foot, last, seen, size, work):
    """Whether bounds of a cell about the foot, which crosses one smooth side at most, prove it.

    `last` is the start (e, s, t), `seen` (m, far, slip), `size` (r, half the cell in s, in t).
    """
    elements = tables.elements
    e, s, t = foot
    m, far, slip = seen
    r, far_s, far_t = size
    bend, other, _, bending = work
    side = _touched(s, t, far_s, far_t)
    if side == -2 or (side >= 0 and elements.table[e]["kind"][side] != SMOOTH):
        return False
    if not bend_bounds(elements, e, _cell(s, t, far_s, far_t), bend, bending):
        return False
    if not (r < far_s * bend[WIDTH_S] and r < far_t * bend[WIDTH_T]):
        return False
    if not whole_around(tables, e, s, t, far_s, far_t):
        return False
    d_s = abs(last[1] - s)
    d_t = abs(last[2] - t)
    inside = last[0] == e and d_s <= far_s and d_t <= far_t
    way = d_s * bend[SPEED_S] + d_t * bend[SPEED_T]
    inner, outer = bend[INNER], bend[OUTER]
    if side >= 0:
        joined, beyond = _over_side(tables, foot, last, (side, size), bend, work)
        if not joined:
            return False
        inner = max(inner, other[INNER])
        outer = max(outer, other[OUTER])
        if last[0] != e:
            inside = beyond >= 0.0
            way = beyond
    return inside and way + tables.scale[1] <= r and holds((inner, outer), m, far, slip, r)


@inner(error_model="numpy")
def _over_side(tables, foot, last, where, bend, work):
    """Bounds of the cell that goes on across a side, into work[1]; whether they are good.

    Both cells are one strip along the side: `along` is the parameter along it, in which a way no
    longer than r stays within the strip whichever of the cells it runs in. Also returned is the
    length of a way to the start `last` if that is across the side, else −1.
    """
    elements = tables.elements
    e, s, t = foot
    side, (r, far_s, far_t) = where
    _, other, h, bending = work
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
    width = principal(h)[2][2 if there < 2 else 3]
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
    if not bend_bounds(elements, n, cell, other, bending):
        return False, -1.0
    across = other[WIDTH_S if there < 2 else WIDTH_T]
    beside = other[WIDTH_T if there < 2 else WIDTH_S]
    if not (r < deep * across and r < far * beside):
        return False, -1.0
    middle_s = 0.5 * (cell[0] + cell[1])
    middle_t = 0.5 * (cell[2] + cell[3])
    half_s = 0.5 * (cell[1] - cell[0])
    if not whole_around(tables, n, middle_s, middle_t, half_s, 0.5 * (cell[3] - cell[2])):
        return False, -1.0
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
def least_bend(curvature, m):
    """Least curvature of f at a foot: 1 − max(κ_i m, −κ_o m)."""
    return 1.0 - max(curvature[0] * m, -curvature[1] * m)


@inner(error_model="numpy")
def _by_ring(tables, foot, last, seen, off):
    """Whether the bounds kept around the foot prove the start `last`, given to within `off`."""
    e, s, t = foot
    table = tables.elements.table
    if table[e]["patch"] != table[last[0]]["patch"]:
        return False
    start = parameters(tables.elements, last[0], last[1], last[2])
    at = parameters(tables.elements, e, s, t)
    ring = tables.rings[e, part_of(s, t)]
    r = by_ring(ring, table[e]["box"], at, start, seen, tables.scale[1] + off)
    width = ring["width"]
    return r > 0.0 and is_whole(tables, table[e]["patch"], at, r / width[0], r / width[1])


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
def _in_element(elements, foot, e):
    """The same foot as a point of element e, if it stands on or next to a side of that, or else as
    it is; and how far it was moved onto the side, in parameters."""
    _, s0, t0 = foot
    s = _snapped(s0)
    t = _snapped(t0)
    if max(abs(s), abs(t)) < 0.5:
        return foot, 0.0
    list_e = np.empty(MOST, np.int64)
    list_st = np.empty((MOST, 2))
    for k in range(around(elements, (foot[0], s, t), list_e, list_st)):
        if list_e[k] == e:
            return (e, list_st[k, 0], list_st[k, 1]), abs(s - s0) + abs(t - t0)
    return foot, 0.0


@inner(error_model="numpy")
def prove(tables, foot, last, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1], (e, s, t) each.

    `work` is (bend, other, h, work of `bend_bounds`).
    """
    elements = tables.elements
    moved = 0.0
    if foot[0] != last[0]:
        last, moved = _in_element(elements, last, foot[0])
    if foot[0] != last[0]:
        here, off = _in_element(elements, foot, last[0])
        if off == 0.0:
            foot = here
    e, s, t = foot
    h = work[2]
    normal = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, metric = principal(h)
    m, far, slip = seen_from(at, normal, path[0], path[1], tables.scale[1])
    # Twice the speeds at the foot: within a hair of the start they are not much larger.
    off = 2.0 * moved * (metric[0] + metric[1])
    if _by_ring(tables, foot, last, (m, far, slip), off):
        return True
    if not metric[2] > 0.0:
        return False
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    if not least > 0.0:
        return False
    if last[0] == e:
        way = abs(last[1] - s) * metric[0] + abs(last[2] - t) * metric[1]
    else:
        normal_at(elements, last[0], last[1], last[2], h)
        origin = elements.table[last[0]]["origin"]
        square = 0.0
        for c in range(3):
            square += (h[c, 0] + origin[c] - at[c]) ** 2
        way = 1.4 * math.sqrt(square)
    r = WIDER * max(1.1 * way + off + tables.scale[1], slip / least)
    size = (r, CELL * r / metric[2], CELL * r / metric[3])
    return moved == 0.0 and _by_cell(tables, foot, last, (m, far, slip), size, work)
