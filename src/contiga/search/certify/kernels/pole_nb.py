"""Bound the bend of an element over a box with a side that is one point, as at a sphere's pole.

With the parameter τ in [0, 1] from the pole P, S − P = τ C, where C = B/w is rational, too. The
tangent plane is spanned by U = C_x (S_x = τ U) and V = C + τ C_τ (= S_τ), which do not vanish.
Along a U + b V the second fundamental form is

    a² C_xx·N/τ + 2 a b C_xτ·N + b² (2 C_τ + τ C_ττ)·N.

If the surface has a tangent plane at the pole, with normal n, then n·C(x, 0) = 0, n·C_xx/τ is
(F/w)_xx with a polynomial F = n·B/τ, and |N − n| ≤ τ G, so that all terms are bounded.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, zero_scratch
from contiga.search.certify.kernels.bend_nb import (
    INNER,
    MAX_STRETCH,
    OUTER,
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    frame_of,
    mean_and_spread,
    set_unbounded,
    stretch_and_turn,
)
from contiga.search.certify.kernels.remainder_nb import (
    D01,
    D02,
    D10,
    D11,
    D20,
    N_COEFS,
    centred_coefficients,
    quotient_remainder,
    sums_of,
    taylor,
)

PLANE_TOL = 1e-9
"""Largest distance of tangents at a pole from a plane, as a share of their length."""


@kernel(linked=True, error_model="numpy")
def pole_side(elements, e, cell):
    """Return the side of the cell that is a pole; −1 if there is none, or more than one."""
    pole = -1
    kind = elements.table[e]["kind"]
    for side in range(4):
        on = cell[side] <= -0.5 if side & 1 == 0 else cell[side] >= 0.5
        if on and kind[side] == POLE:
            if pole >= 0:
                return -1
            pole = side
    return pole


@inner(error_model="numpy")
def _coefficients_from_pole(elements, e, cell, side, a, b):
    """Write the coefficients of (C, w) in powers of x in [-1, 1] along the pole and τ from it.

    They go to `a`; C is relative to the pole; `side` is the pole, `b` work. Returns the degrees in
    x and τ.
    """
    p, q = centred_coefficients(elements, e, cell, b)
    n, m = (q, p) if side < 2 else (p, q)
    sign = -1.0 if side & 1 == 0 else 1.0  # the pole is at y = sign; y = sign (1 − 2 τ)
    a[:] = 0.0
    for c in range(4):
        for i in range(n + 1):
            for j in range(m + 1):
                a[i, j, c] = b[j, i, c] if side < 2 else b[i, j, c]
            for k in range(m):  # powers of y about the pole
                for j in range(m - 1, k - 1, -1):
                    a[i, j, c] += sign * a[i, j + 1, c]
            factor = 1.0
            for j in range(m + 1):
                a[i, j, c] *= factor
                factor *= -2.0 * sign
    for c in range(3):
        at = a[0, 0, c] / a[0, 0, 3]
        for i in range(n + 1):
            for j in range(m + 1):
                a[i, j, c] -= at * a[i, j, 3]
        for i in range(n + 1):
            for j in range(N_COEFS - 1):
                a[i, j, c] = a[i, j + 1, c]
    return n, m


@inner(error_model="numpy")
def _bend_along_pole(a, n, m, normal, min_slope):
    """Return a bound of (F/w)_xx; infinite if the tangents at the pole lie in no plane.

    `a` are the coefficients of (C, w), `min_slope` is a lower bound of w, not of a slope.
    """
    f = zero_scratch(3)
    w = zero_scratch(3)
    off = size = 0.0
    for i in range(n + 1):
        for j in range(m + 1):
            value = along = 0.0
            for c in range(3):
                value += a[i, j, c] * normal[c]
                along += a[i, j, c] ** 2
            if j == 0:
                off = max(off, abs(value))
                size = max(size, along)
            else:
                f[0] += abs(value)
                f[1] += i * abs(value)
                f[2] += i * (i - 1) * abs(value)
            w[1] += i * abs(a[i, j, 3])
            w[2] += i * (i - 1) * abs(a[i, j, 3])
    if not off <= PLANE_TOL * math.sqrt(size):
        return math.inf
    first = (f[1] + w[1] * f[0] / min_slope) / min_slope
    return (f[2] + 2.0 * w[1] * first + w[2] * f[0] / min_slope) / min_slope


@inner(error_model="numpy")
def _length_and_height(h, column, normal):
    """Return the length of a derivative, and of its part along the normal."""
    x, y, z = h[0, column], h[1, column], h[2, column]
    return math.sqrt(x * x + y * y + z * z), abs(x * normal[0] + y * normal[1] + z * normal[2])


@kernel(error_model="numpy")
def pole_bounds(elements, e, cell, side, bend, work):
    """Write the bounds bend[6] of `bend_bounds` over a cell whose `side` is a pole.

    Both curvatures get one bound, the width along the pole is 0. Returns whether any bound holds:
    False, with unbounded `bend`, for elements without monomials, tangents at the pole in no plane,
    or derivatives that change too much. `work` holds the Taylor polynomial of C, not S, afterwards.
    """
    set_unbounded(bend)
    h, remainder = work.derivatives, work.remainder
    if elements.table[e]["monomial"] < 0:
        return False
    a, sums = scratch(N_COEFS, N_COEFS, 4), scratch(3, 6)
    n, m = _coefficients_from_pole(elements, e, cell, side, a, scratch(N_COEFS, N_COEFS, 4))
    taylor(a, h)
    v = scratch(3, 6)  # U, V and their slopes by x and τ at the pole
    for c in range(3):
        v[c, 0] = h[c, 1]
        v[c, 1] = h[c, 0]
        v[c, 2] = h[c, 3]
        v[c, 3] = h[c, 4]
        v[c, 4] = h[c, 1]
        v[c, 5] = 2.0 * h[c, 2]
    x, along, across = frame_of(v)
    if not (x > 0.0 and across > 0.0):
        return False
    i = 1.0 / (x * across)
    normal = (
        (v[1, 0] * v[2, 1] - v[2, 0] * v[1, 1]) * i,
        (v[2, 0] * v[0, 1] - v[0, 0] * v[2, 1]) * i,
        (v[0, 0] * v[1, 1] - v[1, 0] * v[0, 1]) * i,
    )
    min_slope = sums_of(a, n, m, h, normal, sums)
    if not min_slope > 0.0:
        return False
    quotient_remainder(sums[0], sums[2], min_slope, remainder[0])
    quotient_remainder(sums[1], sums[2], min_slope, remainder[1])
    bend_xx = _bend_along_pole(a, n, m, normal, min_slope)
    # Of C_t, C_xx, C_xt and C_tt: length, and part along the normal.
    t, xx = _length_and_height(h, 2, normal), _length_and_height(h, 3, normal)
    xt, tt = _length_and_height(h, 4, normal), _length_and_height(h, 5, normal)
    change = scratch(2, 2)  # deviation of U and V from their slopes: length, and part along n
    for k in range(2):
        change[k, 0] = remainder[k, D10]
        change[k, 1] = (
            0.5 * xx[k] + 2.0 * xt[k] + 1.5 * tt[k] + remainder[k, D10] + 2.0 * remainder[k, D01]
        )
    alpha, beta, gamma = 1.0 / x, -along / (x * across), 1.0 / across
    b = abs(beta)
    stretch, _ = stretch_and_turn(v, normal, (alpha, beta, gamma), change)
    if not (stretch < MAX_STRETCH and bend_xx < math.inf):
        return False
    height_rate_u = xt[1] + remainder[1, D11]
    height_rate_v = 2.0 * (t[1] + xt[1] + tt[1] + remainder[1, D01])
    turn = math.hypot(alpha * height_rate_u, b * height_rate_u + gamma * height_rate_v) / (
        1.0 - stretch
    )
    # The three terms of the second form, with |N − n| ≤ τ `turn`.
    uu = bend_xx + (xx[0] + remainder[0, D20]) * turn
    uv = xt[1] + remainder[1, D11] + (xt[0] + remainder[0, D11]) * turn
    vv = 0.0
    for k in range(2):
        slope = t[k] + xt[k] + tt[k] + remainder[k, D01]  # of C_τ
        vv += (2.0 * slope + tt[k] + remainder[k, D02]) * (turn if k == 0 else 1.0)
    middle, spread = mean_and_spread(
        alpha * alpha * uu,
        alpha * (b * uu + gamma * uv),
        b * b * uu + 2.0 * b * gamma * uv + gamma * gamma * vv,
    )
    bend[INNER] = bend[OUTER] = (middle + spread) / (1.0 - 2.0 * stretch)
    speed = (
        x + _length_and_height(v, 2, normal)[0] + _length_and_height(v, 3, normal)[0] + change[0, 0]
    )
    down = (
        math.hypot(along, across)
        + _length_and_height(v, 4, normal)[0]
        + _length_and_height(v, 5, normal)[0]
    )
    down += change[0, 1]
    width = (1.0 - stretch) * across
    wide, high = cell[1] - cell[0], cell[3] - cell[2]
    if side < 2:
        bend[SPEED_S], bend[WIDTH_S], bend[SPEED_T] = down / wide, width / wide, 2.0 * speed / high
    else:
        bend[SPEED_T], bend[WIDTH_T], bend[SPEED_S] = down / high, width / high, 2.0 * speed / wide
    return True
