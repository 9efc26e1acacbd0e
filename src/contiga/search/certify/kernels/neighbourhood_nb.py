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
from contiga.search.closest.kernels.around_nb import MAX_AROUND, around, stands

BY_POLE = 2
"""Parts this close to a pole have all that is round it for surroundings."""
TIGHT = 1.3
"""Bounds this many times as large as the curvatures are good enough,"""
FLAT = 0.02
"""and so are those of a cell that turns by no more than this (radians)."""


@kernel(error_model="numpy")
def bends_of_parts(elements, depth, raw, start, stop):
    """Bounds of all parts of elements start … stop into raw[element, part, 6].

    From those of their pieces: quartered until they are tight, `depth` times at most.
    """
    stack, bend, work = scratch(16, 5), scratch(BENDS), bend_work()
    h = work.derivatives
    for k in range(start * PARTS * PARTS, stop * PARTS * PARTS):
        e, part = k // (PARTS * PARTS), k % (PARTS * PARTS)
        s, t = part // PARTS / PARTS - 0.5, part % PARTS / PARTS - 0.5
        total = raw[e, part]
        total[:] = 0.0
        total[WIDTH_S] = total[WIDTH_T] = math.inf
        put(stack, 0, (s, s + 1.0 / PARTS, t, t + 1.0 / PARTS, 0.0))
        top = 1
        while top > 0:
            top -= 1
            s0, s1, t0, t1, level = stack[top]
            cell = (s0, s1, t0, t1)
            pole = pole_side(elements, e, cell)
            if pole >= 0:
                good = pole_bounds(elements, e, cell, pole, bend, work)
            else:
                good = bend_bounds(elements, e, cell, bend, work)
            # Next to a pole smaller cells that do not touch it have looser bounds than one that
            # does. Elsewhere bounds are tight if they are about as large as the curvatures in the
            # middle.
            tight = good
            if good and pole < 0:
                inner, outer, _ = principal(h)
                largest = max(bend[INNER], bend[OUTER])
                tight = largest <= TIGHT * max(inner, outer)
                tight = tight or largest * (length(h, 1) + length(h, 2)) <= FLAT
            if level >= depth or tight:
                for c in range(WIDTH_S):
                    total[c] = max(total[c], bend[c])
                for c in range(WIDTH_S, BENDS):
                    total[c] = min(total[c], bend[c])
                if not good:
                    break
                continue
            s2, t2 = 0.5 * (s0 + s1), 0.5 * (t0 + t1)
            put(stack, top, (s0, s2, t0, t2, level + 1.0))
            put(stack, top + 1, (s2, s1, t0, t2, level + 1.0))
            put(stack, top + 2, (s0, s2, t2, t1, level + 1.0))
            put(stack, top + 3, (s2, s1, t2, t1, level + 1.0))
            top += 4


@inner(error_model="numpy")
def _keep_room(neighbourhood, length):
    """A way that leads out may be as short as `length`."""
    neighbourhood["room"] = min(neighbourhood["room"], length)


@inner(error_model="numpy")
def _add_across(elements, raw, e, side, along, neighbourhood):
    """The parts across a smooth side of element e: the one that adjoins, and those beside it."""
    n, there = elements.table[e]["neighbour"][side], elements.table[e]["neighbour_side"][side]
    edge = 0 if there & 1 == 0 else PARTS - 1
    if not is_whole(elements, e, n):
        neighbourhood["room"] = 0.0
    for k in range(max(along - 1, 0), min(along + 2, PARTS)):
        beside = PARTS - 1 - k if elements.table[e]["flip"][side] == 1 else k
        bend = raw[n, edge * PARTS + beside if there < 2 else beside * PARTS + edge]
        take_curvature(neighbourhood, bend)
        _keep_room(neighbourhood, bend[WIDTH_S if there < 2 else WIDTH_T] / PARTS)
        if k != along:
            _keep_room(neighbourhood, bend[WIDTH_T if there < 2 else WIDTH_S] / PARTS)
        if adjoins(elements, e, n, side):
            scale_s, scale_t = scales(elements, e, n)
            take_metric(neighbourhood, bend, scale_s, scale_t)
        else:  # linked point by point: the parameter along the side is the same
            axis = 1 if side < 2 else 0
            width = bend[WIDTH_T if there < 2 else WIDTH_S]
            neighbourhood["width"][axis] = min(neighbourhood["width"][axis], width)


