"""Touching balls never hold a point of the surface, and say which points lie inside."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.unit.search.balls.radii_at import radii_at as radii

import contiga as cg
from contiga.search.balls import ball_cells
from contiga.search.balls import radii as ball
from contiga.statuses import Status

POINTS = 1_000_000 if FULL else 5_000
FEET = 1500 if FULL else 600


def box(x=1.0, y=1.0, z=1.0):
    half = 0.5 * np.array([x, y, z])
    faces = []
    for n in (*np.eye(3), *-np.eye(3)):
        face = cg.shapes.plane(centre=0.5 * n, axis=n)
        faces.append(face.scaled(2.0 * half))
    return cg.Body(faces)


def bumpy(surface, seed, size):
    """A closed body bent by waves: points of seams and poles move together."""
    rng = np.random.default_rng(seed)
    waves, shift = rng.normal(size=(3, 3)) * 2.0, rng.uniform(0.0, 6.0, 3)
    shares = np.array([0.11, 0.29, 0.37, 0.61, 0.83])
    dense = surface.insert_knots(*(a + (b - a) * shares for a, b in surface.domain))
    x = dense.control_points
    moved = x + size * np.sin(x @ waves.T + shift)
    return cg.Body([cg.NurbsSurface(dense.degrees, dense.knots, moved, dense.weights)])


def cubic(surface):
    p, q = surface.degrees
    return surface.elevate(3 - p, 3 - q)


SMOOTH = {
    "sphere": lambda: cg.Body([cg.shapes.sphere()]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=1.0, minor=0.3)]),
    "flat": lambda: cg.Body([cg.shapes.ellipsoid(axes=(1.0, 0.7, 0.3))]),
    "box": box,
    "slab": lambda: box(1.0, 1.0, 0.05),
}
BENT = {
    f"{name} {seed}": (lambda make=make, seed=seed, size=size: bumpy(make(), seed, size))
    for seed in range(10 if FULL else 3)
    for name, make, size in (
        ("bent sphere", lambda: cubic(cg.shapes.sphere()), 0.1),
        ("bent torus", lambda: cg.shapes.torus(major=1.0, minor=0.3), 0.06),
    )
}
BODIES = SMOOTH | BENT
FIRST = ("bent sphere 0", "bent torus 0")
OTHERS = [name for name in BENT if name not in FIRST]


def feet_on(body, n, seed=0):
    """Feet of random parameters of a body, inside its faces."""
    rng = np.random.default_rng(seed)
    patch = rng.integers(len(body.patches), size=n)
    point, normal = np.empty((n, 3)), np.empty((n, 3))
    uv = np.empty((n, 2))
    for k, surface in enumerate(body.patches):
        own = patch == k
        low, high = np.transpose(surface.domain)
        uv[own] = low + (high - low) * rng.uniform(1e-6, 1.0 - 1e-6, (int(own.sum()), 2))
        point[own], normal[own] = surface.evaluate(uv[own]), surface.normal(uv[own])
    return patch.astype(np.int32), uv, point, normal


@pytest.fixture(
    scope="module", params=[*SMOOTH, *FIRST, *full(*(name for name in BENT if name not in FIRST))]
)
def body(request):
    return BODIES[request.param]()


def test_no_ball_holds_a_point_of_the_surface(body):
    patch, uv, point, normal = feet_on(body, FEET)
    inner, outer = radii(body, patch, uv)
    x = feet_on(body, 6000, seed=1)[2]
    apart = x[None] - point[:, None]
    square = (apart**2).sum(axis=2)
    height = (apart * normal[:, None]).sum(axis=2)
    for radius, side in ((inner, -1.0), (outer, 1.0)):
        # |X − C|² ≥ ρ², C the middle of the ball
        margin = (square - 2.0 * radius[:, None] * side * height).min()
        assert margin >= -1e-12 * body.size**2


def test_points_in_inner_balls_are_inside_and_in_outer_balls_outside(body):
    patch, uv, point, normal = feet_on(body, POINTS, seed=2)
    share = np.random.default_rng(3).choice([1e-6, 0.3, 0.9, 1.0 - 1e-9], POINTS)
    for radius, side in zip(radii(body, patch, uv), (-1.0, 1.0), strict=True):
        known = radius > 1e-9 * body.size
        p = point + (side * 2.0 * radius * share)[:, None] * normal
        np.testing.assert_array_equal(body.contains(p[known]), side < 0.0)


def test_within_the_radius_the_foot_is_the_closest_point(body):
    patch, uv, point, normal = feet_on(body, 2000, seed=4)
    for radius, side in zip(radii(body, patch, uv), (-1.0, 1.0), strict=True):
        known = radius > 1e-9 * body.size
        gap = (side * radius)[known]
        feet = body.project(point[known] + gap[:, None] * normal[known])
        assert (feet.status == Status.OK).all()
        np.testing.assert_allclose(feet.gap, gap, atol=1e-12 * body.size)


def test_of_a_sphere_most_of_the_radius_is_proved_nearly_everywhere():
    body = SMOOTH["sphere"]()
    inner, outer = radii(body, *surface_feet(body))
    assert inner.max() <= 1.0
    assert np.median(inner) > 0.12
    assert (inner > 0.015).mean() > 0.97
    assert (outer > 0.015).mean() > 0.97


def surface_feet(body, n=4000, seed=5):
    """Feet spread evenly over a sphere."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(n, 3))
    feet = body.project(1.1 * p / np.linalg.norm(p, axis=1)[:, None])
    return feet.patch, feet.uv


