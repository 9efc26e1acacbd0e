"""A force between a loading and an unloading curve, moved along a line of the slope K between them.

The formulas are those of `contiga.curves.hysteresis`, with their reasons. Pair p of `Curves` is the
loading curve 2 p and the unloading curve 2 p + 1. Below x = 0 the force is zero.
"""

from __future__ import annotations

import math

from contiga.curves.curve_records import Response
from contiga.curves.kernels.curve_nb import curve_at
from contiga.jit import inner, kernel

PARALLEL = 1e-12
"""Relative difference of slopes below which a line and a piece of a curve are parallel."""


@inner()
def _meet(curves, c, slope, x, force, low, high):
    """Return where the line through (x, force) meets curve c, clipped to [low, high].

    The line less the curve, K x − y, never falls: its level is found by bisection. On a piece
    parallel to the line it is the beginning of the piece.
    """
    first, stop = curves.first[c], curves.first[c + 1]
    level = slope * x - force
    j, end = first, stop
    while end - j > 1:
        middle = (j + end) // 2
        if slope * curves.x[middle] - curves.y[middle] <= level:
            j = middle
        else:
            end = middle
    slope_difference = slope - curves.slope[j + c + 1]
    dx = 0.0
    if slope_difference > PARALLEL * slope:
        dx = max((level - (slope * curves.x[j] - curves.y[j])) / slope_difference, 0.0)
    last = curves.x[j + 1] if j + 1 < stop else math.inf
    return min(max(min(curves.x[j] + dx, last), low), high)


@inner()
def _stored(curves, unloading, slope, x, force):
    """Return the energy that an unloading from (x, force) returns."""
    meet = _meet(curves, unloading, slope, x, force, 0.0, x)
    dx = x - meet
    return dx * (force - 0.5 * slope * dx) + curve_at(curves, unloading, meet).integral


@inner(linked=False)
def hysteretic(curves, pair, slope, x_old, f_old, x):
    """Return the `Response` to a step from (x_old, f_old) to x; all zero below x = 0.

    A force without memory, x_old ≤ 0, starts at x = 0, from f_old clipped to the curves.
    """
    if x < 0.0:
        return Response(0.0, 0.0, 0.0, 0.0)
    loading, unloading = 2 * pair, 2 * pair + 1
    start = f_old
    if not x_old > 0.0:
        x_old, least = 0.0, curve_at(curves, unloading, 0.0).value
        start = min(max(f_old, least), curve_at(curves, loading, 0.0).value)
    upper, lower = curve_at(curves, loading, x), curve_at(curves, unloading, x)
    line = start + slope * (x - x_old)
    # If rounding puts the unloading curve above the loading curve, the latter decides.
    force = min(max(line, lower.value), upper.value)
    is_upper = force >= upper.value
    stored = _stored(curves, unloading, slope, x, force)
    lost = 0.0
    if is_upper and x > x_old:
        # Work along the line up to the loading curve, and then along that.
        meet = _meet(curves, loading, slope, x_old, start, x_old, x)
        dx = meet - x_old
        on_curve = upper.integral - curve_at(curves, loading, meet).integral
        work = dx * (start + 0.5 * slope * dx) + on_curve
        lost = work - (stored - _stored(curves, unloading, slope, x_old, start))
    stiffness = slope
    if is_upper:
        stiffness = upper.slope
    elif line <= lower.value:
        stiffness = lower.slope
    return Response(force, stiffness, stored, lost)


@kernel()
def step(curves, slope, x_old, f_old, x):
    """Return force, stiffness, stored and lost energy of the first pair after a step to x."""
    at = hysteretic(curves, 0, slope, x_old, f_old, x)
    return at.force, at.stiffness, at.stored, at.lost


@kernel()
def steps(curves, slope, past, x, out):
    """Write force, stiffness, stored and lost energy of the first pair to the rows of `out` (4, n).

    `past` (2, n) holds x and force at the start of the step, `x` (n,) is at its end.
    """
    for i in range(x.shape[0]):
        at = hysteretic(curves, 0, slope, past[0, i], past[1, i], x[i])
        out[0, i], out[1, i], out[2, i], out[3, i] = at.force, at.stiffness, at.stored, at.lost
