"""Sides of triangles: the same as sorting them gives."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.triangles.kernels.mesh_sides_nb import side_numbers


def reference(triangles, n):
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    key = (ends[..., 0].astype(np.int64) * n + ends[..., 1]).ravel()
    _, place, times = np.unique(key, return_inverse=True, return_counts=True)
    return place.reshape(-1, 3), times


@pytest.mark.parametrize("n", [3, 5, 40, 3000, 2**31 - 1])
def test_sides_are_one_where_their_ends_are(n):
    triangles = np.random.default_rng(n).integers(max(0, n - 3000), n, (5000, 3)).astype(np.int32)
    numbers, times = side_numbers(triangles, n)
    place, expected = reference(triangles, n)
    np.testing.assert_array_equal(times[numbers], expected[place])
    pairs = np.unique(np.stack([numbers.ravel(), place.ravel()], axis=1), axis=0)
    assert len(pairs) == len(times) == len(expected)  # one to one
    first = np.unique(numbers.ravel(), return_index=True)[1]
    assert (np.diff(first) > 0).all()  # as they come


def test_a_fan_of_many_triangles_takes_no_longer_than_others():
    k = np.arange(1, 200_001)
    fan = np.stack([np.zeros_like(k), k, k + 1], axis=1)
    numbers, times = side_numbers(fan, len(k) + 2)
    assert len(times) == 2 * len(k) + 1
    assert (times == 2).sum() == len(k) - 1
    assert numbers.max() == len(times) - 1


def test_no_triangles_have_no_sides():
    numbers, times = side_numbers(np.empty((0, 3), np.int32), 0)
    assert numbers.shape == (0, 3)
    assert len(times) == 0
