"""Points in an order along space."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.triangles.kernels import order_nb

pytestmark = pytest.mark.interpreted


def test_all_rows_come_back_and_neighbours_are_near():
    points = np.random.default_rng(0).random((2000, 3))
    rows = np.arange(2000, dtype=np.int32)
    actual = order_nb.along_space(points, rows, np.zeros(3), 1.0)
    assert sorted(actual.tolist()) == rows.tolist()
    step = np.linalg.norm(np.diff(points[actual], axis=0), axis=1).mean()
    assert step < 0.3 * np.linalg.norm(np.diff(points, axis=0), axis=1).mean()


def test_the_eight_corners_come_in_the_order_of_their_code():
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    shuffled = np.array([5, 2, 7, 0, 3, 6, 1, 4], np.int32)
    actual = order_nb.along_space(corners, shuffled, np.zeros(3), 1.0)
    assert actual.tolist() == list(range(8))


def test_rows_that_are_not_finite_come_first():
    points = np.array([[0.9, 0.9, 0.9], [np.nan, 0.0, 0.0], [0.5, 0.5, 0.5]])
    rows = np.arange(3, dtype=np.int32)
    assert order_nb.along_space(points, rows, np.zeros(3), 1.0)[0] == 1
