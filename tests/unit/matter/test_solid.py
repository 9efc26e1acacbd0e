"""Stresses of solids against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.materials import Elastic, NeoHooke


@pytest.mark.parametrize("stretches", [(2.0, 0.8, 0.9), (0.5, 0.6, 0.7), (3.0, 2.5, 1.5)])
def test_a_neo_hookean_cube(stretches: tuple[float, float, float]) -> None:
    mu, lam = 1.0, 4.0
    nu = lam / (2.0 * (lam + mu))
    stress, energy = rig.pull(NeoHooke(young=2.0 * mu * (1.0 + nu), poisson=nu), stretches)
    s, j = np.array(stretches), math.prod(stretches)
    np.testing.assert_allclose(stress, mu * (s - 1.0 / s) + lam * (j - 1.0) * j / s, rtol=1e-13)
    stored = 0.5 * mu * (s @ s - 3.0) - mu * math.log(j) + 0.5 * lam * (j - 1.0) ** 2
    assert energy == pytest.approx(stored, rel=1e-13)


@pytest.mark.parametrize("j", [1e-3, 0.06, 0.4999, 0.9, 1.0 + 1e-9, 1.9999, 2.0001, 15.0, 400.0])
def test_the_energy_of_a_change_of_volume_has_the_logarithm(j: float) -> None:
    s = j ** (1.0 / 3.0)
    _, energy = rig.pull(NeoHooke(young=2.0, poisson=0.0), (s, s, s))
    expected = 0.5 * 3.0 * (s * s - 1.0) - math.log(j)
    near = 1e-13 if 1.0 / 256.0 <= j <= 256.0 else 1e-11
    assert energy == pytest.approx(expected, rel=near, abs=1e-15)


def test_an_elastic_cube() -> None:
    young, nu = 3.0, 0.3
    mu, lam = 0.5 * young / (1 + nu), young * nu / ((1 + nu) * (1 - 2 * nu))
    s = np.array([1.1, 0.95, 1.02])
    e = 0.5 * (s * s - 1.0)
    stress, energy = rig.pull(Elastic(young=young, poisson=nu), tuple(s))
    np.testing.assert_allclose(stress, s * (lam * e.sum() + 2.0 * mu * e), rtol=1e-13)
    assert energy == pytest.approx(0.5 * lam * e.sum() ** 2 + mu * e @ e, rel=1e-13)
