"""Rows of tables that are written in kernels."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.arrays.kernels import rows_nb

pytestmark = pytest.mark.interpreted


@njit
def put(rows, k, values):
    rows_nb.put(rows, k, values)


@njit
def double_rows(rows):
    return rows_nb.double_rows(rows)


@pytest.mark.parametrize("kind", [float, np.int64, np.int32])
def test_a_tuple_becomes_one_row_and_no_other(kind):
    rows = np.zeros((4, 3), kind)
    put(rows, 2, (5, 6, 7))
    np.testing.assert_array_equal(rows, [[0, 0, 0], [0, 0, 0], [5, 6, 7], [0, 0, 0]])


def test_a_shorter_tuple_leaves_the_rest_of_its_row():
    rows = np.ones((2, 4))
    put(rows, 0, (0.25, -3.0))
    np.testing.assert_array_equal(rows, [[0.25, -3.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]])


@pytest.mark.parametrize("m", [1, 7])
def test_a_table_grows_and_keeps_its_rows(m):
    rows = np.random.default_rng(3).normal(size=(m, 5))
    grown = double_rows(rows)
    assert grown.shape == (2 * m, 5)
    np.testing.assert_array_equal(grown[:m], rows)
    grown[:] = 0.0
    assert np.all(rows != 0.0)
