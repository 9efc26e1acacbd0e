"""What a cell says of its points holds, wherever the body is and however it is bent."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sample import FULL

import contiga as cg
from contiga.search.sides import side_grid
from contiga.search.sides.side_grid import sides_of
from contiga.search.tables import tables_of

SETTINGS = settings(max_examples=25 if FULL else 10, deadline=None, derandomize=True)
N = 1500


def _ring(rng: np.random.Generator) -> list[cg.NurbsSurface]:
    return [cg.shapes.torus(major=1.0, minor=rng.uniform(0.05, 0.9))]


def _ball(_: np.random.Generator) -> list[cg.NurbsSurface]:
    return [cg.shapes.sphere()]


def _box(_: np.random.Generator) -> list[cg.NurbsSurface]:
    return [cg.shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3), *-np.eye(3))]


def _bent(faces: list[cg.NurbsSurface], rng: np.random.Generator, offset: float) -> cg.Body:
    """Turned, stretched up to tenfold, moved away."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix = np.eye(4)
    matrix[:3, :3] = turn @ np.diag(10.0 ** rng.uniform(-1.0, 0.0, 3)) @ turn.T
    matrix[:3, 3] = offset * rng.normal(size=3)
    return cg.Body([face.transformed(matrix) for face in faces])


@SETTINGS
@given(st.integers(0, 2**31 - 1), st.sampled_from([_ring, _ball, _box]), st.floats(-3.0, 5.0))
def test_a_side_told_is_the_side_and_a_reach_no_more_than_the_distance(
    seed: int, faces: object, log_offset: float
) -> None:
    rng = np.random.default_rng(seed)
    body = _bent(faces(rng), rng, 10.0**log_offset)  # type: ignore[operator]
    low, high = body.bounds()
    points = rng.uniform(low - 0.2 * body.size, high + 0.2 * body.size, (N, 3))
    feet = body.project(points)
    away = feet.gap + body.size * 10.0 ** rng.uniform(-6.0, -1.0, N) * rng.choice([-1.0, 1.0], N)
    points = np.concatenate([points, points + (away - feet.gap)[:, None] * feet.normal])
    surface = body.surface
    grid = sides_of(tables_of(body), surface.slit)  # type: ignore[union-attr]
    rows = np.arange(len(points), dtype=np.int32)
    side, reach = side_grid.side_of(grid, points, rows)
    gap = body.project(points).gap
    told = side != 0
    np.testing.assert_array_equal(side[told], np.sign(gap[told]))
    assert (reach[told] > 0.0).all()
    assert (reach[told] <= np.abs(gap[told]) + 1e-10 * body.size).all()
    assert told.mean() > 0.5
    start, end = points[:N], points[N:]
    clear = side_grid.clear_paths(grid, start, end, rows[:N])
    assert (side[:N] == side[N:])[clear & told[:N] & told[N:]].all()
    _, sense = surface.last_crossings(start, end, rows[:N])
    assert not (clear & (sense != 0)).any()
