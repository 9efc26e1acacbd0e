"""One cell of an element and a point: whether it can contain a closer point, or a single minimum.

With the residual r from the point and the derivative bounds of the cell, f = |S − P|²/2 is expanded
about its middle: values of the tangent parallelogram and of the Hessian, and bounds of their
changes over the cell.
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
def slopes_away(elements, e, side, at_ends, g, change):
    """Return whether f is proved to have no minimum in a cell: its slope has one sign all over it.

    `at_ends` tells whether the cell reaches the two ends along `side` (0: s, 2: t); if the surface
    has a kink or a border where f falls to, a minimum may be there in spite of the slope. `g` is
    the slope in the cell's middle, `change` its largest change.
    """
    kind = elements.table[e]["kind"]
    if g > change:
        return not (at_ends[0] and kind[side] != SMOOTH)
    if -g > change:
        return not (at_ends[1] and kind[side + 1] != SMOOTH)
    return False


@inner()
def _square_at(m, x, y):
    """Return |r + x a + y b|² from the products of r, a and b."""
    return m.rr + x * x * m.xx + y * y * m.yy + 2.0 * (x * m.rx + y * m.ry + x * y * m.xy)


@inner()
def nearest_on_plate(m):
    """Return x, y (−1 … 1) where |r + x a + y b| is smallest, and the least |r + x a + y b|².

    The normal equations give a place inside the parallelogram. If they give none, or a and b are
    nearly parallel, the best place on the four sides is returned. `m` is a `Middle`.
    """
    det = m.xx * m.yy - m.xy * m.xy
    if det > 1e-12 * m.xx * m.yy:
        x = (-m.rx * m.yy + m.ry * m.xy) / det
        y = (-m.ry * m.xx + m.rx * m.xy) / det
        if -1.0 <= x <= 1.0 and -1.0 <= y <= 1.0:
            return x, y, _square_at(m, x, y)
    best = math.inf
    best_x = best_y = 0.0
    for k in range(2):
        fixed = 1.0 - 2.0 * k
        y = -(m.ry + fixed * m.xy) / m.yy if m.yy > 0.0 else 0.0
        y = min(max(y, -1.0), 1.0)
        square = _square_at(m, fixed, y)
        if square < best:
            best, best_x, best_y = square, fixed, y
        x = -(m.rx + fixed * m.xy) / m.xx if m.xx > 0.0 else 0.0
        x = min(max(x, -1.0), 1.0)
        square = _square_at(m, x, fixed)
        if square < best:
            best, best_x, best_y = square, x, fixed
    return best_x, best_y, best


@inner()
def plate_distance(m):
    """Return a lower bound of |r + x a + y b| over |x|, |y| ≤ 1, the distance of a plate.

    Far from its middle, cancellation in the products leaves only noise of a small distance.
    """
    noise = ROUNDING * (m.rr + m.xx + m.yy)
    return math.sqrt(max(0.0, nearest_on_plate(m)[2] - noise))


@inner()
def middle(h, local, hs, ht):
    """Return the `Middle` of a cell: products of r, from the point to its middle, and half sides.

    `h` holds the derivatives in the middle, `local` is the point relative to the element's origin,
    `hs` and `ht` are the half sides in s and t. The products of r with second derivatives are
    unscaled.
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
    """Return `Bounds`: those of a cell's derivatives, k[9], for parameters of −1 … 1 in the cell.

    `hs` and `ht` are half the cell's sides in s and t.
    """
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
    """Return the `Hessian`: second derivatives of f in a cell's middle, bounds of their changes.

    All are by parameters that run over −1 … 1 in the cell; `b` are the scaled bounds of the
    surface's derivatives over the cell, `hs` and `ht` its half sides.
    """
    max_residual = math.sqrt(m.rr) + b.x + b.y
    xx = m.hxx * hs * hs + m.xx
    xy = m.hxy * hs * ht + m.xy
    yy = m.hyy * ht * ht + m.yy
    dxx = 3.0 * b.xx * b.x + 2.0 * b.xy * b.x + b.y * b.xx + max_residual * (b.xxx + b.xxy)
    dyy = 3.0 * b.yy * b.y + 2.0 * b.xy * b.y + b.x * b.yy + max_residual * (b.yyy + b.xyy)
    dxy = 2.0 * b.xy * (b.x + b.y) + b.xx * b.y + b.x * b.yy + max_residual * (b.xxy + b.xyy)
    return Hessian(xx, xy, yy, dxx, dxy, dyy)


