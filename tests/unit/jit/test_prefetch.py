"""Rows are asked for ahead: that changes nothing, and may be asked of what is not there."""

from __future__ import annotations

import numpy as np
import pytest
from numba import config, njit

from contiga.jit.prefetch import LINE, prefetch


@njit
def sum_of(rows, order):
    total = 0.0
    for i in range(order.shape[0]):
        prefetch(rows, order[i] - 5, 0)
        prefetch(rows, order[i] + 10**6, LINE)
        total += rows[order[i], 0]
    return total


@pytest.mark.interpreted
def test_a_sum_over_rows_that_are_asked_for_ahead_is_their_sum():
    rows = np.arange(30.0).reshape(10, 3)
    assert sum_of(rows, np.arange(10)[::-1]) == rows[:, 0].sum()


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_it_is_an_instruction_for_each():
    sum_of(np.zeros((1, 3)), np.zeros(1, int))
    code = "".join(sum_of.inspect_llvm().values())
    assert code.count("call void @llvm.prefetch") >= 2
