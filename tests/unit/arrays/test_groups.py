"""Groups of things that pairs join."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.groups import groups_of


@pytest.mark.parametrize("pairs", [0, 3, 30, 300])
def test_groups_are_those_of_a_flood_numbered_as_they_come(pairs: int) -> None:
    n = 60
    first, second = np.random.default_rng(pairs).integers(0, n, (2, pairs))
    label = np.full(n, -1)
    for start in range(n):
        if label[start] < 0:
            number, wait = label.max() + 1, [start]
            while wait:
                k = wait.pop()
                if label[k] < 0:
                    label[k] = number
                    wait += [*second[first == k], *first[second == k]]
    np.testing.assert_array_equal(groups_of(first, second, n), label)


def test_nothing_has_no_groups() -> None:
    assert groups_of(np.zeros(0, int), np.zeros(0, int), 0).tolist() == []
