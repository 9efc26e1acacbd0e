"""The elements that meet at a foot, and the direction of steepest descent among them."""

from __future__ import annotations

import math

from contiga.arrays.codes import CREASE, POLE
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.local_nb import SHIFT, expand

MAX_AROUND = 64
"""Largest number of elements around one point."""
POLE_SAMPLES = 8
"""Number of intervals along a collapsed side in which the deepest descent is searched."""
PARAMETER_TOL = 1e-9
"""Difference of parameters (s, t) below which two places count as one place."""
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
MAX_SECTIONS = 30


@inner()
def stands(side, s, t):
    """Return whether (s, t) lies on a side of its element."""
    if side == 0:
        return s <= -0.5
    if side == 1:
        return s >= 0.5
    if side == 2:
        return t <= -0.5
    return t >= 0.5


@kernel(linked=True)
def cross(elements, e, side, s, t):
    """Return the same point in the element across `side`: (element, s, t, its joined side).

    `side` must have a neighbour.
    """
    x = t if side < 2 else s
    if elements.table[e]["flip"][side] == 1:
        x = -x
    other = elements.table[e]["neighbour_side"][side]
    s, t = side_point(other, x)
    return elements.table[e]["neighbour"][side], s, t, other


@inner()
def collapsed_side(elements, e, s, t):
    """Return the side through (s, t) that is one point in space; −1 for none."""
    for side in range(4):
        if stands(side, s, t) and elements.table[e]["kind"][side] == POLE:
            return side
    return -1


@inner()
def _add(elements, foot, list_e, list_st, n):
    """Append a place (element, s, t) to the n listed ones unless it is there; return their number.

    A place on a collapsed side is listed as the side's middle. A full list (`MAX_AROUND`) stays as
    it is.
    """
    e, s, t = foot
    pole = collapsed_side(elements, e, s, t)
    if pole >= 0:  # one entry for the whole side
        s, t = side_point(pole, 0.0)
    for i in range(n):
        if list_e[i] == e and abs(list_st[i, 0] - s) + abs(list_st[i, 1] - t) < PARAMETER_TOL:
            return n
    if n < MAX_AROUND:
        list_e[n] = e
        list_st[n, 0] = s
        list_st[n, 1] = t
        n += 1
    return n


@kernel()
def around(elements, foot, list_e, list_st):
    """List the places (element, s, t) that are the point `foot`, over linked sides and poles.

    Writes list_e[MAX_AROUND] and list_st[MAX_AROUND, 2], `foot` first; returns their number. At
    `MAX_AROUND` some may be missing. A collapsed side is listed once, by its middle.
    """
    n = _add(elements, foot, list_e, list_st, 0)
    k = 0
    while k < n:
        e = list_e[k]
        s = list_st[k, 0]
        t = list_st[k, 1]
        k += 1
        pole = collapsed_side(elements, e, s, t)
        if pole < 0:
            for side in range(4):
                if stands(side, s, t) and elements.table[e]["kind"][side] <= CREASE:
                    e2, s2, t2, _ = cross(elements, e, side, s, t)
                    n = _add(elements, (e2, s2, t2), list_e, list_st, n)
            continue
        link = elements.table[e]["ring"][pole]
        s2, t2 = side_point(link % 4, 0.0)
        n = _add(elements, (link // 4, s2, t2), list_e, list_st, n)
        for end in range(2):  # the two sides that start from the pole
            side = (2 if pole < 2 else 0) + end
            if elements.table[e]["kind"][side] <= CREASE:
                s2, t2 = side_point(pole, end - 0.5)
                e2, s3, t3, _ = cross(elements, e, side, s2, t2)
                n = _add(elements, (e2, s3, t3), list_e, list_st, n)
    return n


@inner()
def inward_slope(q, side):
    """Return the slope of f per length inwards from a side, by the expansion q there.

    Zero where the derivative across the side vanishes.
    """
    g = q.f_s if side < 2 else q.f_t
    metric = q.square_s if side < 2 else q.square_t
    if metric <= 0.0:
        return 0.0
    return (-g if side & 1 else g) / math.sqrt(metric)


@inner()
def _fall_at(elements, e, side, x, point, h):
    """Return the slope of f inwards from a collapsed side at x, and a measure of the descent.

    The measure is −√2 times the root of the depth of the parabola that f follows there, or the
    slope if f does not fall. The deepest of these parabolas is in the direction of Newton's step in
    the tangent plane, unlike the steepest one if the surface has more curvature in another
    direction.
    """
    s, t = side_point(side, x)
    q = expand(elements, e, s, t, point, h)
    slope = inward_slope(q, side)
    metric = q.square_s if side < 2 else q.square_t
    if metric <= 0.0 or slope >= 0.0:
        return slope, slope
    curvature = (q.f_ss if side < 2 else q.f_tt) / metric
    return slope, slope / math.sqrt(max(curvature, SHIFT))


@inner()
def _deepest_from_pole(elements, e, side, point, h):
    """Return slope, descent and x at the place of a collapsed side where f falls most.

    See `_fall_at` for the descent. The method is golden-section search around the best of some
    samples.
    """
    best = math.inf
    best_x = 0.0
    for i in range(POLE_SAMPLES + 1):
        x = i / POLE_SAMPLES - 0.5
        _, fall = _fall_at(elements, e, side, x, point, h)
        if fall < best:
            best = fall
            best_x = x
    low = max(best_x - 1.0 / POLE_SAMPLES, -0.5)
    high = min(best_x + 1.0 / POLE_SAMPLES, 0.5)
    for _ in range(MAX_SECTIONS):
        a = high - GOLDEN * (high - low)
        b = low + GOLDEN * (high - low)
        _, fall_a = _fall_at(elements, e, side, a, point, h)
        _, fall_b = _fall_at(elements, e, side, b, point, h)
        if fall_a < fall_b:
            high = b
        else:
            low = a
    x = 0.5 * (low + high)
    slope, fall = _fall_at(elements, e, side, x, point, h)
    if fall >= best:
        x = best_x
        slope, fall = _fall_at(elements, e, side, x, point, h)
    return slope, fall, x


@inner()
def vertex_exit(elements, foot, point, miss, h):
    """Return the place (element, s, t) at a corner or pole from which f falls most.

    The steepest slope inwards from a side decides at a corner, the deepest descent (`_fall_at`) at
    a pole. The element is −1 if f falls nowhere; slopes above −`miss` count as level.
    """
    list_e = stack_int64(MAX_AROUND)
    list_st = scratch(MAX_AROUND, 2)
    n = around(elements, foot, list_e, list_st)
    best = -miss
    steepest = (-1, 0.0, 0.0)
    for k in range(n):
        e = list_e[k]
        s = list_st[k, 0]
        t = list_st[k, 1]
        pole = collapsed_side(elements, e, s, t)
        if pole >= 0:
            slope, fall, x = _deepest_from_pole(elements, e, pole, point, h)
            if slope < -miss and fall < best:
                best = fall
                s, t = side_point(pole, x)
                steepest = (e, s, t)
            continue
        q = expand(elements, e, s, t, point, h)
        for side in range(4):
            if stands(side, s, t):
                slope = inward_slope(q, side)
                if slope < best:
                    best = slope
                    steepest = (e, s, t)
    return steepest
