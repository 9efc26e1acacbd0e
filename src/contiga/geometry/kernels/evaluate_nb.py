"""Points, derivatives and normals of NURBS curves and surfaces at many parameters."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.geometry.kernels.basis_nb import basis_derivatives, find_span
from contiga.jit import inner, kernel
from contiga.pointer_records import pass_by_pointer

NOISE = 1e-8
"""Share of its terms below which S_u × S_v has lost half of its digits to cancellation: the normal
is then the limit from inside the domain."""
BORDER = 1e-3
"""Share of the domain from its upper end within which the inside is towards lower parameters."""
LIMIT_ORDER = 5
"""Highest derivative of S_u × S_v for that limit."""
ROUNDING = 4.0 * 2.220446049250313e-16 / NOISE
"""Share of the coordinates up to which a side is a point."""


@pass_by_pointer
class CurveArrays(NamedTuple):
    """The arrays of a curve for kernels."""

    degree: int
    knots: np.ndarray
    """Clamped."""
    net: np.ndarray
    """(n, 4) Cartesian x, y, z and the weight."""
    rational: bool


@pass_by_pointer
class SurfaceArrays(NamedTuple):
    """The arrays of a surface for kernels."""

    p: int
    q: int
    U: np.ndarray
    V: np.ndarray
    net: np.ndarray
    """(n, m, 4) Cartesian x, y, z and the weight."""
    rational: bool


class Scratch(NamedTuple):
    """Work arrays of one thread for derivatives up to one order."""

    Nu: np.ndarray
    Nv: np.ndarray
    rows: np.ndarray
    sums: np.ndarray
    binomial: np.ndarray


@inner()
def binomials(order):
    """Return Pascal's triangle (order + 1, order + 1): entry [n, k] is n over k."""
    table = np.zeros((order + 1, order + 1))
    for n in range(order + 1):
        table[n, 0] = 1.0
        for k in range(1, n + 1):
            table[n, k] = table[n - 1, k - 1] + table[n - 1, k]
    return table


@kernel()
def make_scratch(p, q, order):
    """Return work arrays for derivatives up to `order` of a surface of degrees (p, q)."""
    return Scratch(
        np.empty((order + 1, p + 1)),
        np.empty((order + 1, q + 1)),
        np.empty((order + 1, p + 1, 4)),
        np.empty((order + 1, order + 1, 4)),
        binomials(order),
    )


@inner()
def nearest_point(knots, degree, span, t):
    """Return the index of a control point near `t`, by its share of the span."""
    share = (t - knots[span]) / (knots[span + 1] - knots[span])
    return span - degree + round(degree * share)


@inner(linked=False)
def surface_sums(s, u, v, order, work):
    """Write derivatives of the numerator and the weight at one point to ``work.sums``.

    The numerator is relative to a near control point, whose indices (i, j) are returned: a surface
    far from the origin then loses no digits. Basis functions are left in `work.Nu` and `work.Nv`.
    """
    su = find_span(s.U, s.p, s.net.shape[0], u)
    sv = find_span(s.V, s.q, s.net.shape[1], v)
    basis_derivatives(s.U, s.p, su, u, order, work.Nu)
    basis_derivatives(s.V, s.q, sv, v, order, work.Nv)
    ci = nearest_point(s.U, s.p, su, u)
    cj = nearest_point(s.V, s.q, sv, v)
    cx = s.net[ci, cj, 0]
    cy = s.net[ci, cj, 1]
    cz = s.net[ci, cj, 2]
    work.rows[:] = 0.0
    for i in range(s.p + 1):
        for j in range(s.q + 1):
            w = s.net[su - s.p + i, sv - s.q + j, 3]
            x = w * (s.net[su - s.p + i, sv - s.q + j, 0] - cx)
            y = w * (s.net[su - s.p + i, sv - s.q + j, 1] - cy)
            z = w * (s.net[su - s.p + i, sv - s.q + j, 2] - cz)
            for b in range(order + 1):
                f = work.Nv[b, j]
                work.rows[b, i, 0] += f * x
                work.rows[b, i, 1] += f * y
                work.rows[b, i, 2] += f * z
                work.rows[b, i, 3] += f * w
    work.sums[:] = 0.0
    for a in range(order + 1):
        for b in range(order + 1):
            for i in range(s.p + 1):
                f = work.Nu[a, i]
                for d in range(4):
                    work.sums[a, b, d] += f * work.rows[b, i, d]
    return ci, cj


