"""One cell of an element against a point: whether it can hold a closer one, or just one minimum.

With the residual r from the point and the derivative bounds of the cell, f = |S − P|²/2 is expanded
about its middle: values of the tangent parallelogram and of the Hessian, and how far they can be
off over the cell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contiga.arrays.codes import SMOOTH
from contiga.jit import inner
from contiga.search.hierarchy.kernels.curve_nb import ROUNDING


class Middle(NamedTuple):
    """Products of r, from the point to a cell's middle, and of the cell's half sides x and y."""

    rr: float
    rx: float
    ry: float
    xx: float
    xy: float
    yy: float
    hxx: float
    hxy: float
    hyy: float


class Bounds(NamedTuple):
    """Bounds of the derivatives of a cell laid on −1 … 1."""

    x: float
    y: float
    xx: float
    xy: float
    yy: float
    xxx: float
    xxy: float
    xyy: float
    yyy: float


class Hessian(NamedTuple):
    """Second derivatives of f in a cell's middle, and their largest changes in it."""

    xx: float
    xy: float
    yy: float
    dxx: float
    dxy: float
    dyy: float


@inner()
def slopes_away(elements, e, side, kept, g, change):
    """Return whether f has no minimum in a cell because its slope across it keeps its sign.

    `kept` tells for `side` (0: s, 2: t) which of the two ends the cell reaches; a minimum may
    stand there against the slope where the surface has a kink or ends. `g` is the slope in the
    cell's middle, `change` its largest change.
    """
    kind = elements.table[e]["kind"]
    if g > change:
        return not (kept[0] and kind[side] != SMOOTH)
    if -g > change:
        return not (kept[1] and kind[side + 1] != SMOOTH)
    return False


@inner()
def _square_at(m, x, y):
    """|r + x a + y b|² from the products of r, a and b."""
    return m.rr + x * x * m.xx + y * y * m.yy + 2.0 * (x * m.rx + y * m.ry + x * y * m.xy)


@inner()
def nearest_on_plate(m):
    """x, y (−1 … 1) where |r + x a + y b| is smallest, and its square there."""
    det = m.xx * m.yy - m.xy * m.xy
    if det > 1e-12 * m.xx * m.yy:
        x = (-m.rx * m.yy + m.ry * m.xy) / det
        y = (-m.ry * m.xx + m.rx * m.xy) / det
        if -1.0 <= x <= 1.0 and -1.0 <= y <= 1.0:
            return x, y, _square_at(m, x, y)
    best = math.inf
    best_x = best_y = 0.0
    for k in range(2):
        fix = 1.0 - 2.0 * k
        y = -(m.ry + fix * m.xy) / m.yy if m.yy > 0.0 else 0.0
        y = min(max(y, -1.0), 1.0)
        square = _square_at(m, fix, y)
        if square < best:
            best, best_x, best_y = square, fix, y
        x = -(m.rx + fix * m.xy) / m.xx if m.xx > 0.0 else 0.0
        x = min(max(x, -1.0), 1.0)
        square = _square_at(m, x, fix)
        if square < best:
            best, best_x, best_y = square, x, fix
    return best_x, best_y, best


@inner()
def plate_distance(m):
    """Smallest |r + x a + y b| over |x|, |y| ≤ 1, or less by rounding: to a cell laid flat.

    Far from its middle the products leave but noise of a small distance.
    """
    noise = ROUNDING * (m.rr + m.xx + m.yy)
    return math.sqrt(max(0.0, nearest_on_plate(m)[2] - noise))


@inner()
def middle(h, local, hs, ht):
    """Products of r, from the point to a cell's middle, and the cell's half sides x and y there.

    Also the second derivatives of the surface along r, as they come.
    """
    rr = rx = ry = xx = xy = yy = hxx = hxy = hyy = 0.0
    for c in range(3):
        r = h[c, 0] - local[c]
        x = h[c, 1] * hs
        y = h[c, 2] * ht
        rr += r * r
        rx += r * x
        ry += r * y
        xx += x * x
        xy += x * y
        yy += y * y
        hxx += r * h[c, 3]
        hxy += r * h[c, 4]
        hyy += r * h[c, 5]
    return Middle(rr, rx, ry, xx, xy, yy, hxx, hxy, hyy)


