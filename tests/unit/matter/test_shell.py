"""Kernels of shells: forces by differences of what is stored, stiffness by those of forces."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation
from tests.unit.matter import rig
from tests.unit.matter.iga.shells import crooked, made, plate, still, through

from contiga.errors import ElementError
from contiga.materials import Elastic, Fabric, NeoHooke
from contiga.matter.coefficients import Material
from contiga.matter.iga import Shell, Symmetry

WOVEN = {"warp": 3.0, "weft": 2.0, "shear": 0.5, "direction": [1.0, 0.2, 0.0]}
LOOP = {"warp": [[0, 0], [0.2, 0.6]], "warp_unloading": [[0, 0], [0.1, 0.05], [0.2, 0.3]]}
MATERIALS: dict[str, Material] = {
    "elastic": Elastic(young=3.0, poisson=0.3),
    "rubber": NeoHooke(young=3.0, poisson=0.3),
    "fabric": Fabric(**WOVEN, compression=1.0),
    "tension field": Elastic(young=3.0, poisson=0.3, compression=False),
}
"""The last one is no straight line in its strains, so that its tangent is a bound."""


def moved(shell: Shell, by: float = 0.02) -> np.ndarray:
    return rig.moved(shell.nodes, by, seed=5)


def by_differences(shell: Shell, q: np.ndarray, h: float = 2e-3) -> np.ndarray:
    """Minus the gradient of what is stored, by differences of sixth order."""
    found = np.zeros(q.size)
    for k in range(q.size):
        way = np.zeros(q.size)
        way[k] = h
        way = way.reshape(q.shape)
        near, middle, far = (
            still(shell, q + c * way)[1] - still(shell, q - c * way)[1] for c in (1.0, 2.0, 3.0)
        )
        found[k] = -(45.0 * near - 9.0 * middle + far) / (60.0 * h)
    return found.reshape(q.shape)


def stiffness_by_differences(shell: Shell, q: np.ndarray, h: float = 1e-4) -> np.ndarray:
    columns = []
    for k in range(q.size):
        way = np.zeros(q.size)
        way[k] = h
        way = way.reshape(q.shape)
        near, far = (
            (still(shell, q - c * way)[0] - still(shell, q + c * way)[0]).ravel() for c in (1, 2)
        )
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.stack(columns, axis=1)


def of(name: str, degree: int = 2, **more: Any) -> Shell:
    return made([crooked(degree, (2, 1))], material=MATERIALS[name], **more)


@pytest.mark.parametrize("bending", [1.0, 0.0])
@pytest.mark.parametrize("name", MATERIALS)
def test_forces_are_the_gradient_of_what_is_stored(name: str, bending: float) -> None:
    shell = of(name, bending=bending)
    q = moved(shell, 0.05) * 1.05
    force, _ = still(shell, q)
    # that of a tension field has kinks in its third derivative
    size, slack = np.abs(force).max(), 1e-6 if name == "tension field" else 1e-8
    np.testing.assert_allclose(by_differences(shell, q), force, atol=slack * size)


@pytest.mark.interpreted
def test_stiffness_and_row_sums_of_the_smallest_element() -> None:
    shell = made([crooked(1, (1, 1))], rule=1, bending=0.0)
    q = moved(shell)
    expected = stiffness_by_differences(shell, q)
    state = shell.start()._replace(points=q)
    found = shell.tangent(state).toarray()
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())
    sums = np.abs(found).sum(axis=1).reshape(-1, 3).max(axis=1)
    np.testing.assert_allclose(shell.stiffness(state), sums, rtol=1e-12)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_of_other_degrees_too(degree: int) -> None:
    shell = made([crooked(degree, (1, 1))], bending=0.0 if degree == 1 else 1.0)
    q = moved(shell)
    force, _ = still(shell, q)
    some = np.unravel_index(np.arange(0, q.size, 7), q.shape)
    found = np.array([_slope(shell, q, *place) for place in zip(*some, strict=True)])
    np.testing.assert_allclose(found, force[some], atol=1e-8 * np.abs(force).max())


def _slope(shell: Shell, q: np.ndarray, row: int, way: int, h: float = 1e-3) -> float:
    energies = []
    for c in (-2.0, -1.0, 1.0, 2.0):
        there = q.copy()
        there[row, way] += c * h
        energies.append(still(shell, there)[1])
    a, b, c, d = energies
    return -(8.0 * (c - b) - (d - a)) / (12.0 * h)


@pytest.mark.parametrize("bending", [1.0, 0.0])
@pytest.mark.parametrize("name", ["elastic", "rubber", "fabric"])
def test_the_stiffness_is_that_of_the_forces(name: str, bending: float) -> None:
    shell = of(name, bending=bending)
    q = moved(shell, 0.03) * 1.05
    expected = stiffness_by_differences(shell, q)
    found = shell.tangent(shell.start()._replace(points=q)).toarray()
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())
    np.testing.assert_allclose(found, found.T, atol=1e-15 * np.abs(expected).max())


@pytest.mark.parametrize("name", MATERIALS)
def test_row_sums_are_no_less_than_those_of_the_stiffness(name: str) -> None:
    shell = of(name)
    q = moved(shell, 0.03) * 1.05
    state = shell.start()._replace(points=q)
    told = shell.stiffness(state)
    expected = np.abs(stiffness_by_differences(shell, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
    assert (told >= expected * (1.0 - 1e-7)).all()
    if name != "tension field":
        assert (told <= 1.3 * expected).all()


def test_the_step_of_row_sums_is_at_most_the_critical_one_and_no_less_than_half_of_it() -> None:
    shell = made([plate(2, (6, 4), (3.0, 2.0))], thickness=0.05)
    start = shell.start()
    stiffness = shell.tangent(start).toarray()
    masses = np.repeat(shell.mass, 3)
    fastest = eigh(stiffness, np.diag(masses), eigvals_only=True)[-1]
    told = np.max(shell.stiffness(start) / shell.mass)
    assert fastest <= told <= 4.0 * fastest


@pytest.mark.parametrize("name", MATERIALS)
def test_forces_turn_with_the_shell_and_there_are_none_of_a_rigid_motion(name: str) -> None:
    shell = of(name)
    turn = Rotation.from_rotvec([0.5, -1.0, 0.35]).as_matrix()
    shift = np.array([3.0, -1.0, 2.0])
    force, energy = still(shell, shell.nodes @ turn.T + shift)
    assert np.abs(force).max() < 1e-14
    assert abs(energy) < 1e-16
    q = moved(shell)
    force, energy = still(shell, q)
    turned, same = still(shell, q @ turn.T + shift)
    np.testing.assert_allclose(turned, force @ turn.T, atol=1e-12 * np.abs(force).max())
    assert same == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("turn", ["flipped", "transposed"])
@pytest.mark.parametrize("name", MATERIALS)
def test_which_way_the_parameters_run_changes_nothing(name: str, turn: str) -> None:
    surface = crooked(3, (2, 1))
    shell = made([surface], material=MATERIALS[name])
    other = made([getattr(surface, turn)()], material=MATERIALS[name])
    way = 0.05 * np.sin(3.0 * shell.nodes + [0.0, 1.0, 2.0])
    same = 0.05 * np.sin(3.0 * other.nodes + [0.0, 1.0, 2.0])
    force, energy = still(shell, shell.nodes + way)
    found, stored = still(other, other.nodes + same)
    assert stored == pytest.approx(energy, rel=1e-11)
    order, others = (np.lexsort(np.round(each.nodes, 9).T) for each in (shell, other))
    np.testing.assert_allclose(found[others], force[order], atol=1e-11 * np.abs(force).max())


@pytest.mark.parametrize("name", MATERIALS)
def test_what_is_larger_stores_by_its_volume(name: str) -> None:
    surface, size = crooked(2, (2, 1)), 7.0
    shell = made([surface], material=MATERIALS[name])
    large = made([surface.scaled(size)], material=MATERIALS[name], thickness=0.1 * size)
    q = moved(shell)
    energy, stored = still(shell, q)[1], still(large, size * q)[1]
    assert stored == pytest.approx(size**3 * energy, rel=1e-11)


@pytest.mark.parametrize("name", MATERIALS)
def test_forces_and_their_moments_sum_to_nothing(name: str) -> None:
    shell = of(name)
    q = moved(shell)
    force, _ = still(shell, q)
    size = np.abs(force).max()
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(q, force).sum(axis=0), 0.0, atol=1e-13 * size)


def test_layers_of_what_is_linear_are_as_forces_and_moments_of_the_middle() -> None:
    whole = of("elastic", bending=0.4)
    q = moved(whole)
    expected, energy = still(whole, q)
    for layers in (2, 3):
        force, stored = still(of("elastic", bending=0.4, layers=layers), q)
        np.testing.assert_allclose(force, expected, atol=1e-13)
        assert stored == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("stretches", [(1.3, 1.1), (1.2, 0.7)])
def test_a_sheet_is_as_one_of_triangles(name: str, stretches: tuple[float, float]) -> None:
    shell = made([plate(2, (2, 1), (1.0, 1.0))], material=MATERIALS[name], thickness=1.0)
    _, energy = still(shell, shell.nodes * [*stretches, 1.0])
    assert energy == pytest.approx(rig.pull_sheet(MATERIALS[name], stretches)[1], rel=1e-12)


def test_what_unloads_by_another_curve_loses_as_much_as_triangles_do() -> None:
    cloth = Fabric(**(WOVEN | LOOP), hysteresis_slope=20.0)
    sheet = rig.one_part("tri3", rig.grid((1, 1, 0)), rig.sheet(1, 1), cloth, thickness=0.1)
    shell = made([plate(2, (2, 1), (1.0, 1.0))], material=cloth)
    lost = []
    for matter in (sheet, shell):
        state, total = matter.start(), 0.0
        for stretch in (1.05, 1.1, 1.15, 1.05, 1.0, 1.1):
            q = matter.nodes * [stretch, 1.0, 1.0]
            answer = matter.forces(state, q, np.zeros_like(q), 0.1)
            state, total = answer.state, total + answer.energy.hysteresis
        lost.append([total, answer.energy.strain])
    assert lost[0][0] > 1e-4
    np.testing.assert_allclose(lost[1], lost[0], rtol=1e-12)


def test_layers_remember_each_their_own_strain() -> None:
    """What is bent to and fro takes what it stores and loses, by the trapezoidal rule."""
    cloth = Fabric(**(WOVEN | LOOP), hysteresis_slope=20.0)
    shell = made([plate(2, (2, 1), (1.0, 1.0))], material=cloth, thickness=0.3, layers=3)
    x = shell.nodes[:, 0]
    way = np.stack([0.2 * x, 0.0 * x, 0.9 * x * x], axis=1)
    answer = before = shell.forces(shell.start(), shell.nodes, 0.0 * way, 0.0)
    here = work = lost = 0.0
    for there in (0.6, 0.1, 1.0, 0.5):
        for share in np.linspace(here, there, 201)[1:]:
            q = shell.nodes + share * way
            answer = shell.forces(before.state, q, 0.0 * q, 0.1)
            work -= 0.5 * float(((answer.force + before.force) * (q - before.state.points)).sum())
            lost += answer.energy.hysteresis
            before = answer
        here = there
    assert lost > 0.2 * answer.energy.strain > 0.0
    assert work == pytest.approx(answer.energy.strain + lost, rel=1e-4)


def test_a_strip_rolled_to_a_ring_stores_what_bending_takes() -> None:
    """E t³/12 κ²/2 by area, κ the curvature by length at rest, with ν = 0."""
    length, t, young = 2.0 * np.pi, 0.1, 3.0
    strip = plate(5, (16, 1), (length, 1.0))
    shell = made([strip], material=Elastic(young=young), thickness=t)
    angles = shell.net.sites[:, 0]
    ring = np.stack([np.sin(angles), shell.net.sites[:, 1], 1.0 - np.cos(angles)], axis=1)
    _, energy = still(shell, through(shell, ring))
    expected = 0.5 * young * t**3 / 12.0 * length
    assert energy == pytest.approx(expected, rel=1e-6)


def test_no_bit_depends_on_threads() -> None:
    shell = made([crooked(2, (40, 20))])
    q = moved(shell, 0.01)
    before = numba.get_num_threads()
    found = []
    try:
        for threads in (1, 2):
            numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
            state = shell.start()._replace(points=q)
            found.append((*still(shell, q), shell.stiffness(state), shell.points(q)))
    finally:
        numba.set_num_threads(before)
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


def test_elements_that_fill_a_block_add_nothing() -> None:
    """65 elements are two blocks, the second nearly empty."""
    shell = made([plate(1, (65, 1), (65.0, 1.0))], bending=0.0)
    assert shell.mass.sum() == pytest.approx(65.0 * 0.2, rel=1e-12)
    q = moved(shell)
    halves = [
        made([plate(1, (n, 1), (float(n), 1.0)).translated([x, 0.0, 0.0])], bending=0.0)
        for n, x in ((64, 0.0), (1, 64.0))
    ]
    rows = [slice(0, 130), slice(128, 132)]
    parts = [still(half, q[row])[1] for half, row in zip(halves, rows, strict=True)]
    assert still(shell, q)[1] == pytest.approx(sum(parts), rel=1e-12)


def test_an_element_pressed_to_a_line_is_told() -> None:
    shell = of("elastic")
    with pytest.raises(ElementError, match=r"of a shell, pressed to a line.*, and 1 more"):
        still(shell, shell.nodes * [1.0, 0.0, 0.0])
    q = shell.nodes.copy()
    q[shell.net.edge("u1", rows=3)] *= [1.0, 0.0, 0.0]
    with pytest.raises(ElementError, match=r"element 1 \(of a shell"):
        still(shell, q)
    q = shell.nodes.copy()
    q[0, 0] = np.nan
    with pytest.raises(ElementError, match="of a shell"):
        still(shell, q)


def test_a_membrane_may_be_pressed_to_a_line() -> None:
    shell = of("tension field", bending=0.0)
    force, energy = still(shell, shell.nodes * [1.1, 0.0, 0.0])
    assert np.isfinite(force).all()
    assert energy > 0.0
    assert not still(shell, 0.0 * shell.nodes)[0].any()


def test_slopes_across_a_kink_and_at_a_plane_are_springs_with_an_energy() -> None:
    first = crooked(2, (1, 1))
    second = crooked(2, (1, 1), seed=4)
    second = second.translated([2.0, 0.0, 0.7])
    points, weights = np.array(second.control_points), np.array(second.weights)
    points[0], weights[0] = first.control_points[-1], first.weights[-1]
    joined = type(first)(second.degrees, second.knots, points, weights)
    plane = Symmetry("u1", np.array([1.0, 0.2, 0.0]), 1)
    shell = made([first, joined], symmetry=[plane], slope_stiffness=1e3)
    loose = made([first, joined], slope_stiffness=1e-12)
    assert len(shell.mass) == 15
    force, energy = still(shell, shell.nodes)
    assert np.abs(force).max() < 1e-15
    assert abs(energy) < 1e-17
    q = moved(shell, 0.05)
    force, energy = still(shell, q)
    assert energy > 1.01 * still(loose, q)[1]
    np.testing.assert_allclose(
        by_differences(shell, q, 1e-3), force, atol=1e-8 * np.abs(force).max()
    )
    expected = stiffness_by_differences(shell, q)
    state = shell.start()._replace(points=q)
    found = shell.tangent(state).toarray()
    np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())
    sums = np.abs(expected).sum(axis=1).reshape(-1, 3).max(axis=1)
    assert (shell.stiffness(state) >= sums * (1.0 - 1e-6)).all()


@pytest.mark.interpreted
def test_a_spring_between_two_flat_elements_stores_what_its_angle_says() -> None:
    """k (1 − cos φ) by length, k of `slope_stiffness` E t³/12 over the width of the elements."""
    halves = [plate(2, (1, 1), (1.0, 1.0)).translated([x, 0.0, 0.0]) for x in (0.0, 1.0)]
    shell = made(halves, slope_stiffness=7.0, rule=1)
    angle = 0.4
    q = shell.nodes.copy()
    far = q[:, 0] > 1.0
    reach = q[far, 0] - 1.0
    q[far, 0], q[far, 2] = 1.0 + reach * np.cos(angle), reach * np.sin(angle)
    force, energy = still(shell, q)
    stiff = 7.0 * 3.0 * 0.1**3 / 12.0
    assert energy == pytest.approx(stiff * (1.0 - np.cos(angle)), rel=1e-12)
    moment = np.cross(q[far] - [1.0, 0.0, 0.0], force[far])[:, 1].sum()
    assert moment == pytest.approx(stiff * np.sin(angle), rel=1e-12)
