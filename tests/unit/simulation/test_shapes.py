"""Simulations of bodies that change their shape as a table says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.errors import ContigaError, InputError
from contiga.matter.iga import assemble_shell
from contiga.simulation import step_size


def breathing(step: Any = 0.01, **options: Any) -> cg.Simulation:
    """A ball that breathes in and out once pushes 30 free points away."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    rest = ball.net.points
    way = np.random.default_rng(3).standard_normal((30, 3))
    slave = cg.Slave(1.2 * way / np.linalg.norm(way, axis=1)[:, None], area=np.ones(30))
    motion = cg.motion.ControlPoints([0.0, 1.0, 2.0], [rest, 1.4 * rest, rest])
    how = {"law": cg.PenaltyLaw(20.0), "shell_thickness": 0.2} | options
    contact = cg.Contact(ball, slave, **how)
    return cg.Simulation(
        bodies={"ball": (ball, motion)},
        slaves={"cloud": (slave, cg.motion.Free(0.05))},
        contacts=[contact],
        end=2.0,
        step=step,
    )


@pytest.mark.parametrize(
    "options", [{}, {"friction": cg.Coulomb(0.2, stiffness=5.0)}, {"shell_thickness": None}]
)
def test_the_ledger_counts_the_work_of_the_motion_to_second_order(options: dict[str, Any]) -> None:
    errors = []
    for step in (0.04, 0.02):
        result = breathing(step, **options).run()
        history = result.history
        came_in = history["energy.external"][-1]
        assert came_in > 0.1
        errors.append(np.abs(history["energy.error"]).max() / came_in)
        assert history["energy.kinetic"][-1] == pytest.approx(came_in, rel=0.05)
    assert errors[1] < 2e-2
    assert errors[0] > 3.0 * errors[1]


def test_a_body_that_pushes_points_that_stand_is_counted_too() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    slave = cg.Slave([[0.0, 0.0, 1.2]], area=[1.0])
    rest = ball.net.points
    simulation = cg.Simulation(
        bodies={"ball": (ball, cg.motion.ControlPoints([0.0, 1.0], [rest, 1.2 * rest]))},
        slaves={"point": slave},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(20.0), shell_thickness=0.2)],
        end=1.0,
        step=0.01,
    )
    state = simulation.start()
    for _ in range(100):
        state = simulation.step(state)
    stored = 0.5 * 20.0 * 0.1**2  # half of 0.2 reaches 0.1 deeper than where the ball ends
    assert state.energy.contact == pytest.approx(stored, rel=1e-9)
    assert state.energy.external == pytest.approx(stored, rel=1e-3)


