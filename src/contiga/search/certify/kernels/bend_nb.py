"""Bound the bend of an element over a box: its normal curvatures and widths, rigorously.

In a frame that is orthonormal in the middle of the box, S_p and S_q change by their second
derivatives there and a remainder (`remainder_nb`). The part of the change in the tangent plane of
the middle, made symmetric, is ε at most (a turn of the frame is no stretch), the part along the
normal D at most. So lengths shrink by 1 − ε at most and the normal turns by τ = D/(1 − ε) at most.
With the eigenvalues λ of the second fundamental form in the middle, the largest tangential second
derivative T there, the largest change E of a second derivative and E_N of its part along the normal
of the middle,

    |II(d, d) − II_0(d, d)| ≤ W |d|²,   W = E_N + (T + E) τ + |λ| τ²/2,   I(d, d) ≥ (1 − 2ε) |d|²,

and all normal curvatures lie between (λ_min − W)/(1 − 2ε) and (λ_max + W)/(1 − 2ε).
"""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, zero_scratch
from contiga.search.certify.certify_records import Bending, Principal
from contiga.search.certify.kernels.remainder_nb import (
    D01,
    D02,
    D10,
    D11,
    D20,
    remainder_of,
    unit_normal,
)

INNER, OUTER, SPEED_S, SPEED_T, WIDTH_S, WIDTH_T = 0, 1, 2, 3, 4, 5
N_BENDS = 6
MAX_STRETCH = 0.45
"""Largest admissible ε."""


@kernel(linked=True, error_model="numpy")
def bend_work():
    """Return a new `Bending` record, which `bend_bounds` fills."""
    return Bending(np.empty((4, 6)), np.empty((2, 5)))


@inner(error_model="numpy")
def mean_and_spread(a, b, c):
    """Return mean and half the difference of the eigenvalues of the matrix ((a, b), (b, c))."""
    return 0.5 * (a + c), math.sqrt(0.25 * (a - c) ** 2 + b * b)


@inner(error_model="numpy")
def set_unbounded(bend):
    """Set the bounds to infinite curvatures and speeds, and zero widths."""
    for c in range(N_BENDS):
        bend[c] = 0.0 if c >= WIDTH_S else math.inf


@inner(error_model="numpy")
def frame_of(v):
    """Return the length of the tangent v[:, 0], and the parts of v[:, 1] along and across it.

    The frame S_p = α S_x, S_q = β S_x + γ S_y is orthonormal for α = 1/length, γ = 1/across and β =
    −along α γ. Zeros if the first tangent vanishes.
    """
    xx = xy = yy = 0.0
    for c in range(3):
        xx += v[c, 0] * v[c, 0]
        xy += v[c, 0] * v[c, 1]
        yy += v[c, 1] * v[c, 1]
    x = math.sqrt(xx)
    if x == 0.0:
        return 0.0, 0.0, 0.0
    return x, xy / x, math.sqrt(max(yy - (xy / x) ** 2, 0.0))


@inner(linked=False, error_model="numpy")
def second_form(h, alpha, beta, gamma):
    """Return the normal parts pp, pq, qq of the second derivatives in a frame, and a fourth number.

    It bounds the tangential part over all unit directions. The frame is S_p = α S_s, S_q = β S_s +
    γ S_t; `h` holds the derivatives of S.
    """
    n = unit_normal(h)
    pp = pq = qq = 0.0
    app = apq = aqq = 0.0
    for c in range(3):
        d_pp = alpha * alpha * h[c, 3]
        d_pq = alpha * (beta * h[c, 3] + gamma * h[c, 4])
        d_qq = beta * beta * h[c, 3] + 2.0 * beta * gamma * h[c, 4] + gamma * gamma * h[c, 5]
        pp += d_pp * n[c]
        pq += d_pq * n[c]
        qq += d_qq * n[c]
        app += d_pp * d_pp
        apq += d_pq * d_pq
        aqq += d_qq * d_qq
    app = math.sqrt(max(app - pp * pp, 0.0))
    apq = math.sqrt(max(apq - pq * pq, 0.0))
    aqq = math.sqrt(max(aqq - qq * qq, 0.0))
    middle, spread = mean_and_spread(app, apq, aqq)
    return pp, pq, qq, middle + spread


@inner(error_model="numpy")
def principal(h):
    """Return `Principal`: the largest normal curvatures towards the normal and away from it.

    The metric is |S_s|, |S_t| and their parts across each other; `h` holds the derivatives.
    Curvatures are infinite and the metric zero if S_s and S_t are parallel.
    """
    xx = xy = yy = 0.0
    for c in range(3):
        xx += h[c, 1] * h[c, 1]
        xy += h[c, 1] * h[c, 2]
        yy += h[c, 2] * h[c, 2]
    det = xx * yy - xy * xy
    if not det > 1e-20 * xx * yy:
        return Principal(math.inf, math.inf, (0.0, 0.0, 0.0, 0.0))
    x = math.sqrt(xx)
    y = math.sqrt(yy)
    area = math.sqrt(det)
    pp, pq, qq, _ = second_form(h, 1.0 / x, -xy / (x * area), x / area)
    middle, spread = mean_and_spread(pp, pq, qq)
    return Principal(middle + spread, spread - middle, (x, y, area / y, area / x))


