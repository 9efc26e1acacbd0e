"""Laws every spline obeys, on random ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga import NurbsCurve, NurbsSurface

T = np.linspace(0.0, 1.0, 101)
FEW = settings(max_examples=25, deadline=None)


@st.composite
def knot_vectors(draw, degree):
    """Clamped on [0, 1] with some repeated interior knots."""
    values = draw(st.lists(st.integers(1, 31), max_size=5, unique=True))
    times = [draw(st.integers(1, degree)) for _ in values]
    inner = np.repeat(np.sort(np.array(values, dtype=float)) / 32.0, times)
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


@st.composite
def curves(draw, max_degree=6):
    degree = draw(st.integers(1, max_degree))
    knots = draw(knot_vectors(degree))
    n = knots.size - degree - 1
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    weights = 10.0 ** rng.uniform(-2, 2, n) if draw(st.booleans()) else None
    return NurbsCurve(degree, knots, rng.normal(size=(n, 3)), weights)


@st.composite
def surfaces(draw, max_degree=4):
    p, q = draw(st.integers(1, max_degree)), draw(st.integers(1, max_degree))
    U, V = draw(knot_vectors(p)), draw(knot_vectors(q))
    shape = (U.size - p - 1, V.size - q - 1)
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    weights = 10.0 ** rng.uniform(-1, 1, shape) if draw(st.booleans()) else None
    return NurbsSurface((p, q), (U, V), rng.normal(size=(*shape, 3)), weights)


@FEW
@given(curves())
def test_curve_stays_in_the_hull_of_the_points_of_its_span(curve):
    """Strong convex hull property, seen along 20 directions."""
    directions = np.random.default_rng(0).normal(size=(20, 3))
    heights = curve.control_points @ directions.T
    for t, point in zip(T, curve.evaluate(T), strict=True):
        span = min(int(np.searchsorted(curve.knots, t, side="right")) - 1, len(heights) - 1)
        span = max(span, curve.degree)
        local = heights[span - curve.degree : span + 1]
        height = point @ directions.T
        assert (height <= local.max(axis=0) + 1e-12).all()
        assert (height >= local.min(axis=0) - 1e-12).all()


@FEW
@given(curves(), st.integers(0, 2**32 - 1))
def test_no_plane_cuts_a_curve_more_often_than_its_polygon(curve, seed):
    """Variation diminishing property."""
    rng = np.random.default_rng(seed)
    points = curve.evaluate(np.linspace(0, 1, 2001))
    for _ in range(10):
        normal, through = rng.normal(size=3), rng.normal(size=3) * 0.3
        of_curve = np.sign((points - through) @ normal)
        of_polygon = np.sign((curve.control_points - through) @ normal)
        crossings = [np.count_nonzero(np.diff(s[s != 0.0])) for s in (of_curve, of_polygon)]
        assert crossings[0] <= crossings[1]


@FEW
@given(surfaces(), st.integers(0, 2**32 - 1))
def test_affine_maps_commute_with_evaluation(surface, seed):
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3] = rng.normal(size=(3, 4))
    uv = rng.random((20, 2))
    moved = surface.transformed(matrix)
    if np.linalg.det(matrix) < 0.0:
        moved = moved.flipped()
    expected = surface.evaluate(uv) @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(moved.evaluate(uv), expected, rtol=0, atol=1e-12)


@FEW
@given(surfaces(), st.integers(0, 2**32 - 1))
def test_refinement_leaves_the_surface(surface, seed):
    rng = np.random.default_rng(seed)
    uv = rng.random((20, 2))
    expected = surface.evaluate(uv)
    u, v = rng.random(3), rng.random(2)
    for other in (
        surface.insert_knots(u=u, v=v),
        surface.elevate(u=1, v=2),
        surface.k_refined((1, 1), u, v),
        surface.flipped().flipped(),
    ):
        np.testing.assert_allclose(other.evaluate(uv), expected, rtol=0, atol=1e-12)


@FEW
@given(surfaces(), st.floats(0.01, 0.99))
def test_parts_of_a_split_have_the_area_of_the_whole(surface, at):
    for axis in "uv":
        parts = surface.split(**{axis: at})
        # Where normals vanish four boxes may agree with one by chance: errors reach 40 tolerances.
        area = sum(part.area(1e-8) for part in parts)
        assert area == pytest.approx(surface.area(1e-8), rel=1e-6)


@FEW
@given(surfaces())
def test_normals_are_unit_vectors_across_both_tangents(surface):
    uv = np.random.default_rng(0).random((30, 2))
    normals, D = surface.normal(uv), surface.derivatives(uv, 1)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-14)
    for tangent in (D[:, 1, 0], D[:, 0, 1]):
        size = np.linalg.norm(tangent, axis=1)
        sine = np.linalg.norm(np.cross(D[:, 1, 0], D[:, 0, 1]), axis=1)
        steep = np.linalg.norm(D[:, 1, 0], axis=1) * np.linalg.norm(D[:, 0, 1], axis=1)
        allowed = 1e-12 * np.maximum(1.0, steep / np.maximum(sine, 1e-300))
        assert (np.abs((normals * tangent).sum(axis=1)) <= allowed * size).all()


@FEW
@given(curves(), st.floats(0.05, 0.95))
def test_length_adds_up_and_survives_reversal(curve, at):
    whole = curve.length(1e-7)
    assert curve.reversed().length(1e-7) == pytest.approx(whole, rel=1e-6)
    assert sum(part.length(1e-7) for part in curve.split(at)) == pytest.approx(whole, rel=1e-6)
