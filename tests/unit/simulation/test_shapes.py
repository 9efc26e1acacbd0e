"""Simulations of bodies that change their shape as a table says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError


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


@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.2, stiffness=5.0)])
def test_the_ledger_counts_the_work_of_the_motion_to_second_order(friction: Any) -> None:
    errors = []
    for step in (0.04, 0.02):
        result = breathing(step, friction=friction).run()
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
        ({"shell_thickness": None}, r"bodies\['ball'\]: motion.*a closed solid that changes"),
        ({"step": "auto"}, "steps that choose themselves do not foresee"),
    ],
)
def test_what_cannot_be_is_refused(change: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        breathing(**change)


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
