"""f = |S − P|²/2 about a foot, and the step that lowers it inside one element.

Newton's step (Piegl & Tiller, The NURBS Book, ch. 6) where the Hessian is positive definite, a
Levenberg shift elsewhere.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.search.closest.closest_records import Expansion

COLLAPSED = 1e-24
"""Ratio of |S_s|² to |S_t|², or the reverse, below which the side through a place is one point."""
MIN_EIGENVALUE = 1e-12
"""Smallest eigenvalue of a definite Hessian in the metric, as a share of the largest."""
SHIFT = 1e-3
"""Smallest eigenvalue of a shifted Hessian in the metric, as a share of the largest."""
ARMIJO = 1e-4
"""Share of the predicted decrease of f that a step must reach."""
MAX_HALVINGS = 40


@inner()
def expand(elements, e, s, t, point, h):
    """Return the `Expansion` at (s, t) of element e.

    `h` then holds the derivatives of S. Lengths are relative to the element's origin, so that no
    digits are lost far from the origin of the body.
    """
    evaluate(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    f = g_s = g_t = h_ss = h_st = h_tt = a = b = 0.0
    for c in range(3):
        r = h[c, 0] - (point[c] - origin[c])
        f += r * r
        g_s += r * h[c, 1]
        g_t += r * h[c, 2]
        a += h[c, 1] * h[c, 1]
        b += h[c, 2] * h[c, 2]
        h_ss += r * h[c, 3]
        h_st += r * h[c, 4] + h[c, 1] * h[c, 2]
        h_tt += r * h[c, 5]
    return Expansion(0.5 * f, g_s, g_t, h_ss + a, h_st, h_tt + b, a, b)


@inner()
def newton(q):
    """Return Newton's step (d_s, d_t) for the expansion q, its Hessian shifted where not definite.

    The shift makes the Hessian positive definite in the metric.
    """
    g_s, g_t, h_ss, h_st, h_tt = q.f_s, q.f_t, q.f_ss, q.f_st, q.f_tt
    a, b = q.square_s, q.square_t
    x = h_ss / a
    z = h_tt / b
    spread = math.sqrt(0.25 * (x - z) ** 2 + h_st * h_st / (a * b))
    low = 0.5 * (x + z) - spread
    top = max(1.0, 0.5 * (x + z) + spread)
    shift = 0.0
    if low < MIN_EIGENVALUE * top:
        shift = SHIFT * top - 1.5 * min(low, 0.0)
    p = h_ss + shift * a
    r = h_tt + shift * b
    det = p * r - h_st * h_st
    return (h_st * g_t - r * g_s) / det, (h_st * g_s - p * g_t) / det


@inner()
def newton_along(g, curvature, metric):
    """Return Newton's step of one variable with the derivative g.

    The metric replaces a curvature that is not positive (`MIN_EIGENVALUE`).
    """
    return -g / (curvature if curvature > MIN_EIGENVALUE * metric else metric)


@inner()
def leaves(x, d):
    """Return whether a step d leads out of [-1/2, 1/2] from its end x."""
    return (x <= -0.5 and d < 0.0) or (x >= 0.5 and d > 0.0)


@inner()
def direction(q, s, t, free_s, free_t):
    """Return a descent step (d_s, d_t) of the free variables that stays in the square at first.

    Newton's step if that does; else the step along a side, or of each variable by itself.
    """
    g_s, g_t = q.f_s, q.f_t
    d_s = newton_along(g_s, q.f_ss, q.square_s) if free_s else 0.0
    d_t = newton_along(g_t, q.f_tt, q.square_t) if free_t else 0.0
    if free_s and free_t:
        n_s, n_t = newton(q)
        out_s = leaves(s, n_s)
        out_t = leaves(t, n_t)
        if not out_s and not out_t:
            return n_s, n_t
        # A step across the side on which the foot lies is turned along that side.
        if out_s and not out_t and not leaves(t, d_t) and g_t * d_t < ARMIJO * g_s * d_s:
            return 0.0, d_t
        if out_t and not out_s and not leaves(s, d_s) and g_s * d_s < ARMIJO * g_t * d_t:
            return d_s, 0.0
    if leaves(s, d_s):
        d_s = 0.0
    if leaves(t, d_t):
        d_t = 0.0
    if free_s and free_t and d_s != 0.0 and d_t != 0.0:
        # Half of each one-variable step: their sum still lowers f.
        return 0.5 * d_s, 0.5 * d_t
    return d_s, d_t


@inner()
def _to_side(x, d):
    """Return the share of the step d at which x meets an end of [−1/2, 1/2]; 1 if it does not."""
    if x + d < -0.5:
        return (-0.5 - x) / d
    if x + d > 0.5:
        return (0.5 - x) / d
    return 1.0


@inner()
def _moved(x, d, reach, ends):
    """Return x + reach d, exactly on the side if the step ends there."""
    if ends:
        return math.copysign(0.5, d)
    return min(max(x + reach * d, -0.5), 0.5)


@inner()
def line_search(elements, e, foot, step, q, target, h):
    """Move the foot (s, t) by `step`, to the first side at most, halved until f decreases enough.

    Enough is `ARMIJO` of the predicted decrease; `target` is (point, noise): changes of f below the
    noise are its rounding. `q` is the expansion at the foot. Returns (whether the foot moved, s, t,
    expansion there); False and the old foot after `MAX_HALVINGS`.
    """
    point, noise = target
    s, t = foot
    d_s, d_t = step
    f = q.f
    descent = q.f_s * d_s + q.f_t * d_t
    reach_s = _to_side(s, d_s)
    reach_t = _to_side(t, d_t)
    reach = min(reach_s, reach_t)
    for k in range(MAX_HALVINGS):
        first = k == 0
        new_s = _moved(s, d_s, reach, first and reach_s <= reach and reach_s < 1.0)
        new_t = _moved(t, d_t, reach, first and reach_t <= reach and reach_t < 1.0)
        new = expand(elements, e, new_s, new_t, point, h)
        if new.f <= f + ARMIJO * reach * descent + noise:
            return new_s != s or new_t != t, new_s, new_t, new
        reach *= 0.5
    return False, s, t, expand(elements, e, s, t, point, h)
