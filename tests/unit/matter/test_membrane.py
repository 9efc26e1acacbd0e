"""Stresses of membranes against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.materials import Elastic, Fabric, NeoHooke
from contiga.matter.coefficients import Material


def test_rubber_at_twice_its_length_carries_three_and_a_half_mu() -> None:
    """σ = μ (λ² − 1/λ) for what keeps its volume."""
    material = NeoHooke(young=3.0, poisson=0.499999)
    mu = 0.5 * 3.0 / 1.499999
    nominal, _ = rig.pull_sheet(material, (2.0, math.sqrt(0.5)))
    assert 2.0 * nominal[0] / mu == pytest.approx(3.5, rel=1e-4)
    assert abs(nominal[1]) < 1e-4
    both, _ = rig.pull_sheet(material, (2.0, 2.0))
    np.testing.assert_allclose(2.0 * both / mu, 3.9375, rtol=1e-4)


def test_a_balloon_of_rubber() -> None:
    """p R/(μ T) = 2 (λ⁻¹ − λ⁻⁷), by the tension of its skin: 2 σ t = p r."""
    material = NeoHooke(young=3.0, poisson=0.499999)
    mu = 0.5 * 3.0 / 1.499999
    for stretch, expected in ((1.2, 1.108503), (7.0 ** (1.0 / 6.0), 1.239463), (2.0, 0.984375)):
        nominal, _ = rig.pull_sheet(material, (stretch, stretch))
        # force/length at rest over the stretch is the tension of the deformed skin
        pressure = 2.0 * nominal[0] / stretch / stretch
        assert pressure / mu == pytest.approx(expected, rel=2e-5)


def test_a_membrane_is_a_solid_that_is_free_across() -> None:
    material = NeoHooke(young=3.0, poisson=0.4)
    nominal, energy = rig.pull_sheet(material, (1.4, 0.9))
    low, high = 0.5, 1.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if rig.pull(material, (1.4, 0.9, middle))[0][2] < 0.0 else (low, middle)
        )
    stress, stored = rig.pull(material, (1.4, 0.9, low))
    np.testing.assert_allclose(nominal, stress[:2], rtol=1e-12)
    assert energy == pytest.approx(stored, rel=1e-12)


def test_an_elastic_sheet_is_in_plane_stress() -> None:
    young, nu = 3.0, 0.3
    a, b = math.sqrt(1.0 + 2e-2), math.sqrt(1.0 - 0.6e-2)  # E₂₂ = −ν E₁₁
    stress, energy = rig.pull_sheet(Elastic(young=young, poisson=nu), (a, b))
    np.testing.assert_allclose(stress, [a * young * 1e-2, 0.0], atol=1e-14)
    assert energy == pytest.approx(0.5 * young * 1e-4, rel=1e-10)


def test_cloth_carries_no_compression() -> None:
    cloth = Elastic(young=3.0, poisson=0.3, compression=False)
    plain = Elastic(young=3.0, poisson=0.3)
    stress, energy = rig.pull_sheet(cloth, (0.9, 0.8))
    assert (stress == 0.0).all()
    assert energy == 0.0
    stress, energy = rig.pull_sheet(cloth, (1.1, 0.5))
    e = 0.5 * (1.1**2 - 1.0)
    np.testing.assert_allclose(stress, [1.1 * 3.0 * e, 0.0], atol=1e-14)
    assert energy == pytest.approx(0.5 * 3.0 * e * e, rel=1e-13)
    for taut in ((1.1, 1.05), (1.1, 0.98)):
        for mine, theirs in zip(
            rig.pull_sheet(cloth, taut), rig.pull_sheet(plain, taut), strict=True
        ):
            np.testing.assert_allclose(mine, theirs, rtol=1e-12)


SHEETS = [
    Elastic(young=2.0, poisson=0.3),
    Elastic(young=2.0, poisson=0.3, compression=False),
    Fabric(warp=2.0, shear=0.1, direction=[1.0, 0.0, 0.0]),
    NeoHooke(young=2.0, poisson=0.3),
]


@pytest.mark.parametrize("material", SHEETS, ids=["elastic", "slack", "fabric", "neo-hooke"])
def test_a_triangle_pressed_flat_has_finite_forces_and_carries_nothing_at_a_point(
    material: Material,
) -> None:
    nodes = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.3, 0.8, 0.0]])
    matter = rig.one_part("tri3", nodes, np.arange(3)[None], material, thickness=0.5)
    for squeezed in (0.0 * nodes, nodes * [1.0, 0.0, 0.0], nodes[[0, 1, 1]], nodes[[0, 1, 0]]):
        answer = matter.forces(matter.start(), squeezed, np.zeros_like(nodes), 0.1)
        assert np.isfinite([*answer.force.ravel(), *answer.energy]).all()
        assert np.isfinite(matter.stiffness(answer.state)).all()
        np.testing.assert_array_equal(matter.nodal_fields(answer.state).stress, 0.0)
        if not squeezed.any():
            np.testing.assert_array_equal(answer.force, 0.0)
