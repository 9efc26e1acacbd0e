"""The fused multiply-add is rounded once, compiled or not."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from numba import njit

from contiga.arrays.kernels.fma_nb import exact_fma, fma

BIG, TINY = 1.7e308, 5e-324
SPECIAL = [0.0, -0.0, 1.0, -1.0, BIG, -BIG, TINY, -TINY, 1.5e-162, math.inf, -math.inf, math.nan]


@njit
def _fma(x, y, z, out):
    for k in range(x.shape[0]):
        out[k] = fma(x[k], y[k], z[k])


def triples():
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(2, 4000)) * 10.0 ** rng.integers(-30, 30, (2, 4000))
    z = -x * y * (1.0 + rng.integers(-2, 3, 4000) * 2.0**-52)
    return x, y, z


def same(a, b):
    return (math.isnan(a) and math.isnan(b)) or (
        a == b and math.copysign(1, a) == math.copysign(1, b)
    )


@pytest.mark.interpreted
def test_a_product_and_a_sum_are_rounded_once():
    x, y, z = (v[:300] for v in triples())
    out = np.empty(300)
    _fma(x, y, z, out)
    for k in range(300):
        assert out[k] == float(Fraction(x[k]) * Fraction(y[k]) + Fraction(z[k]))
    assert (out != x * y + z).mean() > 0.5


def test_with_and_without_the_instruction_the_value_is_the_same():
    x, y, z = triples()
    out = np.empty(len(x))
    _fma(x, y, z, out)
    assert out.tolist() == [exact_fma(*t) for t in zip(x, y, z, strict=True)]


def test_zeros_infinities_and_numbers_that_run_over_are_as_the_standard_says():
    x, y, z = (v.ravel() for v in np.meshgrid(SPECIAL, SPECIAL, SPECIAL, indexing="ij"))
    out = np.empty(len(x))
    _fma(x, y, z, out)
    for row in zip(x, y, z, out, strict=True):
        assert same(exact_fma(*row[:3]), row[3]), row
