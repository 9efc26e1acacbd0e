"""Crossings with a surface that moves meanwhile: none missed, none false."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.geometry.test_net import bent, brick

import contiga as cg
from contiga.records import empty_projection
from contiga.search.deformable import Deformable, DeformedSurface, deformable_of
from contiga.statuses import Status

BODIES = {
    "ball": lambda: cg.Body([cg.shapes.sphere(radius=1.0)]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]),
    "box": brick,
}


def are_inside(surface: DeformedSurface, points: np.ndarray) -> np.ndarray:
    feet = empty_projection(len(points))
    surface.closest(points, np.arange(len(points), dtype=np.int32), feet)
    return feet.gap < 0.0


def paths(body: cg.Body, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Ways of any length, from near the body."""
    rng = np.random.default_rng(seed)
    low, high = body.bounds()
    a = rng.uniform(low - 0.1, high + 0.1, (n, 3))
    return a, a + rng.standard_normal((n, 3)) * 10.0 ** rng.uniform(-4.0, 0.0, (n, 1))


def shapes_of(body: cg.Body, by: float) -> tuple[Deformable, np.ndarray, np.ndarray]:
    """Control points before and after a step that bends them by so much."""
    before = bent(body, 3, 0.01)
    return deformable_of(body), before, before + bent(body, 4, by) - body.net.points


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("by", [1e-9, 1e-4, 0.01])
def test_the_last_crossing_is_in_where_a_path_ends_inside(name: str, by: float) -> None:
    body = BODIES[name]()
    deformable, before, now = shapes_of(body, by)
    first, last = deformable.at(before), deformable.at(now)
    a, b = paths(body, 1500, 1)
    began, ended = are_inside(first, a), are_inside(last, b)
    hits, sense = last.last_crossings_from(first, a, b)
    assert (hits.status != Status.BUDGET).all()
    wanted = np.where(ended, 1, -1)
    np.testing.assert_array_equal(sense[began != ended], wanted[began != ended])
    both = (began == ended) & (sense != 0)  # in and out again, or out and in
    np.testing.assert_array_equal(sense[both], wanted[both])
    assert (began != ended).sum() > 80


@pytest.mark.parametrize("name", BODIES)
def test_a_crossing_lies_on_the_path_and_on_the_shape_of_its_time(name: str) -> None:
    body = BODIES[name]()
    deformable, before, now = shapes_of(body, 0.01)
    a, b = paths(body, 400, 2)
    hits, sense = deformable.at(now).last_crossings_from(deformable.at(before), a, b)
    rows = np.flatnonzero(sense)
    assert len(rows) > 20
    for k in rows:
        at, patch = hits.fraction[k], body.patches[hits.patch[k]]
        rows_of_patch = body.net.control[hits.patch[k]]
        for net, point in (
            ((1.0 - at) * before + at * now, a[k] + at * (b[k] - a[k])),
            (now, hits.point[k]),
        ):
            shape = cg.NurbsSurface(patch.degrees, patch.knots, net[rows_of_patch], patch.weights)
            np.testing.assert_allclose(shape.evaluate(hits.uv[k])[0], point, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", BODIES)
def test_with_a_surface_that_stays_they_are_those_of_paths_alone(name: str) -> None:
    body = BODIES[name]()
    surface = deformable_of(body).at(bent(body, 3, 0.01))
    a, b = paths(body, 800, 3)
    hits, sense = surface.last_crossings_from(surface, a, b)
    alone, own = surface.last_crossings(a, b, np.arange(len(a), dtype=np.int32))
    np.testing.assert_array_equal(sense, own)
    np.testing.assert_allclose(hits.fraction, alone.fraction, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", BODIES)
def test_a_surface_that_flies_far_is_crossed_by_what_flies_with_it(name: str) -> None:
    body = BODIES[name]()
    deformable, before, now = shapes_of(body, 0.01)
    a, b = paths(body, 800, 5)
    fly = np.array([30.0, -20.0, 10.0])
    hits, sense = deformable.at(now).last_crossings_from(deformable.at(before), a, b)
    there, own = deformable.at(now + fly).last_crossings_from(deformable.at(before), a, b + fly)
    assert (sense != 0).sum() > 40
    np.testing.assert_array_equal(own, sense)
    np.testing.assert_allclose(there.fraction, hits.fraction, rtol=0, atol=1e-9)
    crossed = sense != 0
    np.testing.assert_allclose(there.point[crossed], (hits.point + fly)[crossed], atol=1e-9)


def test_a_surface_that_comes_over_a_point_at_rest_is_crossed() -> None:
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    deformable, rest = deformable_of(body), body.net.points
    still = np.array([[0.3, 0.2, 0.5], [0.3, 0.2, 1.5], [3.0, 0.0, 0.5]])
    up = deformable.at(rest + np.array([0.0, 0.0, 1.0]))
    hits, sense = up.last_crossings_from(deformable.at(rest), still, still)
    assert sense.tolist() == [1, 0, 0]  # its front comes to the first alone
    np.testing.assert_allclose(hits.fraction[0], 0.5, rtol=0, atol=1e-12)
    _, back = deformable.at(rest).last_crossings_from(up, still, still)
    assert back.tolist() == [-1, 0, 0]


def test_a_plate_that_tips_crosses_the_points_at_rest_that_it_sweeps_over() -> None:
    """Its middle stands, and it stays flat: only what its displacement differs tells of them."""
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    deformable, rest = deformable_of(body), body.net.points
    tipped = rest + np.outer(0.5 * rest[:, 0], [0.0, 0.0, 1.0])
    rng = np.random.default_rng(6)
    still = rng.uniform([-0.99, -0.99, -0.6], [0.99, 0.99, 0.6], (500, 3))
    hits, sense = deformable.at(tipped).last_crossings_from(deformable.at(rest), still, still)
    x, _, z = still.T
    passed = (z / x > 0.0) & (z / x < 0.5)
    np.testing.assert_array_equal(sense, np.where(passed, np.sign(z), 0.0))
    np.testing.assert_allclose(hits.fraction[passed], (2.0 * z / x)[passed], rtol=0, atol=1e-9)


def test_a_path_that_is_not_finite_is_said_to_be() -> None:
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    surface = deformable_of(body).at(body.net.points)
    path = np.array([[np.nan, 0.0, 0.0]])
    hits, sense = surface.last_crossings_from(surface, path, path)
    assert hits.status.tolist() == [Status.NOT_FINITE]
    assert sense.tolist() == [0]
