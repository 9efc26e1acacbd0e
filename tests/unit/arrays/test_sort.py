"""Sorting in kernels and counting in what is sorted, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from contiga.arrays.kernels import sort_nb

pytestmark = pytest.mark.interpreted

numbers = st.floats(allow_nan=False) | st.sampled_from([0.0, 1.0, 2.0, -1.0])


@njit
def sort(values):
    sort_nb.sort(values)


@njit
def sort_by(keys, column, rows):
    sort_nb.sort_by(keys, column, rows, rows.copy())


@njit
def count_below(values, x):
    return sort_nb.count_below(values, x)


@njit
def count_up_to(values, x):
    return sort_nb.count_up_to(values, x)


@given(st.lists(numbers, max_size=80))
def test_numbers_ascend(values):
    found = np.array(values, float)
    sort(found)
    np.testing.assert_array_equal(found, np.sort(np.array(values, float)))


@given(st.lists(numbers, min_size=1, max_size=80), st.integers(0, 2), st.randoms())
def test_rows_ascend_by_a_column_and_equals_stay_as_they_were(values, column, random):
    keys = np.full((len(values), 3), np.nan)
    keys[:, column] = values
    rows = np.array(random.sample(range(len(values)), len(values)), np.int32)
    expected = rows[np.argsort(keys[rows, column], kind="stable")]
    sort_by(keys, column, rows)
    np.testing.assert_array_equal(rows, expected)


def test_thousands_of_numbers_with_equals_among_them_ascend():
    values = np.random.default_rng(3).normal(size=3000)
    values[::3] = values[0]
    expected = np.sort(values)
    sort(values)
    np.testing.assert_array_equal(values, expected)


@given(st.lists(numbers, max_size=80), numbers)
def test_of_ascending_numbers_those_below_another_are_counted(values, x):
    ascending = np.sort(np.array(values, float))
    for other in (x, *values[:3]):
        assert count_below(ascending, other) == np.searchsorted(ascending, other)
        assert count_up_to(ascending, other) == np.searchsorted(ascending, other, side="right")