@inner()
def scaled(k, hs, ht):
    """The bounds of a cell's derivatives, as those of the cell laid on −1 … 1."""
    return Bounds(
        k[0] * hs,
        k[1] * ht,
        k[2] * hs * hs,
        k[3] * hs * ht,
        k[4] * ht * ht,
        k[5] * hs**3,
        k[6] * hs * hs * ht,
        k[7] * hs * ht * ht,
        k[8] * ht**3,
    )


@inner()
def hessian(m, b, hs, ht):
    """Second derivatives of f in a cell's middle, and how much each changes in the cell."""
    far = math.sqrt(m.rr) + b.x + b.y
    xx = m.hxx * hs * hs + m.xx
    xy = m.hxy * hs * ht + m.xy
    yy = m.hyy * ht * ht + m.yy
    dxx = 3.0 * b.xx * b.x + 2.0 * b.xy * b.x + b.y * b.xx + far * (b.xxx + b.xxy)
    dyy = 3.0 * b.yy * b.y + 2.0 * b.xy * b.y + b.x * b.yy + far * (b.yyy + b.xyy)
    dxy = 2.0 * b.xy * (b.x + b.y) + b.xx * b.y + b.x * b.yy + far * (b.xxy + b.xyy)
    return Hessian(xx, xy, yy, dxx, dxy, dyy)


@inner()
def without_minimum(elements, e, cell, m, f):
    """Return whether f has no minimum in a cell, `f` its Hessian there."""
    change = abs(f.xx) + f.dxx + abs(f.xy) + f.dxy
    if slopes_away(elements, e, 0, (cell[0] <= -0.5, cell[1] >= 0.5), m.rx, change):
        return True
    change = abs(f.yy) + f.dyy + abs(f.xy) + f.dxy
    return slopes_away(elements, e, 2, (cell[2] <= -0.5, cell[3] >= 0.5), m.ry, change)


@inner()
def bends_down(elements, e, cell, f):
    """Return whether f has no minimum in a cell because somewhere it bends down all over it.

    A minimum may stand there all the same on a side where the surface has a kink or ends.
    """
    kind = elements.table[e]["kind"]
    flat_s = (cell[0] > -0.5 or kind[0] == SMOOTH) and (cell[1] < 0.5 or kind[1] == SMOOTH)
    flat_t = (cell[2] > -0.5 or kind[2] == SMOOTH) and (cell[3] < 0.5 or kind[3] == SMOOTH)
    high, high_y = f.xx + f.dxx, f.yy + f.dyy
    if (flat_s and high < 0.0) or (flat_t and high_y < 0.0):
        return True
    across = abs(f.xy) - f.dxy
    return flat_s and flat_t and across > 0.0 and high * high_y < across * across


@inner()
def convex(f):
    """Return whether f is convex in a cell."""
    low = f.xx - f.dxx
    low_y = f.yy - f.dyy
    return low > 0.0 and low_y > 0.0 and low * low_y > (abs(f.xy) + f.dxy) ** 2


@inner()
def least_value(m, f):
    """Return a lower bound of f = |S − P|²/2 in a cell, by its Taylor series about the middle.

    The Hessian is off by no more than τ times its largest change on the part τ of a way from the
    middle, so the series of second order by a sixth of that. Of a quadratic function that is not
    convex, the least value stands on the sides.
    """
    rest = (f.dxx + 2.0 * f.dxy + f.dyy) / 6.0
    det = f.xx * f.yy - f.xy * f.xy
    if f.xx > 0.0 and det > 1e-12 * f.xx * f.yy:
        x, y = (m.ry * f.xy - m.rx * f.yy) / det, (m.rx * f.xy - m.ry * f.xx) / det
        if -1.0 <= x <= 1.0 and -1.0 <= y <= 1.0:
            return 0.5 * (m.rr + m.rx * x + m.ry * y) - rest
    best = math.inf
    for k in range(2):
        fix = 1.0 - 2.0 * k
        slope = m.ry + fix * f.xy
        y = min(max(-slope / f.yy, -1.0), 1.0) if f.yy > 0.0 else -math.copysign(1.0, slope)
        best = min(best, fix * m.rx + 0.5 * f.xx + y * slope + 0.5 * y * y * f.yy)
        slope = m.rx + fix * f.xy
        x = min(max(-slope / f.xx, -1.0), 1.0) if f.xx > 0.0 else -math.copysign(1.0, slope)
        best = min(best, fix * m.ry + 0.5 * f.yy + x * slope + 0.5 * x * x * f.xx)
    return 0.5 * m.rr + best - rest
