"""Nodes of what deforms that are attached to a body: its mass, its forces, its critical step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import Chain, block

import contiga as cg
from contiga.errors import InputError
from contiga.simulation.critical import limit_of

INERTIA = np.diag([4.0, 5.0, 6.0])
TOP = {"plane": [[0, 0, 3.0], [0, 0, 1]]}
RUBBER = {"material": cg.materials.NeoHooke(young=20.0, poisson=0.3), "density": 0.02}


def _simulation(slave: cg.Slave, motion: Any, carrier: Any, **options: Any) -> cg.Simulation:
    """A slave, the board that some of its nodes are attached to, and a ball far below."""
    board = cg.Body([cg.shapes.sphere(radius=1.0, centre=(1.0, 1.0, 5.0))])
    ball = cg.Body([cg.shapes.sphere(radius=10.0, centre=(0.0, 0.0, -100.0))])
    area = {} if slave.facets is not None else {"area": cg.NodalArea(1.0)}
    law = cg.PenaltyLaw(1.0, per_area=bool(slave.facets is not None))
    return cg.Simulation(
        bodies={"ball": ball, "board": (board, carrier)},
        slaves={"pad": (slave, motion)},
        contacts=[cg.Contact(ball, slave, law=law, **area)],
        **options,
    )


def _free(mass: float = 2.0, **options: Any) -> cg.motion.Free:
    return cg.motion.Free(mass=mass, inertia=INERTIA, centre=(1.0, 1.0, 4.0), **options)


def test_a_mass_on_a_spring_below_a_body_swings_as_two_masses_do() -> None:
    """Body and attached node 3 + 1, the other node 1, on a spring of 50."""
    slave = cg.Slave([[1.0, 1.0, 2.0], [1.0, 1.0, 3.0]])
    material, omega = Chain.of(slave, 1.0, 50.0), np.sqrt(50.0 * (1.0 / 4.0 + 1.0))
    motion = cg.motion.Deforming(
        material=material, attached=TOP | {"body": "board"}, velocity=[[0, 0, -0.1], [0, 0, 0]]
    )
    off = []
    for step in (0.01, 0.005):
        state = _simulation(slave, motion, _free(3.0), end=1.0, step=step).run().state
        length = np.ptp(state.slaves["pad"].points[:, 2]) - 1.0
        off.append(abs(length - 0.1 / omega * np.sin(omega)))
        both = 4.0 * state.bodies["board"].twist.velocity[2] + state.slaves["pad"].velocities[0, 2]
        assert both == pytest.approx(-0.1, abs=1e-12)
    assert off[0] < 1e-4
    assert off[1] < off[0] / 3.5


def test_momenta_stay_and_the_ledger_closes_while_board_and_pad_tumble() -> None:
    slave, spin = block((1, 1, 2), (2.0, 2.0, 3.0)), np.array([0.3, -0.2, 0.4])
    centre = np.array([1.0, 1.0, 4.0])
    velocity = np.cross(spin, slave.points - centre)
    motion = cg.motion.Deforming(attached=TOP | {"body": "board"}, velocity=velocity, **RUBBER)
    errors = []
    for step in (0.01, 0.005):
        simulation = _simulation(slave, motion, _free(spin=spin), end=2.0, step=step)
        system = simulation.mechanism
        result = simulation.run()
        states = [simulation.start(), result.state]
        apart = ~np.isclose(slave.points[:, 2], 3.0)
        mass = system.nodes["pad"].mass[apart]
        linear, angular = [], []
        for state in states:
            row, fixed = state.rigid[0], system.fixed[0]
            x, v = (part[apart] for part in state.slaves["pad"])
            linear.append(fixed[0] * row[7:10] + (mass[:, None] * v).sum(axis=0))
            of_body = row[10:13] + fixed[0] * np.cross(row[:3], row[7:10])
            angular.append(of_body + (mass[:, None] * np.cross(x, v)).sum(axis=0))
        np.testing.assert_allclose(linear[1], linear[0], atol=1e-12)
        np.testing.assert_allclose(angular[1], angular[0], atol=1e-12)
        history = result.history
        errors.append(np.abs(history["energy.error"]).max() / history["energy.total"][0])
    assert errors[0] < 1e-3
    assert errors[1] < errors[0] / 3.5


def test_a_board_carries_the_mass_of_a_pad_that_is_wholly_attached() -> None:
    slave = block((1, 1, 2), (2.0, 2.0, 3.0))
    motion = cg.motion.Deforming(attached={"body": "board"}, **RUBBER)
    system = _simulation(slave, motion, _free(), end=1.0, step=0.01).mechanism
    mass = system.nodes["pad"].mass
    total = 2.0 + mass.sum()
    assert system.fixed[0, 0] == pytest.approx(total)
    centre = (2.0 * np.array([1.0, 1.0, 4.0]) + mass @ slave.points) / total
    np.testing.assert_allclose(system.fixed[0, 1:4], centre)
    arms = slave.points - centre
    whole = INERTIA + sum(
        m * ((r @ r) * np.eye(3) - np.outer(r, r))
        for m, r in [(2.0, np.array([1.0, 1.0, 4.0]) - centre), *zip(mass, arms, strict=True)]
    )
    np.testing.assert_allclose(np.sort(system.fixed[0, 13:16]), np.linalg.eigvalsh(whole))


def test_a_board_that_a_motion_moves_does_the_work_on_the_pad() -> None:
    slave = block((1, 1, 2), (2.0, 2.0, 3.0))
    up = cg.motion.Translate([[0.0, 0, 0, 0], [2.0, 0, 0, 0.4]])
    fixed = {"plane": [[0, 0, 0], [0, 0, 1]]}
    runs = [
        _simulation(slave, cg.motion.Deforming(fixed=fixed, **one, **RUBBER), up, end=1, step=0.01)
        for one in ({"attached": TOP | {"body": "board"}}, {"driven": TOP | {"motion": up}})
    ]
    attached, driven = (simulation.run() for simulation in runs)
    np.testing.assert_array_equal(
        attached.state.slaves["pad"].points, driven.state.slaves["pad"].points
    )
    np.testing.assert_allclose(
        attached.history["energy.external"], driven.history["energy.external"], atol=1e-12
    )
    assert attached.history["energy.external"][-1] > 0.1


def test_weight_and_pressure_on_attached_nodes_move_the_board() -> None:
    """All of it attached: a rigid body of both masses, under both loads."""
    slave = block((1, 1, 1), (2.0, 2.0, 3.0))
    push = cg.motion.NodalForce([0.6, 0.0, 0.0])
    motion = cg.motion.Deforming(attached={"body": "board"}, loads=push, **RUBBER)
    carrier = cg.motion.Free(mass=2.0, hold=["rx", "ry", "rz"])
    simulation = _simulation(slave, motion, carrier, end=1.0, step=0.01, gravity=[0, 0, -2.0])
    result = simulation.run()
    mass = 2.0 + 0.02 * 12.0
    velocity = result.state.bodies["board"].twist.velocity
    np.testing.assert_allclose(velocity, [0.6 / mass, 0.0, -2.0], atol=1e-12)
    np.testing.assert_allclose(result.history["energy.error"], 0.0, atol=1e-12)


def test_a_light_board_on_a_stiff_pad_shortens_the_critical_step() -> None:
    slave = cg.Slave([[1.0, 1.0, 2.0], [1.0, 1.0, 3.0]])
    material = Chain.of(slave, 1e-3, 50.0)
    motion = cg.motion.Deforming(
        material=material, attached=TOP | {"body": "board"}, fixed={"nodes": [0]}
    )
    carrier = cg.motion.Free(mass=1e-3, hold=["x", "y", "rx", "ry", "rz"])
    simulation = _simulation(slave, motion, carrier, end=0.01, step=1e-4)
    # ω² = 50/2e-3 by itself; the row sums of the spring's stiffness are twice as large.
    critical = limit_of(simulation, simulation.start()).critical
    assert 0.6 < critical * np.sqrt(50.0 / 2e-3) / 2.0 <= 1.0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"attached": TOP | {"body": "bord"}}, "no body of this name.*'bord'"),
        ({"attached": TOP}, "attached: body: must be the name of a body"),
        ({"attached": "board"}, r"attached\[0\]: must be tables"),
        ({"attached": {"plane": [[0, 0, 9], [0, 0, 1]], "body": "board"}}, "no node"),
        ({"attached": TOP | {"body": "board"}, "fixed": TOP}, "held, driven or attached already"),
        (
            {"attached": [TOP | {"body": "board"}, TOP | {"body": "ball"}]},
            r"attached\[1\]: .*attached already",
        ),
    ],
)
def test_what_cannot_be_attached_is_refused(options: dict[str, Any], text: str) -> None:
    slave = block((1, 1, 1), (2.0, 2.0, 3.0))
    with pytest.raises(InputError, match=text):
        _simulation(slave, cg.motion.Deforming(**options, **RUBBER), _free(), end=1, step=0.01)


def test_nodes_that_are_attached_twice_to_a_body_are_attached_once() -> None:
    slave, twice = block((1, 1, 1), (2.0, 2.0, 3.0)), [TOP | {"body": "board"}] * 2
    for attached in (twice[:1], twice):
        motion = cg.motion.Deforming(attached=attached, **RUBBER)
        simulation = _simulation(slave, motion, _free(), end=1.0, step=0.01)
        (joint,) = simulation.mechanism.nodes["pad"].joints
        assert len(joint.rows) == 4


def test_a_board_that_may_turn_needs_inertia_to_carry_a_pad() -> None:
    slave = block((1, 1, 1), (2.0, 2.0, 3.0))
    motion = cg.motion.Deforming(attached=TOP | {"body": "board"}, **RUBBER)
    with pytest.raises(InputError, match="needs mass and inertia"):
        _simulation(slave, motion, cg.motion.Free(mass=1.0, hold=["rx"]), end=1.0, step=0.01)


def test_the_velocity_given_is_that_of_the_own_centre_and_glued_nodes_have_the_body_s() -> None:
    """Written beside it for glued nodes, another is overridden, and the ledger has what moves."""
    slave, spin = block((1, 1, 2), (2.0, 2.0, 3.0)), np.array([0.3, -0.2, 0.4])
    given, own = np.array([0.1, 0.5, -0.2]), np.array([1.0, 1.0, 4.0])
    rigid, more = given + np.cross(spin, slave.points - own), np.array([0.0, 0.0, 0.7])
    glued = np.isclose(slave.points[:, 2], 3.0)
    motion = cg.motion.Deforming(attached=TOP | {"body": "board"}, velocity=rigid + more, **RUBBER)
    carrier = _free(velocity=given, spin=spin)
    simulation = _simulation(slave, motion, carrier, end=0.5, step=0.01)
    state = simulation.start()
    twist = state.bodies["board"].twist
    np.testing.assert_allclose(twist.at(np.zeros(3), own), given, atol=1e-14)
    went = np.where(glued[:, None], rigid, rigid + more)
    np.testing.assert_allclose(state.slaves["pad"].velocities, went, atol=1e-14)
    mass = simulation.mechanism.nodes["pad"].mass
    kinetic = 0.5 * (2.0 * given @ given + spin @ INERTIA @ spin + mass @ (went * went).sum(axis=1))
    assert state.energy.kinetic == pytest.approx(kinetic, rel=1e-14)
    for _ in range(5):
        state = simulation.step(state)
        pose, twist = state.bodies["board"]
        points, velocities = (part[glued] for part in state.slaves["pad"])
        np.testing.assert_allclose(velocities, twist.at(pose[:3, 3], points), atol=1e-15)


def test_what_is_held_of_a_board_stays_though_glued_nodes_shift_its_centre() -> None:
    slave = block((1, 1, 2), (2.0, 2.0, 3.0))
    motion = cg.motion.Deforming(attached=TOP | {"body": "board"}, **RUBBER)
    carrier = _free(velocity=[0.0, 0.3, 0.0], spin=[0.0, 0.2, 0.0], hold=["x"])
    system = _simulation(slave, motion, carrier, end=0.5, step=0.01).mechanism
    lower = system.fixed[0, 3] - 4.0
    assert lower < -1e-3
    # Spin about y would take the common centre along x, which is held, and leaves y as it is.
    np.testing.assert_allclose(system.start[0, 7:9], [0.0, 0.3], atol=1e-15)