@inner(error_model="numpy")
def stretch_and_turn(v, n, frame, remainder):
    """Return ε and D of a cell: the largest stretch, and the largest change along the normal n.

    v[:, 0] and v[:, 1] are the tangents in the middle, v[:, 2:4] and v[:, 4:6] their slopes by the
    parameters, which run over [-1, 1]; remainder[0] bounds their change beyond that, remainder[1]
    its part along n. `frame` is (α, β, γ).
    """
    alpha, beta, gamma = frame
    pp = zero_scratch(2)  # of ΔS_p along e1, by each parameter
    qq = zero_scratch(2)
    pq = zero_scratch(2)  # of ΔS_q along e1 with ΔS_p along e2
    np_ = zero_scratch(2)
    nq = zero_scratch(2)
    for c in range(3):
        e1 = alpha * v[c, 0]
        e2 = beta * v[c, 0] + gamma * v[c, 1]
        for k in range(2):
            p = alpha * v[c, 2 + k]
            q = beta * v[c, 2 + k] + gamma * v[c, 4 + k]
            pp[k] += e1 * p
            qq[k] += e2 * q
            pq[k] += e1 * q + e2 * p
            np_[k] += n[c] * p
            nq[k] += n[c] * q
    extra_p = alpha * remainder[0, 0]
    extra_q = abs(beta) * remainder[0, 0] + gamma * remainder[0, 1]
    middle, spread = mean_and_spread(
        abs(pp[0]) + abs(pp[1]) + extra_p,
        0.5 * (abs(pq[0]) + abs(pq[1]) + extra_p + extra_q),
        abs(qq[0]) + abs(qq[1]) + extra_q,
    )
    extra_p = alpha * remainder[1, 0]
    extra_q = abs(beta) * remainder[1, 0] + gamma * remainder[1, 1]
    turn = math.hypot(abs(np_[0]) + abs(np_[1]) + extra_p, abs(nq[0]) + abs(nq[1]) + extra_q)
    return middle + spread, turn


@inner(error_model="numpy")
def length(h, column):
    return math.sqrt(h[0, column] ** 2 + h[1, column] ** 2 + h[2, column] ** 2)


@inner(error_model="numpy")
def _form_change(frame, remainder):
    """Return a bound of the change of the second derivative in any unit direction of the frame.

    `frame` is (α, β, γ), `remainder` (5,) bounds the derivatives of the remainder.
    """
    alpha, beta, gamma = frame
    b = abs(beta)
    xx, xy, yy = remainder[D20], remainder[D11], remainder[D02]
    middle, spread = mean_and_spread(
        alpha * alpha * xx,
        alpha * (b * xx + gamma * xy),
        b * b * xx + 2.0 * b * gamma * xy + gamma * gamma * yy,
    )
    return middle + spread


@kernel(error_model="numpy")
def bend_bounds(elements, e, cell, bend, work):
    """Write the bounds bend[6] over a cell (s0, s1, t0, t1) of element e; return whether any hold.

    They are the largest normal curvature towards the normal and away from it (each at least 0), the
    largest |S_s| and |S_t|, and the smallest part of S_s across S_t and of S_t across S_s: the
    widths that bound the length of paths from one side of the cell to the other. Where derivatives
    vanish, or change by `MAX_STRETCH` or more, curvatures and speeds are infinite and widths zero.
    `work` is the result of `bend_work`, and holds the Taylor polynomial and the bounds of its
    remainder afterwards.
    """
    h, remainder = work.derivatives, work.remainder
    if not remainder_of(elements, e, cell, h, remainder):
        set_unbounded(bend)
        return False
    v = scratch(3, 6)
    for c in range(3):
        v[c, 0], v[c, 1] = h[c, 1], h[c, 2]
        v[c, 2], v[c, 3], v[c, 4], v[c, 5] = h[c, 3], h[c, 4], h[c, 4], h[c, 5]
    x, m, across = frame_of(v)
    if not (x > 0.0 and across > 0.0):
        set_unbounded(bend)
        return False
    frame = (1.0 / x, -m / (x * across), 1.0 / across)
    stretch, turn = stretch_and_turn(v, unit_normal(h), frame, remainder)
    if not stretch < MAX_STRETCH:
        set_unbounded(bend)
        return False
    turn /= 1.0 - stretch
    pp, pq, qq, tangential = second_form(h, frame[0], frame[1], frame[2])
    middle, spread = mean_and_spread(pp, pq, qq)
    change = (
        _form_change(frame, remainder[1]) + (tangential + _form_change(frame, remainder[0])) * turn
    )
    change += 0.5 * turn * turn * (abs(middle) + spread)
    scale = 1.0 / (1.0 - 2.0 * stretch)
    hs = 0.5 * (cell[1] - cell[0])
    ht = 0.5 * (cell[3] - cell[2])
    y = math.hypot(m, across)
    xy = length(h, 4)
    bend[INNER] = max(middle + spread + change, 0.0) * scale
    bend[OUTER] = max(spread - middle + change, 0.0) * scale
    bend[SPEED_S] = (x + length(h, 3) + xy + remainder[0, D10]) / hs
    bend[SPEED_T] = (y + xy + length(h, 5) + remainder[0, D01]) / ht
    bend[WIDTH_S] = (1.0 - stretch) * x * across / (y * hs)
    bend[WIDTH_T] = (1.0 - stretch) * across / ht
    return True
