"""One round of Newton's method on one point, and the record of its foot: scalar mathematics.

Lanes of a vector unit (`lanes_nb`) and threads of a GPU (`row_nb`) run the same text. It has no
branches: conditions choose values.
"""

from __future__ import annotations

import math

from contiga.arrays.kernels.fma_nb import fma
from contiga.elements.kernels.element_nb import bicubic, quotient
from contiga.jit import inlined

ROUNDS = 6
"""Largest number of rounds; points that need more are left to the safeguarded walk."""
ACTIVE, DONE, REJECTED, LEFT = 0.0, 1.0, 2.0, 3.0
"""States of a point: iterating, at its foot, to be walked with safeguards, outside its element."""
LAST_STEP = 1e10
"""A step shorter than the root of this many tolerances (1e-7 of the body's size) is the last one:
Newton's method squares the miss, which is measured where the step ends."""


@inlined()
def _dot(a, b, c, x, y, z):
    return fma(c, z, fma(b, y, a * x))


@inlined()
def local_place(u, u0, scale):
    """Return s of the parameter u in an element, clipped to its sides.

    The element starts at u0 and has the length 1/scale.
    """
    return min(max((u - u0) * scale - 0.5, -0.5), 0.5)


@inlined()
def polynomial_at(k, o, n, s, t):
    """Return the coordinates x, y, z at (s, t), each with its derivatives (six numbers).

    (s, t) are relative to the centre of expansion; coefficients are every n-th number from k[o].
    """
    x = bicubic(k, o, n, s, t)
    return x, bicubic(k, o + 16 * n, n, s, t), bicubic(k, o + 32 * n, n, s, t)


@inlined()
def weight_at(k, o, n, s, t):
    """Return the weight with its derivatives; its coefficients follow those of the coordinates."""
    return bicubic(k, o + 48 * n, n, s, t)


@inlined()
def rational_at(k, o, n, s, t):
    """Return the same as `polynomial_at` for a rational element."""
    w = weight_at(k, o, n, s, t)
    x = quotient(bicubic(k, o, n, s, t), w)
    y = quotient(bicubic(k, o + 16 * n, n, s, t), w)
    z = quotient(bicubic(k, o + 32 * n, n, s, t), w)
    return x, y, z


@inlined()
def newton_step(place, progress, p, x, y, z, tolerance):
    """Run one round for the point p from place = (s, t), with the derivatives x, y, z there.

    `progress` is (square of the distance that may not be exceeded, state), `tolerance` the square
    of the accepted tangential miss. Returns the new s and t, the square of the distance at the old
    place, and the new state: DONE after a last step; REJECTED, with the place unchanged, near a
    pole, without a definite Hessian, or if the distance has not fallen; LEFT where the step ends
    outside of the element; else ACTIVE. With another state than ACTIVE nothing changes.
    """
    s, t = place
    best, state = progress
    r_x = x[0] - p[0]
    r_y = y[0] - p[1]
    r_z = z[0] - p[2]
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
    is_regular = (a > 1e-12 * b) & (b > 1e-12 * a)  # away from poles
    is_sound = is_regular & (det > 1e-6 * a * b) & (h_ss > 0.0) & (f <= best + tolerance)
    i = 1.0 / (det if det != 0.0 else 1.0)  # zero at a pole, which is not sound
    new_s = fma(fma(g_t, h_st, -g_s * h_tt), i, s)
    new_t = fma(fma(g_s, h_st, -g_t * h_ss), i, t)
    step_s = new_s - s
    step_t = new_t - t
    last = fma(step_s * step_s, a, step_t * step_t * b) <= LAST_STEP * tolerance
    inside = (new_s >= -0.5) & (new_s <= 0.5) & (new_t >= -0.5) & (new_t <= 0.5)
    new_state = REJECTED if not is_sound else (LEFT if not inside else (DONE if last else ACTIVE))
    is_active = state == ACTIVE
    takes_step = is_active & (new_state != REJECTED)
    next_s = new_s if takes_step else s
    next_t = new_t if takes_step else t
    next_best = f * (1.0 + 1e-12) if is_active else best
    next_state = new_state if is_active else state
    return next_s, next_t, next_best, next_state


@inlined()
def foot_record(p, state, x, y, z, tolerance):
    """Return n_x, n_y, n_z, gap and state of the point p, by the derivatives at its foot.

    x, y, z are the coordinates of the foot with their derivatives. The normal is zero at a pole.
    `tolerance` is the square of the accepted tangential miss: a DONE foot beyond it is REJECTED.
    """
    r_x = x[0] - p[0]
    r_y = y[0] - p[1]
    r_z = z[0] - p[2]
    g_s = _dot(r_x, r_y, r_z, x[1], y[1], z[1])
    g_t = _dot(r_x, r_y, r_z, x[2], y[2], z[2])
    a = _dot(x[1], y[1], z[1], x[1], y[1], z[1])
    b = _dot(x[2], y[2], z[2], x[2], y[2], z[2])
    is_missed = (g_s * g_s > tolerance * a) | (g_t * g_t > tolerance * b)
    new_state = REJECTED if (state == DONE) & is_missed else state
    n_x = fma(y[1], z[2], -z[1] * y[2])
    n_y = fma(z[1], x[2], -x[1] * z[2])
    n_z = fma(x[1], y[2], -y[1] * x[2])
    square = _dot(n_x, n_y, n_z, n_x, n_y, n_z)
    i = 1.0 / math.sqrt(
        square if square != 0.0 else 1.0
    )  # zero at a pole, whose point is given back
    n_x *= i
    n_y *= i
    n_z *= i
    return n_x, n_y, n_z, -_dot(r_x, r_y, r_z, n_x, n_y, n_z), new_state
