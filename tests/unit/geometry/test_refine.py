"""Refinement leaves the shape: insertion, elevation, splitting."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import NurbsCurve, NurbsSurface, shapes
from contiga.errors import GeometryError
from contiga.geometry import knots as kv

T = np.linspace(0.0, 1.0, 41)
UV = np.random.default_rng(5).random((60, 2))


def make_surface(p: int, q: int, spans: int = 3) -> NurbsSurface:
    rng = np.random.default_rng(10 * p + q)
    U, V = (
        np.concatenate([np.zeros(d + 1), np.sort(rng.random(spans - 1)), np.ones(d + 1)])
        for d in (p, q)
    )
    shape = (p + spans, q + spans)
    return NurbsSurface((p, q), (U, V), rng.uniform(-1, 1, (*shape, 3)), rng.uniform(0.5, 2, shape))


@pytest.mark.interpreted
def test_thesis_example_of_one_inserted_knot():
    """Section 2.4: 0.5 into the cubic [0 0 0 0 1 1 1 1] halves every leg of the polygon."""
    P = np.random.default_rng(0).normal(size=(4, 3))
    curve = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], P).insert_knots(0.5)
    np.testing.assert_array_equal(curve.knots, [0, 0, 0, 0, 0.5, 1, 1, 1, 1])
    expected = [P[0], (P[0] + P[1]) / 2, (P[1] + P[2]) / 2, (P[2] + P[3]) / 2, P[3]]
    np.testing.assert_allclose(curve.control_points, expected, rtol=0, atol=1e-15)


@pytest.mark.interpreted
def test_knot_raised_to_the_degree_is_met_by_a_control_point():
    curve = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], np.random.default_rng(0).normal(size=(4, 3)))
    refined = curve.insert_knots([0.3, 0.3, 0.3])
    np.testing.assert_allclose(
        refined.control_points[3], curve.evaluate(0.3)[0], rtol=0, atol=1e-15
    )


@pytest.mark.parametrize(("p", "q"), [(1, 2), (3, 3), (4, 7), (15, 10)])
def test_insertion_leaves_the_surface(p, q):
    surface = make_surface(p, q)
    old = float(np.unique(surface.knots[0])[1])
    u = [0.2, 0.9, *([old] if p > 1 else [])]
    refined = surface.insert_knots(u=u, v=[0.4] * q)
    assert refined.control_points.shape[0] == surface.control_points.shape[0] + len(u)
    np.testing.assert_allclose(refined.evaluate(UV), surface.evaluate(UV), rtol=0, atol=1e-13)


@pytest.mark.parametrize(("p", "q"), [(1, 2), (3, 3), (4, 7), (13, 9)])
def test_elevation_leaves_the_surface_and_its_smoothness(p, q):
    surface = make_surface(p, q)
    raised = surface.elevate(u=2, v=1)
    assert raised.degrees == (p + 2, q + 1)
    inner = np.unique(surface.knots[0])[1]
    assert kv.multiplicity(raised.knots[0], inner) == kv.multiplicity(surface.knots[0], inner) + 2
    np.testing.assert_allclose(raised.evaluate(UV), surface.evaluate(UV), rtol=0, atol=1e-13)


def test_elevation_of_a_cubic_segment_has_its_closed_form():
    """Q_i = (i P_{i−1} + (4 − i) P_i) / 4, The NURBS Book, Eq. 5.36."""
    P = np.random.default_rng(0).normal(size=(4, 3))
    raised = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], P).elevate()
    expected = [P[0], *((i * P[i - 1] + (4 - i) * P[i]) / 4 for i in (1, 2, 3)), P[3]]
    np.testing.assert_allclose(raised.control_points, expected, rtol=0, atol=1e-15)


def test_k_refinement_gives_smoother_knots_than_the_other_order():
    curve = NurbsCurve(2, [0, 0, 0, 1, 1, 1], np.random.default_rng(0).normal(size=(3, 3)))
    k = curve.k_refined(2, [0.5])
    p = curve.insert_knots([0.5]).elevate(2)
    assert kv.multiplicity(k.knots, 0.5) == 1
    assert kv.multiplicity(p.knots, 0.5) == 3
    np.testing.assert_allclose(k.evaluate(T), curve.evaluate(T), rtol=0, atol=1e-14)


@pytest.mark.parametrize("at", [0.1, 0.5, 0.77])
def test_split_parts_are_the_surface(at):
    surface = make_surface(3, 4)
    for axis, name in enumerate("uv"):
        low, high = surface.split(**{name: at})
        assert low.domain[axis] == (0.0, at)
        assert high.domain[axis] == (at, 1.0)
        for part in (low, high):
            (u0, u1), (v0, v1) = part.domain
            uv = UV * [u1 - u0, v1 - v0] + [u0, v0]
            np.testing.assert_allclose(part.evaluate(uv), surface.evaluate(uv), rtol=0, atol=1e-13)
        assert low.area() + high.area() == pytest.approx(surface.area(), rel=1e-9)


def test_split_at_an_existing_knot():
    surface = shapes.sphere()
    low, high = surface.split(u=0.5)
    assert low.control_points.shape == high.control_points.shape == (5, 5, 3)
    half = np.linspace(0, 0.5, 9)
    np.testing.assert_allclose(
        low.isocurve(v=0.5).evaluate(half),
        surface.isocurve(v=0.5).evaluate(half),
        rtol=0,
        atol=1e-15,
    )


def test_high_degree_with_many_spans_elevates_without_loss():
    curve = NurbsCurve(14, kv.open_knots(14, 60), np.random.default_rng(0).normal(size=(60, 3)))
    raised = curve.elevate()
    np.testing.assert_allclose(raised.evaluate(T), curve.evaluate(T), rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([0.0], "inside the domain only"),
        ([1.5], "inside the domain only"),
        ([0.5] * 4, "would stand 4 times"),
        ([np.nan], "not finite"),
    ],
)
def test_knots_that_cannot_be_inserted(values, message):
    curve = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], np.zeros((4, 3)))
    with pytest.raises(GeometryError, match=message):
        curve.insert_knots(values)
