"""Woven fabric: warp, weft and shear, each by its own curve."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError
from contiga.materials import Fabric
from contiga.matter import Assembled

WARP = [[0.0, 0.0], [0.05, 0.1], [0.4, 3.0]]
GOOD: dict[str, Any] = {"warp": WARP, "weft": 2.0, "shear": 0.3, "direction": [1.0, 0.0, 0.0]}
LOOP = {"warp_unloading": [[0, 0], [0.2, 0.3], [0.4, 2.0]], "hysteresis_slope": 20.0}
NODES = rig.grid((1, 1, 0))


def square(**more: Any) -> Assembled:
    """A unit square, a fifth thick."""
    return rig.one_part("tri3", NODES, rig.sheet(1, 1), Fabric(**(GOOD | more)), thickness=0.2)


def strained(a: float, b: float, ab: float) -> np.ndarray:
    """A symmetric deformation with Green's strains E₁₁, E₂₂ and E₁₂."""
    square_of = np.array([[1.0 + 2.0 * a, 2.0 * ab], [2.0 * ab, 1.0 + 2.0 * b]])
    values, axes = np.linalg.eigh(square_of)
    deform = np.eye(3)
    deform[:2, :2] = axes @ np.diag(np.sqrt(values)) @ axes.T
    return deform


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_each_direction_carries_its_own_strain(turned: float) -> None:
    """S₁₁ = f(E₁₁), S₂₂ = 2 E₂₂, S₁₂ = 0.3 · 2 E₁₂, with the warp turned in the plane."""
    c, s = math.cos(turned), math.sin(turned)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    matter = square(direction=turn[:, 0])
    deform = turn @ strained(0.2, 0.1, 0.05) @ turn.T
    force, energy = rig.still(matter, NODES @ deform.T)
    f = Characteristic(WARP)(np.array([0.2]))[0]
    stress = np.zeros((3, 3))
    stress[:2, :2] = [[f, 0.03], [0.03, 0.2]]
    expected = 0.2 * deform @ turn @ stress @ turn.T
    np.testing.assert_allclose(-force.T @ NODES, expected[:, :] * [1, 1, 0], atol=1e-14)
    w = 0.5 * 0.05 * 0.1 + 0.5 * 0.15 * (0.1 + f) + 0.5 * 0.1 * 0.2 + 0.5 * 0.1 * 0.03
    assert energy == pytest.approx(0.2 * w, rel=1e-12)


def test_it_carries_little_or_nothing_in_compression() -> None:
    deform = strained(-0.2, -0.1, 0.0)
    force, energy = rig.still(square(), NODES @ deform.T)
    assert np.abs(force).max() < 1e-16
    assert energy == 0.0
    force, energy = rig.still(square(compression=0.1), NODES @ deform.T)
    assert energy == pytest.approx(0.2 * 0.5 * (0.2 * 0.2**2 + 0.2 * 0.1**2), rel=1e-12)
    stress = -force[NODES[:, 0] == 1.0, 0].sum()
    assert stress == pytest.approx(-0.2 * 0.1 * 2.0 * 0.2 * deform[0, 0], rel=1e-12)


def test_an_unloading_force_is_the_gradient_of_what_is_stored() -> None:
    matter = square(**LOOP)
    state = matter.start()
    for a in (0.1, 0.3, 0.2):
        q = NODES @ strained(a, 0.1, 0.05).T
        state = matter.forces(state, q, np.zeros_like(q), 0.0).state
    q = NODES @ strained(0.15, 0.08, 0.06).T + rig.moved(np.zeros_like(NODES), 0.003)
    force, _ = rig.still(matter, q, state)
    expected = rig.by_differences(matter, q, state, h=1e-5)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-8 * np.abs(force).max())


def test_a_cycle_loses_what_lies_between_the_curves() -> None:
    """To E = 0.3 and back: ∫L − ∫U without the corner that the line cuts."""
    matter, state, lost = square(**LOOP, shear=1e-9, weft=1e-9), None, 0.0
    state = matter.start()
    for a in np.concatenate([np.linspace(0.0, 0.3, 31), np.linspace(0.29, 0.0, 30)]):
        q = NODES @ strained(a, 0.0, 0.0).T
        answer = matter.forces(state, q, np.zeros_like(q), 0.0)
        state, lost = answer.state, lost + answer.energy.hysteresis
    loading = 0.5 * 0.05 * 0.1 + 0.5 * 0.25 * (0.1 + 0.1 + 2.9 / 0.35 * 0.25)
    unloading = 0.5 * 0.2 * 0.3 + 0.5 * 0.1 * (0.3 + 1.15)
    corner = 0.5 * (0.1 + 2.9 / 0.35 * 0.25 - 1.15) ** 2 / (20.0 - 8.5)
    assert lost == pytest.approx(0.2 * (loading - unloading - corner), rel=1e-9)
    assert answer.energy.strain == pytest.approx(0.0, abs=1e-12)


def test_its_stiffness_is_bounded_by_the_steepest_curves() -> None:
    """Wherever it goes: row sums at rest hold when it is taut."""
    matter = square()
    q = NODES @ strained(0.2, 0.1, 0.02).T
    exact = np.abs(rig.tangent(matter, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
    told = matter.stiffness(matter.start()._replace(points=q))
    assert (told >= exact * (1.0 - 1e-6)).all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"warp": [[0, 0], [0.1, 2], [0.2, 1]]}, "warp: the stress falls"),
        ({"direction": [0.0, 0.0, 0.0]}, "no length"),
        ({"direction": [1.0, 0.0]}, "no direction"),
        ({"compression": -0.1}, "share"),
        ({"warp_unloading": WARP}, "hysteresis_slope: is missing"),
        ({**LOOP, "hysteresis_slope": 5.0}, "steepest slope"),
        ({"weft_unloading": 2.1, "hysteresis_slope": 30.0}, "above the loading"),
    ],
)
def test_a_wrong_fabric_is_refused(change: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Fabric(**(GOOD | change))


def test_a_warp_across_the_plane_is_refused() -> None:
    with pytest.raises(InputError, match="across its plane"):
        square(direction=[0.0, 0.0, 1.0])
