"""Which points a closed mesh holds."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import TriMesh


def test_points_inside_a_torus_are_told_from_its_closed_form():
    torus = cg.shapes.torus(major=2.0, minor=0.5).tessellate(1e-3)
    points = np.random.default_rng(0).uniform([-3, -3, -1], [3, 3, 1], (4000, 3))
    way = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 2.0, points[:, 2]) - 0.5
    clear = np.abs(way) > 2e-3
    np.testing.assert_array_equal(torus.contains(points)[clear], (way < 0.0)[clear])
    np.testing.assert_array_equal(torus.flipped().contains(points)[clear], (way > 0.0)[clear])


@pytest.mark.interpreted
def test_a_box_holds_its_inside_and_its_sides(oracle):
    box = oracle.box()
    points = [[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0.5], [0.6, 0, 0], [np.nan, 0, 0]]
    assert box.contains(points).tolist() == [True, True, True, False, False]


def test_beside_an_open_sheet_is_behind_nothing():
    sheet = TriMesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]])
    points = [[1, 1, -0.1], [1, 1, 0.1], [3, 1, -0.1]]
    assert sheet.contains(points).tolist() == [True, False, False]
