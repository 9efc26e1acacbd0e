"""What knot vectors and control nets are accepted."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import NurbsCurve, NurbsSurface
from contiga.errors import GeometryError, InputError
from contiga.geometry import knots as kv

LINE = [0.0, 0.0, 1.0, 1.0]
CUBIC = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
FOUR = np.arange(12.0).reshape(4, 3)


@pytest.mark.parametrize(
    ("degree", "knots", "points", "weights", "message"),
    [
        (0, LINE, FOUR[:2], None, "degree must be a whole number"),
        (16, LINE, FOUR[:2], None, "degree must be a whole number"),
        (1.5, LINE, FOUR[:2], None, "degree must be a whole number"),
        (True, LINE, FOUR[:2], None, "degree must be a whole number"),
        (1, [0.0, 0.0, 2.0, 1.0], FOUR[:2], None, "must not decrease"),
        (1, [0.0, 0.0, 1.0], FOUR[:2], None, "need 4 knots"),
        (3, LINE, FOUR[:2], None, "at least 4 control points"),
        (1, [0.0, 0.0, 0.0, 0.0], FOUR[:2], None, "is empty"),
        (1, [0.0, 0.0, np.nan, 1.0], FOUR[:2], None, "not finite"),
        (1, LINE, [[0.0, 0.0, np.inf], [1.0, 0.0, 0.0]], None, "not finite"),
        (1, LINE, FOUR[:2].tolist()[0], None, r"shape \(n, 3\)"),
        (1, LINE, [["a", "b", "c"]] * 2, None, "not an array of numbers"),
        (1, LINE, FOUR[:2], [1.0, 0.0], "must be positive"),
        (1, LINE, FOUR[:2], [1.0, -2.0], "must be positive"),
        (1, LINE, FOUR[:2], [1.0, np.nan], "not finite"),
        (1, LINE, FOUR[:2], [1.0], "one weight for each"),
        (1, [0.0, 0.0, 0.5, 0.5, 1.0, 1.0], FOUR, None, r"interior knot 0\.5 is there 2 times"),
    ],
)
def test_bad_curve_is_refused_with_one_message(degree, knots, points, weights, message):
    with pytest.raises(GeometryError, match=message):
        NurbsCurve(degree, knots, points, weights)


@pytest.mark.parametrize(
    ("degrees", "knots", "shape", "message"),
    [
        ((1,), (LINE, LINE), (2, 2, 3), "two degrees"),
        ((1, 0), (LINE, LINE), (2, 2, 3), "degree in v"),
        ((1, 1), (LINE,), (2, 2, 3), "two knot vectors"),
        ((1, 1), (LINE, CUBIC), (2, 2, 3), "knots in v"),
        ((1, 1), (LINE, LINE), (2, 2, 2), r"shape \(n, m, 3\)"),
        ((1, 1), (LINE, LINE), (4, 3), r"shape \(n, m, 3\)"),
    ],
)
def test_bad_surface_is_refused_with_one_message(degrees, knots, shape, message):
    with pytest.raises(GeometryError, match=message):
        NurbsSurface(degrees, knots, np.zeros(shape))


def test_error_names_the_value_and_what_is_allowed():
    with pytest.raises(GeometryError, match=r"found 16; allowed: 1 to 15"):
        NurbsCurve(16, LINE, FOUR[:2])


def test_unclamped_knots_are_clamped_with_the_same_parameters():
    """A uniform cubic B-spline: at its first interior knot the point is (1, 4, 1)/6 of three."""
    points = np.random.default_rng(1).normal(size=(6, 3))
    curve = NurbsCurve(3, np.arange(10.0), points)
    assert curve.domain == (3.0, 6.0)
    assert kv.is_clamped(curve.knots, 3, len(curve.control_points))
    expected = [(points[i] + 4.0 * points[i + 1] + points[i + 2]) / 6.0 for i in (0, 1, 2, 3)]
    np.testing.assert_allclose(curve.evaluate([3.0, 4.0, 5.0, 6.0]), expected, rtol=0, atol=1e-15)


def test_too_many_end_knots_drop_the_points_that_have_no_influence():
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    curve = NurbsCurve(1, knots, FOUR)
    np.testing.assert_array_equal(curve.knots, LINE)
    np.testing.assert_array_equal(curve.control_points, FOUR[1:3])


def test_knots_that_differ_by_rounding_are_one_knot():
    third = 1.0 / 3.0
    knots = [0, 0, 0, third, np.nextafter(third, 1.0), 1, 1, 1]
    curve = NurbsCurve(2, knots, np.random.default_rng(0).normal(size=(5, 3)))
    assert kv.multiplicity(curve.knots, third) == 2


def test_arrays_are_copied_and_cannot_be_written():
    points = np.zeros((2, 3))
    curve = NurbsCurve(1, LINE, points)
    points[:] = 7.0
    assert not curve.control_points.any()
    for array in (curve.control_points, curve.knots):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(AttributeError):
        curve.degree = 2


@pytest.mark.parametrize("excess", [1e-9, 1.0, np.nan, np.inf])
def test_parameter_outside_the_domain_is_an_error(excess):
    curve = NurbsCurve(1, LINE, FOUR[:2])
    with pytest.raises(InputError, match="row 1 of u is outside the domain"):
        curve.evaluate([0.5, 1.0 + excess])


def test_rounding_sized_excess_is_clipped():
    curve = NurbsCurve(1, LINE, FOUR[:2])
    np.testing.assert_array_equal(curve.evaluate(1.0 + 1e-12), FOUR[1:2])


@pytest.mark.interpreted
@pytest.mark.parametrize("degree", [1, 2, 3, 7, 15])
def test_basis_sums_to_one_and_its_derivatives_to_zero(degree):
    rng = np.random.default_rng(degree)
    knots = np.concatenate([np.zeros(degree + 1), np.sort(rng.random(4)), np.ones(degree + 1)])
    values = kv.basis(knots, degree, np.append(rng.random(20), [0.0, 1.0]), order=2)
    assert (values[:, 0] >= 0.0).all()
    np.testing.assert_allclose(values[:, 0].sum(axis=-1), 1.0, rtol=0, atol=1e-14)
    scale = np.abs(values[:, 1:]).sum(axis=-1)
    assert (np.abs(values[:, 1:].sum(axis=-1)) <= 1e-13 * scale).all()


@pytest.mark.interpreted
def test_basis_of_the_thesis_example_is_quadratic():
    """The uniform open knots of section 5.1.1: ten functions, the middle one peaks at 3/4."""
    knots = np.array([0, 0, 0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1, 1, 1])
    values = kv.basis(knots, 2, [0.4375])
    assert values.shape == (1, 1, 10)
    assert values[0, 0, 4] == pytest.approx(0.75, abs=1e-15)
    np.testing.assert_allclose(values[0, 0, [3, 5]], 0.125, rtol=0, atol=1e-15)