@inner()
def quotient(sums, binomial, order, rational, out):
    """Write derivatives of numerator / weight to `out` (order + 1, order + 1, 3).

    The NURBS Book, Algorithm A4.4, kept to the full square of mixed orders.
    """
    for a in range(order + 1):
        for b in range(order + 1):
            for d in range(3):
                out[a, b, d] = sums[a, b, d]
            if not rational:
                continue
            for i in range(a + 1):
                for j in range(b + 1):
                    if i + j > 0:
                        f = binomial[a, i] * binomial[b, j] * sums[i, j, 3]
                        for d in range(3):
                            out[a, b, d] -= f * out[a - i, b - j, d]
            for d in range(3):
                out[a, b, d] /= sums[0, 0, 3]


@inner(linked=False)
def surface_point(s, u, v, order, work, out):
    """Write the point and derivatives at (u, v) to `out` (order + 1, order + 1, 3)."""
    ci, cj = surface_sums(s, u, v, order, work)
    quotient(work.sums, work.binomial, order, s.rational, out)
    for d in range(3):
        out[0, 0, d] += s.net[ci, cj, d]


@kernel()
def surface_range(s, uv, order, out, start, stop):
    """Write rows start … stop − 1 of `out`: points and derivatives at `uv`, see `surface_point`."""
    work = make_scratch(s.p, s.q, order)
    for k in range(start, stop):
        surface_point(s, uv[k, 0], uv[k, 1], order, work, out[k])


@kernel()
def curve_range(c, t, order, out):
    """Write points and derivatives of a curve at `t` (k,) to `out` (k, order + 1, 3).

    Algorithm A4.2 of The NURBS Book, about a control point near each: see `surface_sums`.
    """
    N = np.empty((order + 1, c.degree + 1))
    sums = np.empty((order + 1, 4))
    binomial = binomials(order)
    for k in range(t.size):
        span = find_span(c.knots, c.degree, c.net.shape[0], t[k])
        basis_derivatives(c.knots, c.degree, span, t[k], order, N)
        centre = nearest_point(c.knots, c.degree, span, t[k])
        sums[:] = 0.0
        for i in range(c.degree + 1):
            w = c.net[span - c.degree + i, 3]
            for a in range(order + 1):
                f = N[a, i] * w
                for d in range(3):
                    sums[a, d] += f * (c.net[span - c.degree + i, d] - c.net[centre, d])
                sums[a, 3] += f
        for a in range(order + 1):
            for d in range(3):
                value = sums[a, d]
                for i in range(1, a + 1 if c.rational else 1):
                    value -= binomial[a, i] * sums[i, 3] * out[k, a - i, d]
                out[k, a, d] = value / sums[0, 3] if c.rational else value
        for d in range(3):
            out[k, 0, d] += c.net[centre, d]


@inner()
def length3(x, y, z):
    """Return the Euclidean length of (x, y, z)."""
    return math.sqrt(x * x + y * y + z * z)


@inner()
def add_cross(a, b, factor, out):
    """Add factor · a × b to `out` (3,)."""
    out[0] += factor * (a[1] * b[2] - a[2] * b[1])
    out[1] += factor * (a[2] * b[0] - a[0] * b[2])
    out[2] += factor * (a[0] * b[1] - a[1] * b[0])


