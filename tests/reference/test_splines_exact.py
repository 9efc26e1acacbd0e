"""Rational surfaces against the same formulas in exact fractions: no rounding at all."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from math import comb

import numpy as np
import pytest

from contiga import NurbsSurface

ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def exact_basis(knots, degree, t):
    """Rows 0 to 2: all basis functions at `t` and two derivatives, by the Cox-de Boor recursion."""
    U, t = [Fraction(k) for k in knots], Fraction(t)

    def over(a, b):
        return a / b if b else Fraction(0)

    @cache
    def N(i, p):
        if p == 0:
            return Fraction(U[i] <= t < U[i + 1])
        rise = over(t - U[i], U[i + p] - U[i]) * N(i, p - 1)
        return rise + over(U[i + p + 1] - t, U[i + p + 1] - U[i + 1]) * N(i + 1, p - 1)

    @cache
    def dN(i, p, order):
        if order == 0:
            return N(i, p)
        if p == 0:
            return Fraction(0)
        rise = over(Fraction(p), U[i + p] - U[i]) * dN(i, p - 1, order - 1)
        return rise - over(Fraction(p), U[i + p + 1] - U[i + 1]) * dN(i + 1, p - 1, order - 1)

    return [[dN(i, degree, k) for i in range(len(U) - degree - 1)] for k in range(3)]


def exact_derivatives(surface, u, v):
    """The entries of ORDERS as (3,) arrays, rounded once at the end."""
    (p, q), (U, V) = surface.degrees, surface.knots
    rows, columns = exact_basis(U.tolist(), p, u), exact_basis(V.tolist(), q, v)
    net = np.concatenate([surface.control_points, surface.weights[..., None]], axis=-1).tolist()
    net = [[[Fraction(c) for c in point] for point in line] for line in net]
    A = {}
    for a, b in ORDERS:
        A[a, b] = [
            sum(
                f * g * point[3] * (point[d] if d < 3 else 1)
                for f, line in zip(rows[a], net, strict=True)
                for g, point in zip(columns[b], line, strict=True)
                if f and g
            )
            for d in range(4)
        ]
    S = {}
    for a, b in ORDERS:
        S[a, b] = [
            (
                A[a, b][d]
                - sum(
                    comb(a, i) * comb(b, j) * A[i, j][3] * S[a - i, b - j][d]
                    for i in range(a + 1)
                    for j in range(b + 1)
                    if i + j
                )
            )
            / A[0, 0][3]
            for d in range(3)
        ]
    return {k: np.array([float(x) for x in value]) for k, value in S.items()}


@pytest.mark.parametrize(("p", "q"), [(1, 2), (3, 3), (7, 4), (15, 2), (15, 15)])
def test_points_and_derivatives_are_right_to_thirteen_digits(p, q):
    rng = np.random.default_rng(p * 31 + q)
    U, V = (np.r_[np.zeros(d + 1), 0.3, 0.6, np.ones(d + 1)] for d in (p, q))
    shape = (p + 3, q + 3)
    surface = NurbsSurface((p, q), (U, V), rng.normal(size=(*shape, 3)), rng.uniform(0.1, 5, shape))
    for u, v in rng.random((3, 2)).tolist():
        D = surface.derivatives([u, v], order=2)[0]
        for (a, b), expected in exact_derivatives(surface, u, v).items():
            scale = 1.0 + np.abs(expected).max()
            np.testing.assert_allclose(D[a, b], expected, rtol=0, atol=1e-13 * scale)