@inner()
def without_minimum(elements, e, cell, m, f):
    """Return whether slopes rule out a minimum of f in a cell (s0, s1, t0, t1); False if unproved.

    One of the two slopes has to exceed its largest change over the cell (`slopes_away`). `m` is the
    `Middle` of the cell, `f` its `Hessian`.
    """
    change = abs(f.xx) + f.dxx + abs(f.xy) + f.dxy
    if slopes_away(elements, e, 0, (cell[0] <= -0.5, cell[1] >= 0.5), m.rx, change):
        return True
    change = abs(f.yy) + f.dyy + abs(f.xy) + f.dxy
    return slopes_away(elements, e, 2, (cell[2] <= -0.5, cell[3] >= 0.5), m.ry, change)


@inner()
def bends_down(elements, e, cell, f):
    """Return whether f is proved concave in one direction all over a cell: it has no minimum there.

    The direction is s, t, or any if the determinant is negative. A minimum may still be on a side
    where the surface has a kink or a border: directions across such sides do not count.
    """
    kind = elements.table[e]["kind"]
    flat_s = (cell[0] > -0.5 or kind[0] == SMOOTH) and (cell[1] < 0.5 or kind[1] == SMOOTH)
    flat_t = (cell[2] > -0.5 or kind[2] == SMOOTH) and (cell[3] < 0.5 or kind[3] == SMOOTH)
    max_ss, max_tt = f.xx + f.dxx, f.yy + f.dyy
    if (flat_s and max_ss < 0.0) or (flat_t and max_tt < 0.0):
        return True
    across = abs(f.xy) - f.dxy
    return flat_s and flat_t and across > 0.0 and max_ss * max_tt < across * across


@inner()
def convex(f):
    """Return whether f is proved strictly convex all over a cell, by the bounds of its Hessian."""
    min_ss = f.xx - f.dxx
    min_tt = f.yy - f.dyy
    return min_ss > 0.0 and min_tt > 0.0 and min_ss * min_tt > (abs(f.xy) + f.dxy) ** 2


@inner()
def least_value(m, f):
    """Return a lower bound of f = |S − P|²/2 in a cell, by its Taylor series about the middle.

    At the fraction τ from the middle the Hessian has changed by no more than τ times its largest
    change, so that the error of the second-order series is a sixth of that. A quadratic function
    that is not convex has its minimum on the sides.
    """
    remainder = (f.dxx + 2.0 * f.dxy + f.dyy) / 6.0
    det = f.xx * f.yy - f.xy * f.xy
    if f.xx > 0.0 and det > 1e-12 * f.xx * f.yy:
        x, y = (m.ry * f.xy - m.rx * f.yy) / det, (m.rx * f.xy - m.ry * f.xx) / det
        if -1.0 <= x <= 1.0 and -1.0 <= y <= 1.0:
            return 0.5 * (m.rr + m.rx * x + m.ry * y) - remainder
    best = math.inf
    for k in range(2):
        fixed = 1.0 - 2.0 * k
        slope = m.ry + fixed * f.xy
        y = min(max(-slope / f.yy, -1.0), 1.0) if f.yy > 0.0 else -math.copysign(1.0, slope)
        best = min(best, fixed * m.rx + 0.5 * f.xx + y * slope + 0.5 * y * y * f.yy)
        slope = m.rx + fixed * f.xy
        x = min(max(-slope / f.xx, -1.0), 1.0) if f.xx > 0.0 else -math.copysign(1.0, slope)
        best = min(best, fixed * m.ry + 0.5 * f.yy + x * slope + 0.5 * x * x * f.xx)
    return 0.5 * m.rr + best - remainder
