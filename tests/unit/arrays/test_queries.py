"""Rays, distances with a sign and tracked feet, of exact bodies and of triangles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.errors import InputError

BALL = cg.Body([cg.shapes.sphere(radius=2.0)])


def rays(n: int = 500) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.uniform(-3.0, 3.0, (n, 3)), rng.normal(size=(n, 3))


def through_ball(origins: np.ndarray, directions: np.ndarray, radius: float) -> np.ndarray:
    """Distances to a sphere about the origin by the quadratic, NaN where it is missed."""
    units = directions / np.linalg.norm(directions, axis=1)[:, None]
    along = (origins * units).sum(axis=1)
    with np.errstate(invalid="ignore"):
        half = np.sqrt(along**2 - (origins**2).sum(axis=1) + radius**2)
        near, far = -along - half, -along + half
        return np.where(near > 0.0, near, np.where(far > 0.0, far, np.nan))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("length", [1e-200, 1.0, 1e200])
def test_rays_hit_a_ball_where_the_quadratic_says(scale: float, length: float) -> None:
    origins, directions = rays()
    body = cg.Body([cg.shapes.sphere(radius=2.0 * scale)])
    hit = body.ray(scale * origins, length * directions)
    wanted = through_ball(origins, directions, 2.0)
    assert 20 < np.isnan(wanted).sum() < 480
    np.testing.assert_allclose(hit.distance / scale, wanted, rtol=0, atol=1e-13)
    found = hit.status == cg.Status.OK
    np.testing.assert_array_equal(found, ~np.isnan(wanted))
    np.testing.assert_array_equal(hit.patch[~found], -1)
    for name in ("uv", "point", "normal"):
        assert np.isnan(getattr(hit, name)[~found]).all()
    at = body.patches[0].evaluate(hit.uv[found])
    np.testing.assert_allclose(hit.point[found], at, rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(hit.normal[found], at / (2.0 * scale), rtol=0, atol=1e-13)


def test_rays_from_a_million_sizes_away_lose_no_more_than_their_origins_do() -> None:
    origins, directions = rays()
    units = directions / np.linalg.norm(directions, axis=1)[:, None]
    hit = BALL.ray(origins - 4e6 * units, units)
    wanted = through_ball(origins - 10.0 * units, units, 2.0)
    np.testing.assert_allclose(hit.distance - 4e6 + 10.0, wanted, rtol=0, atol=1e-7)


def test_rays_hit_triangles_and_the_solid_that_they_are_of_alike() -> None:
    solid = box((-1.0, -0.5, -2.0), (1.0, 0.5, 2.0)).rotated((1, 2, 3), 0.4)
    mesh = solid.tessellate(0.1)
    origins, directions = rays()
    exact, faceted = solid.ray(origins, directions), mesh.ray(origins, directions)
    assert 30 < (exact.status == cg.Status.OK).sum() < 470
    np.testing.assert_array_equal(faceted.status, exact.status)
    for name in ("distance", "point", "normal"):
        a, b = getattr(faceted, name), getattr(exact, name)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


def test_an_open_shell_is_hit_from_either_side() -> None:
    sheet = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    origins = [[0.1, 0.2, 3.0], [0.1, 0.2, -3.0], [5.0, 0.0, 1.0]]
    hit = sheet.ray(origins, [[0.0, 0.0, -1.0], [0.0, 0.0, 2.0], [0.0, 0.0, -1.0]])
    np.testing.assert_array_equal(hit.distance, [3.0, 3.0, np.nan])
    np.testing.assert_array_equal(hit.normal[:2], [[0.0, 0.0, 1.0]] * 2)


def test_one_origin_or_one_direction_serves_all_and_no_rays_are_no_hits() -> None:
    to = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(BALL.ray([0.0, 0.0, 1.0], to).distance, [3.0, 1.0], atol=1e-14)
    np.testing.assert_allclose(BALL.ray([[0, 0, 3.0], [0, 0, 5.0]], to[0]).distance, [1.0, 3.0])
    assert len(BALL.ray(np.zeros((0, 3)), np.zeros((0, 3))).status) == 0


def test_a_ray_from_nowhere_hits_nothing() -> None:
    hit = BALL.ray([[math.nan, 0.0, 0.0], [math.inf, 0.0, 0.0], [0.0, 0.0, 0.0]], [1.0, 0.0, 0.0])
    assert [cg.Status(s).name for s in hit.status] == ["NO_HIT", "NO_HIT", "OK"]


@pytest.mark.parametrize(
    ("directions", "told"),
    [
        ([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], r"directions\[1\]: a direction must be finite"),
        ([[1.0, 0.0, 0.0], [0.0, math.inf, 0.0]], r"directions\[1\]: a direction must be finite"),
        (np.ones((3, 3)), r"directions: a ray has an origin and a direction; found \(3, 3\)"),
        ([1.0, 2.0], "directions must have shape"),
    ],
)
def test_wrong_rays_are_refused(directions: object, told: str) -> None:
    with pytest.raises(InputError, match=told):
        BALL.ray([[0.0, 0.0, 5.0]] * 2, directions)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["exact", "triangles"])
def test_a_distance_has_the_sign_of_its_side_and_tracked_feet_go_on(kind: str) -> None:
    master = BALL if kind == "exact" else BALL.tessellate(1e-4)
    points = np.array([[0.0, 3.0, 0.0], [0.0, 0.0, 1.5], [math.nan, 0.0, 0.0]])
    found = master.signed_distance(points)
    np.testing.assert_allclose(found, [1.0, -0.5, math.nan], rtol=0, atol=2e-4)
    start = master.project(points[:2])
    feet = master.track(points[:2] + 0.01, start)
    again = master.project(points[:2] + 0.01, start=start, mode="track")
    for a, b in zip(feet, again, strict=True):
        np.testing.assert_array_equal(a, b)
