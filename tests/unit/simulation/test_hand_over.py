"""Points that share one force: by how much they hand it on early or late."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from tests.scenes import box
from tests.unit.simulation.test_step_size import G, grid

import contiga as cg
from contiga.dynamics.stepping import AutoSteps, GivenTimes
from contiga.simulation.critical import limit_of


def pair(apart: float, **time: object) -> cg.Simulation:
    """Two nodes that fall on a block whose law has one force for both, one after the other."""
    points = np.array([[-0.5, 0.0, 0.01], [0.5, 0.0, 0.01 + apart]])
    slave = cg.Slave(points, mass=np.ones(2), area=np.ones(2))
    block = box((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0))
    return cg.Simulation(
        bodies={"block": block},
        slaves={"pair": (slave, cg.motion.Free(velocity=[0.0, 0.0, -1.0]))},
        contacts=[cg.Contact(block, slave, law=cg.ForceLaw(1e3))],
        **time,
    )


def rod(apart: float, **time: object) -> cg.Simulation:
    """The same two points at the ends of a rod that falls."""
    points = np.array([[-0.5, 0.0, 0.01], [0.5, 0.0, 0.01 + apart]])
    slave = cg.Slave(points, area=np.ones(2))
    block = box((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0))
    body = box((-0.5, -0.1, 0.02), (0.5, 0.1, 0.1))
    motion = cg.motion.Free(body.mass_properties(2.0 / 0.016), velocity=[0.0, 0.0, -1.0])
    return cg.Simulation(
        bodies={"block": block, "rod": (body, motion)},
        slaves={"ends": (slave, cg.motion.Attached("rod"))},
        contacts=[cg.Contact(block, slave, law=cg.ForceLaw(1e3))],
        **time,
    )


def handed_on(history: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Times at which the moment goes through zero, and the steps in which it does."""
    time, moment = history["time"], history["moment_y"]
    at = np.flatnonzero(moment[1:] * moment[:-1] < 0.0)
    share = moment[at] / (moment[at] - moment[at + 1])
    return time[at] + share * np.diff(time)[at], at + 1


def told(result: cg.Result) -> list[str]:
    return [text for text in result.summary["warnings"] if text.startswith("step: ")]


@pytest.mark.full
def test_each_hand_over_is_off_by_no_more_than_is_said() -> None:
    result = pair(0.001, end=0.09, step="auto").run()
    times = result.history["time"]
    parts = [np.linspace(a, b, 4)[1:] for a, b in itertools.pairwise(times)]
    fine = pair(0.001, stepping=GivenTimes(np.concatenate([times[:1], *parts]))).run()
    own, steps = handed_on(result.history)
    late = result.history["step.late"][steps]
    assert len(own) == 6
    read = 0.01 * np.diff(times)[steps - 1]  # forces do not change along straight lines
    assert (np.abs(own - handed_on(fine.history)[0]) < late + read).all()
    assert (np.diff(late) > 0.0).all()  # each multiplies what was wrong before it
    assert late[-1] < 1e-3


def test_a_rigid_body_hands_a_force_from_end_to_end_within_what_is_said() -> None:
    result = rod(0.001, end=0.06, step="auto").run()
    times = result.history["time"]
    parts = [np.linspace(a, b, 4)[1:] for a, b in itertools.pairwise(times)]
    fine = rod(0.001, stepping=GivenTimes(np.concatenate([times[:1], *parts]))).run()
    own, steps = handed_on(result.history)
    off = np.abs(own - handed_on(fine.history)[0])
    late = result.history["step.late"][steps]
    assert len(own) > 2
    assert (off < late + 0.01 * np.diff(times)[steps - 1]).all()


def test_hand_overs_that_are_off_by_more_than_a_step_are_told() -> None:
    (text,) = told(pair(0.001, end=0.11, step="auto").run())
    assert "share one force hand it on up to" in text
    assert float(text.split("time.largest of ")[1].split(" ")[0]) < 0.11 / 200
    assert not told(pair(0.01, end=0.11, step="auto").run())


def test_nodes_that_fall_flat_share_a_force_and_hand_nothing_on() -> None:
    result = pair(0.0, end=0.05, step="auto").run()
    assert result.history["force"].max() > 30.0
    assert not result.history["step.late"].any()
    assert not told(result)


@pytest.mark.parametrize("steps", [20, 150])
def test_a_swing_of_points_that_share_a_force_is_told_once_it_is_out_of_phase(steps: int) -> None:
    """A box rocks on a bed that bears it with one force. Each step of 0.2/ω is 3e-4 rad off."""

    def rocking(**time: object) -> cg.Simulation:
        block, mass, stiff = box((-0.2, -0.2, 0.0), (0.2, 0.2, 0.1)), 10.0, 1e4
        deep = mass * G / stiff / 1.004**2
        bed = cg.Slave(grid(5, 0.18, deep), area=np.full(25, 1e-3))
        motion = cg.motion.Free(block.mass_properties(mass / 0.016), spin=[0.01, 0.02, 0.0])
        contact = cg.Contact(block, bed, law=cg.ForceLaw(stiff), search="penetration")
        return cg.Simulation(
            bodies={"block": (block, motion)}, slaves={"bed": bed}, contacts=[contact],
            gravity=[0.0, 0.0, -G], **time,
        )  # fmt: skip

    simulation = rocking(end=1.0, step="auto")
    step = 0.1 * limit_of(simulation, simulation.start()).critical
    result = rocking(stepping=AutoSteps(0.0, steps * step, largest=step)).run()
    lag = result.history["step.lag"].sum()
    assert lag == pytest.approx(0.2**3 / 24.0 * steps, rel=0.3)
    assert any(f"{lag:.2g} rad off" in text for text in told(result)) == (steps > 100)