def test_fields_have_the_body_in_its_shape(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    breathing(0.1).run(tmp_path / "out")
    (path,) = (tmp_path / "out").glob("*.vtkhdf")
    with h5py.File(path) as file:
        points = np.asarray(file["VTKHDF/Points"])
        steps = int(file["VTKHDF/Steps"].attrs["NSteps"])
        part = np.asarray(file["VTKHDF/PointData/part"])
    points = points.reshape(steps, -1, 3)
    on_ball = part[: points.shape[1]] == 0
    radius = np.linalg.norm(points[:, on_ball], axis=2)
    np.testing.assert_allclose(radius[10], 1.4, rtol=1e-6)
    np.testing.assert_allclose(radius[-1], 1.0, rtol=1e-6)


def test_a_run_that_was_stopped_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    simulation = breathing(0.1)
    state = simulation.start()
    states = [state]
    for _ in range(12):
        state = simulation.step(state)
        states.append(state)
    again = states[6]
    for k in range(7, 13):
        again = simulation.step(again)
        np.testing.assert_array_equal(
            again.contacts[next(iter(again.contacts))].control_force,
            states[k].contacts[next(iter(states[k].contacts))].control_force,
        )


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            {"shell_thickness": None, "foot": "tracked"},
            r"bodies\['ball'\]: motion.*feet are not followed",
        ),
    ],
)
def test_what_cannot_be_is_refused(change: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        breathing(**change)


def test_steps_that_choose_themselves_follow_a_table() -> None:
    history = breathing("auto").run().history
    came_in = history["energy.external"][-1]
    assert came_in > 0.1
    assert np.abs(history["energy.error"]).max() < 2e-3 * came_in
    assert len(history["time"]) < 1000


def test_no_step_takes_a_wall_past_a_point() -> None:
    """A sheet that comes up at 100 a time, beside points at rest: in one step of a tenth of the run
    it would have gone 100."""
    sheet = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    rest, up = sheet.net.points, np.array([0.0, 0.0, 1.0])
    motion = cg.motion.ControlPoints([0.0, 1.0, 10.0], [rest, rest + 100.0 * up, rest + 100.0 * up])
    slave = cg.Slave([[0.3, 0.2, 50.0], [-0.7, 0.1, 60.0]], area=np.ones(2))
    simulation = cg.Simulation(
        bodies={"sheet": (sheet, motion)},
        slaves={"points": (slave, cg.motion.Free(1e-3))},
        contacts=[cg.Contact(sheet, slave, law=cg.PenaltyLaw(1e6), shell_thickness=0.02)],
        end=10.0,
        step="auto",
    )
    state = simulation.start()
    while state.time < 1.0:
        state = simulation.step(state)
    assert (state.slaves["points"].points[:, 2] > 100.0).all()


def test_points_beside_a_shape_that_changes_go_half_a_thickness_at_most() -> None:
    """Or as far as is known to be free: so none is behind the wall and out of its reach at once."""
    sheet = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    slave = cg.Slave([[0.3, 0.2, 0.012], [-0.7, 0.1, 0.51]], area=np.ones(2))
    simulation = cg.Simulation(
        bodies={"sheet": (sheet, cg.motion.ControlPoints([0.0], [sheet.net.points]))},
        slaves={"points": (slave, cg.motion.Free(1e-3))},
        contacts=[cg.Contact(sheet, slave, law=cg.PenaltyLaw(1.0), shell_thickness=0.02)],
        end=1.0,
        step="auto",
    )
    (part,), (before,) = simulation.contacts, simulation.start().contacts.values()
    room = step_size._allowed_travel(simulation, part, before, np.full(2, 10.0))
    np.testing.assert_allclose(room, [0.01, 0.5], atol=1e-6)


def test_what_settles_comes_to_rest_on_the_shape_of_the_start() -> None:
    plate = cg.Body([cg.shapes.plane(width=8.0, length=8.0)])
    raised = plate.net.points + np.array([0.0, 0.0, 3.0])
    cube = block((2, 2, 2), (2.0, 2.0, 2.0), kind="hexahedron")
    slave = cube.transformed(cg.motion.pose.translation([0.0, 0.0, 3.15 - cube.points[:, 2].min()]))
    rubber = cg.materials.Elastic(young=1.0)
    contact = cg.Contact(
        plate, slave, law=cg.PenaltyLaw(0.1), shell_thickness=0.4, search="penetration", depth=0.2
    )
    simulation = cg.Simulation(
        bodies={"plate": (plate, cg.motion.ControlPoints([0.0, 9.0], [raised, plate.net.points]))},
        slaves={"cube": (slave, cg.motion.Deforming(material=rubber, density=1e-3))},
        contacts=[contact],
        gravity=[0.0, 0.0, -0.5],
        end=1.0,
        step=0.01,
        settling=cg.Settle(tolerance=1e-4),
    )
    state = simulation.settle()
    (touched,) = state.contacts.values()
    assert touched.total_force[2] == pytest.approx(8.0 * 1e-3 * 0.5, rel=1e-3)
    feet = touched.foot[touched.in_contact, 2]
    np.testing.assert_allclose(feet, 3.2, atol=1e-9)  # half a thickness above the raised plate


def test_a_shell_that_is_a_master_comes_to_rest_under_what_lies_on_it() -> None:
    plate = plate_of(20.0)
    body, slave = cg.Body([plate]), cg.Slave(surfaces=[plate])
    edges = [{"edge": edge} for edge in ("u0", "u1", "v0", "v1")]
    dust = cg.Slave([[x, y, 0.4] for x in (-2.0, 0.0, 2.0) for y in (-2.0, 2.0)], area=np.ones(6))
    held = cg.motion.Deforming(material=STEEL, density=1e-3, thickness=1.0, fixed=edges)
    contact = cg.Contact(
        body, dust, law=cg.PenaltyLaw(5.0), shell_thickness=1.0, search="penetration", depth=0.5
    )
    simulation = cg.Simulation(
        bodies={"upper side": (body, cg.motion.ControlPointsOf("plate"))},
        slaves={"plate": (slave, held), "dust": dust},
        contacts=[contact],
        end=1.0,
        step="auto",
        settling=cg.Settle(tolerance=1e-4),
    )
    state = simulation.settle()
    (touched,) = state.contacts.values()
    assert state.rest.residual <= 1e-4
    assert touched.n_contact == 6
    assert state.slaves["plate"].points[:, 2].min() < -1e-3
    before = touched.total_force[2]
    for _ in range(20):
        state = simulation.step(state)
    (touched,) = state.contacts.values()
    assert touched.total_force[2] == pytest.approx(before, rel=1e-3)


def test_steps_that_choose_themselves_follow_a_shell_that_is_a_master() -> None:
    simulation = falling_masses("auto")
    state, steps, error, touched = simulation.start(), 0, 0.0, 0
    while state.time < 1.0:
        state = simulation.step(state)
        steps, error = steps + 1, max(error, abs(state.energy.error))
        touched = max(touched, next(iter(state.contacts.values())).n_contact)
    assert touched == 81
    assert error < 1e-3 * state.energy.initial
    assert steps < 500


def test_a_table_for_another_body_is_refused() -> None:
    ball, slave = cg.Body([cg.shapes.sphere(radius=1.0)]), cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    motion = cg.motion.ControlPoints([0.0], [np.zeros((5, 3))])
    with pytest.raises(InputError, match=r"bodies\['ball'\]: motion.*one row a control point"):
        cg.Simulation(
            bodies={"ball": (ball, motion)},
            slaves={"point": slave},
            contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0), shell_thickness=0.1)],
            end=1.0,
            step=0.1,
        )


