"""Hysteresis in kernels: the same as that of the contact laws."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.laws.characteristic import Characteristic
from contiga.laws.hysteresis import Hysteresis
from contiga.matter.kernels import hysteresis_nb
from contiga.matter.woven import _both_curves

LOADING = np.array([[0.0, 0.0], [0.1, 2.0], [0.5, 3.0], [1.0, 9.0]])
UNLOADING = np.array([[0.0, 0.0], [0.3, 0.2], [0.5, 1.0], [1.0, 6.0]])


@njit
def moved(numbers: np.ndarray, n: int, x: np.ndarray, out: np.ndarray) -> None:
    x_old, force = 0.0, 0.0
    for k in range(len(x)):
        force, stored, lost = hysteresis_nb.hysteretic(numbers, 0, n, x[k], (x_old, force))
        x_old = x[k]
        out[k, 0], out[k, 1], out[k, 2] = force, stored, lost


def path(seed: int, n: int = 200) -> np.ndarray:
    """A walk that turns, leaves below zero, and goes beyond the table's end."""
    steps = np.random.default_rng(seed).normal(size=n) * 0.15
    x = np.abs(np.cumsum(steps)) % 1.2
    x[60:63] = -0.1
    return x


@pytest.mark.interpreted
@pytest.mark.parametrize("seed", range(3))
def test_it_is_that_of_the_contact_laws(seed: int) -> None:
    x = path(seed)
    block = _both_curves(LOADING, UNLOADING, 30.0, "")
    out = np.empty((len(x), 3))
    moved(block, (len(block) - 1) // 6, x, out)
    law = Hysteresis(Characteristic(LOADING), Characteristic(UNLOADING), 30.0)
    x_old, force = np.zeros(1), np.zeros(1)
    for k, at in enumerate(np.maximum(x, 0.0)[:, None]):
        step = law.move(x_old, force, at)
        x_old, force = at, step.force
        expected = [step.force[0], step.stored[0], step.lost[0]]
        np.testing.assert_allclose(out[k], expected, rtol=1e-11, atol=1e-13, err_msg=str(k))


@pytest.mark.interpreted
def test_without_an_unloading_curve_nothing_is_lost() -> None:
    x = path(0)
    block = _both_curves(LOADING, None, None, "")
    out = np.empty((len(x), 3))
    moved(block, (len(block) - 1) // 6, x, out)
    curve = Characteristic(LOADING)
    np.testing.assert_allclose(out[:, 0], curve(np.maximum(x, 0.0)), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(out[:, 1], curve.energy(np.maximum(x, 0.0)), rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(out[:, 2], 0.0, atol=1e-14)
