"""Curves: values, derivatives, parts and moves."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from contiga import NurbsCurve, shapes
from contiga.errors import GeometryError, InputError

T = np.linspace(0.0, 1.0, 23)


def random_curve(degree: int, *, rational: bool = True, seed: int = 0) -> NurbsCurve:
    rng = np.random.default_rng(seed + degree)
    inner = np.sort(rng.random(4))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    points = rng.normal(size=(degree + 5, 3))
    return NurbsCurve(
        degree, knots, points, rng.uniform(0.3, 3.0, degree + 5) if rational else None
    )


@pytest.mark.interpreted
def test_bernstein_cubic_has_its_closed_form():
    a = np.random.default_rng(0).normal(size=(4, 3))
    curve = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], a)
    t = T[:, None]
    s = 1.0 - t
    value = s**3 * a[0] + 3 * s**2 * t * a[1] + 3 * s * t**2 * a[2] + t**3 * a[3]
    slope = 3 * (s**2 * (a[1] - a[0]) + 2 * s * t * (a[2] - a[1]) + t**2 * (a[3] - a[2]))
    third = 6 * (a[3] - 3 * a[2] + 3 * a[1] - a[0])
    actual = curve.derivatives(T, order=5)
    np.testing.assert_allclose(actual[:, 0], value, rtol=0, atol=1e-14)
    np.testing.assert_allclose(actual[:, 1], slope, rtol=0, atol=1e-14)
    np.testing.assert_allclose(actual[:, 3], np.broadcast_to(third, (23, 3)), rtol=0, atol=1e-13)
    assert not actual[:, 4:].any()


def test_rational_derivatives_of_a_circle_obey_its_equation():
    """From |C|² = 1: C·C' = 0, C·C'' + |C'|² = 0, C·C''' + 3 C'·C'' = 0."""
    d = shapes.circle().derivatives(T, order=3)
    dot = lambda a, b: (d[:, a] * d[:, b]).sum(axis=1)  # noqa: E731
    np.testing.assert_allclose(dot(0, 1), 0.0, rtol=0, atol=1e-13)
    np.testing.assert_allclose(dot(0, 2) + dot(1, 1), 0.0, rtol=0, atol=1e-11)
    np.testing.assert_allclose(dot(0, 3) + 3.0 * dot(1, 2), 0.0, rtol=0, atol=1e-10)


def test_weight_pulls_the_curve_towards_its_point():
    """Fig. 5.6 and 5.7 of the thesis: weight 2, then 5, on the second control point."""
    knots = [0, 0, 0, 0.125, 0.3, 0.375, 0.5, 0.6, 0.7, 0.875, 1, 1, 1]
    points = np.column_stack([np.arange(10.0), np.tile([0.0, 1.0], 5), np.zeros(10)])
    nearest = []
    for weight in (1.0, 2.0, 5.0):
        weights = np.ones(10)
        weights[1] = weight
        curve = NurbsCurve(2, knots, points, weights)
        distances = np.linalg.norm(curve.evaluate(np.linspace(0, 1, 2001)) - points[1], axis=1)
        nearest.append(distances.min())
    assert nearest[0] > 1.3 * nearest[1] > 1.5 * nearest[2] > 0.0


def test_equal_weights_give_the_polynomial_curve():
    plain = random_curve(3, rational=False)
    weighted = NurbsCurve(3, plain.knots, plain.control_points, np.full(8, 7.3))
    np.testing.assert_allclose(weighted.derivatives(T), plain.derivatives(T), rtol=0, atol=1e-11)


@pytest.mark.parametrize("degree", [1, 2, 5, 15])
def test_ends_are_the_end_points_exactly(degree):
    curve = random_curve(degree)
    ends = curve.evaluate([0.0, 1.0])
    np.testing.assert_array_equal(ends, curve.control_points[[0, -1]])


def test_reversed_runs_backwards_over_the_same_domain():
    curve = random_curve(4)
    back = curve.reversed()
    assert back.domain == curve.domain
    np.testing.assert_allclose(back.evaluate(T), curve.evaluate(1.0 - T), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        back.derivatives(T)[:, 1], -curve.derivatives(1.0 - T)[:, 1], rtol=1e-9
    )


def test_plane_control_points_get_zero_z():
    curve = NurbsCurve(1, [0, 0, 1, 1], [[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(curve.control_points, [[1, 2, 0], [3, 4, 0]])


def test_curve_far_from_the_origin_keeps_its_derivatives():
    curve = random_curve(3)
    far = curve.translated((1e6, -1e6, 1e6))
    ours, near = far.derivatives(T), curve.derivatives(T)
    for order in (1, 2):
        scale = np.abs(near[:, order]).max()
        np.testing.assert_allclose(ours[:, order], near[:, order], rtol=0, atol=1e-9 * scale)


def test_a_curve_survives_pickling():
    curve = random_curve(3)
    again = pickle.loads(pickle.dumps(curve))
    np.testing.assert_array_equal(again.evaluate(T), curve.evaluate(T))


def test_order_and_steps_must_be_whole_numbers():
    curve = random_curve(2)
    with pytest.raises(InputError, match="whole number"):
        curve.derivatives(T, order=-1)
    with pytest.raises(InputError, match="whole number"):
        curve.elevate(0.5)
    with pytest.raises(GeometryError, match="after elevation"):
        curve.elevate(14)
