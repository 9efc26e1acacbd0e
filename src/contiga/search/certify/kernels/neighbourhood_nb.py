"""Bounds around every sixteenth of an element: what the quick certificate of a tracked foot asks.

A foot in one of the 4 × 4 parts of an element has the parts around it for its surroundings: those
of the element itself and, over smooth sides and corners, of the elements that join it. A way that
leads out of these is at least `room` long, unless it leaves over a side where the surface ends or
has a kink; which sides those are is kept in `ends`.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE, SMOOTH
from contiga.arrays.kernels.rows_nb import put
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import (
    BENDS,
    INNER,
    OUTER,
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    bend_bounds,
    bend_work,
    length,
    principal,
)
from contiga.search.certify.kernels.part_nb import (
    PARTS,
    adjoins,
    is_whole,
    part_of,
    scales,
    take_curvature,
    take_metric,
)
from contiga.search.certify.kernels.pole_nb import pole_bounds, pole_side
from contiga.search.certify.kernels.wide_neighbourhood_nb import widen
from contiga.search.closest.kernels.around_nb import MOST, around, stands

BY_POLE = 2
"""Parts this close to a pole have all that is round it for surroundings."""
TIGHT = 1.3
"""Bounds this many times as large as the curvatures are good enough,"""
FLAT = 0.02
"""and so are those of a cell that turns by no more than this (radians)."""


@inner(error_model="numpy")
def _is_tight(bend, h):
    """Whether the curvatures in the middle, whose derivatives are in `h`, are about as large."""
    inner, outer, _ = principal(h)
    largest = max(bend[INNER], bend[OUTER])
    return largest <= TIGHT * max(inner, outer) or largest * (length(h, 1) + length(h, 2)) <= FLAT


@inner(error_model="numpy")
def _merge(total, bend):
    for c in range(WIDTH_S):
        total[c] = max(total[c], bend[c])
    for c in range(WIDTH_S, BENDS):
        total[c] = min(total[c], bend[c])


@inner(error_model="numpy")
def _bends_of(elements, e, cell, depth, total, work):
    """Bounds over a cell from those of its pieces: quartered until they are tight."""
    stack, bend, bending = work
    total[:] = 0.0
    total[WIDTH_S] = total[WIDTH_T] = math.inf
    put(stack, 0, (cell[0], cell[1], cell[2], cell[3], 0.0))
    top = 1
    while top > 0:
        top -= 1
        s0, s1, t0, t1, level = stack[top]
        cell = (s0, s1, t0, t1)
        pole = pole_side(elements, e, cell)
        if pole >= 0:
            good = pole_bounds(elements, e, cell, pole, bend, bending)
        else:
            good = bend_bounds(elements, e, cell, bend, bending)
        # Next to a pole smaller cells that do not touch it have looser bounds than one that does.
        if level >= depth or (good and (pole >= 0 or _is_tight(bend, bending.derivatives))):
            _merge(total, bend)
            if not good:
                return
            continue
        s = 0.5 * (s0 + s1)
        t = 0.5 * (t0 + t1)
        put(stack, top, (s0, s, t0, t, level + 1.0))
        put(stack, top + 1, (s, s1, t0, t, level + 1.0))
        put(stack, top + 2, (s0, s, t, t1, level + 1.0))
        put(stack, top + 3, (s, s1, t, t1, level + 1.0))
        top += 4


@kernel(error_model="numpy")
def bends_of_parts(elements, depth, raw, start, stop):
    """Bounds of all parts of elements start … stop into raw[element, part, 6]."""
    work = (scratch(16, 5), scratch(BENDS), bend_work())
    for e in range(start, stop):
        for i in range(PARTS):
            for j in range(PARTS):
                cell = (
                    i / PARTS - 0.5,
                    (i + 1) / PARTS - 0.5,
                    j / PARTS - 0.5,
                    (j + 1) / PARTS - 0.5,
                )
                _bends_of(elements, e, cell, depth, raw[e, i * PARTS + j], work)


@inner(error_model="numpy")
def _beyond(elements, e, side, i, j):
    """The element across a side and its part that adjoins part (i, j) of element e."""
    n = elements.table[e]["neighbour"][side]
    there = elements.table[e]["neighbour_side"][side]
    along = j if side < 2 else i
    if elements.table[e]["flip"][side] == 1:
        along = PARTS - 1 - along
    edge = 0 if there & 1 == 0 else PARTS - 1
    part = edge * PARTS + along if there < 2 else along * PARTS + edge
    return n, part, there


@inner(error_model="numpy")
def _add_inside(raw, e, part, way, neighbourhood):
    """Another part of the same element; `way` tells in which directions it lies off."""
    bend = raw[e, part]
    take_curvature(neighbourhood, bend)
    take_metric(neighbourhood, bend, 1.0, 1.0)
    if way[0] != 0:
        neighbourhood["room"] = min(neighbourhood["room"], bend[WIDTH_S] / PARTS)
    if way[1] != 0:
        neighbourhood["room"] = min(neighbourhood["room"], bend[WIDTH_T] / PARTS)


@inner(error_model="numpy")
def _add_across(elements, raw, e, side, along, neighbourhood):
    """The parts across a smooth side: the one that adjoins, and those beside it."""
    for step in range(-1, 2):
        k = along + step
        if k < 0 or k >= PARTS:
            continue
        n, part, there = _beyond(elements, e, side, k, k)
        bend = raw[n, part]
        if not is_whole(elements, e, n):
            neighbourhood["room"] = 0.0
        take_curvature(neighbourhood, bend)
        neighbourhood["room"] = min(
            neighbourhood["room"], bend[WIDTH_S if there < 2 else WIDTH_T] / PARTS
        )
        if step != 0:
            neighbourhood["room"] = min(
                neighbourhood["room"], bend[WIDTH_T if there < 2 else WIDTH_S] / PARTS
            )
        if adjoins(elements, e, n, side):
            scale_s, scale_t = scales(elements, e, n)
            take_metric(neighbourhood, bend, scale_s, scale_t)
        else:  # linked point by point: the parameter along the side is the same
            beside = 1 if side < 2 else 0
            width = bend[WIDTH_T if there < 2 else WIDTH_S]
            neighbourhood["width"][beside] = min(neighbourhood["width"][beside], width)


@inner(error_model="numpy")
def _add_fan(elements, raw, e, corner, neighbourhood, work):
    """The parts of all elements around a corner; False where one has a kink or an end there."""
    list_e, list_st = work
    s, t = corner
    n = around(elements, (e, s, t), list_e, list_st)
    if n >= MOST:
        return False
    for k in range(n):
        e2 = list_e[k]
        s2 = list_st[k, 0]
        t2 = list_st[k, 1]
        for side in range(4):
            if stands(side, s2, t2) and elements.table[e2]["kind"][side] != SMOOTH:
                return False
        if e2 == e:
            continue
        if not is_whole(elements, e, e2):
            return False
        bend = raw[e2, part_of(s2, t2)]
        take_curvature(neighbourhood, bend)
        neighbourhood["room"] = min(
            neighbourhood["room"], min(bend[WIDTH_S], bend[WIDTH_T]) / PARTS
        )
        if elements.table[e2]["patch"] == elements.table[e]["patch"]:
            scale_s, scale_t = scales(elements, e, e2)
            take_metric(neighbourhood, bend, scale_s, scale_t)
    return True


@inner(error_model="numpy")
def _corner_is_open(elements, e, side_s, side_t):
    """Whether beyond one smooth side of a corner the surface ends where it ends here."""
    element = elements.table[e]
    smooth, ended = (side_s, side_t) if element["kind"][side_s] == SMOOTH else (side_t, side_s)
    there = element["neighbour_side"][smooth]
    end = (ended & 1) ^ element["flip"][smooth]
    kind = elements.table[element["neighbour"][smooth]]["kind"][(2 if there < 2 else 0) + end]
    return kind != SMOOTH and kind != POLE


@inner(error_model="numpy")
def _block(elements, e, i, j, neighbourhood):
    """The parameters of patch around part (i, j), as far as its surroundings go on in them."""
    table, box = elements.table, elements.table[e]["box"]
    for axis in range(2):
        k = i if axis == 0 else j
        low = box[2 * axis]
        wide = (box[2 * axis + 1] - low) / PARTS
        for end in range(2):
            edge = low + (max(k - 1, 0) if end == 0 else min(k + 2, PARTS)) * wide
            if k == (PARTS - 1 if end == 1 else 0):
                side = 2 * axis + end
                edge = box[side]
                n = table[e]["neighbour"][side]
                if table[e]["kind"][side] == SMOOTH and adjoins(elements, e, n, side):
                    part = (table[n]["box"][2 * axis + 1] - table[n]["box"][2 * axis]) / PARTS
                    edge += part if end == 1 else -part
            neighbourhood["block"][2 * axis + end] = edge


@inner(error_model="numpy")
def _pole_near(kind, i, j):
    """The side that is a pole no more than one part off; −1 where there is none."""
    for side in range(4):
        k = i if side < 2 else j
        off = k if side & 1 == 0 else PARTS - 1 - k
        if kind[side] == POLE and off <= BY_POLE:
            return side
    return -1


@inner(error_model="numpy")
def _part_at(side, along, depth):
    k = depth if side & 1 == 0 else PARTS - 1 - depth
    return k * PARTS + along if side < 2 else along * PARTS + k


@inner(error_model="numpy")
def _fan_of_pole(elements, e, side, list_e, list_side):
    """Elements around the pole that is a side of e; 0 where they do not close up smoothly."""
    n = 0
    link = 4 * e + side
    while n < MOST:
        list_e[n] = link // 4
        list_side[n] = link % 4
        n += 1
        link = elements.table[list_e[n - 1]]["ring"][list_side[n - 1]]
        if link == 4 * e + side:
            break
    if n == MOST:
        return 0
    for k in range(n):
        for end in range(2):
            lateral = (2 if list_side[k] < 2 else 0) + end
            if elements.table[list_e[k]]["kind"][lateral] != SMOOTH:
                return 0
            other = elements.table[list_e[k]]["neighbour"][lateral]
            known = False
            for i in range(n):
                known = known or list_e[i] == other
            if not known:
                return 0
    return n


@inner(error_model="numpy")
def _cap(elements, raw, foot, part, neighbourhood, work):
    """Fill the record of a part beside a pole: all round it, one part farther than this one.

    `foot` is (element, side that is the pole). A way leads out only over the far rim.
    """
    e, side = foot
    list_e = work[0]
    list_side = stack_int64(MOST)
    n = _fan_of_pole(elements, e, side, list_e, list_side)
    k = part[0] if side < 2 else part[1]
    deep = (k if side & 1 == 0 else PARTS - 1 - k) + 1
    box = elements.table[e]["box"]
    for c in range(4):
        neighbourhood["block"][c] = box[c]
    axis = 0 if side < 2 else 2
    away = (deep + 1) / PARTS * (box[axis + 1] - box[axis])
    neighbourhood["block"][axis + 1 if side & 1 == 0 else axis] = (
        box[axis] + away if side & 1 == 0 else box[axis + 1] - away
    )
    if n == 0 or deep >= PARTS:
        neighbourhood["room"] = 0.0
    for f in range(n):
        e2 = list_e[f]
        if not is_whole(elements, e, e2):
            neighbourhood["room"] = 0.0
        same = elements.table[e2]["patch"] == elements.table[e]["patch"] and list_side[f] == side
        for depth in range(min(deep + 1, PARTS)):
            for along in range(PARTS):
                bend = raw[e2, _part_at(list_side[f], along, depth)]
                take_curvature(neighbourhood, bend)
                if depth == deep:
                    across = bend[WIDTH_S if list_side[f] < 2 else WIDTH_T]
                    neighbourhood["room"] = min(neighbourhood["room"], across / PARTS)
                if same:
                    scale_s, scale_t = scales(elements, e, e2)
                    take_metric(neighbourhood, bend, scale_s, scale_t)
        if same:
            other = elements.table[e2]["box"]
            low = 2 - axis
            neighbourhood["block"][low] = min(neighbourhood["block"][low], other[low])
            neighbourhood["block"][low + 1] = max(neighbourhood["block"][low + 1], other[low + 1])


@inner(error_model="numpy")
def _neighbourhood(elements, raw, e, i, j, neighbourhood, work):
    """Fill the record of part (i, j) of element e."""
    bend = raw[e, i * PARTS + j]
    kind = elements.table[e]["kind"]
    neighbourhood["curvature"][0] = bend[INNER]
    neighbourhood["curvature"][1] = bend[OUTER]
    neighbourhood["room"] = math.inf
    neighbourhood["speed"][0] = bend[SPEED_S]
    neighbourhood["speed"][1] = bend[SPEED_T]
    neighbourhood["width"][0] = bend[WIDTH_S]
    neighbourhood["width"][1] = bend[WIDTH_T]
    for side in range(4):
        neighbourhood["ends"][side] = neighbourhood["reach"][side] = 0
    neighbourhood["pole"] = _pole_near(kind, i, j)
    if neighbourhood["pole"] >= 0:
        _cap(elements, raw, (e, neighbourhood["pole"]), (i, j), neighbourhood, work)
        return
    for a in range(-1, 2):
        for b in range(-1, 2):
            if 0 <= i + a < PARTS and 0 <= j + b < PARTS and (a != 0 or b != 0):
                _add_inside(raw, e, (i + a) * PARTS + j + b, (a, b), neighbourhood)
    out_s = 0 if i == 0 else (1 if i == PARTS - 1 else -1)
    out_t = 2 if j == 0 else (3 if j == PARTS - 1 else -1)
    for side in (out_s, out_t):
        if side >= 0:
            if kind[side] == SMOOTH:
                neighbourhood["reach"][side] = 1
                _add_across(elements, raw, e, side, j if side < 2 else i, neighbourhood)
            else:
                neighbourhood["ends"][side] = 1
    if out_s >= 0 and out_t >= 0:
        smooth = int(kind[out_s] == SMOOTH) + int(kind[out_t] == SMOOTH)
        corner = (-0.5 if out_s == 0 else 0.5, -0.5 if out_t == 2 else 0.5)
        closed = smooth == 0
        if smooth == 2:
            closed = _add_fan(elements, raw, e, corner, neighbourhood, work)
        elif smooth == 1:
            closed = _corner_is_open(elements, e, out_s, out_t)
        if not closed:
            neighbourhood["room"] = 0.0
    _block(elements, e, i, j, neighbourhood)


@kernel(error_model="numpy")
def join_parts(elements, raw, neighbourhoods, start, stop):
    """Fill neighbourhoods[element, part] of elements start … stop from the bounds of all parts."""
    work = (stack_int64(MOST), scratch(MOST, 2))
    for e in range(start, stop):
        box = elements.table[e]["box"]
        for i in range(PARTS):
            for j in range(PARTS):
                neighbourhood = neighbourhoods[e, i * PARTS + j]
                _neighbourhood(elements, raw, e, i, j, neighbourhood, work)
                widen(elements, raw, e, (i, j), neighbourhood)
                for axis in range(2):  # from local parameters to those of the patch
                    scale = 1.0 / (box[2 * axis + 1] - box[2 * axis])
                    neighbourhood["speed"][axis] *= scale
                    neighbourhood["width"][axis] *= scale
