"""Sums in one order: to the bit those of NumPy, of few numbers and of many."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.contact.kernels import sums_nb

pytestmark = pytest.mark.interpreted


@njit
def summed(values, n):
    return sums_nb.sum_of(values, n)


def numbers(n: int) -> np.ndarray:
    """Numbers of many sizes and both signs, so that another order gives other bits."""
    rng = np.random.default_rng(n)
    return rng.normal(size=n) * 10.0 ** rng.integers(-8, 8, n)


@pytest.mark.parametrize("n", [*range(140), 255, 256, 257, 300, 1000, 1025, 4099, 12_345])
def test_the_bits_are_those_of_numpy(n: int) -> None:
    values = numbers(n)
    assert summed(values, n) == values.sum()


def test_of_products_of_vectors_too() -> None:
    force, way = numbers(3 * 700).reshape(700, 3), numbers(3 * 701)[3:].reshape(700, 3)
    assert summed((force * way).reshape(-1), 2100) == (force * way).sum()


def test_only_the_first_are_summed_and_nothing_is_zero() -> None:
    assert summed(np.array([1.0, 2.0, np.nan]), 2) == 3.0
    assert not np.signbit(summed(np.array([-0.0, 1.0]), 1))
    assert np.isnan(summed(np.array([1.0, 2.0, np.nan]), 3))
