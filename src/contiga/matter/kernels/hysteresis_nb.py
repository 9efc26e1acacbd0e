"""A force that unloads by another curve than it loads, on a line in between, for one lane.

As the contact laws have it: F = clip(F_old + K Δx, U(x), L(x)), K no less than any slope of both
curves. What is stored is the area under the line down to U, and from there under U; what is lost
is the work along L that is not stored. Below zero there is no force and no memory.
"""

from __future__ import annotations

from contiga.jit import inner
from contiga.matter.kernels.curve_nb import curve_at, on_piece


@inner()
def _meet(numbers, first, n, line, low, high):
    """Where a curve meets a line (x, F, K), which is below it to the left and above it to the
    right, from `low` to `high`."""
    x, force, slope = line
    a, b = 0, n - 1
    while b - a > 1:
        middle = (a + b) // 2
        at = numbers[first + middle]
        if numbers[first + n + middle] >= force + slope * (at - x):
            a = middle
        else:
            b = middle
    y, _ = on_piece(numbers, first, first + n, a, x)
    start = numbers[first + a]
    rise = (numbers[first + n + a + 1] - numbers[first + n + a]) / (numbers[first + a + 1] - start)
    if slope - rise <= 0.0:
        return high
    return min(max(x + (y - force) / (slope - rise), low), high)


@inner()
def _stored(numbers, first, n, line):
    """What an unloading from (x, F) gives back, by the unloading curve that begins at `first`."""
    x, force, slope = line
    meet = _meet(numbers, first, n, line, 0.0, x)
    _, under = curve_at(numbers, first, n, meet)
    way = x - meet
    return way * (force - 0.5 * slope * way) + under


@inner(linked=False)
def hysteretic(numbers, first, n, x, before):
    """F, what is stored and what was lost, at x after before = (x, F).

    From `first` on stand K, the loading curve and the unloading curve, of n points each.
    """
    slope, load, unload = numbers[first], first + 1, first + 1 + 3 * n
    x_old, f_old = before
    if x_old <= 0.0:
        x_old, f_old = 0.0, 0.0
    old = _stored(numbers, unload, n, (x_old, f_old, slope))
    if x <= 0.0:
        return 0.0, 0.0, 0.0
    upper, work_upper = curve_at(numbers, load, n, x)
    lower, _ = curve_at(numbers, unload, n, x)
    force = min(max(f_old + slope * (x - x_old), lower), upper)
    stored = _stored(numbers, unload, n, (x, force, slope))
    lost = 0.0
    if force >= upper and x > x_old:
        meet = _meet(numbers, load, n, (x_old, f_old, slope), x_old, x)
        way = meet - x_old
        _, work_meet = curve_at(numbers, load, n, meet)
        work = way * (f_old + 0.5 * slope * way) + work_upper - work_meet
        lost = max(work - (stored - old), 0.0)
    return force, stored, lost
