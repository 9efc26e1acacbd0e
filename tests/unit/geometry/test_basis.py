"""Basis functions and the maps between knot vectors, against other codes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from contiga.geometry.kernels import basis_nb

pytestmark = pytest.mark.interpreted

KNOTS = np.array([0, 0, 0, 0, 0.3, 0.5, 0.5, 0.9, 1, 1, 1, 1.0])
COUNT, DEGREE = 8, 3
T = np.linspace(0.0, 1.0, 101)


def spline(knots, degree, points):
    return BSpline(knots, points, degree)(T)


def test_derivatives_of_the_basis_are_those_of_scipy():
    for t in (0.0, 0.2, 0.5, 0.77, 1.0):
        span = basis_nb.find_span(KNOTS, DEGREE, COUNT, t)
        out = np.empty((DEGREE + 1, DEGREE + 1))
        basis_nb.basis_derivatives(KNOTS, DEGREE, span, t, DEGREE, out)
        for i in range(DEGREE + 1):
            one = BSpline(KNOTS, np.eye(COUNT)[span - DEGREE + i], DEGREE)
            expected = [one(t, nu=k) for k in range(DEGREE + 1)]
            np.testing.assert_allclose(out[:, i], expected, rtol=1e-10, atol=1e-10)


def test_spans_hold_their_parameters_and_the_last_one_is_closed():
    assert basis_nb.find_span(KNOTS, DEGREE, COUNT, 0.5) == 6
    assert basis_nb.find_span(KNOTS, DEGREE, COUNT, 1.0) == 7
    assert basis_nb.find_span(KNOTS, DEGREE, COUNT, 0.0) == 3


@pytest.mark.parametrize("what", ["refined", "elevated"])
def test_new_points_give_the_same_curve(what):
    points = np.random.default_rng(0).random((COUNT, 2))
    if what == "refined":
        knots, degree = np.sort(np.append(KNOTS, [0.1, 0.3, 0.7, 0.7])), DEGREE
        rows = basis_nb.refinement_rows(KNOTS, DEGREE, COUNT, knots)
    else:
        knots, degree = np.sort(np.append(KNOTS, np.unique(KNOTS))), DEGREE + 1
        rows = basis_nb.elevation_rows(KNOTS, DEGREE, COUNT, knots)
    np.testing.assert_allclose(rows[1].sum(axis=1), 1.0, atol=1e-14)
    assert rows[1].min() >= -1e-15
    actual = spline(knots, degree, basis_nb.apply_rows(*rows, points))
    np.testing.assert_allclose(actual, spline(KNOTS, DEGREE, points), atol=1e-13)
