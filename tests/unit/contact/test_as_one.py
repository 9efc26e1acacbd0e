"""Friction of a law that gives one force: it sticks and slips as one point would."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg

pose = cg.motion.pose
R, DEPTH, STIFFNESS, MU = 1.0, 0.05, 100.0, 0.3
PAD = cg.Slave(*square_sheet(2.0, 21))
BALL = cg.Body([cg.shapes.sphere(radius=R)])


def drawn(friction: object, way: float, steps: int, law: object = None) -> list[cg.State]:
    """A ball pressed into a flat pad and drawn along it, each in equal steps; states of the way."""
    law = cg.ForceLaw(STIFFNESS) if law is None else law
    contact = cg.Contact(BALL, PAD, law=law, friction=friction)  # type: ignore[arg-type]
    state = contact.start(PAD.points, pose.translation([0.0, 0.0, R]))
    for z in np.linspace(0.0, -DEPTH, steps + 1)[1:]:
        state = contact.step(state, PAD.points, pose.translation([0.0, 0.0, R + z]), 0.1)
    states = [state]
    for x in np.linspace(0.0, way, steps + 1)[1:]:
        X_WB = pose.translation([x, 0.0, R - DEPTH])
        states.append(contact.step(states[-1], PAD.points, X_WB, 0.1))
    return states


def test_a_ball_that_slides_feels_all_of_its_friction_from_node_to_node() -> None:
    """Nodes are 0.1 apart, and the spring of the whole is full after 0.3 × 0.05."""
    normal = STIFFNESS * DEPTH
    for friction in (cg.Coulomb(MU), cg.ViscousFriction(MU, speed=1e-6)):
        states = drawn(friction, 0.4, 80)
        along = np.array([s.friction.sum(axis=0)[0] for s in states[5:]])
        np.testing.assert_allclose(along, MU * normal, rtol=0.03)


def test_a_ball_that_sticks_is_held_by_one_spring() -> None:
    states = drawn(cg.Coulomb(MU), 0.2 * MU * DEPTH, 5)
    force = [s.friction.sum(axis=0)[0] for s in states]
    expected = STIFFNESS * np.linspace(0.0, 0.2 * MU * DEPTH, 6)
    np.testing.assert_allclose(force, expected, rtol=1e-3, atol=1e-12)


def test_the_work_of_friction_is_told() -> None:
    """What was put in along the way, less what the spring holds, was lost by sliding."""
    errors = []
    for steps in (40, 80, 160):
        energy = drawn(cg.Coulomb(MU), 0.4, steps)[-1].energy
        assert energy.friction == pytest.approx(0.4 * MU * STIFFNESS * DEPTH, rel=0.05)
        errors.append(abs(energy.error) / energy.friction)
    assert errors[-1] < 1e-3
    assert errors[-1] < errors[0] / 8.0


def test_shares_of_the_thesis_keep_the_friction_of_each_point() -> None:
    law = cg.ForceLaw(STIFFNESS, share="penetration")
    state = drawn(cg.Coulomb(MU), 0.02, 4, law)[-1]
    rows = np.flatnonzero(state.normal_force)
    assert len(np.unique(state.friction_memory[rows, 6].round(9))) > 3


def test_a_contact_that_comes_back_holds_nothing_of_its_last_friction() -> None:
    contact = cg.Contact(BALL, PAD, law=cg.ForceLaw(STIFFNESS), friction=cg.Coulomb(MU))
    state = drawn(cg.Coulomb(MU), 0.4, 40)[-1]
    for z in (R + 0.01, R - DEPTH):
        state = contact.step(state, PAD.points, pose.translation([0.4, 0.0, z]), 0.1)
    assert np.abs(state.friction.sum(axis=0)[:2]).max() < 1e-9


def test_where_all_that_carried_have_left_the_way_is_that_of_those_that_carry() -> None:
    """A plate spins below the point that carries now: that does not slide, others do."""
    plane = cg.Body([cg.shapes.plane(width=4, length=4)])
    points = np.array([[0.5, 0.1, -0.02], [0.1, 0.2, -0.01], [0.9, 0.2, -0.005]])
    contact = cg.Contact(
        plane,
        cg.Slave(points, area=np.ones(3)),
        law=cg.ForceLaw(STIFFNESS),
        friction=cg.Coulomb(MU),
        search="penetration",
    )
    state = contact.start(points)
    assert np.flatnonzero(state.normal_force).tolist() == [0]
    left = points.copy()
    left[0, 2] = 0.1
    arm, angle = left[2] - left[1], 0.01
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    left[2, :2] = left[1, :2] + turn @ arm[:2]
    state = contact.step(state, left, dt=0.1)
    assert np.flatnonzero(state.normal_force).tolist() == [1]
    assert np.abs(state.friction).max() < 1e-12
