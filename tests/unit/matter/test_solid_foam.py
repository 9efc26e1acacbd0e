"""Low-density foam: principal stresses by a curve, what a cycle gives back, rates."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.matter import rig

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError
from contiga.materials import Foam
from contiga.matter import Assembled, MatterState

CURVE = [[0.0, 0.0], [0.05, 0.1], [0.6, 0.2], [0.9, 3.0]]


def cube(**more: Any) -> Assembled:
    """A unit cube of one hexahedron."""
    material = Foam(**({"loading": CURVE} | more))
    return rig.one_part("hex8", rig.grid((1, 1, 1)), rig.hexes((1, 1, 1)), material)


def top_force(matter: Assembled, force: np.ndarray) -> float:
    """Sum along z of the upper nodes."""
    return float(force[matter.nodes[:, 2] == 1.0, 2].sum())


def pressed(
    matter: Assembled, state: MatterState, strains: np.ndarray, dt: float = 1.0
) -> tuple[MatterState, np.ndarray, np.ndarray]:
    """Strains along z one after the other: the state, forces on top, energies."""
    forces, energies, last = [], [], 1.0 - state.points[:, 2].max()
    for strain in strains:
        q = matter.nodes * [1.0, 1.0, 1.0 - strain]
        v = matter.nodes * [0.0, 0.0, -(strain - last) / dt]
        answer = matter.forces(state, q, v, dt)
        state, last = answer.state, strain
        forces.append(top_force(matter, answer.force))
        energies.append(answer.energy)
    return state, np.array(forces), np.array(energies)


def test_stress_follows_the_curve_along_each_principal_axis() -> None:
    matter = cube(tension=4.0)
    turn = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
    stretch = np.array([0.5, 0.97, 1.2])
    axes = Rotation.from_rotvec([1.0, 0.2, -0.4]).as_matrix()
    deform = turn @ axes @ np.diag(stretch) @ axes.T
    force, energy = rig.still(matter, matter.nodes @ deform.T)
    table = Characteristic(CURVE)
    stress = np.append(-table(1.0 - stretch[:2]), 4.0 * 0.2)
    expected = turn @ axes @ np.diag(stress) @ axes.T
    # P = −Σ f ⊗ X over a unit cube
    np.testing.assert_allclose(-force.T @ matter.nodes, expected, atol=1e-13)
    half = 0.5 * 0.05 * 0.1 + 0.5 * 0.45 * (0.1 + table(np.array([0.5]))[0])
    assert energy == pytest.approx(half + 0.5 * 2.0 * 0.03**2 + 0.5 * 4.0 * 0.04, rel=1e-12)


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_an_unloading_force_is_the_gradient_of_what_is_stored(kind: str) -> None:
    nodes = rig.ONE_HEX if kind == "hex8" else rig.grid((1, 1, 1))
    elements = rig.hexes((1, 1, 1)) if kind == "hex8" else rig.tets((1, 1, 1))
    material = Foam(loading=[[0, 0], [0.9, 3.0]], hysteresis=0.1, shape=3.0, tension=2.0)
    matter = rig.one_part(kind, nodes, elements, material)
    deep = matter.forces(matter.start(), nodes * [0.9, 0.8, 0.4], np.zeros_like(nodes), 0.0).state
    q = rig.moved(nodes * [0.95, 0.9, 0.6], 0.01)
    force, _ = rig.still(matter, q, deep)
    expected = rig.by_differences(matter, q, deep)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-8 * np.abs(force).max())


@pytest.mark.parametrize(("kept", "shape"), [(0.0, 1.0), (0.1, 5.0), (1.0, 2.0)])
def test_a_cycle_gives_back_what_is_said(kept: float, shape: float) -> None:
    """A linear curve: returned is H + (1 − H)/(S + 1) of what was taken."""
    material = {"loading": [[0, 0], [1, 2]], "hysteresis": kept, "shape": shape}
    matter = cube(**material)
    up = np.linspace(0.0, 0.6, 201)[1:]
    state, load, taken = pressed(matter, matter.start(), up)
    state, unload, back = pressed(matter, state, up[::-1][1:])
    work = np.trapezoid(np.append(0.0, load), np.append(0.0, up))
    returned = np.trapezoid(np.append(0.0, unload[::-1]), np.append(0.0, up[:-1]))
    returned += 0.5 * (unload[0] + load[-1]) * (up[-1] - up[-2])
    share = Foam(**material).returned
    assert share == pytest.approx(kept + (1.0 - kept) / (shape + 1.0))
    assert work == pytest.approx(0.5 * 2.0 * 0.6**2, rel=1e-12)
    assert returned / work == pytest.approx(share, abs=2e-4)
    assert taken[:, 3].sum() == pytest.approx((1.0 - share) * work, rel=1e-10, abs=1e-14)
    assert (back[:, 3] == 0.0).all()
    # pressed again it follows the way it came until it is as deep as it was
    _, again, _ = pressed(matter, state, up[:-1])
    np.testing.assert_allclose(again, unload[::-1], rtol=1e-9, atol=1e-12)


RATES = ((1e-3, [[0, 0], [0.05, 0.15], [0.6, 0.3], [0.9, 4.0]]),
         (1e-1, [[0, 0], [0.05, 0.3], [0.6, 0.6], [0.9, 8.0]]))  # fmt: skip


def test_rates_add_what_their_tables_have_more() -> None:
    """At a steady rate, long after the filter has settled; above the last rate it stays."""
    matter = cube(rates=RATES, filter=1.0)
    for rate, shares in ((1e-3, (1.0, 0.0)), (0.0505, (0.5, 0.5)), (5.0, (0.0, 1.0))):
        dt = 0.3 / rate / 400.0
        slow = cube(rates=RATES, filter=5.0 * dt)
        _, force, _ = pressed(slow, slow.start(), np.linspace(0.0, 0.3, 401)[1:], dt)
        tables = [Characteristic(table)(np.array([0.3]))[0] for _, table in RATES]
        assert force[-1] == pytest.approx(np.dot(shares, tables), rel=1e-9)
    _, force, _ = pressed(matter, matter.start(), np.array([0.1, 0.2, 0.3]), 1e9)
    assert force[-1] == pytest.approx(Characteristic(CURVE)(np.array([0.3]))[0], rel=1e-6)


def test_what_a_rate_takes_closes_the_balance() -> None:
    """Work = stored + viscosity + hysteresis over a cycle, to second order in the step."""
    errors = []
    for n in (100, 200, 400):
        matter = cube(rates=RATES, filter=0.05, hysteresis=0.2, shape=2.0)
        t = np.linspace(0.0, 1.0, n + 1)
        strain = 0.25 * np.sin(np.pi * t) ** 2
        _, force, energy = pressed(matter, matter.start(), strain[1:], 1.0 / n)
        work = np.trapezoid(np.append(0.0, force), strain)
        errors.append(abs(work - energy[-1, 0] - energy[:, 2:].sum()) / np.abs(energy[:, 2:]).sum())
    assert errors[2] < 2e-5
    assert errors[2] < 0.1 * errors[0]  # a sixteenth, but for the steps across kinks of the tables


def test_each_axis_has_its_own_rate() -> None:
    """One axis is pressed quickly while another has been held for long: it alone has more."""
    matter = cube(rates=RATES, filter=1.0)
    state, q = matter.start(), matter.nodes
    for stretches, dt in (([1.0, 0.5, 1.0], 1e9), ([1.0, 0.5, 1.0], 1e9), ([0.6, 0.5, 1.0], 1.0)):
        before, q = q, matter.nodes * stretches
        answer = matter.forces(state, q, (q - before) / dt, dt)
        state = answer.state
    force = [-float(answer.force[matter.nodes[:, k] == 1.0, k].sum()) for k in range(3)]
    at_rest = Characteristic(CURVE)(np.array([0.4, 0.5]))
    fast = Characteristic(RATES[1][1])(np.array([0.4]))[0]  # its rate is above the last table's
    np.testing.assert_allclose(-np.array(force), [fast, at_rest[1], 0.0], rtol=1e-9, atol=1e-12)


def test_axes_that_are_followed_are_those_found_anew() -> None:
    """Tables that add nothing: forces as without them, after thousands of turns of the axes."""
    matter = cube(rates=((1.0, CURVE),), filter=0.1)
    state, t = matter.start(), np.linspace(0.0, 60.0, 3001)
    deform = np.eye(3) + 0.15 * np.sin(np.outer(t, np.linspace(0.3, 2.7, 9))).reshape(-1, 3, 3)
    for one in deform:
        answer = matter.forces(state, matter.nodes @ one.T, matter.nodes, t[1])
        state = answer.state
    expected, stored = rig.still(cube(), matter.nodes @ deform[-1].T)
    np.testing.assert_allclose(answer.force, expected, rtol=0, atol=1e-13)
    assert answer.energy.strain == pytest.approx(stored, rel=1e-12)
    assert answer.energy.viscosity == 0.0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"loading": [[0, 0], [0.1, 2], [0.2, 1]]}, "stress falls"),
        ({"hysteresis": 1.5}, "share"),
        ({"shape": 0.0}, "shape"),
        ({"tension": -1.0}, "tension"),
        ({"rates": RATES}, "filter"),
        ({"rates": RATES[::-1], "filter": 1.0}, "rates must rise|falls with the rate"),
        ({"rates": ((1.0, [[0, 0], [0.9, 0.1]]),), "filter": 1.0}, "falls with the rate"),
    ],
)
def test_a_wrong_foam_is_refused(change: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Foam(**({"loading": CURVE} | change))
