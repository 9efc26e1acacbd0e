"""Newton's method on many points of one element at once: the fast lane of tracking.

Elements of degree up to three in each direction are kept as bicubics. Points are binned by
element and taken sixteen at a time: the coefficients are the same for all lanes, the lanes' data
lie one after the other in one work array, and the body of the lane loop has no branches, so the
compiler turns it into vector code without gathers: as long as these kernels are compiled by
themselves, and not within their callers. Lanes that want to leave the element go on from
there in another block; those that meet an indefinite Hessian or do not descend are handed back, and
the careful walk takes them.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import bicubic, quotient
from contiga.num.jit import inlined, inner
from contiga.num.kernels.fma_nb import fma

LANES = 16
# Rows of the work array, each LANES long.
ROW_S, ROW_T, ROW_X, ROW_Y, ROW_Z, ROW_F, ROW_STATE = 0, 1, 2, 3, 4, 5, 6
ROW_FOOT, ROW_NORMAL, ROW_GAP = 7, 10, 13
ROWS = 14
ACTIVE, DONE, GIVEN_BACK, LEFT = 0.0, 1.0, 2.0, 3.0
LAST = 1e10
"""A step shorter than the root of this many tolerances (1e-7 of the body's size) is the last:
Newton squares the miss, which is measured where the step ends."""


@inlined()
def _dot(a, b, c, x, y, z):
    return fma(c, z, fma(b, y, a * x))


@inlined()
def _round(lanes, l, x, y, z, tolerance):
    """One Newton round of lane l, from the derivatives x, y, z of the surface's coordinates."""
    n = LANES
    s = lanes[l]
    t = lanes[n + l]
    r_x = x[0] - lanes[ROW_X * n + l]
    r_y = y[0] - lanes[ROW_Y * n + l]
    r_z = z[0] - lanes[ROW_Z * n + l]
    f = _dot(r_x, r_y, r_z, r_x, r_y, r_z)
    g_s = _dot(r_x, r_y, r_z, x[1], y[1], z[1])
    g_t = _dot(r_x, r_y, r_z, x[2], y[2], z[2])
    a = _dot(x[1], y[1], z[1], x[1], y[1], z[1])
    b = _dot(x[2], y[2], z[2], x[2], y[2], z[2])
    m = _dot(x[1], y[1], z[1], x[2], y[2], z[2])
    h_ss = fma(r_z, z[3], fma(r_y, y[3], fma(r_x, x[3], a)))
    h_st = fma(r_z, z[4], fma(r_y, y[4], fma(r_x, x[4], m)))
    h_tt = fma(r_z, z[5], fma(r_y, y[5], fma(r_x, x[5], b)))
    det = fma(h_ss, h_tt, -h_st * h_st)
    regular = (a > 1e-12 * b) & (b > 1e-12 * a)  # away from poles
    sound = regular & (det > 1e-6 * a * b) & (h_ss > 0.0) & (f <= lanes[ROW_F * n + l] + tolerance)
    i = 1.0 / det
    new_s = fma(fma(g_t, h_st, -g_s * h_tt), i, s)
    new_t = fma(fma(g_s, h_st, -g_t * h_ss), i, t)
    step_s = new_s - s
    step_t = new_t - t
    last = fma(step_s * step_s, a, step_t * step_t * b) <= LAST * tolerance
    inside = (new_s >= -0.5) & (new_s <= 0.5) & (new_t >= -0.5) & (new_t <= 0.5)
    state = lanes[ROW_STATE * n + l]
    now = GIVEN_BACK if not sound else (LEFT if not inside else (DONE if last else ACTIVE))
    active = state == ACTIVE
    step = active & (now != GIVEN_BACK)
    lanes[l] = new_s if step else s
    lanes[n + l] = new_t if step else t
    lanes[ROW_F * n + l] = f * (1.0 + 1e-12) if active else lanes[ROW_F * n + l]
    lanes[ROW_STATE * n + l] = now if active else state


@inlined()
def _finish(lanes, l, x, y, z, tolerance):
    """Foot, normal and gap of lane l; it is given back if it misses by more than tolerated."""
    n = LANES
    r_x = x[0] - lanes[ROW_X * n + l]
    r_y = y[0] - lanes[ROW_Y * n + l]
    r_z = z[0] - lanes[ROW_Z * n + l]
    g_s = _dot(r_x, r_y, r_z, x[1], y[1], z[1])
    g_t = _dot(r_x, r_y, r_z, x[2], y[2], z[2])
    a = _dot(x[1], y[1], z[1], x[1], y[1], z[1])
    b = _dot(x[2], y[2], z[2], x[2], y[2], z[2])
    missed = (g_s * g_s > tolerance * a) | (g_t * g_t > tolerance * b)
    state = lanes[ROW_STATE * n + l]
    lanes[ROW_STATE * n + l] = GIVEN_BACK if (state == DONE) & missed else state
    n_x = fma(y[1], z[2], -z[1] * y[2])
    n_y = fma(z[1], x[2], -x[1] * z[2])
    n_z = fma(x[1], y[2], -y[1] * x[2])
    i = 1.0 / math.sqrt(_dot(n_x, n_y, n_z, n_x, n_y, n_z))
    n_x *= i
    n_y *= i
    n_z *= i
    lanes[ROW_FOOT * n + l] = x[0]
    lanes[(ROW_FOOT + 1) * n + l] = y[0]
    lanes[(ROW_FOOT + 2) * n + l] = z[0]
    lanes[ROW_NORMAL * n + l] = n_x
    lanes[(ROW_NORMAL + 1) * n + l] = n_y
    lanes[(ROW_NORMAL + 2) * n + l] = n_z
    lanes[ROW_GAP * n + l] = -_dot(r_x, r_y, r_z, n_x, n_y, n_z)


@inner(linked=False)
def newton_rational(lanes, k, tolerance):
    """One round on all lanes; k holds the coefficients of x, y, z, w, sixteen each.

    `tolerance` is the square of the accepted tangential miss.
    """
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        w = bicubic(k, 48, s, t)
        x = quotient(bicubic(k, 0, s, t), w)
        y = quotient(bicubic(k, 16, s, t), w)
        z = quotient(bicubic(k, 32, s, t), w)
        _round(lanes, l, x, y, z, tolerance)


@inner(linked=False)
def newton_polynomial(lanes, k, tolerance):
    """As `newton_rational`, for elements whose weight is one."""
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        x = bicubic(k, 0, s, t)
        y = bicubic(k, 16, s, t)
        z = bicubic(k, 32, s, t)
        _round(lanes, l, x, y, z, tolerance)


@inner(linked=False)
def finish_rational(lanes, k, tolerance):
    """The records of all lanes where they have come to; arguments as of `newton_rational`."""
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        w = bicubic(k, 48, s, t)
        x = quotient(bicubic(k, 0, s, t), w)
        y = quotient(bicubic(k, 16, s, t), w)
        z = quotient(bicubic(k, 32, s, t), w)
        _finish(lanes, l, x, y, z, tolerance)


@inner(linked=False)
def finish_polynomial(lanes, k, tolerance):
    """As `finish_rational`, for elements whose weight is one."""
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        x = bicubic(k, 0, s, t)
        y = bicubic(k, 16, s, t)
        z = bicubic(k, 32, s, t)
        _finish(lanes, l, x, y, z, tolerance)