@inner(error_model="numpy")
def _add_corner(elements, raw, e, out, neighbourhood, work):
    """The parts of all elements around the corner between the sides `out` of element e; False where
    a way may lead out there, by a kink or an end."""
    table, (side_s, side_t), (list_e, list_st) = elements.table, out, work
    smooth_s, smooth_t = table[e]["kind"][side_s] == SMOOTH, table[e]["kind"][side_t] == SMOOTH
    if not (smooth_s and smooth_t):
        if not (smooth_s or smooth_t):
            return True
        # Beyond the smooth side the surface has to end where it ends here.
        smooth, ended = (side_s, side_t) if smooth_s else (side_t, side_s)
        there = table[e]["neighbour_side"][smooth]
        end = (ended & 1) ^ table[e]["flip"][smooth]
        kind = table[table[e]["neighbour"][smooth]]["kind"][(2 if there < 2 else 0) + end]
        return kind != SMOOTH and kind != POLE
    s, t = -0.5 if side_s == 0 else 0.5, -0.5 if side_t == 2 else 0.5
    n = around(elements, (e, s, t), list_e, list_st)
    if n >= MAX_AROUND:
        return False
    for k in range(n):
        e2 = list_e[k]
        s2 = list_st[k, 0]
        t2 = list_st[k, 1]
        for side in range(4):
            if stands(side, s2, t2) and table[e2]["kind"][side] != SMOOTH:
                return False
        if e2 == e:
            continue
        if not is_whole(elements, e, e2):
            return False
        bend = raw[e2, part_of(s2, t2)]
        take_curvature(neighbourhood, bend)
        _keep_room(neighbourhood, min(bend[WIDTH_S], bend[WIDTH_T]) / PARTS)
        if table[e2]["patch"] == table[e]["patch"]:
            scale_s, scale_t = scales(elements, e, e2)
            take_metric(neighbourhood, bend, scale_s, scale_t)
    return True


@inner(error_model="numpy")
def _fan_of_pole(elements, e, side, list_e, list_side):
    """Elements around the round pole that is a side of e; 0 where they do not join smoothly."""
    n = 0
    link = 4 * e + side
    while n < MAX_AROUND:
        list_e[n] = link // 4
        list_side[n] = link % 4
        n += 1
        link = elements.table[list_e[n - 1]]["ring"][list_side[n - 1]]
        if link == 4 * e + side:
            break
    if n == MAX_AROUND:
        return 0
    for k in range(n):
        lateral = 2 if list_side[k] < 2 else 0
        kind = elements.table[list_e[k]]["kind"]
        if kind[lateral] != SMOOTH or kind[lateral + 1] != SMOOTH:
            return 0
    return n


@inner(error_model="numpy")
def _cap(elements, raw, foot, part, neighbourhood, work):
    """Fill the record of a part beside a pole: all round it, one part farther than this one.

    `foot` is (element, side that is the pole). A way leads out only over the far rim.
    """
    e, side = foot
    list_e = work[0]
    list_side = stack_int64(MAX_AROUND)
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
                off = depth if list_side[f] & 1 == 0 else PARTS - 1 - depth
                by_s = list_side[f] < 2
                bend = raw[e2, off * PARTS + along if by_s else along * PARTS + off]
                take_curvature(neighbourhood, bend)
                if depth == deep:
                    _keep_room(neighbourhood, bend[WIDTH_S if by_s else WIDTH_T] / PARTS)
                if same:
                    scale_s, scale_t = scales(elements, e, e2)
                    take_metric(neighbourhood, bend, scale_s, scale_t)
        if same:
            other = elements.table[e2]["box"]
            low = 2 - axis
            neighbourhood["block"][low] = min(neighbourhood["block"][low], other[low])
            neighbourhood["block"][low + 1] = max(neighbourhood["block"][low + 1], other[low + 1])


