"""A step of nodes that forces move, against plain numpy."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.dynamics import deforming_nodes as node_steps
from contiga.records import FloatArray

pytestmark = pytest.mark.interpreted

RNG = np.random.default_rng(8)
N = 333  # two blocks and a part of one
DT, DAMPING = 0.03, 0.7
GRAVITY = np.array([0.3, -9.0, 2.0])
MASS = RNG.uniform(0.5, 2.0, N)
POINTS, VELOCITIES, ELEMENTS, LOADS, DRAG = RNG.normal(size=(5, N, 3))
ENDS = [0, 127, 128, 255, 256, N - 1]
"""Nodes at the ends of blocks."""
ROWS = np.union1d(RNG.choice(N, 60, replace=False), ENDS).astype(np.int32)
FORCES = RNG.normal(size=(len(ROWS), 3))
EVERYWHERE = RNG.normal(size=(N, 3))
HELD = RNG.random((N, 3)) < 0.1
DRIVEN = RNG.random((N, 3)) < 0.2
NONE = np.zeros((N, 3), np.bool_)


def accelerations(held: np.ndarray, loads: bool) -> FloatArray:
    force = ELEMENTS.copy()
    force[ROWS] += FORCES
    if loads:
        force += EVERYWHERE + LOADS + DRAG
    return np.where(held, 0.0, force / MASS[:, None] + GRAVITY)


def acting(loads: bool) -> node_steps.Acting:
    none = node_steps.NO_FORCES
    everywhere, *more = (EVERYWHERE, LOADS, DRAG) if loads else (none, none, none)
    return node_steps.Acting(ROWS, FORCES, everywhere, ELEMENTS, *more, GRAVITY)


@pytest.mark.parametrize("loads", [False, True])
@pytest.mark.parametrize("held", [NONE, HELD])
def test_a_drift_is_half_a_kick_a_way_and_a_prediction(held: np.ndarray, loads: bool) -> None:
    masses = node_steps.masses_of(MASS, held, NONE)
    expected = accelerations(held, loads)
    np.testing.assert_allclose(node_steps.accelerated(masses, acting(loads)), expected, rtol=1e-13)
    moved = node_steps.drift_nodes(masses, acting(loads), POINTS, VELOCITIES, DT)
    half = VELOCITIES + 0.5 * DT * expected
    np.testing.assert_allclose(moved.half, half, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(moved.points, POINTS + DT * half, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(moved.velocities, VELOCITIES + DT * expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("driven", [NONE, DRIVEN])
def test_a_kick_ends_the_step_with_damping_and_without_driven_nodes(driven: np.ndarray) -> None:
    masses = node_steps.masses_of(MASS, HELD, driven)
    half, predicted = RNG.normal(size=(2, N, 3))
    velocities, energy = node_steps.kick_nodes(masses, acting(True), half, predicted, DT, DAMPING)
    free = half + 0.5 * DT * accelerations(HELD, True)
    free /= 1.0 + 0.5 * DT * DAMPING
    expected_velocities = np.where(driven, predicted, free)
    np.testing.assert_allclose(velocities, expected_velocities, rtol=1e-12, atol=1e-14)
    both = np.where(driven, 0.0, half * (2.0 * free - half))
    assert energy.sum() == pytest.approx(0.5 * (MASS[:, None] * both).sum(), rel=1e-12)
    square = np.where(driven, 0.0, velocities * velocities)
    expected = 0.5 * (MASS[:, None] * square).sum()
    assert node_steps.kinetic(masses, velocities) == pytest.approx(expected, rel=1e-12)


def test_a_part_of_the_nodes_takes_its_part_of_the_list() -> None:
    masses = node_steps.masses_of(MASS, HELD, NONE)
    whole, parts = np.empty((N, 3)), np.empty((N, 3))
    node_steps.nodes_nb.accelerate(masses, acting(True), whole, 0, N)
    for start, stop in ((0, 128), (128, N)):
        node_steps.nodes_nb.accelerate(masses, acting(True), parts, start, stop)
    np.testing.assert_array_equal(whole, parts)
