"""Value, slope and integral of piecewise linear curves, which are `Curves`."""

from __future__ import annotations

from contiga.curves.curve_records import CurvePoint
from contiga.jit import inner, kernel


@inner()
def curve_at(curves, c, x):
    """Return the `CurvePoint` of curve c at x, on the piece to the right of a knot."""
    first, low, high = curves.first[c], curves.first[c], curves.first[c + 1]
    while low < high:
        middle = (low + high) // 2
        if curves.x[middle] <= x:
            low = middle + 1
        else:
            high = middle
    j = max(low - 1, first)
    dx, slope = x - curves.x[j], curves.slope[low + c]
    y = slope * dx + curves.y[j]
    return CurvePoint(y, slope, curves.integral[j] + 0.5 * dx * (curves.y[j] + y))


@kernel()
def point(curves, c, x):
    """Return value, slope and integral of curve c at x."""
    at = curve_at(curves, c, x)
    return at.value, at.slope, at.integral


@kernel()
def points(curves, c, x, out):
    """Write value, slope and integral of curve c at x (n,) to the rows of `out` (3, n)."""
    for i in range(x.shape[0]):
        at = curve_at(curves, c, x[i])
        out[0, i], out[1, i], out[2, i] = at.value, at.slope, at.integral
