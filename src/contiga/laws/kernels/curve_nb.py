"""Forces of tables, elastic or between a loading and an unloading curve: a point after the other.

The formulas are those of `contiga.laws.hysteresis`, which says why they hold.
"""

from __future__ import annotations

import math

from contiga.arrays.kernels.sort_nb import count_up_to
from contiga.jit import inner, kernel

SAME = 1e-12
"""Relative difference of slopes that counts as none."""
FORCE, STIFFNESS, STORED, LOST = 0, 1, 2, 3
"""Rows of what is answered, as `Moved`."""


@inner()
def _carried(curve, x):
    """Force at x, the slope behind it, and ∫ of the force from zero."""
    j = max(count_up_to(curve.x, x) - 1, 0)
    way = max(x - curve.x[j], 0.0)
    y = curve.slope[j] * way + curve.y[j]
    return y, curve.slope[j], curve.energy[j] + 0.5 * way * (curve.y[j] + y)


@kernel()
def elastic(curve, x, moved):
    """Force, stiffness and stored energy of an elastic curve at x (n,); nothing is lost."""
    for i in range(x.shape[0]):
        y, slope, energy = _carried(curve, x[i])
        moved[FORCE, i] = y
        moved[STIFFNESS, i] = slope
        moved[STORED, i] = energy
        moved[LOST, i] = 0.0


@inner()
def _meet(table, slope, x, force, low, high):
    """Where the line through (x, force) meets a `BoundTable`, kept in [low, high]."""
    nodes, drop = table.curve.x, table.drop
    level = slope * x - force
    j = max(count_up_to(drop, level) - 1, 0)
    faster = slope - table.curve.slope[j]
    way = (level - drop[j]) / faster if faster > SAME * slope else 0.0
    end = nodes[j + 1] if j + 1 < nodes.shape[0] else math.inf
    return min(max(min(nodes[j] + max(way, 0.0), end), low), high)


@inner()
def _stored(unloading, slope, x, force):
    """What an unloading from (x, force) gives back."""
    meet = _meet(unloading, slope, x, force, 0.0, x)
    way = x - meet
    _, _, energy = _carried(unloading.curve, meet)
    return way * (force - 0.5 * slope * way) + energy


@inner()
def _work_up(loading, slope, x_old, start, x):
    """∫ F dx of a step up: along the line to where it meets the loading curve, then along that."""
    meet = _meet(loading, slope, x_old, start, x_old, x)
    way = meet - x_old
    _, _, up_to_end = _carried(loading.curve, x)
    _, _, up_to_meet = _carried(loading.curve, meet)
    return way * (start + 0.5 * slope * way) + (up_to_end - up_to_meet)


@kernel()
def hysteretic(curves, slope, past, x, moved):
    """The step of each point to x (n,); `curves` are (loading, unloading), each a `BoundTable`,
    `past` (2, n) where the points were and their forces."""
    loading, unloading = curves
    least, most = _carried(unloading.curve, 0.0)[0], _carried(loading.curve, 0.0)[0]
    for i in range(x.shape[0]):
        x_old, start, now = past[0, i], past[1, i], x[i]
        if not x_old > 0.0:  # without a past: between the curves at zero
            start = min(max(start, least), most)
        upper, upper_slope, _ = _carried(loading.curve, now)
        lower, lower_slope, _ = _carried(unloading.curve, now)
        line = start + slope * (now - x_old)
        # The loading curve has the last word where rounding puts the other above it.
        force = min(max(line, lower), upper)
        on_upper = force >= upper
        stored = _stored(unloading, slope, now, force)
        lost = 0.0
        if on_upper and now > x_old:
            gained = stored - _stored(unloading, slope, x_old, start)
            lost = _work_up(loading, slope, x_old, start, now) - gained
        stiffness = slope
        if on_upper:
            stiffness = upper_slope
        elif line <= lower:
            stiffness = lower_slope
        moved[FORCE, i] = force
        moved[STIFFNESS, i] = stiffness
        moved[STORED, i] = stored
        moved[LOST, i] = lost
