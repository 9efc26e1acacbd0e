"""The camera holds what it is pointed at."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.rendering.camera import look, project, unit


@pytest.mark.parametrize("towards", [[1, 0, 0], [0.3, -0.8, -0.4], [0, 0, -1], [0, 0, 1]])
@pytest.mark.parametrize("size", [(200, 300), (300, 200)])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_all_points_are_in_the_picture_and_fill_it(
    towards: list[float], size: tuple[int, int], scale: float
) -> None:
    points = scale * (np.random.default_rng(3).normal(size=(200, 3)) * [3, 1, 2] + [50, 7, -9])
    camera = look(np.array(towards, float), np.array([0.0, 0.0, 1.0]), points, size)
    column, row, depth = project(camera, points).T
    assert (depth > 0.0).all()
    for pixels, count in ((column, size[1]), (row, size[0])):
        assert pixels.min() >= 0.0
        assert pixels.max() <= count - 1
    filled = max(np.ptp(column) / size[1], np.ptp(row) / size[0])
    assert filled > 0.6


def test_up_is_up_and_right_is_right() -> None:
    points = np.array([[0.0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0]])
    camera = look(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), points, (100, 100))
    screen = project(camera, points)
    assert screen[0, 1] < screen[1, 1]
    assert screen[2, 0] > screen[3, 0]


def test_nearer_things_look_larger_by_the_ratio_of_their_depths() -> None:
    points = np.array([[0.0, -2, 0], [1, -2, 0], [0, 2, 0], [1, 2, 0]])
    camera = look(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), points, (100, 100))
    column, _, depth = project(camera, points).T
    near, far = column[1] - column[0], column[3] - column[2]
    assert near / far == pytest.approx(depth[2] / depth[0], rel=1e-12)


def test_one_point_can_be_looked_at() -> None:
    camera = look(np.array([1.0, 0, 0]), np.array([0.0, 0, 1]), np.zeros((1, 3)), (10, 10))
    np.testing.assert_allclose(project(camera, np.zeros((1, 3)))[0, :2], 4.5)


def test_unit_of_nothing_is_nothing() -> None:
    assert unit(np.zeros(3)).tolist() == [0.0, 0.0, 0.0]
