"""The nearest point is the one that brute force finds; past a border of a sheet distance counts."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.masters.nearness import gaps_and_feet, nearest, smallest_gap

PLATE = cg.Body(cg.shapes.plane(width=10.0, length=10.0))
BALL = cg.Body(cg.shapes.sphere(radius=2.0))
RNG = np.random.default_rng(7)


def rows(points: np.ndarray) -> np.ndarray:
    return np.arange(len(points), dtype=np.int32)


@pytest.mark.parametrize(
    ("point", "gap"),
    [
        ([0.0, 0.0, 0.5], 0.5),
        ([1.0, 2.0, -0.5], -0.5),
        ([1.0, 2.0, -3.0], 3.0),  # deeper than asked about
        ([8.0, 0.0, -4.0], 5.0),  # beyond the border, behind the plane
        ([8.0, 9.0, 0.0], 5.0),
        ([8.0, 0.0, 4.0], 5.0),
    ],
)
def test_gaps_of_a_plate(point: list[float], gap: float) -> None:
    found, _ = gaps_and_feet(PLATE.surface, np.array([point]), 1.0)
    assert found[0] == pytest.approx(gap, abs=1e-12)


def plate_gaps(p: np.ndarray, depth: float) -> np.ndarray:
    """Closed form."""
    past = np.maximum(np.abs(p[:, :2]) - 5.0, 0.0)
    away = np.sqrt(np.square(past).sum(axis=1) + p[:, 2] ** 2)
    behind = (past == 0.0).all(axis=1) & (p[:, 2] < 0.0) & (away <= depth)
    return np.where(behind, -away, away)


def ball_gaps(p: np.ndarray) -> np.ndarray:
    return np.sqrt(np.square(p).sum(axis=1)) - 2.0


@pytest.mark.parametrize("low", [-20.0, -0.9, 0.3])
@pytest.mark.parametrize("depth", [0.2, 1.0, np.inf])
def test_the_nearest_to_a_plate_is_that_of_the_closed_form(low: float, depth: float) -> None:
    points = RNG.uniform([-30, -30, low], [30, 30, 20], (3_000, 3))
    gaps = plate_gaps(points, depth)
    feet = nearest(PLATE.surface, points, rows(points), depth=depth)
    assert feet.row == gaps.argmin()
    assert feet.gap == pytest.approx(gaps.min(), abs=1e-10)
    assert (feet.bounds <= gaps + 1e-12).all()


@pytest.mark.parametrize("low", [-9.0, 0.5, 2.5])
def test_the_nearest_to_a_ball_is_the_deepest_one_inside(low: float) -> None:
    points = RNG.uniform([-9, -9, low], [9, 9, 9], (3_000, 3))
    signed, plain = ball_gaps(points), np.abs(ball_gaps(points))
    for depth, gaps in ((np.inf, signed), (None, plain)):
        feet = nearest(BALL.surface, points, rows(points), depth=depth)
        assert (feet.row, feet.gap) == (gaps.argmin(), pytest.approx(gaps.min(), abs=1e-10))


def test_only_the_rows_asked_for_count() -> None:
    points = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 3.0], [0.0, 0.0, 2.0]])
    feet = nearest(PLATE.surface, points, np.array([1, 2], np.int32))
    assert (feet.row, feet.gap) == (2, pytest.approx(2.0))


def test_of_many_that_are_about_as_near_few_are_worked_out() -> None:
    asked: list[int] = []

    def gaps(rows: np.ndarray) -> np.ndarray:
        asked.extend(rows.tolist())
        return 1.0005 + 1e-4 * np.sin(rows)

    gap, _ = smallest_gap(np.ones(1000), gaps, 1e-3)
    assert len(asked) < 100
    assert gap <= 1.001 * (1.0005 - 1e-4)
    asked.clear()
    gap, row = smallest_gap(np.ones(1000), gaps)
    assert len(asked) == 1000
    assert row == np.sin(np.arange(1000)).argmin()
