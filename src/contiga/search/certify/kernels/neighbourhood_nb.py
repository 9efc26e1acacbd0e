"""Bounds around every sixteenth of an element, for the quick certificate of a tracked foot.

The neighbourhood of a foot in one of the 4 × 4 parts of an element is formed by the parts around
it: of the element itself and, across smooth sides and corners, of adjoining elements. A path that
leaves it is at least `room` long, unless it leaves over a side where the surface ends or has a
kink; `ends` marks these sides.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE, SMOOTH
from contiga.arrays.kernels.rows_nb import put
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import (
    INNER,
    N_BENDS,
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
    N_PARTS,
    add_curvature,
    add_metric,
    adjoins,
    is_untrimmed_beyond,
    part_of,
    scales,
)
from contiga.search.certify.kernels.pole_nb import pole_bounds, pole_side
from contiga.search.certify.kernels.wide_neighbourhood_nb import widen
from contiga.search.closest.kernels.around_nb import MAX_AROUND, around, stands

POLE_PARTS = 2
"""Largest distance from a pole, in parts, of parts whose neighbourhood is a cap around the pole."""
MAX_LOOSENESS = 1.3
"""Largest ratio of tight bounds to the curvatures."""
MAX_TURN = 0.02
"""Turn of the normal in a cell, rad, up to which any bounds are tight enough."""


@kernel(error_model="numpy")
def bends_of_parts(elements, depth, raw, start, stop):
    """Write the bounds raw[element, part, 6] of all parts of elements start … stop.

    The six bounds are those of `bend_bounds`. Parts are quartered until the bounds of their pieces
    are tight, at most `depth` times. A part of which a piece has no bounds has infinite curvatures
    and zero widths.
    """
    stack, bend, work = scratch(16, 5), scratch(N_BENDS), bend_work()
    h = work.derivatives
    for k in range(start * N_PARTS * N_PARTS, stop * N_PARTS * N_PARTS):
        e, part = k // (N_PARTS * N_PARTS), k % (N_PARTS * N_PARTS)
        s, t = part // N_PARTS / N_PARTS - 0.5, part % N_PARTS / N_PARTS - 0.5
        total = raw[e, part]
        total[:] = 0.0
        total[WIDTH_S] = total[WIDTH_T] = math.inf
        put(stack, 0, (s, s + 1.0 / N_PARTS, t, t + 1.0 / N_PARTS, 0.0))
        top = 1
        while top > 0:
            top -= 1
            s0, s1, t0, t1, level = stack[top]
            cell = (s0, s1, t0, t1)
            pole = pole_side(elements, e, cell)
            if pole >= 0:
                has_bounds = pole_bounds(elements, e, cell, pole, bend, work)
            else:
                has_bounds = bend_bounds(elements, e, cell, bend, work)
            # Next to a pole smaller cells that do not touch it have looser bounds than one that
            # does. Elsewhere bounds are tight if they are about as large as the curvatures in the
            # middle.
            is_tight = has_bounds
            if has_bounds and pole < 0:
                inner, outer, _ = principal(h)
                largest = max(bend[INNER], bend[OUTER])
                is_tight = largest <= MAX_LOOSENESS * max(inner, outer)
                is_tight = is_tight or largest * (length(h, 1) + length(h, 2)) <= MAX_TURN
            if level >= depth or is_tight:
                for c in range(WIDTH_S):
                    total[c] = max(total[c], bend[c])
                for c in range(WIDTH_S, N_BENDS):
                    total[c] = min(total[c], bend[c])
                if not has_bounds:
                    break
                continue
            s2, t2 = 0.5 * (s0 + s1), 0.5 * (t0 + t1)
            put(stack, top, (s0, s2, t0, t2, level + 1.0))
            put(stack, top + 1, (s2, s1, t0, t2, level + 1.0))
            put(stack, top + 2, (s0, s2, t2, t1, level + 1.0))
            put(stack, top + 3, (s2, s1, t2, t1, level + 1.0))
            top += 4


@inner(error_model="numpy")
def _limit_room(neighbourhood, length):
    """Limit the length of paths that leave a neighbourhood to `length`."""
    neighbourhood["room"] = min(neighbourhood["room"], length)


@inner(error_model="numpy")
def _add_parts_across(elements, raw, e, side, along, neighbourhood):
    """Extend a neighbourhood by the parts across a smooth side of element e.

    These are the part that adjoins the one with index `along` the side, and its neighbours along
    the side. They extend curvature, room, and the width by the parameter along the side; the other
    width and the speeds only if the parameters of e continue there (`adjoins`). The room becomes
    zero if the other element may be trimmed.
    """
    n, side_there = elements.table[e]["neighbour"][side], elements.table[e]["neighbour_side"][side]
    edge = 0 if side_there & 1 == 0 else N_PARTS - 1
    if not is_untrimmed_beyond(elements, e, n):
        neighbourhood["room"] = 0.0
    for k in range(max(along - 1, 0), min(along + 2, N_PARTS)):
        index = N_PARTS - 1 - k if elements.table[e]["flip"][side] == 1 else k
        bend = raw[n, edge * N_PARTS + index if side_there < 2 else index * N_PARTS + edge]
        add_curvature(neighbourhood, bend)
        _limit_room(neighbourhood, bend[WIDTH_S if side_there < 2 else WIDTH_T] / N_PARTS)
        if k != along:
            _limit_room(neighbourhood, bend[WIDTH_T if side_there < 2 else WIDTH_S] / N_PARTS)
        if adjoins(elements, e, n, side):
            scale_s, scale_t = scales(elements, e, n)
            add_metric(neighbourhood, bend, scale_s, scale_t)
        else:  # joined point by point: the parameter along the side is the same
            axis = 1 if side < 2 else 0
            width = bend[WIDTH_T if side_there < 2 else WIDTH_S]
            neighbourhood["width"][axis] = min(neighbourhood["width"][axis], width)


@inner(error_model="numpy")
def _add_parts_at_corner(elements, raw, e, out, neighbourhood, work):
    """Extend a neighbourhood by the parts around the corner between the sides `out` of element e.

    Returns False if a path may leave there, over a kink, a border or a trim, or too many elements
    meet. Nothing is added if one of the two sides is not smooth. `work` are the lists of `around`.
    """
    table, (side_s, side_t), (list_e, list_st) = elements.table, out, work
    smooth_s, smooth_t = table[e]["kind"][side_s] == SMOOTH, table[e]["kind"][side_t] == SMOOTH
    if not (smooth_s and smooth_t):
        if not (smooth_s or smooth_t):
            return True
        # Beyond the smooth side the surface has to end where it ends here.
        smooth_side, end_side = (side_s, side_t) if smooth_s else (side_t, side_s)
        side_there = table[e]["neighbour_side"][smooth_side]
        end = (end_side & 1) ^ table[e]["flip"][smooth_side]
        kind = table[table[e]["neighbour"][smooth_side]]["kind"][(2 if side_there < 2 else 0) + end]
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
        if not is_untrimmed_beyond(elements, e, e2):
            return False
        bend = raw[e2, part_of(s2, t2)]
        add_curvature(neighbourhood, bend)
        _limit_room(neighbourhood, min(bend[WIDTH_S], bend[WIDTH_T]) / N_PARTS)
        if table[e2]["patch"] == table[e]["patch"]:
            scale_s, scale_t = scales(elements, e, e2)
            add_metric(neighbourhood, bend, scale_s, scale_t)
    return True


@inner(error_model="numpy")
def _fill_at_pole(elements, raw, foot, part, neighbourhood, work):
    """Fill the record of a part near a pole with the cap around it, one part deeper than this one.

    `foot` is (element, side that is the pole). A path leaves the cap only over its rim. The room is
    zero if the elements around do not close smoothly, or may be trimmed.
    """
    e, side = foot
    list_e = work[0]
    list_side = stack_int64(MAX_AROUND)
    # The elements around the pole; none if the ring is too long, or not smooth all around.
    n, link, is_smooth = 0, 4 * e + side, True
    while n < MAX_AROUND and (n == 0 or link != 4 * e + side):
        list_e[n] = link // 4
        list_side[n] = link % 4
        lateral = 2 if list_side[n] < 2 else 0
        kind = elements.table[list_e[n]]["kind"]
        is_smooth = is_smooth and kind[lateral] == SMOOTH and kind[lateral + 1] == SMOOTH
        link = elements.table[list_e[n]]["ring"][list_side[n]]
        n += 1
    if n == MAX_AROUND or not is_smooth:
        n = 0
    k = part[0] if side < 2 else part[1]
    n_deep = (k if side & 1 == 0 else N_PARTS - 1 - k) + 1
    box = elements.table[e]["box"]
    for c in range(4):
        neighbourhood["block"][c] = box[c]
    axis = 0 if side < 2 else 2
    cap_depth = (n_deep + 1) / N_PARTS * (box[axis + 1] - box[axis])
    neighbourhood["block"][axis + 1 if side & 1 == 0 else axis] = (
        box[axis] + cap_depth if side & 1 == 0 else box[axis + 1] - cap_depth
    )
    if n == 0 or n_deep >= N_PARTS:
        neighbourhood["room"] = 0.0
    for f in range(n):
        e2 = list_e[f]
        if not is_untrimmed_beyond(elements, e, e2):
            neighbourhood["room"] = 0.0
        is_same_patch = (
            elements.table[e2]["patch"] == elements.table[e]["patch"] and list_side[f] == side
        )
        for depth in range(min(n_deep + 1, N_PARTS)):
            for along in range(N_PARTS):
                off = depth if list_side[f] & 1 == 0 else N_PARTS - 1 - depth
                by_s = list_side[f] < 2
                bend = raw[e2, off * N_PARTS + along if by_s else along * N_PARTS + off]
                add_curvature(neighbourhood, bend)
                if depth == n_deep:
                    _limit_room(neighbourhood, bend[WIDTH_S if by_s else WIDTH_T] / N_PARTS)
                if is_same_patch:
                    scale_s, scale_t = scales(elements, e, e2)
                    add_metric(neighbourhood, bend, scale_s, scale_t)
        if is_same_patch:
            box2 = elements.table[e2]["box"]
            low = 2 - axis
            neighbourhood["block"][low] = min(neighbourhood["block"][low], box2[low])
            neighbourhood["block"][low + 1] = max(neighbourhood["block"][low + 1], box2[low + 1])


@inner(error_model="numpy")
def _fill_record(elements, raw, e, part, neighbourhood, work):
    """Fill the record of a part (i, j) of element e, with speeds and widths by local parameters.

    Near a round pole its neighbourhood is a cap, elsewhere the 3 × 3 parts around it, across smooth
    sides and corners, too.
    """
    i, j = part
    bend = raw[e, i * N_PARTS + j]
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
        # A pole without a tangent plane is an end like others.
        if is_round[side] == 1 and (k if side & 1 == 0 else N_PARTS - 1 - k) <= POLE_PARTS:
            neighbourhood["pole"] = side
    if neighbourhood["pole"] >= 0:
        _fill_at_pole(elements, raw, (e, neighbourhood["pole"]), part, neighbourhood, work)
        return
    for a in range(max(i - 1, 0), min(i + 2, N_PARTS)):
        for b in range(max(j - 1, 0), min(j + 2, N_PARTS)):
            bend = raw[e, a * N_PARTS + b]
            add_curvature(neighbourhood, bend)
            add_metric(neighbourhood, bend, 1.0, 1.0)
            if a != i:
                _limit_room(neighbourhood, bend[WIDTH_S] / N_PARTS)
            if b != j:
                _limit_room(neighbourhood, bend[WIDTH_T] / N_PARTS)
    out_s = 0 if i == 0 else (1 if i == N_PARTS - 1 else -1)
    out_t = 2 if j == 0 else (3 if j == N_PARTS - 1 else -1)
    for side in (out_s, out_t):
        if side >= 0:
            if kind[side] == SMOOTH:
                neighbourhood["reach"][side] = 1
                _add_parts_across(elements, raw, e, side, j if side < 2 else i, neighbourhood)
            else:
                neighbourhood["ends"][side] = 1
    out = out_s, out_t
    if (
        out_s >= 0
        and out_t >= 0
        and not _add_parts_at_corner(elements, raw, e, out, neighbourhood, work)
    ):
        neighbourhood["room"] = 0.0
    # The block of the patch's parameters around the part, as far as the neighbourhood covers it.
    table, box = elements.table, elements.table[e]["box"]
    for side in range(4):
        axis, end = side >> 1, side & 1
        k = i if axis == 0 else j
        width = (box[2 * axis + 1] - box[2 * axis]) / N_PARTS
        edge = box[2 * axis] + (max(k - 1, 0) if end == 0 else min(k + 2, N_PARTS)) * width
        if k == (N_PARTS - 1 if end == 1 else 0):
            edge = box[side]
            n = table[e]["neighbour"][side]
            if kind[side] == SMOOTH and adjoins(elements, e, n, side):
                part_width = (table[n]["box"][2 * axis + 1] - table[n]["box"][2 * axis]) / N_PARTS
                edge += part_width if end == 1 else -part_width
        neighbourhood["block"][side] = edge


@kernel(error_model="numpy")
def join_parts(elements, raw, neighbourhoods, start, stop):
    """Fill neighbourhoods[element, part] of elements start … stop from the bounds of all parts.

    Each is widened where that is better (`widen`), and its speeds and widths end up by (u, v).
    """
    work = (stack_int64(MAX_AROUND), scratch(MAX_AROUND, 2))
    for e in range(start, stop):
        box = elements.table[e]["box"]
        for i in range(N_PARTS):
            for j in range(N_PARTS):
                neighbourhood = neighbourhoods[e, i * N_PARTS + j]
                _fill_record(elements, raw, e, (i, j), neighbourhood, work)
                widen(elements, raw, e, (i, j), neighbourhood)
                for axis in range(2):  # from local parameters to those of the patch
                    scale = 1.0 / (box[2 * axis + 1] - box[2 * axis])
                    neighbourhood["speed"][axis] *= scale
                    neighbourhood["width"][axis] *= scale
