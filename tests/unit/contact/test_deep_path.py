"""Ways of points: on exact geometry a kernel goes along them, elsewhere the surface is asked; both
find the same."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.contact import deep_paths
from contiga.contact.deep_paths import DeepPaths, WallStates
from contiga.contact.foot_rows import closest
from contiga.contact.kernels import deep_path_nb
from contiga.contact.search_records import Options

N = 400


def gone(body: cg.Body, kernels: bool) -> DeepPaths:
    """Ways within a body, or behind a sheet, that begin at its walls and lead anywhere."""
    rng = np.random.default_rng(8)
    low, high = body.bounds()
    feet = body.project(rng.uniform(low, high, (N, 3)))
    start = feet.point - 1e-3 * feet.normal
    end = start + rng.normal(scale=0.3, size=(N, 3))
    if body.closed:
        inside = body.contains(start) & body.contains(end)
        feet, start, end = cg.Projection._make(f[inside] for f in feet), start[inside], end[inside]
    n, surface = len(start), body.surface
    options = Options(False, False, False, True, np.inf, body.closed, 1.0, 1e-12, kernels)
    begin = WallStates(feet.normal, np.full(n, 1e-3), np.zeros(n, np.bool_), feet.patch, feet.uv)
    nearest = closest(surface, end, np.arange(n, dtype=np.int32))
    return deep_paths.follow_paths(surface, (start, end), begin, nearest, options)


def block() -> cg.Body:
    return box((-1.0, -1.0, -0.3), (1.0, 1.0, 0.3))


BODIES = {
    "box": block,
    "box without a wall": lambda: cg.Body(block().patches[:5]),
    "sheets": lambda: cg.Body(
        [cg.shapes.plane(), cg.shapes.plane().transformed(cg.motion.pose.translation([0, 0, -0.2]))]
    ),
    "egg": lambda: cg.Body([cg.shapes.sphere(radius=1.0).scaled([1.0, 0.8, 0.5])]),
}


@pytest.mark.parametrize("name", BODIES)
def test_the_kernel_finds_what_the_surface_answers(name: str) -> None:
    body = BODIES[name]()
    one, other = gone(body, True), gone(body, False)
    assert len(one.rows) > 50
    np.testing.assert_array_equal(one.outcome, other.outcome)
    np.testing.assert_array_equal(one.is_opposed, other.is_opposed)
    pushed = one.outcome <= deep_path_nb.RESTARTED
    assert pushed.sum() > 20
    np.testing.assert_allclose(one.feet.gap[pushed], other.feet.gap[pushed], rtol=0, atol=1e-12)
    assert body.closed or (one.outcome > deep_path_nb.RESTARTED).sum() > 20


def test_a_way_within_a_plate_ends_at_the_wall_that_it_began_at() -> None:
    plate = box((-9.0, -9.0, -0.5), (9.0, 9.0, 0.5))
    end = np.array([[0.0, 0.0, -0.4], [0.0, 0.0, 0.4], [8.95, 0.0, -0.4]])
    start, n = np.array([[0.0, 0.0, 0.5]]).repeat(3, axis=0), 3
    up = np.array([[0.0, 0.0, 1.0]]).repeat(3, axis=0)
    nearest = closest(plate.surface, end, np.arange(n, dtype=np.int32))
    begin = WallStates(up, np.zeros(n), np.zeros(n, np.bool_), np.full(n, -1), np.zeros((n, 2)))
    options = Options(False, False, False, True, np.inf, True, 1.0, 1e-12)
    found = deep_paths.follow_paths(plate.surface, (start, end), begin, nearest, options)
    assert found.is_opposed.tolist() == [True, False, False]
    np.testing.assert_allclose(found.feet.gap, [-0.9, -0.1, -0.05], rtol=0, atol=1e-12)