@inner(error_model="numpy")
def _fill(elements, raw, e, part, neighbourhood, work):
    """Fill the record of a part (i, j) of element e."""
    i, j = part
    bend = raw[e, i * PARTS + j]
    kind, is_round = elements.table[e]["kind"], elements.table[e]["round"]
    neighbourhood["curvature"][0] = bend[INNER]
    neighbourhood["curvature"][1] = bend[OUTER]
    neighbourhood["room"] = math.inf
    neighbourhood["speed"][0] = bend[SPEED_S]
    neighbourhood["speed"][1] = bend[SPEED_T]
    neighbourhood["width"][0] = bend[WIDTH_S]
    neighbourhood["width"][1] = bend[WIDTH_T]
    neighbourhood["pole"] = -1
    for side in range(3, -1, -1):
        neighbourhood["ends"][side] = neighbourhood["reach"][side] = 0
        k = i if side < 2 else j
        # Where the surface does not close round it in one plane, a pole is an end like others.
        if is_round[side] == 1 and (k if side & 1 == 0 else PARTS - 1 - k) <= BY_POLE:
            neighbourhood["pole"] = side
    if neighbourhood["pole"] >= 0:
        _cap(elements, raw, (e, neighbourhood["pole"]), part, neighbourhood, work)
        return
    for a in range(max(i - 1, 0), min(i + 2, PARTS)):
        for b in range(max(j - 1, 0), min(j + 2, PARTS)):
            bend = raw[e, a * PARTS + b]
            take_curvature(neighbourhood, bend)
            take_metric(neighbourhood, bend, 1.0, 1.0)
            if a != i:
                _keep_room(neighbourhood, bend[WIDTH_S] / PARTS)
            if b != j:
                _keep_room(neighbourhood, bend[WIDTH_T] / PARTS)
    out_s = 0 if i == 0 else (1 if i == PARTS - 1 else -1)
    out_t = 2 if j == 0 else (3 if j == PARTS - 1 else -1)
    for side in (out_s, out_t):
        if side >= 0:
            if kind[side] == SMOOTH:
                neighbourhood["reach"][side] = 1
                _add_across(elements, raw, e, side, j if side < 2 else i, neighbourhood)
            else:
                neighbourhood["ends"][side] = 1
    out = out_s, out_t
    if out_s >= 0 and out_t >= 0 and not _add_corner(elements, raw, e, out, neighbourhood, work):
        neighbourhood["room"] = 0.0
    # The parameters of the patch around the part, as far as its surroundings go on in them.
    table, box = elements.table, elements.table[e]["box"]
    for side in range(4):
        axis, end = side >> 1, side & 1
        k = i if axis == 0 else j
        wide = (box[2 * axis + 1] - box[2 * axis]) / PARTS
        edge = box[2 * axis] + (max(k - 1, 0) if end == 0 else min(k + 2, PARTS)) * wide
        if k == (PARTS - 1 if end == 1 else 0):
            edge = box[side]
            n = table[e]["neighbour"][side]
            if kind[side] == SMOOTH and adjoins(elements, e, n, side):
                beyond = (table[n]["box"][2 * axis + 1] - table[n]["box"][2 * axis]) / PARTS
                edge += beyond if end == 1 else -beyond
        neighbourhood["block"][side] = edge


@kernel(error_model="numpy")
def join_parts(elements, raw, neighbourhoods, start, stop):
    """Fill neighbourhoods[element, part] of elements start … stop from the bounds of all parts."""
    work = (stack_int64(MAX_AROUND), scratch(MAX_AROUND, 2))
    for e in range(start, stop):
        box = elements.table[e]["box"]
        for i in range(PARTS):
            for j in range(PARTS):
                neighbourhood = neighbourhoods[e, i * PARTS + j]
                _fill(elements, raw, e, (i, j), neighbourhood, work)
                widen(elements, raw, e, (i, j), neighbourhood)
                for axis in range(2):  # from local parameters to those of the patch
                    scale = 1.0 / (box[2 * axis + 1] - box[2 * axis])
                    neighbourhood["speed"][axis] *= scale
                    neighbourhood["width"][axis] *= scale
