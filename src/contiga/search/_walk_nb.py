"""The local foot from a start: safeguarded Newton that walks over elements and patches.

Stationary points of f = |S − P|²/2 on the element's square, whose sides are handled as an active
set: a foot that wants out through a side goes on in the element across it; where there is none,
or where the surface beyond the kink falls back too, the side is held and the foot moves along it.
At a collapsed side (a pole) the whole ring of elements around it is asked which way is down.
Newton's step (Piegl & Tiller, The NURBS Book, ch. 6) is used where the Hessian is positive
definite, a Levenberg shift elsewhere; every step must lower f.
"""

from __future__ import annotations

import math

from numba import njit

from contiga.search._element_nb import evaluate
from contiga.search._sides_nb import side_point

OK, BORDER_STATUS, MAX_ITERATIONS = 0, 1, 3
FACE, EDGE, VERTEX = 0, 1, 2
SMOOTH, CREASE, BORDER, POLE, SHARED = 0, 1, 2, 3, 4
STEPS = 80
CROSSINGS = 10
RING_SAMPLES = 5
ARMIJO = 1e-4


@njit(cache=True)
def _flipped(x, flip):
    return -x if flip else x


@njit(cache=True)
def cross(elements, e, side, s, t):
    """The same point of the surface seen from the element across `side`."""
    x = t if side < 2 else s
    other = elements.table[e]["neighbour_side"][side]
    s, t = side_point(other, _flipped(x, elements.table[e]["flip"][side] == 1))
    return elements.table[e]["neighbour"][side], s, t, other


@njit(cache=True)
def _pole_exit(elements, start, point, tolerance, h):
    """The steepest way down from a pole: element, s, t on its collapsed side, or element −1.

    `start` is element*4 + side of one of the sides around the pole.
    """
    best = -tolerance
    found = (-1, 0.0, 0.0)
    link = start
    while True:
        e = link // 4
        side = link % 4
        for i in range(RING_SAMPLES):
            s, t = side_point(side, i / (RING_SAMPLES - 1) - 0.5)
            evaluate(elements, e, s, t, h)
            column = 1 if side < 2 else 2
            inward = -1.0 if side & 1 else 1.0
            slope = 0.0
            length = 0.0
            for c in range(3):
                slope += (h[c, 0] + elements.table[e]["origin"][c] - point[c]) * h[c, column]
                length += h[c, column] ** 2
            if length > 0.0:
                slope *= inward / math.sqrt(length)
                if slope < best:
                    best = slope
                    found = (e, s, t)
        link = elements.table[e]["ring"][side]
        if link == start:
            return found


@njit(cache=True)
def _newton(g_s, g_t, h_ss, h_st, h_tt, scale):
    """Step of the 2×2 system, shifted to be positive definite in the metric `scale`."""
    a, b = scale  # |S_s|², |S_t|²
    floor = 1e-3
    shift = 0.0
    # Smallest eigenvalue of the Hessian measured in the metric's diagonal.
    x = h_ss / a
    z = h_tt / b
    y2 = h_st * h_st / (a * b)
    low = 0.5 * (x + z) - math.sqrt(0.25 * (x - z) ** 2 + y2)
    top = 0.5 * (x + z) + math.sqrt(0.25 * (x - z) ** 2 + y2)
    if low < 1e-12 * max(1.0, top):
        shift = floor * max(1.0, top) - 1.5 * min(low, 0.0)
    p = h_ss + shift * a
    r = h_tt + shift * b
    det = p * r - h_st * h_st
    return (-r * g_s + h_st * g_t) / det, (h_st * g_s - p * g_t) / det


@njit(cache=True)
def _half_squared(elements, e, s, t, point, h):
    evaluate(elements, e, s, t, h)
    f = 0.0
    for c in range(3):
        f += (h[c, 0] + elements.table[e]["origin"][c] - point[c]) ** 2
    return 0.5 * f


