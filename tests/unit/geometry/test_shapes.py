"""Shapes are exact: every point obeys its equation to rounding, normals point outward."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga import NurbsCurve, shapes
from contiga.errors import GeometryError

UV = np.random.default_rng(0).random((3000, 2))
T = np.linspace(0.0, 1.0, 1001)
PI = math.pi


@pytest.mark.interpreted
@pytest.mark.parametrize("radius", [1e-6, 1.0, 3.7, 1e6])
def test_circle_is_exact_to_rounding(radius):
    points = shapes.circle(radius=radius).evaluate(T)
    assert np.abs(np.hypot(points[:, 0], points[:, 1]) / radius - 1.0).max() < 1e-14
    assert not points[:, 2].any()


@pytest.mark.parametrize(
    ("start", "end"), [(0, 0.1), (0, PI / 2), (0.3, 2.9), (-1, 2 * PI - 1), (1, 5)]
)
def test_arc_runs_from_angle_to_angle(start, end):
    curve = shapes.arc(radius=2.0, start=start, end=end)
    points = curve.evaluate(T)
    assert np.abs(np.hypot(points[:, 0], points[:, 1]) / 2.0 - 1.0).max() < 1e-14
    ends = 2.0 * np.array([[math.cos(a), math.sin(a), 0.0] for a in (start, end)])
    np.testing.assert_allclose(points[[0, -1]], ends, rtol=0, atol=1e-14)
    turned = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert (np.diff(turned) > 0.0).all()
    assert curve.length() == pytest.approx(2.0 * (end - start), rel=1e-12)


def test_ellipse_obeys_its_equation():
    points = shapes.ellipse(axes=(3.0, 2.0)).evaluate(T)
    assert np.abs((points[:, 0] / 3) ** 2 + (points[:, 1] / 2) ** 2 - 1.0).max() < 1e-14


@pytest.mark.interpreted
def test_sphere_is_exact_and_outward():
    surface = shapes.sphere(radius=2.5)
    points = surface.evaluate(UV)
    assert np.abs(np.linalg.norm(points, axis=1) / 2.5 - 1.0).max() < 1e-14
    np.testing.assert_allclose(surface.normal(UV), points / 2.5, rtol=0, atol=1e-13)


def test_ellipsoid_is_exact_and_outward():
    surface = shapes.ellipsoid(axes=(3.0, 2.0, 0.5))
    points = surface.evaluate(UV)
    assert np.abs(((points / [3.0, 2.0, 0.5]) ** 2).sum(axis=1) - 1.0).max() < 1e-14
    gradient = points / np.square([3.0, 2.0, 0.5])
    gradient /= np.linalg.norm(gradient, axis=1, keepdims=True)
    np.testing.assert_allclose(surface.normal(UV), gradient, rtol=0, atol=1e-12)


def test_torus_is_exact_and_outward():
    surface = shapes.torus(major=3.0, minor=0.7)
    points = surface.evaluate(UV)
    ring = points * [1, 1, 0] / np.hypot(points[:, 0], points[:, 1])[:, None] * 3.0
    away = points - ring
    assert np.abs(np.linalg.norm(away, axis=1) / 0.7 - 1.0).max() < 1e-14 * 3.7 / 0.7
    np.testing.assert_allclose(surface.normal(UV), away / 0.7, rtol=0, atol=1e-13)


def test_cylinder_is_exact_outward_and_centred():
    surface = shapes.cylinder(radius=2.0, height=5.0)
    points = surface.evaluate(UV)
    assert np.abs(np.hypot(points[:, 0], points[:, 1]) / 2.0 - 1.0).max() < 1e-14
    np.testing.assert_allclose(points[:, 2], 5.0 * (UV[:, 1] - 0.5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(surface.normal(UV), points * [0.5, 0.5, 0.0], rtol=0, atol=1e-13)


def test_cone_and_its_stump_are_exact_and_outward():
    for top in (0.0, 0.5):
        surface = shapes.cone(radius=2.0, height=3.0, top_radius=top)
        points = surface.evaluate(UV)
        radius = 2.0 + (top - 2.0) * points[:, 2] / 3.0
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), radius, rtol=0, atol=1e-14)
        assert (surface.normal(UV) * (points * [1, 1, 0])).sum(axis=1).min() >= 0.0


def test_disc_is_flat_round_and_faces_its_axis():
    surface = shapes.disc(radius=2.0)
    points = surface.evaluate(UV)
    np.testing.assert_allclose(
        np.hypot(points[:, 0], points[:, 1]), 2.0 * UV[:, 0], rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(surface.normal(UV), [[0.0, 0.0, 1.0]] * len(UV), rtol=0, atol=1e-13)
    np.testing.assert_allclose(surface.normal([[0.0, 0.4]]), [[0.0, 0.0, 1.0]], rtol=0, atol=1e-15)


def test_plane_spans_its_sizes():
    surface = shapes.plane(width=4.0, length=2.0, centre=(1.0, 2.0, 3.0))
    np.testing.assert_array_equal(surface.bounds(), [[-1, 1, 3], [3, 3, 3]])
    np.testing.assert_array_equal(surface.normal([[0.3, 0.7]]), [[0, 0, 1]])


def test_saddle_obeys_its_equation():
    points = shapes.saddle(width=2.0, length=4.0, height=0.3).evaluate(UV)
    expected = 0.3 * (points[:, 0] ** 2 - (points[:, 1] / 2.0) ** 2)
    np.testing.assert_allclose(points[:, 2], expected, rtol=0, atol=1e-14)


def test_bumpy_plate_is_close_to_its_sines():
    surface = shapes.bumpy_plate(width=2.0, length=3.0, amplitude=0.2, waves=(2, 3))
    points = surface.evaluate(UV)
    x, y = UV.T
    np.testing.assert_allclose(points[:, 0], 2.0 * (x - 0.5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(points[:, 1], 3.0 * (y - 0.5), rtol=0, atol=1e-14)
    height = 0.2 * np.sin(4 * PI * x) * np.sin(6 * PI * y)
    assert np.abs(points[:, 2] - height).max() < 0.003 * 0.2
    assert surface.normal(UV)[:, 2].min() > 0.0


def test_bilinear_meets_its_corners():
    corners = np.random.default_rng(0).normal(size=(4, 3))
    surface = shapes.bilinear(*corners)
    np.testing.assert_array_equal(surface.evaluate([[0, 0], [1, 0], [0, 1], [1, 1]]), corners)


def test_ruled_joins_curves_of_different_kind():
    low, high = shapes.circle(radius=2.0), shapes.line((2.0, 0.0, 1.0), (3.0, 0.0, 1.0))
    shifted = NurbsCurve(1, [5.0, 5.0, 9.0, 9.0], high.control_points)
    surface = shapes.ruled(low, shifted)
    ends = (
        surface.evaluate(np.column_stack([T, 0 * T])),
        surface.evaluate(np.column_stack([T, 1 + 0 * T])),
    )
    np.testing.assert_allclose(ends[0], low.evaluate(T), rtol=0, atol=1e-14)
    np.testing.assert_allclose(ends[1], high.evaluate(T), rtol=0, atol=1e-14)
    middle = surface.evaluate([[0.3, 0.5]])[0]
    assert np.linalg.norm(np.cross(ends[1][300] - ends[0][300], middle - ends[0][300])) < 1e-14


def test_extruded_moves_its_curve():
    curve = shapes.arc(radius=2.0)
    surface = shapes.extruded(curve, (0.0, 1.0, 3.0))
    points = surface.evaluate(UV)
    expected = curve.evaluate(UV[:, 0]) + UV[:, 1:] * [0.0, 1.0, 3.0]
    np.testing.assert_allclose(points, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("angle", [0.3, PI, 2 * PI])
def test_revolved_points_keep_height_and_distance(angle):
    rng = np.random.default_rng(1)
    curve = NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], rng.uniform(0.5, 2.0, (4, 3)))
    axis, origin = np.array([1.0, 2.0, 2.0]) / 3.0, np.array([5.0, 0.0, -1.0])
    surface = shapes.revolved(curve, angle, axis=axis, origin=origin)

    def measures(points):
        away = points - origin
        height = away @ axis
        return np.column_stack([height, np.linalg.norm(away - np.outer(height, axis), axis=1)])

    turned, start = surface.evaluate(UV), curve.evaluate(UV[:, 1])
    np.testing.assert_allclose(measures(turned), measures(start), rtol=0, atol=1e-13)
    end = surface.evaluate(np.column_stack([np.ones(9), T[::125]]))
    np.testing.assert_allclose(
        end, curve.rotated(axis, angle, origin).evaluate(T[::125]), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize("axis", ["x", "y", "z", (0, 0, -1), (1, 1, 1), (0.3, -2, -0.1)])
def test_centre_and_axis_place_a_shape(axis):
    k = shapes.transform.unit_axis(axis)
    surface = shapes.cylinder(radius=1.0, height=4.0, centre=(1, 2, 3), axis=axis)
    away = surface.evaluate(UV) - [1, 2, 3]
    along = away @ k
    np.testing.assert_allclose(along, 4.0 * (UV[:, 1] - 0.5), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        np.linalg.norm(away - np.outer(along, k), axis=1), 1.0, rtol=0, atol=1e-14
    )
    assert (surface.normal(UV) * (away - np.outer(along, k))).sum(axis=1).min() > 0.99


@pytest.mark.parametrize("surface", [shapes.sphere(), shapes.torus(), shapes.ellipsoid()])
def test_closed_shapes_enclose_their_volume_outward(surface):
    """Gauss: ∫ x·n dA / 3 > 0 and equal to the closed form."""
    mesh = surface.tessellate(1e-3)
    a, b, c = mesh.corners().transpose(1, 0, 2)
    volume = (a * np.cross(b, c)).sum() / 6.0
    exact = {(9, 5): 4 / 3 * PI, (9, 9): 2 * PI**2 * 2.0 * 0.25}[surface.control_points.shape[:2]]
    if surface.bounds()[1, 0] == 3.0:
        exact *= 6.0
    assert volume == pytest.approx(exact, rel=3e-3)


def test_seams_and_poles_close_exactly():
    v = np.linspace(0, 1, 33)
    for surface in (shapes.sphere(radius=1.3), shapes.torus(), shapes.cylinder(), shapes.cone()):
        first = surface.evaluate(np.column_stack([0 * v, v]))
        last = surface.evaluate(np.column_stack([1 + 0 * v, v]))
        np.testing.assert_array_equal(first, last)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: shapes.sphere(radius=-1.0), "radius: a size must be positive; found -1"),
        (lambda: shapes.sphere(radius=0), "radius"),
        (lambda: shapes.sphere(radius="big"), "radius"),
        (lambda: shapes.sphere(radius=math.nan), "radius"),
        (lambda: shapes.sphere(radius=10**400), "radius"),
        (lambda: shapes.extruded(5, (0, 0, 1)), "curve: must be a curve; found 'int'"),
        (lambda: shapes.ruled(shapes.circle(), None), "second: must be a curve"),
        (lambda: shapes.revolved([0, 1]), "curve: must be a curve; found 'list'"),
        (lambda: shapes.revolved(shapes.arc(radius=80.0)), "curve: sweeps no area"),
        (lambda: shapes.revolved(shapes.circle(radius=1e-9, axis="x"), axis="x"), "sweeps no area"),
        (lambda: shapes.revolved(shapes.line((0, 0, 1), (0, 0, 2))), "curve: sweeps no area"),
        (lambda: shapes.revolved(shapes.circle(), "turn"), "angle: must be a number"),
        (lambda: shapes.cylinder(height=0.0), "height"),
        (lambda: shapes.cylinder(angle=7.0), "angle"),
        (lambda: shapes.cone(top_radius=-0.1), "top_radius"),
        (lambda: shapes.ellipsoid(axes=(1.0, 2.0)), "axes"),
        (lambda: shapes.ellipsoid(axes=(1.0, 2.0, 0.0)), "axes"),
        (lambda: shapes.torus(major=1.0, minor=1.0), "minor"),
        (lambda: shapes.plane(width=-2.0), "width"),
        (lambda: shapes.bumpy_plate(waves=0), "waves"),
        (lambda: shapes.bumpy_plate(waves=10**9), "waves"),
        (lambda: shapes.bumpy_plate(waves=1.5), "waves"),
        (lambda: shapes.line((0, 0, 0), (0, 0, 0)), "two different points"),
        (lambda: shapes.arc(start=1.0, end=0.5), "from start to end"),
        (lambda: shapes.extruded(shapes.circle(), (0, 0, 0)), "direction"),
        (lambda: shapes.sphere(axis="w"), "not an axis"),
        (lambda: shapes.sphere(axis=(0, 0, 0)), "zero vector"),
        (lambda: shapes.sphere(centre=(0, 0)), "centre"),
    ],
)
def test_wrong_sizes_are_refused(make, message):
    with pytest.raises(GeometryError, match=message):
        make()
