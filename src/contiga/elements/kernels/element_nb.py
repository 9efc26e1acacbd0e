"""Evaluation of one Bézier element and its derivatives to second order.

Horner's scheme carries the value and its first two derivatives together (value, slope and half
the curvature), in t for every power of s and then in s. The rational case follows the quotient
rule of Piegl & Tiller, The NURBS Book, Eq. 4.20. Multiply-adds are fused only where the code says
so: the compiler has no choice that would change bits.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import GENERAL, RATIONAL_CUBIC
from contiga.arrays.kernels.fma_nb import fma
from contiga.jit import inlined, inner, kernel

# Columns of the table `h`: value, d/ds, d/dt, d²/ds², d²/dsdt, d²/dt².
VALUE, DS, DT, DSS, DST, DTT = 0, 1, 2, 3, 4, 5

BINOMIAL = np.array([[float(math.comb(n, k)) for k in range(16)] for n in range(16)])


@inlined()
def cubic(a, b, c, d, x):
    """Return value, slope and half the curvature of a + b x + c x² + d x³."""
    # The sums run in parallel with the multiply-adds: 0.9 of the time of six multiply-adds.
    top = d * x
    v = top + c
    d1 = top + v
    v = fma(v, x, b)
    d2 = top + d1
    d1 = fma(d1, x, v)
    return fma(v, x, a), d1, d2


@inlined()
def bicubic(k, o, n, s, t):
    """Return value, d/ds, d/dt, d²/ds², d²/dsdt, d²/dt² of a bicubic at (s, t).

    The coefficient of sⁱ tʲ is k[o + (4 i + j) n].
    """
    b0, p0, q0 = cubic(k[o], k[o + n], k[o + 2 * n], k[o + 3 * n], t)
    b1, p1, q1 = cubic(k[o + 4 * n], k[o + 5 * n], k[o + 6 * n], k[o + 7 * n], t)
    b2, p2, q2 = cubic(k[o + 8 * n], k[o + 9 * n], k[o + 10 * n], k[o + 11 * n], t)
    b3, p3, q3 = cubic(k[o + 12 * n], k[o + 13 * n], k[o + 14 * n], k[o + 15 * n], t)
    v, v_s, v_ss = cubic(b0, b1, b2, b3, s)
    v_t, v_st, _ = cubic(p0, p1, p2, p3, s)
    v_tt = fma(fma(fma(q3, s, q2), s, q1), s, q0)
    return v, v_s, v_t, 2.0 * v_ss, v_st, 2.0 * v_tt


@inlined()
def quotient(n, w):
    """Return value and derivatives of the quotient n/w, from those of n and w; see `bicubic`."""
    i = 1.0 / w[0]
    v = n[0] * i
    v_s = fma(-w[1], v, n[1]) * i
    v_t = fma(-w[2], v, n[2]) * i
    v_ss = fma(-2.0 * w[1], v_s, fma(-w[3], v, n[3])) * i
    v_st = fma(-w[1], v_t, fma(-w[2], v_s, fma(-w[4], v, n[4]))) * i
    v_tt = fma(-2.0 * w[2], v_t, fma(-w[5], v, n[5])) * i
    return v, v_s, v_t, v_ss, v_st, v_tt


@inner(inline="never")
def _evaluate_bicubic(k, s, t, h, rational):
    """Write point and derivatives of coefficients `k` stored as bicubics to h[:3].

    They are divided by the weight if `rational`. Unrolled, 2.5 times as fast as by loops.
    """
    x = bicubic(k, 0, 1, s, t)
    y = bicubic(k, 16, 1, s, t)
    z = bicubic(k, 32, 1, s, t)
    if rational:
        w = bicubic(k, 48, 1, s, t)
        x = quotient(x, w)
        y = quotient(y, w)
        z = quotient(z, w)
    for i in range(6):
        h[0, i] = x[i]
        h[1, i] = y[i]
        h[2, i] = z[i]


@inner(inline="never")
def _evaluate_monomial(coefs, start, degree, s, t, h, components):
    """Write `components` and their derivatives to h by Horner's scheme, not divided by the weight.

    The coefficients of powers begin at coefs[start]; s and t are relative to `about`.
    """
    p, q = degree
    for c in range(components):
        a = a_s = a_ss = a_t = a_st = a_tt = 0.0
        for i in range(p, -1, -1):
            b = b_t = b_tt = 0.0
            k = start + (i * (q + 1) + q) * 4 + c
            for _ in range(q + 1):
                b_tt = fma(b_tt, t, b_t)
                b_t = fma(b_t, t, b)
                b = fma(b, t, coefs[k])
                k -= 4
            a_ss = fma(a_ss, s, a_s)
            a_s = fma(a_s, s, a)
            a = fma(a, s, b)
            a_st = fma(a_st, s, a_t)
            a_t = fma(a_t, s, b_t)
            a_tt = fma(a_tt, s, b_tt)
        h[c, 0] = a
        h[c, 1] = a_s
        h[c, 2] = a_t
        h[c, 3] = 2.0 * a_ss
        h[c, 4] = a_st
        h[c, 5] = 2.0 * a_tt


@inner(inline="never")
def bernstein_basis(degree, x, basis):
    """Write Bernstein polynomials at x in [0, 1] and two derivatives to basis[3, :]; `degree` ≥ 1.

    By the recurrence of de Casteljau: derivatives are differences of the rows of lower degree.
    """
    low = degree - 2
    basis[0, 0] = 1.0
    for k in range(1, degree + 1):
        if k - 1 == low:
            for i in range(degree + 1):
                left = basis[0, i - 2] if i >= 2 else 0.0
                mid = basis[0, i - 1] if 1 <= i <= degree - 1 else 0.0
                right = basis[0, i] if i <= low else 0.0
                basis[2, i] = degree * (degree - 1) * (left - 2.0 * mid + right)
        if k == degree:
            for i in range(degree + 1):
                left = basis[0, i - 1] if i >= 1 else 0.0
                right = basis[0, i] if i <= degree - 1 else 0.0
                basis[1, i] = degree * (left - right)
        saved = 0.0
        for i in range(k):
            value = basis[0, i]
            basis[0, i] = saved + (1.0 - x) * value
            saved = x * value
        basis[0, k] = saved
    if degree == 1:
        basis[2, 0] = 0.0
        basis[2, 1] = 0.0


@inner()
def _bernstein_row(coefs, k, q, t):
    """Return value, slope and curvature at t in [0, 1] of the Bernstein coefficients from coefs[k].

    They are every fourth, q + 1 in all.

    Nested as value·(1 − t) + binomial·tʲ·coefficient: all terms of a positive polynomial are
    positive, so that no digits are lost however much its coefficients differ.
    """
    r = 1.0 - t
    b0 = b1 = b2 = 0.0
    power = power1 = power2 = 1.0
    x1 = x2 = 0.0
    for j in range(q + 1):
        x = coefs[k]
        k += 4
        b0 = b0 * r + BINOMIAL[q, j] * power * x
        if j > 0:
            b1 = b1 * r + BINOMIAL[q - 1, j - 1] * power1 * (x - x1)
        if j > 1:
            b2 = b2 * r + BINOMIAL[q - 2, j - 2] * power2 * (x - 2.0 * x1 + x2)
        x2 = x1
        x1 = x
        power2 = power1
        power1 = power
        power *= t
    return b0, q * b1, q * (q - 1) * b2


@inner(inline="never")
def _evaluate_bernstein(coefs, start, degree, s, t, h, components):
    """Write `components` and their derivatives to h, not divided by the weight.

    By Bernstein coefficients from coefs[start], for elements whose monomials would lose digits.
    """
    p, q = degree
    s += 0.5
    t += 0.5
    r = 1.0 - s
    for c in range(components):
        v = v_s = v_t = v_ss = v_st = v_tt = 0.0
        power = power1 = power2 = 1.0
        x1 = y1 = x2 = 0.0
        for i in range(p + 1):
            x, y, z = _bernstein_row(coefs, start + i * (q + 1) * 4 + c, q, t)
            weight = BINOMIAL[p, i] * power
            v = v * r + weight * x
            v_t = v_t * r + weight * y
            v_tt = v_tt * r + weight * z
            if i > 0:
                weight = BINOMIAL[p - 1, i - 1] * power1
                v_s = v_s * r + weight * (x - x1)
                v_st = v_st * r + weight * (y - y1)
            if i > 1:
                v_ss = v_ss * r + BINOMIAL[p - 2, i - 2] * power2 * (x - 2.0 * x1 + x2)
            x2 = x1
            x1 = x
            y1 = y
            power2 = power1
            power1 = power
            power *= s
        h[c, 0] = v
        h[c, 1] = p * v_s
        h[c, 2] = v_t
        h[c, 3] = p * (p - 1) * v_ss
        h[c, 4] = p * v_st
        h[c, 5] = v_tt


@kernel()
def evaluate(elements, e, s, t, h):
    """Write point and derivatives of element e at (s, t) to h[:3, :6], relative to its origin.

    Columns are the value, d/ds, d/dt, d²/ds², d²/dsdt, d²/dt²; h[3] may be overwritten.
    """
    form = elements.table[e]["form"]
    x = s - elements.table[e]["about"][0]
    y = t - elements.table[e]["about"][1]
    if form != GENERAL:
        _evaluate_bicubic(elements.table[e]["cubic"], x, y, h, form == RATIONAL_CUBIC)
        return
    p = elements.table[e]["degree"][0]
    q = elements.table[e]["degree"][1]
    n = elements.table[e]["components"]
    start = elements.table[e]["monomial"]
    if start >= 0:
        _evaluate_monomial(elements.coefs, start, (p, q), x, y, h, n)
    else:
        _evaluate_bernstein(elements.coefs, elements.table[e]["bernstein"], (p, q), s, t, h, n)
    if n == 4:
        w = (h[3, 0], h[3, 1], h[3, 2], h[3, 3], h[3, 4], h[3, 5])
        for c in range(3):
            v = quotient((h[c, 0], h[c, 1], h[c, 2], h[c, 3], h[c, 4], h[c, 5]), w)
            for i in range(6):
                h[c, i] = v[i]


@inlined()
def place_in(u, first, last):
    """Return the local s in [-1/2, 1/2] of u between `first` and `last`, clamped to these."""
    return min(max((u - first) / (last - first) - 0.5, -0.5), 0.5)


@inner(linked=False)
def locate(grid, patch, u, v):
    """Return the element of `patch` that contains (u, v), and the local (s, t) there.

    A point on a side is in the element after it, one outside the patch at its nearest side.
    """
    row = grid.patches[patch]
    ku = _span(grid.breaks, row["u"][0], row["u"][1], u)
    kv = _span(grid.breaks, row["v"][0], row["v"][1], v)
    s = place_in(u, grid.breaks[ku], grid.breaks[ku + 1])
    t = place_in(v, grid.breaks[kv], grid.breaks[kv + 1])
    nv = row["v"][1] - row["v"][0] - 1
    return row["first"] + (ku - row["u"][0]) * nv + kv - row["v"][0], s, t


@inner()
def _span(breaks, start, stop, x):
    return span(breaks, start, stop, span_density(breaks, start, stop), x)


@inner()
def span_density(breaks, start, stop):
    """Return the number of spans of breaks[start:stop] per unit of parameter; 0 for one span."""
    # In bodies of many faces most are one element: their breaks need not be read.
    if stop - start == 2:
        return 0.0
    return (stop - 1 - start) / (breaks[stop - 1] - breaks[start])


@inner()
def span(breaks, start, stop, density, x):
    """Return the index in `breaks` at which the span of breaks[start:stop] with x begins.

    `density` is the result of `span_density`. Outside the breaks it is the first or the last span.
    """
    if stop - start == 2:
        return start
    # For even breaks the guess is right: 2.5 times as fast as bisection, whose branches are random.
    offset = (x - breaks[start]) * density
    if 0.0 <= offset < stop - 1 - start:
        guess = start + int(offset)
        if breaks[guess] <= x < breaks[guess + 1]:
            return guess
    low = start
    high = stop - 1
    while high - low > 1:
        mid = (low + high) >> 1
        if x >= breaks[mid]:
            low = mid
        else:
            high = mid
    return low


@inner()
def parameters(elements, e, s, t):
    """Return the patch parameters (u, v) of local (s, t); exact on the element's sides."""
    u0 = elements.table[e]["box"][0]
    u1 = elements.table[e]["box"][1]
    v0 = elements.table[e]["box"][2]
    v1 = elements.table[e]["box"][3]
    u = u0 if s <= -0.5 else (u1 if s >= 0.5 else u0 + (s + 0.5) * (u1 - u0))
    v = v0 if t <= -0.5 else (v1 if t >= 0.5 else v0 + (t + 0.5) * (v1 - v0))
    return u, v