def test_between_parallel_planes_the_ball_is_half_as_wide():
    body = SMOOTH["slab"]()
    x = np.array([[0.0, 0.0, 0.025], [0.2, -0.3, -0.025]])
    feet = body.project(x)
    inner, outer = radii(body, feet.patch, feet.uv)
    assert (inner <= 0.025).all()
    assert (inner > 0.0125).all()
    assert inner.max() > 0.024999
    np.testing.assert_allclose(outer, ball_cells.CAP * body.size, rtol=1e-6)


def test_on_a_box_the_inner_ball_falls_with_the_distance_to_the_edge():
    body = box()
    a = np.array([1e-6, 1e-4, 0.01, 0.1, 0.3])
    feet = body.project(np.column_stack([0.5 - a, 0.02 + 0.0 * a, 0.5 + 0.0 * a]))
    inner, outer = radii(body, feet.patch, feet.uv)
    assert (inner <= a).all()
    assert (inner >= 0.4 * a).all()
    assert (outer >= np.minimum(2.0 * a, 0.99 * ball_cells.CAP * body.size)).all()


def test_cells_along_edges_are_not_cut_until_the_budget_is_spent():
    """A bound that is zero at an edge is as steep as the ball: halves would prove no more."""
    assert len(ball.balls_of(box(2.0, 3.0, 4.0).surface.tables).child) < 1000
    can = cg.Body(
        [
            cg.shapes.cylinder(radius=2.0, height=3.0),
            cg.shapes.disc(radius=2.0, centre=(0.0, 0.0, 1.5)),
            cg.shapes.disc(radius=2.0, centre=(0.0, 0.0, -1.5), axis=(0.0, 0.0, -1.0)),
        ]
    )
    assert can.closed
    assert len(ball.balls_of(can.surface.tables).child) < 3000


def test_far_from_the_origin_the_balls_are_nearly_the_same():
    here = BENT["bent torus 0"]()
    there = here.translated((1e6, -2e6, 5e5))
    patch, uv, _, _ = feet_on(here, 500)
    for a, b in zip(radii(here, patch, uv), radii(there, patch, uv), strict=True):
        assert abs(np.median(a) - np.median(b)) < 0.2 * np.median(a)


def test_rows_without_a_foot_have_no_ball():
    inside, outside = radii(box(), np.full(2, -1, np.int32), np.zeros((2, 2)))
    assert not inside.any()
    assert not outside.any()


def test_balls_are_worked_out_once_and_only_when_asked_for():
    body = box()
    surface = body.surface
    body.project([[0.0, 0.0, 0.6]])
    assert ball.balls_if_they_pay(surface.tables, 0) is None
    radii(body, np.zeros(1, np.int32), np.full((1, 2), 0.5))
    assert ball.balls_of(surface.tables) is ball.balls_if_they_pay(surface.tables, 0)
