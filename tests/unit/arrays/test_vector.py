"""Vectors of three numbers, as tuples."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.arrays.kernels import vector_nb

pytestmark = pytest.mark.interpreted


@njit
def vectors(a, b, h):
    return (
        vector_nb.dot(a, b),
        vector_nb.minus(a, b),
        vector_nb.cross(a, b),
        vector_nb.column(h, 2),
    )


def test_products_and_differences_are_those_of_numpy():
    rng = np.random.default_rng(0)
    for a, b in rng.integers(-9, 9, (20, 2, 3)).astype(float):
        h = rng.random((3, 4))
        dot, minus, cross, column = vectors(tuple(a), tuple(b), h)
        assert dot == a @ b
        assert minus == tuple(a - b)
        assert cross == tuple(np.cross(a, b))
        assert column == tuple(h[:, 2])
