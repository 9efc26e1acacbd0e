"""The filter of two poles against that of scipy, bit by bit."""

from __future__ import annotations

import platform

import numpy as np
import pytest

from contiga.criteria.filters import CLASSES, coefficients
from contiga.criteria.kernels.two_poles_nb import forward_and_back

pytestmark = pytest.mark.interpreted


def one_way(values: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """scipy's filter, settled on the first value."""
    from scipy.signal import lfilter

    return lfilter(a, [1.0, -b[0], -b[1]], values - values[:1], axis=0) + values[:1]


@pytest.mark.parametrize("cls", CLASSES)
@pytest.mark.parametrize("dt", [1e-4, 3.3e-5, 1e-6])
@pytest.mark.parametrize("n", [1, 2, 3, 4, 101, 700])
@pytest.mark.parametrize("columns", [1, 3])
def test_it_has_the_bits_of_scipy(cls: int, dt: float, n: int, columns: int) -> None:
    a, b = coefficients(cls, dt)
    values = 1e3 + np.random.default_rng(n).normal(size=(n, columns)).cumsum(axis=0)
    theirs = one_way(one_way(values, a, b)[::-1], a, b)[::-1]
    forward_and_back(values, a, b)
    if platform.machine().lower() in ("x86_64", "amd64"):
        assert values.tobytes() == theirs.tobytes()
    assert values == pytest.approx(theirs, rel=1e-12)  # elsewhere scipy may be compiled to fuse
