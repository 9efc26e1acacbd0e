"""Polynomial splines against scipy, of every degree, on clamped and unclamped knots."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, NdBSpline

from contiga import NurbsCurve, NurbsSurface


@pytest.mark.parametrize("degree", range(1, 16))
def test_curves_on_unclamped_knots_agree(degree):
    rng = np.random.default_rng(degree)
    knots = np.cumsum(rng.uniform(0.5, 1.5, 2 * degree + 7)) - 40.0
    points = rng.normal(size=(degree + 6, 3))
    theirs = BSpline(knots, points, degree)
    ours = NurbsCurve(degree, knots, points)
    assert ours.domain == (knots[degree], knots[degree + 6])
    u = np.linspace(*ours.domain, 31)[1:-1]
    for order in range(min(degree, 4) + 1):
        expected = theirs.derivative(order)(u) if order else theirs(u)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(
            ours.derivatives(u, order)[:, order],
            expected,
            rtol=0,
            atol=1e-9 * scale if order else 1e-12,
        )


def test_repeated_interior_knots_agree():
    knots = np.array([0, 0, 0, 0, 1, 1, 2, 2, 2, 4, 5, 5, 5, 5.0])
    points = np.random.default_rng(0).normal(size=(10, 3))
    u = np.linspace(0, 5, 101)
    np.testing.assert_allclose(
        NurbsCurve(3, knots, points).evaluate(u), BSpline(knots, points, 3)(u), rtol=0, atol=1e-14
    )


@pytest.mark.parametrize(("p", "q"), [(2, 3), (4, 1), (11, 6)])
def test_surfaces_on_unclamped_knots_agree(p, q):
    rng = np.random.default_rng(p)
    U = np.cumsum(rng.uniform(0.5, 1.5, 2 * p + 4))
    V = np.cumsum(rng.uniform(0.5, 1.5, 2 * q + 5))
    points = rng.normal(size=(p + 3, q + 4, 3))
    ours = NurbsSurface((p, q), (U, V), points)
    (u0, u1), (v0, v1) = ours.domain
    uv = rng.random((50, 2)) * [u1 - u0, v1 - v0] + [u0, v0]
    theirs = NdBSpline((U, V), points, (p, q))
    np.testing.assert_allclose(ours.evaluate(uv), theirs(uv), rtol=0, atol=1e-12)
