"""Stresses of elements: closed forms of uniform stretches."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from contiga.materials import Elastic, Foam, NeoHooke
from contiga.matter import MatterState, Part, assemble
from contiga.matter.stress import von_mises


def _stress(kind: str, material: object, stretch: np.ndarray, turn: float = 0.3) -> np.ndarray:
    """Of a block that is stretched along its axes and then turned, in its own axes."""
    slave = block((3, 2, 2), (1.0, 2.0, 3.0), kind={"tet4": "tetra", "hex8": "hexahedron"}[kind])
    (elements,) = slave.elements.values()
    part = Part(kind=kind, elements=np.asarray(elements), material=material, density=1.0)
    matter = assemble(slave.points, [part])
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    R = R @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    q = (matter.nodes * stretch) @ R.T
    state = matter.forces(matter.start(), q, np.zeros_like(q), 1.0).state
    six = matter.stress(state)
    whole = six[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    return R.T @ whole @ R


@pytest.mark.parametrize("kind", ["tet4", "hex8"])
@pytest.mark.parametrize("volume", ["element", "nodes"])
def test_neo_hooke_has_its_cauchy_stress(kind: str, volume: str) -> None:
    young, poisson, stretch = 3.0, 0.4, np.array([1.2, 0.9, 1.05])
    mu, lam = young / 2.8, young * 0.4 / (1.4 * 0.2)
    J = stretch.prod()
    exact = (mu * (stretch**2 - 1.0) + lam * J * (J - 1.0)) / J
    material = NeoHooke(young=young, poisson=poisson, volume=volume)
    stress = _stress(kind, material, stretch)
    np.testing.assert_allclose(stress, np.broadcast_to(np.diag(exact), stress.shape), atol=1e-9)


def test_foam_has_that_of_its_table() -> None:
    foam = Foam(loading=np.array([[0.0, 0.0], [0.5, 0.4], [0.9, 4.0]]), hysteresis=0.2)
    stress = _stress("hex8", foam, np.array([1.0, 1.0, 0.75]))
    np.testing.assert_allclose(stress[:, 2, 2], -0.2, atol=1e-9)


def test_a_membrane_carries_by_its_thickness_and_a_bar_by_its_section() -> None:
    nodes = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    sheet = Part(
        kind="tri3",
        elements=np.array([[0, 1, 2], [0, 2, 3]]),
        material=Elastic(young=5.0),
        density=1.0,
        thickness=0.1,
    )
    strain = 1e-4
    for part in (sheet, Part(kind="bar2", elements=np.array([[0, 1], [2, 3]]),
                             material=Elastic(young=5.0), density=1.0, section=0.3)):  # fmt: skip
        matter = assemble(nodes, [part])
        q = nodes * [1.0 + strain, 1.0, 1.0]
        stress = matter.stress(MatterState(q, matter.start().memory))
        np.testing.assert_allclose(stress[:, 0], 5.0 * strain, rtol=1e-3)
        np.testing.assert_allclose(stress[:, 1:], 0.0, atol=1e-12)


def test_von_mises_of_pressure_is_nothing() -> None:
    assert von_mises(np.array([[-2.0, -2, -2, 0, 0, 0]]))[0] == 0.0
