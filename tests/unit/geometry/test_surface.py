"""Surfaces: values, derivatives, normals, moves."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from contiga import NurbsSurface, shapes
from contiga.errors import GeometryError, InputError

UV = np.random.default_rng(5).random((40, 2))
GRID = np.stack(np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9)), -1).reshape(-1, 2)


def random_surface(p: int, q: int, *, rational: bool = True, spans: int = 3) -> NurbsSurface:
    rng = np.random.default_rng(100 * p + q)
    U, V = (
        np.concatenate([np.zeros(d + 1), np.sort(rng.random(spans - 1)), np.ones(d + 1)])
        for d in (p, q)
    )
    shape = (p + spans, q + spans)
    points = rng.normal(size=(*shape, 3))
    return NurbsSurface((p, q), (U, V), points, rng.uniform(0.3, 3, shape) if rational else None)


@pytest.mark.interpreted
def test_biquadratic_saddle_has_its_closed_form():
    """z = h (ξ² − η²) with ξ = 2u − 1, η = 2v − 1."""
    surface = shapes.saddle(width=3.0, length=2.0, height=0.7)
    u, v = UV.T
    D = surface.derivatives(UV, order=3)
    xi, eta = 2 * u - 1, 2 * v - 1
    value = np.column_stack([1.5 * xi, eta, 0.7 * (xi**2 - eta**2)])
    np.testing.assert_allclose(D[:, 0, 0], value, rtol=0, atol=1e-14)
    np.testing.assert_allclose(D[:, 1, 0, 2], 0.7 * 4 * xi, rtol=0, atol=1e-13)
    np.testing.assert_allclose(D[:, 0, 1, 2], -0.7 * 4 * eta, rtol=0, atol=1e-13)
    np.testing.assert_allclose(D[:, 2, 0, 2], 0.7 * 8, rtol=0, atol=1e-12)
    np.testing.assert_allclose(D[:, 1, 1], 0.0, rtol=0, atol=1e-13)
    assert not D[:, 3].any()
    assert not D[:, :, 3].any()


@pytest.mark.parametrize(("p", "q"), [(1, 1), (2, 3), (5, 2), (9, 12), (15, 15)])
@pytest.mark.parametrize("rational", [False, True])
def test_each_derivative_is_the_slope_of_the_one_below(p, q, rational):
    """Fourth-order central differences of entry [a, b] give [a + 1, b] and [a, b + 1]."""
    surface = random_surface(p, q, rational=rational)
    uv = UV[:12] * 0.9 + 0.05
    # one span only: derivatives jump at knots
    (U, V), h = surface.knots, 1e-4
    near = [
        np.abs(np.subtract.outer(uv[:, i], K)).min(axis=1) > 3 * h for i, K in enumerate((U, V))
    ]
    uv = uv[near[0] & near[1]]
    D = surface.derivatives(uv, order=3)
    for axis in (0, 1):
        step = np.eye(2)[axis] * h
        at = {k: surface.derivatives(uv + k * step, order=2) for k in (-2, -1, 1, 2)}
        slope = (at[-2] - 8 * at[-1] + 8 * at[1] - at[2]) / (12 * h)
        exact = D[:, 1:, :3] if axis == 0 else D[:, :3, 1:]
        scale = np.abs(exact).max(axis=(0, 3), keepdims=True) + np.abs(at[1]).max()
        assert (np.abs(slope - exact) <= 2e-6 * scale).all()


@pytest.mark.parametrize("order", [0, 1, 2, 4, 6])
def test_orders_agree_with_each_other(order):
    surface = random_surface(3, 4)
    whole = surface.derivatives(UV, order=6)
    part = surface.derivatives(UV, order=order)
    np.testing.assert_array_equal(part, whole[:, : order + 1, : order + 1])


def test_many_points_give_the_same_bits_as_few():
    surface = random_surface(3, 3)
    uv = np.random.default_rng(0).random((9000, 2))
    many = surface.derivatives(uv, order=1)
    few = np.concatenate([surface.derivatives(part, order=1) for part in np.array_split(uv, 9)])
    np.testing.assert_array_equal(many, few)
    normals = np.concatenate([surface.normal(part) for part in np.array_split(uv, 9)])
    np.testing.assert_array_equal(surface.normal(uv), normals)


@pytest.mark.interpreted
@pytest.mark.parametrize("axis", ["x", "z", (1.0, 2.0, -3.0)])
def test_sphere_normal_is_radial_at_the_poles_and_next_to_them(axis):
    centre = np.array([10.0, -20.0, 30.0])
    surface = shapes.sphere(radius=2.0, centre=centre, axis=axis)
    near = [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3]
    v = np.array(near + [1.0 - t for t in near])
    uv = np.stack(np.meshgrid([0.0, 0.1, 0.25, 0.9, 1.0], v), -1).reshape(-1, 2)
    expected = (surface.evaluate(uv) - centre) / 2.0
    np.testing.assert_allclose(surface.normal(uv), expected, rtol=0, atol=1e-7)


def test_cone_apex_has_the_normal_of_its_generator():
    surface = shapes.cone(radius=1.0, height=1.0)
    u = np.linspace(0.0, 1.0, 9)
    apex = surface.normal(np.column_stack([u, np.ones(9)]))
    below = surface.normal(np.column_stack([u, np.full(9, 0.3)]))
    np.testing.assert_allclose(apex, below, rtol=0, atol=1e-14)


def test_corner_with_parallel_tangents_has_a_normal():
    """A disc as one square patch: at its corners S_u and S_v are parallel."""
    a = math.sqrt(0.5)
    points = [[[-a, -a, 0], [-2 * a, 0, 0], [-a, a, 0]], [[0, -2 * a, 0], [0, 0, 0], [0, 2 * a, 0]]]
    points.append([[a, -a, 0], [2 * a, 0, 0], [a, a, 0]])
    weights = [[1, a, 1], [a, 1, a], [1, a, 1]]
    knots = [0, 0, 0, 1, 1, 1]
    disc = NurbsSurface((2, 2), (knots, knots), points, weights)
    np.testing.assert_allclose(disc.normal(GRID), [[0.0, 0.0, 1.0]] * len(GRID), rtol=0, atol=1e-12)
    assert disc.area() == pytest.approx(math.pi, rel=1e-10)


def test_patch_with_one_side_collapsed_by_rounding_only_has_its_limit_normal():
    rng = np.random.default_rng(3)
    turned = shapes.sphere(radius=1.0).rotated((1, 1, 2), 0.9).translated((3.0, 5.0, 7.0))
    net = turned.control_points + rng.uniform(-1, 1, turned.control_points.shape) * 1e-15
    surface = NurbsSurface(turned.degrees, turned.knots, net, turned.weights)
    uv = np.column_stack([np.linspace(0, 1, 33), np.zeros(33)])
    expected = surface.evaluate(uv) - [3.0, 5.0, 7.0]
    np.testing.assert_allclose(surface.normal(uv), expected, rtol=0, atol=1e-7)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-1e-5, 1e-5), (1e5, 1e5 + 3.0), (0.0, 1e7)])
def test_knot_range_and_size_do_not_matter(scale, low, high):
    surface = random_surface(3, 2)
    knots = tuple(low + (high - low) * k for k in surface.knots)
    other = NurbsSurface(surface.degrees, knots, scale * surface.control_points, surface.weights)
    uv = low + (high - low) * UV
    np.testing.assert_allclose(other.evaluate(uv) / scale, surface.evaluate(UV), rtol=0, atol=1e-8)
    np.testing.assert_allclose(other.normal(uv), surface.normal(UV), rtol=0, atol=1e-7)


def test_flipped_swaps_the_normal_and_keeps_the_domain():
    surface = random_surface(2, 3)
    other = surface.flipped()
    assert other.domain == surface.domain
    mirrored = UV * [-1, 1] + [1, 0]
    np.testing.assert_allclose(other.evaluate(mirrored), surface.evaluate(UV), rtol=0, atol=1e-13)
    np.testing.assert_allclose(other.normal(mirrored), -surface.normal(UV), rtol=0, atol=1e-9)


def test_reflection_keeps_the_free_side():
    """A sphere stays a sphere with its normals outward."""
    matrix = np.diag([1.0, 1.0, -1.0, 1.0])
    mirrored = shapes.sphere().transformed(matrix)
    np.testing.assert_allclose(mirrored.normal(UV), mirrored.evaluate(UV), rtol=0, atol=1e-13)


def test_transposed_exchanges_u_and_v():
    surface = random_surface(2, 4)
    other = surface.transposed()
    np.testing.assert_allclose(
        other.evaluate(UV[:, ::-1]), surface.evaluate(UV), rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(other.normal(UV[:, ::-1]), -surface.normal(UV), rtol=0, atol=1e-12)


@pytest.mark.parametrize("u", [0.0, 0.3, 1.0])
def test_isocurve_lies_on_the_surface(u):
    surface = random_surface(3, 2)
    t = np.linspace(0, 1, 17)
    along_v = surface.isocurve(u=u).evaluate(t)
    np.testing.assert_allclose(
        along_v, surface.evaluate(np.column_stack([u + 0 * t, t])), rtol=0, atol=1e-13
    )
    along_u = surface.isocurve(v=u).evaluate(t)
    np.testing.assert_allclose(
        along_u, surface.evaluate(np.column_stack([t, u + 0 * t])), rtol=0, atol=1e-13
    )


def test_one_of_u_and_v_must_be_given():
    surface = shapes.plane()
    for arguments in ({}, {"u": 0.5, "v": 0.5}):
        with pytest.raises(GeometryError, match="either u or v"):
            surface.isocurve(**arguments)
    with pytest.raises(GeometryError, match="inside the domain"):
        surface.split(u=1.0)


@pytest.mark.parametrize("bad", [[[0.5, 1.1]], [[np.nan, 0.5]], [[-1e-6, 0.5]]])
def test_parameters_outside_are_one_clear_error(bad):
    for ask in (shapes.plane().evaluate, shapes.plane().normal):
        with pytest.raises(InputError, match=r"row 0 of [uv] is outside the domain"):
            ask(bad)


def test_no_points_give_no_rows():
    surface = shapes.sphere()
    assert surface.evaluate(np.zeros((0, 2))).shape == (0, 3)
    assert surface.normal(np.zeros((0, 2))).shape == (0, 3)


def test_a_copy_through_pickle_has_the_same_bits_and_cannot_be_written_to():
    for surface in (shapes.sphere(radius=0.3), shapes.saddle()):
        again = pickle.loads(pickle.dumps(surface, protocol=5))
        assert again.homogeneous.tobytes() == surface.homogeneous.tobytes()
        assert again.is_rational == surface.is_rational
        assert not again.control_points.flags.writeable
    for curve in (shapes.circle(radius=0.3), shapes.line((0, 0, 0), (1, 2, 3))):
        again = pickle.loads(pickle.dumps(curve, protocol=5))
        assert again.homogeneous.tobytes() == curve.homogeneous.tobytes()
        assert not again.control_points.flags.writeable