@njit(cache=True)
def walk(elements, start, point, tolerance, h):
    """Local foot of `point` from `start` = (element, s, t).

    Returns (status, element, s, t, feature). `tolerance` is a length: the tangential miss. `h`
    is a work table (4, 6) and holds the derivatives at the foot afterwards.
    """
    e, s, t = start
    came = -1  # side of e we have just come in by, with no step since
    crossings = 0
    f = _half_squared(elements, e, s, t, point, h)
    for _ in range(STEPS):
        g_s = g_t = h_ss = h_st = h_tt = 0.0
        a = b = 0.0
        for c in range(3):
            r = h[c, 0] + elements.table[e]["origin"][c] - point[c]
            g_s += r * h[c, 1]
            g_t += r * h[c, 2]
            a += h[c, 1] * h[c, 1]
            b += h[c, 2] * h[c, 2]
            h_ss += r * h[c, 3]
            h_st += r * h[c, 4] + h[c, 1] * h[c, 2]
            h_tt += r * h[c, 5]
        h_ss += a
        h_tt += b
        slip_s = abs(g_s) / math.sqrt(a) if a > 0.0 else 0.0
        slip_t = abs(g_t) / math.sqrt(b) if b > 0.0 else 0.0
        miss = tolerance + 8e-16 * math.sqrt(2.0 * f)
        # Sides the foot presses against.
        out_s = -1
        if slip_s > miss or a <= 1e-24 * b:
            if s <= -0.5 and g_s >= 0.0 and a > 0.0:
                out_s = 0
            elif s >= 0.5 and g_s <= 0.0 and a > 0.0:
                out_s = 1
        out_t = -1
        if slip_t > miss or b <= 1e-24 * a:
            if t <= -0.5 and g_t >= 0.0 and b > 0.0:
                out_t = 2
            elif t >= 0.5 and g_t <= 0.0 and b > 0.0:
                out_t = 3
        held_s = out_s >= 0
        held_t = out_t >= 0
        moved_on = False
        for k in range(2):
            side = out_s if k == 0 else out_t
            if side < 0 or crossings > CROSSINGS:
                continue
            kind = elements.table[e]["kind"][side]
            if kind == POLE:
                found = _pole_exit(elements, 4 * e + side, point, miss, h)
                crossings += 1
                if found[0] >= 0 and crossings <= CROSSINGS:
                    e, s, t = found
                    came = -1
                    moved_on = True
                    break
            elif kind <= CREASE and side != came:
                e, s, t, came = cross(elements, e, side, s, t)
                crossings += 1
                moved_on = True
                break
        if moved_on:
            f = _half_squared(elements, e, s, t, point, h)
            continue
        free_s = not held_s and a > 1e-24 * b
        free_t = not held_t and b > 1e-24 * a
        if (not free_s or slip_s <= miss) and (not free_t or slip_t <= miss):
            return _settle(elements, e, s, t, point, (out_s, out_t, a, b), h)
        if free_s and free_t:
            d_s, d_t = _newton(g_s, g_t, h_ss, h_st, h_tt, (a, b))
        elif free_s:
            d_s = -g_s / (h_ss if h_ss > 1e-3 * a else a)
            d_t = 0.0
        else:
            d_s = 0.0
            d_t = -g_t / (h_tt if h_tt > 1e-3 * b else b)
        # A step out through a side where the foot stands is bent along it.
        if (s <= -0.5 and d_s < 0.0) or (s >= 0.5 and d_s > 0.0):
            d_s = 0.0
            d_t = -g_t / (h_tt if h_tt > 1e-3 * b else b) if free_t else 0.0
            if (t <= -0.5 and d_t < 0.0) or (t >= 0.5 and d_t > 0.0):
                d_t = 0.0
        elif (t <= -0.5 and d_t < 0.0) or (t >= 0.5 and d_t > 0.0):
            d_t = 0.0
            d_s = -g_s / (h_ss if h_ss > 1e-3 * a else a) if free_s else 0.0
            if (s <= -0.5 and d_s < 0.0) or (s >= 0.5 and d_s > 0.0):
                d_s = 0.0
        descent = g_s * d_s + g_t * d_t
        if descent >= 0.0:
            if abs(d_s) + abs(d_t) > 0.0:
                return _settle(elements, e, s, t, point, (out_s, out_t, a, b), h)
            # Both ways lead out through sides the gradient does not press against.
            d_s = -g_s / a if free_s and not _leaves(s, -g_s) else 0.0
            d_t = -g_t / b if free_t and not _leaves(t, -g_t) else 0.0
            descent = g_s * d_s + g_t * d_t
            if descent >= 0.0:
                return _settle(elements, e, s, t, point, (out_s, out_t, a, b), h)
        # To the first side the step meets, at most.
        reach = 1.0
        hit_s = 0
        hit_t = 0
        if s + d_s < -0.5:
            reach = (-0.5 - s) / d_s
            hit_s = -1
        elif s + d_s > 0.5:
            reach = (0.5 - s) / d_s
            hit_s = 1
        if t + d_t < -0.5:
            reach_t = (-0.5 - t) / d_t
            if reach_t < reach:
                reach = reach_t
                hit_s = 0
                hit_t = -1
        elif t + d_t > 0.5:
            reach_t = (0.5 - t) / d_t
            if reach_t < reach:
                reach = reach_t
                hit_s = 0
                hit_t = 1
        accepted = False
        for k in range(40):
            new_s = 0.5 * hit_s if hit_s != 0 and k == 0 else s + reach * d_s
            new_t = 0.5 * hit_t if hit_t != 0 and k == 0 else t + reach * d_t
            new_s = min(max(new_s, -0.5), 0.5)
            new_t = min(max(new_t, -0.5), 0.5)
            new_f = _half_squared(elements, e, new_s, new_t, point, h)
            if new_f <= f + ARMIJO * reach * descent + 4e-16 * f:
                accepted = new_s != s or new_t != t
                break
            reach *= 0.5
        if not accepted:
            # Rounding: f cannot be lowered any more from here.
            f = _half_squared(elements, e, s, t, point, h)
            small = 1e4 * miss
            if (not free_s or slip_s <= small) and (not free_t or slip_t <= small):
                return _settle(elements, e, s, t, point, (out_s, out_t, a, b), h)
            return MAX_ITERATIONS, e, s, t, FACE
        if new_f < f:
            crossings = 0
        s = new_s
        t = new_t
        f = new_f
        came = -1
    return MAX_ITERATIONS, e, s, t, FACE


@njit(cache=True)
def _leaves(x, d):
    return (x <= -0.5 and d < 0.0) or (x >= 0.5 and d > 0.0)


@njit(cache=True)
def _settle(elements, e, s, t, point, state, h):
    """Status and feature of a converged foot, from the sides it presses against."""
    out_s, out_t, a, b = state
    status = OK
    held = 0
    for side in (out_s, out_t):
        if side >= 0:
            held += 1
            if elements.table[e]["kind"][side] == BORDER:
                status = BORDER_STATUS
    if a <= 1e-24 * b or b <= 1e-24 * a:
        held = 2 if held > 0 else 0
    return status, e, s, t, held