@inner()
def tangent_noise(s, u, v, work):
    """Return the sizes of the terms that cancel in S_u and in S_v, the scale of their rounding.

    Uses the basis functions left in `work` by `surface_sums`.
    """
    su = find_span(s.U, s.p, s.net.shape[0], u)
    sv = find_span(s.V, s.q, s.net.shape[1], v)
    ci = nearest_point(s.U, s.p, su, u)
    cj = nearest_point(s.V, s.q, sv, v)
    a_u = 0.0
    a_v = 0.0
    for i in range(s.p + 1):
        for j in range(s.q + 1):
            square = 0.0
            for d in range(3):
                square += (s.net[su - s.p + i, sv - s.q + j, d] - s.net[ci, cj, d]) ** 2
            point = s.net[su - s.p + i, sv - s.q + j]
            magnitude = length3(point[0], point[1], point[2])
            size = math.sqrt(square) + ROUNDING * magnitude
            size *= s.net[su - s.p + i, sv - s.q + j, 3]
            a_u += abs(work.Nu[1, i] * work.Nv[0, j]) * size
            a_v += abs(work.Nu[0, i] * work.Nv[1, j]) * size
    w = work.sums[0, 0, 3]
    return a_u / w, a_v / w


@inner()
def inward(knots, count, t):
    """Return the length of the domain, negative at its upper end: it points inside from `t`."""
    low = knots[0]
    high = knots[count]
    if t > high - BORDER * (high - low):
        return low - high
    return high - low


@inner()
def limit_normal(s, u, v, normal):
    """Write the unit normal as a limit from inside to `normal`; False, and NaN, if there is none.

    If S_u × S_v vanishes, its lowest derivative along the inward direction that does not vanish
    gives the direction in the limit; derivatives up to `LIMIT_ORDER` are tried.
    """
    top = LIMIT_ORDER
    work = make_scratch(s.p, s.q, top + 1)
    D = np.empty((top + 2, top + 2, 3))
    surface_point(s, u, v, top + 1, work, D)
    du = inward(s.U, s.net.shape[0], u)
    dv = inward(s.V, s.net.shape[1], v)
    C = work.binomial
    for k in range(1, top + 1):
        normal[:] = 0.0
        size = 0.0
        for a in range(k + 1):
            b = k - a
            for i in range(a + 1):
                for j in range(b + 1):
                    f = C[k, a] * C[a, i] * C[b, j] * du**a * dv**b
                    first = D[i + 1, j]
                    second = D[a - i, b - j + 1]
                    add_cross(first, second, f, normal)
                    a1 = length3(first[0], first[1], first[2])
                    size += abs(f) * a1 * length3(second[0], second[1], second[2])
        norm = length3(normal[0], normal[1], normal[2])
        if norm > NOISE * size and norm > 0.0:
            for d in range(3):
                normal[d] /= norm
            return True
    normal[:] = np.nan
    return False


@kernel()
def normal_range(s, uv, out, start, stop):
    """Write rows start … stop − 1 of the unit normals at `uv` to `out`; NaN where there is none.

    Where S_u × S_v is small as its rounding it is the `limit_normal`.
    """
    work = make_scratch(s.p, s.q, 1)
    D = np.empty((2, 2, 3))
    for k in range(start, stop):
        u = uv[k, 0]
        v = uv[k, 1]
        surface_point(s, u, v, 1, work, D)
        a_u, a_v = tangent_noise(s, u, v, work)
        out[k, :] = 0.0
        add_cross(D[1, 0], D[0, 1], 1.0, out[k])
        norm = length3(out[k, 0], out[k, 1], out[k, 2])
        scale = a_u * length3(D[0, 1, 0], D[0, 1, 1], D[0, 1, 2])
        scale += a_v * length3(D[1, 0, 0], D[1, 0, 1], D[1, 0, 2])
        if norm > NOISE * scale and norm > 0.0:
            for d in range(3):
                out[k, d] /= norm
        else:
            limit_normal(s, u, v, out[k])