def plate_of(width: float, height: float = 0.0) -> cg.NurbsSurface:
    parts = [k / 4 for k in range(1, 4)]
    plate = cg.shapes.plane(width=width, length=width, centre=(0.0, 0.0, height))
    return plate.k_refined((1, 1), parts, parts)


STEEL = cg.materials.Elastic(young=2000.0, poisson=0.3)


def falling_masses(step: Any, friction: Any = None, law: float = 20.0) -> cg.Simulation:
    """81 masses fall on a free shell of splines, sideways as well."""
    plate = plate_of(100.0)
    shell = assemble_shell([plate], material=STEEL, density=1e-3, thickness=1.0)
    slave = cg.Slave.of(shell)
    grid = np.stack(np.meshgrid(*[np.linspace(-14.0, 14.0, 9)] * 2), axis=-1).reshape(-1, 2)
    dust = cg.Slave(np.column_stack([grid, np.full(81, 0.7)]), area=np.full(81, 10.0))
    body = cg.Body([plate])
    contact = cg.Contact(body, dust, law=cg.PenaltyLaw(law), shell_thickness=1.0, friction=friction)
    return cg.Simulation(
        bodies={"upper side": (body, cg.motion.ControlPointsOf("plate"))},
        slaves={
            "plate": (slave, cg.motion.Deforming(material=shell)),
            "dust": (dust, cg.motion.Free(30.0 / 81, velocity=(0.5, 0.0, -2.0))),
        },
        contacts=[contact],
        end=1.5,
        step=step,
    )


def momentum_of(simulation: cg.Simulation, state: cg.SystemState) -> np.ndarray:
    """(6,) momentum and moment of momentum of all slaves."""
    total = np.zeros(6)
    for name, mover in simulation.mechanism.nodes.items():
        slave = state.slaves[name]
        points, speeds, mass = slave.points, slave.velocities, mover.mass
        if "q" in slave.matter:
            points, speeds = slave.matter["q"], slave.matter["q_velocity"]
            mass = mover.matter.mass
        each = np.asarray(mass)[:, None] * speeds
        total += np.concatenate([each.sum(axis=0), np.cross(points, each).sum(axis=0)])
    return total


