"""The closest feet that do not face away from a guard, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.records import FacingLimits, Projection, SurfacePlaces, empty_projection
from contiga.statuses import Feature, Status

UP, LEAST = np.array([0.0, 0.0, 1.0]), float(np.cos(np.radians(160.0)))


def facing(
    master: cg.Body | cg.TriMesh,
    points: np.ndarray,
    guard: np.ndarray,
    least: float = LEAST,
    about: np.ndarray | None = None,
) -> Projection:
    """Looked for from the closest points of `about`, or from nowhere."""
    out = empty_projection(len(points))
    starts = SurfacePlaces(np.full(len(points), -1, np.int32), np.zeros((len(points), 2)))
    if about is not None:
        starts = SurfacePlaces(*master.project(about)[:2])
    limits = FacingLimits(least, np.zeros(len(points)), np.full(len(points), np.inf))
    guards = np.tile(np.asarray(guard, dtype=float), (len(points), 1))
    master.surface.closest_facing(np.asarray(points, dtype=float), guards, limits, starts, out)
    return out


@pytest.mark.parametrize("kind", ["patches", "triangles"])
def test_the_underside_of_a_plate_is_left_out(kind: str) -> None:
    plate: cg.Body | cg.TriMesh = box((0.0, 0.0, 0.0), (10.0, 10.0, 1.0))
    plate = plate if kind == "patches" else plate.tessellate(0.1)
    rng = np.random.default_rng(1)
    points = rng.uniform([0.01, 0.01, 0.01], [9.99, 9.99, 0.99], (300, 3))
    feet = facing(plate, points, UP)
    walls = np.column_stack([points[:, :2], 10.0 - points[:, :2], 1.0 - points[:, 2]])
    normals = np.array([[-1, 0, 0], [0, -1, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    np.testing.assert_allclose(-feet.gap, walls.min(axis=1), rtol=0, atol=1e-12)
    np.testing.assert_allclose(feet.normal, normals[walls.argmin(axis=1)], rtol=0, atol=1e-9)
    assert (feet.certified == 1).all()
    assert (feet.feature == Feature.FACE).all()


def test_of_a_ball_only_what_the_point_sees_from_behind_holds_it() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    # The one minimum of each: towards it, in the cone but for the last.
    towards = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.5, 0.0, -np.sqrt(0.75)], [0, 0, -1]])
    feet = facing(ball, 0.7 * towards, UP, about=0.9 * towards)
    assert feet.status.tolist() == [Status.OK] * 3 + [Status.MAX_ITERATIONS]
    np.testing.assert_allclose(feet.gap[:3], -1.3, rtol=0, atol=1e-9)
    np.testing.assert_allclose(feet.normal[:3], towards[:3], rtol=0, atol=1e-5)


def test_what_a_point_stands_before_does_not_hold_it() -> None:
    # Two plates, one over the other: the lower one's upper side is nearer, and seen from the front.
    patches = [*box((0, 0, 0), (9, 9, 1)).patches, *box((0, 0, 1.2), (9, 9, 2.2)).patches]
    feet = facing(cg.Body(patches), np.array([[4.5, 4.5, 1.3]]), UP)
    assert feet.gap[0] == pytest.approx(-0.9)


def test_an_inner_edge_holds_with_the_way_to_it_for_a_normal() -> None:
    corners = np.array([[0, 0], [4, 0], [4, 4], [2, 4], [2, 2], [0, 2], [0, 0]], dtype=float)
    outline = cg.NurbsCurve(1, [0, *range(7), 6], np.column_stack([corners, np.zeros(7)]))
    point = np.array([[2.6, 1.4, 0.0]])
    feet = facing(cg.Body.from_profile(outline), point, [-1.0, 1.0, 0.0])
    np.testing.assert_allclose(feet.point[0], [2.0, 2.0, 0.0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(feet.normal[0], np.array([-1, 1, 0]) / np.sqrt(2), rtol=0, atol=1e-9)
    assert feet.gap[0] == pytest.approx(-0.6 * np.sqrt(2))


@pytest.mark.parametrize("kind", ["patches", "triangles"])
def test_an_edge_that_is_a_minimum_of_one_of_its_faces_alone_does_not_hold(kind: str) -> None:
    """Above a tube, beside the edge of its side: on the top the foot goes on."""
    walls = box((0.0, 0.0, 0.0), (2.0, 1.4, 0.8)).patches
    tube = [wall for wall in walls if np.ptp(wall.control_points[..., 0]) > 0.0]
    master: cg.Body | cg.TriMesh = cg.Body(tube)
    master = master if kind == "patches" else master.tessellate(0.1)
    point = np.array([[0.8, 0.35, 0.8035]])
    feet = facing(master, point, [0.0, 0.0, -1.0])
    np.testing.assert_allclose(feet.gap, [-0.8035], rtol=0, atol=1e-12)
    np.testing.assert_allclose(feet.normal, [[0, 0, -1]], rtol=0, atol=1e-12)
    limits = FacingLimits(LEAST, np.zeros(1), np.full(1, 0.7))
    out, nowhere = empty_projection(1), SurfacePlaces(np.full(1, -1, np.int32), np.zeros((1, 2)))
    master.surface.closest_facing(point, np.array([[0.0, 0.0, -1.0]]), limits, nowhere, out)
    assert out.status.tolist() == [Status.MAX_ITERATIONS]


def test_without_a_guard_they_are_the_closest_points_of_points_inside() -> None:
    torus = cg.Body([cg.shapes.torus(major=2.0, minor=0.8)])
    rng = np.random.default_rng(5)
    points = rng.uniform([-2.8, -2.8, -0.8], [2.8, 2.8, 0.8], (4000, 3))
    points = points[torus.contains(points)][:300]
    feet, truth = facing(torus, points, UP, -1.5), torus.project(points)
    np.testing.assert_allclose(feet.gap, truth.gap, rtol=0, atol=1e-9)


def test_beside_a_pole_the_foot_is_found_from_where_it_was() -> None:
    disc = cg.Body([cg.shapes.ellipsoid(axes=(5.0, 5.0, 0.5))])
    x = np.array([0.0, 1e-6, 1e-3, 0.1])
    points = np.column_stack([x, np.zeros(4), np.full(4, -0.2)])
    feet = facing(disc, points, UP, about=points + np.array([0.0, 0.0, 0.4]))
    np.testing.assert_allclose(feet.gap, -0.7, rtol=0, atol=2e-4)
    assert (feet.normal[:, 2] > 0.999).all()


def test_what_is_no_number_is_marked() -> None:
    feet = facing(box((0, 0, 0), (1, 1, 1)), np.array([[np.nan, 0, 0], [0.5, 0.5, 0.9]]), UP)
    assert feet.status.tolist() == [Status.NOT_FINITE, Status.OK]


def test_no_place_of_a_border_is_a_foot() -> None:
    # A square whose border is a loop: one point nearer than the floor, one beside the border.
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float)
    loop = tuple(cg.NurbsCurve(1, [0, 0, 1, 1], corners[k : k + 2]) for k in range(4))
    knots, net = [-2.0, -2.0, 2.0, 2.0], np.array([[[x, y, 0.0] for y in (-2, 2)] for x in (-2, 2)])
    plate = cg.Body([cg.NurbsSurface((1, 1), (knots, knots), net)], trims=[[loop]])
    points = np.array([[0.2, 0.1, -0.3], [1.4, 0.1, -0.3]])
    out = empty_projection(2)
    starts = SurfacePlaces(np.full(2, -1, np.int32), np.zeros((2, 2)))
    limits = FacingLimits(LEAST, np.full(2, 0.4), np.full(2, np.inf))
    plate.surface.closest_facing(points, np.tile(UP, (2, 1)), limits, starts, out)
    assert out.status.tolist() == [Status.MAX_ITERATIONS] * 2


@pytest.mark.parametrize("angle", [80.0, 170.0])
def test_of_a_point_on_the_axis_of_a_gutter_the_turn_that_is_allowed_is_found(angle: float) -> None:
    line = cg.shapes.line([1.0, 0.0, 0.0], [1.0, 0.0, 3.0])
    gutter = cg.Body([cg.shapes.revolved(line, np.radians(angle))])
    middle = np.radians(0.5 * angle)
    guard = -np.array([np.cos(middle), np.sin(middle), 0.0])
    way = np.linspace(0.0, 2.0 * np.pi, 24)
    about = 1e-13 * np.column_stack([np.cos(way), np.sin(way), np.zeros(24)])
    feet = facing(gutter, about + np.linspace(0.5, 2.5, 24)[:, None] * UP, guard)
    assert feet.status.tolist() == [Status.OK] * 24
    np.testing.assert_allclose(feet.gap, -1.0, rtol=0, atol=1e-9)
    assert (feet.normal @ guard >= LEAST).all()
