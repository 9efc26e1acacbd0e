"""Blocks of numbers are moved as they would be one by one."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numba import config, njit

from contiga.jit.block import bits_of, reload_numbers, turn
from contiga.jit.scratch import scratch


@njit
def turned(source, rows, to, columns):
    turn(source, rows, to, columns)


@njit
def sums(table, m):
    own = scratch(8)
    total = 0.0
    for k in range(m):
        reload_numbers(table, own, 8)
        for i in range(8):
            total += own[i]
        table[0] = k
    return total


@njit
def bits(x):
    return bits_of(x)


@pytest.mark.interpreted
def test_rows_become_columns_wherever_both_lie():
    source, to = np.arange(40.0).reshape(5, 8), np.full((6, 9), -1.0)
    turned(source, (8, 32, 0, 17), to, (2, 11, 29, 38))
    expected = np.full((6, 9), -1.0)
    block = source.ravel()[np.add.outer([8, 32, 0, 17], range(4))]
    for c, first in enumerate((2, 11, 29, 38)):
        expected.ravel()[first : first + 4] = block[:, c]
    np.testing.assert_array_equal(to, expected)


@pytest.mark.interpreted
def test_of_columns_in_the_same_place_the_first_stays():
    source, to = np.arange(16.0).reshape(4, 4), np.zeros((3, 4))
    turned(source, (0, 4, 8, 12), to, (0, 4, 4, 4))
    np.testing.assert_array_equal(to, [[0, 4, 8, 12], [1, 5, 9, 13], [0, 0, 0, 0]])


@pytest.mark.interpreted
def test_records_are_numbers_one_after_the_other():
    records = np.zeros(4, [("a", "f8", 3), ("b", "i1", 8)])
    records["a"] = np.arange(12.0).reshape(4, 3)
    records["b"] = [0, 1, 0, 0, 0, 0, 0, 0]
    to = np.zeros((4, 4))
    turned(records, (0, 4, 8, 12), to, (0, 4, 8, 12))
    np.testing.assert_array_equal(to[:3], records["a"].T)
    assert [bits(x) for x in to[3]] == [1 << 8] * 4


@pytest.mark.interpreted
def test_a_table_that_changes_is_read_as_it_is():
    assert sums(np.ones(8), 3) == 8.0 + 7.0 + 8.0


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_four_rows_are_four_vectors():
    turned(np.zeros((4, 4)), (0, 4, 8, 12), np.zeros((4, 4)), (0, 4, 8, 12))
    (code, *_) = turned.inspect_llvm().values()
    assert len(re.findall(r"load <4 x double>", code)) >= 4
    assert len(re.findall(r"store <4 x double>", code)) >= 4