@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.3, stiffness=5.0)])
def test_a_shell_is_a_master_of_masses_and_what_is_closed_keeps_its_own(friction: Any) -> None:
    errors = []
    for step in (0.008, 0.004):
        simulation = falling_masses(step, friction)
        state = simulation.start()
        before, touched, error, drift = momentum_of(simulation, state), 0, 0.0, 0.0
        while state.time < 1.0:
            state = simulation.step(state)
            touched = max(touched, next(iter(state.contacts.values())).n_contact)
            error = max(error, abs(state.energy.error))
            drift = max(drift, np.abs(momentum_of(simulation, state) - before).max())
        assert touched == 81
        assert drift < 1e-9  # of 6,000 g mm²/ms
        errors.append(error / state.energy.initial)
    assert errors[1] < 1e-3
    assert errors[0] > 3.0 * errors[1]


def test_steps_are_refused_that_the_shell_as_a_master_cannot_take() -> None:
    stiff = falling_masses(0.008, law=4000.0)
    with pytest.raises(ContigaError, match=r"critical|stable|0\.00"):
        stiff.run()


def colliding_shells(step: float) -> cg.Simulation:
    """Two free shells, each master and slave of the other: half of the law each way, and half a
    thickness of both between their mid-surfaces."""
    plates = {"low": plate_of(40.0), "high": plate_of(30.0, 1.2).flipped()}
    bodies, slaves, contacts = {}, {}, []
    for name in ("low", "high"):
        shell = assemble_shell([plates[name]], material=STEEL, density=1e-3, thickness=1.0)
        falls = (0.3, 0.1, -2.0 if name == "high" else 0.0)
        bodies[f"{name} side"] = cg.Body([plates[name]]), cg.motion.ControlPointsOf(name)
        slaves[name] = cg.Slave.of(shell), cg.motion.Deforming(material=shell, velocity=falls)
    for name, other in (("low", "high"), ("high", "low")):
        contacts.append(
            cg.Contact(
                bodies[f"{name} side"][0],
                slaves[other][0],
                law=cg.PenaltyLaw(2.5, per_area=True),
                shell_thickness=2.0,
                on_edge="hold",
            )
        )
    return cg.Simulation(bodies=bodies, slaves=slaves, contacts=contacts, end=1.0, step=step)


def test_two_shells_are_each_master_and_slave_of_the_other() -> None:
    simulation = colliding_shells(0.002)
    state = simulation.start()
    before, most = momentum_of(simulation, state), np.zeros(2)
    while state.time < 1.0 - 1e-9:
        state = simulation.step(state)
        forces = np.array([one.total_force[2] for one in state.contacts.values()])
        most = np.maximum(most, np.abs(forces))
        error = state.energy.error / state.energy.initial
        assert abs(error) < 5e-3
    np.testing.assert_allclose(momentum_of(simulation, state), before, rtol=0, atol=1e-9)
    assert most.min() > 0.3 * most.max() > 1.0  # both ways about half of it
    assert state.slaves["low"].velocities[:, 2].mean() < -0.5
    assert all(one.n_unproved == 0 for one in state.contacts.values())


@pytest.mark.parametrize(
    "motion", [cg.motion.ControlPointsOf("dust"), cg.motion.ControlPoints([0.0], [[[0.0] * 3]])]
)
def test_points_of_a_slave_are_no_control_points(motion: Any) -> None:
    body, slave = cg.Body([cg.shapes.plane()]), cg.Slave([[0.0, 0.0, 1.0]], area=[1.0])
    contact = cg.Contact(body, slave, law=cg.PenaltyLaw(1.0), shell_thickness=0.1)
    with pytest.raises(InputError, match=r"slaves\['dust'\]: motion: only bodies have control"):
        cg.Simulation(
            bodies={"plate": body}, slaves={"dust": (slave, motion)}, contacts=[contact], end=1.0
        )


@pytest.mark.parametrize(
    ("slave", "told"),
    [
        ("nobody", r"bodies\['upper side'\]: motion: names a slave that is not there"),
        ("dust", "only a slave that deforms as a shell of splines"),
    ],
)
def test_slaves_without_control_points_are_refused(slave: str, told: str) -> None:
    model = falling_masses(0.01)
    bodies = {"upper side": (model.bodies["upper side"].body, cg.motion.ControlPointsOf(slave))}
    with pytest.raises(InputError, match=told):
        cg.Simulation(
            bodies=bodies,
            slaves={name: tuple(part) for name, part in model.slaves.items()},
            contacts=[part.contact for part in model.contacts],
            end=1.0,
            step=0.01,
        )
