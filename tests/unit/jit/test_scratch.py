"""Small arrays on the stack of the kernel that works in them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import config
from numba.core.errors import TypingError

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64, zero_scratch

compiled = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


@inner()
def _norm(x, depth):
    """Euclidean norm, by an array of each call; of more and more calls at once where deep."""
    own = scratch(2, 3)
    for c in range(3):
        own[1, c] = x[c] * x[c]
    below = _norm(x, depth - 1) if depth > 0 else 0.0
    return np.sqrt(own[1, 0] + own[1, 1] + own[1, 2]) + below


@kernel()
def norms(x):
    return _norm(x, 0) + 10.0 * _norm(2.0 * x, 4)


@pytest.mark.interpreted
def test_arrays_of_calls_that_are_under_way_together_are_apart() -> None:
    x = np.array([2.0, 3.0, 6.0])
    assert norms(x) == 7.0 + 10.0 * 5 * 14.0


@kernel()
def counted(n):
    """Sum of what zeros hold that are asked for again and again, and written to."""
    total = 0.0
    for k in range(n):
        zeros = zero_scratch(3, 4)
        for i in range(3):
            for j in range(4):
                total += zeros[i, j]
                zeros[i, j] = k + 1.0
    return total


@pytest.mark.interpreted
def test_zeros_are_zeros_each_time() -> None:
    assert counted(50) == 0.0


@kernel()
def turned(values):
    """Whole numbers and their shape and order, by way of the stack."""
    own = stack_int64(2, 3)
    for i in range(2):
        for j in range(3):
            own[i, j] = values[i, j]
    other = own[1]
    for j in range(3):
        values[0, j] = other[2 - j]
        values[1, j] = own[0, j]
    return own.shape[0], own.shape[1], own.size


@pytest.mark.interpreted
def test_whole_numbers_keep_their_places() -> None:
    values = np.array([[1, 2, 2**62 + 1], [4, 5, -6]])
    assert turned(values) == (2, 3, 6)
    assert values.tolist() == [[-6, 5, 4], [1, 2, 2**62 + 1]]


@compiled
def test_shapes_are_written_out() -> None:
    @kernel()
    def unknown(n: int) -> float:
        return scratch(n)[0]

    with pytest.raises(TypingError):
        unknown(3)


@compiled
def test_an_array_of_the_stack_cannot_be_answered() -> None:
    @kernel()
    def plain() -> np.ndarray:
        return scratch(3)

    @kernel()
    def part(n: int) -> np.ndarray:
        own = zero_scratch(3, 3)
        row = own[n % 3]
        return row[1:]

    @kernel()
    def among(n: int) -> tuple[int, np.ndarray]:
        own = stack_int64(3)
        return n, own

    @kernel()
    def first_of_two(x: np.ndarray) -> np.ndarray:
        out = x
        if x[0] > 0.0:
            out = scratch(3)
        return out

    with pytest.raises(TypingError, match="an array of its stack"):
        plain()
    with pytest.raises(TypingError, match="an array of its stack"):
        part(1)
    with pytest.raises(TypingError, match="an array of its stack"):
        among(1)
    with pytest.raises(TypingError, match="an array of its stack"):
        first_of_two(np.ones(3))


@compiled
def test_numbers_and_new_arrays_that_were_worked_out_there_can() -> None:
    @kernel()
    def first(x: np.ndarray) -> tuple[float, np.ndarray]:
        own = scratch(3)
        for c in range(3):
            own[c] = 2.0 * x[c]
        return own[1], own.copy()

    one, twice = first(np.array([1.0, 2.0, 3.0]))
    assert one == 4.0
    assert twice.tolist() == [2.0, 4.0, 6.0]
