"""Near points are found by cells as they are by a tree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from contiga.arrays import near_pairs as module
from contiga.arrays.near_pairs import near_pairs


def by_tree(points, reach):
    pairs = np.sort(cKDTree(points).query_pairs(reach, output_type="ndarray"), axis=1)
    return np.unique(pairs, axis=0).reshape(-1, 2)


@pytest.mark.parametrize("reach", [1e-7, 0.03, 0.2, 5.0])
@pytest.mark.parametrize("offset", [0.0, -1e3])
def test_pairs_are_those_of_a_tree(reach, offset):
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (300, 3)) + offset
    twins = points[:50] + rng.uniform(-0.9, 0.9, (50, 3)) * reach
    points = np.concatenate([points, points[:20], twins])
    np.testing.assert_array_equal(near_pairs(points, reach), by_tree(points, reach))


def test_points_in_a_plane_and_on_a_line_are_paired():
    grid = np.stack(np.meshgrid(np.arange(9.0), np.arange(9.0), [0.0]), axis=-1).reshape(-1, 3)
    np.testing.assert_array_equal(near_pairs(grid, 1.1), by_tree(grid, 1.1))
    line = np.zeros((40, 3))
    line[:, 2] = np.arange(40.0)
    np.testing.assert_array_equal(near_pairs(line, 2.5), by_tree(line, 2.5))


def test_cells_that_share_a_number_are_told_apart(monkeypatch):
    monkeypatch.setattr(module, "_cell_keys", lambda cell: np.zeros(len(cell), np.uint64))
    points = np.random.default_rng(1).uniform(size=(40, 3))
    np.testing.assert_array_equal(near_pairs(points, 0.2), by_tree(points, 0.2))


@pytest.mark.parametrize("n", [0, 1])
def test_fewer_than_two_points_have_no_pairs(n):
    assert near_pairs(np.zeros((n, 3)), 1.0).shape == (0, 2)
