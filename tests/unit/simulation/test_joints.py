"""Joints in a simulation: checkpoints, settling, steps that choose themselves, driven bodies, the
ledger, and what `check` says."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError, RunError
from contiga.previewing.stage import stage_of
from contiga.records import FloatArray
from contiga.simulation.checks.joint_checks import joint_notes
from contiga.simulation.joints import joint_lines

from .makers import StopAfter
from .sameness import same_history, same_states

G = 9.81
Y = (0.0, 1.0, 0.0)
DAMPED = cg.JointLaw(
    [[0, 0], [0.5, 2.0], [2.0, 20.0]],
    unloading=[[0, 0], [0.5, 1.0], [2.0, 8.0]],
    hysteresis_slope=60.0,
    damping=0.05,
    friction=0.2,
    friction_slope=40.0,
)


def link(at: Sequence[float], **given: Any) -> tuple[cg.Body, Any]:
    body = cg.Body([cg.shapes.sphere(radius=0.1, centre=at)])
    motion = cg.motion.Free(1.0, inertia=np.diag([0.02, 0.1, 0.09]), centre=at, **given)
    return body, motion


def swinging(**given: Any) -> cg.Simulation:
    """Two links from the horizontal, with laws of all kinds, and a third that hangs by a spring."""
    joints = [
        cg.Joint("revolute", "ground", "upper", at=[0, 0, 0], axis=Y, angle=DAMPED, name="hip"),
        cg.Joint(
            "universal",
            "upper",
            "lower",
            at=[1, 0, 0],
            axis=[Y, [0, 0, 1]],
            angle_1=cg.JointLaw(stops=(-0.2, 0.3), stop_curve=50.0),
            angle_2=cg.JointLaw(5.0, damping=0.1),
            name="knee",
        ),
        cg.Joint("spherical", "lower", "foot", at=[2, 0, 0], axis=[1, 0, 0], cone=DAMPED),
    ]
    arguments = {
        "bodies": {
            "upper": link([0.5, 0, 0]),
            "lower": link([1.5, 0, 0], spin=[0.0, 0.0, 1.0]),
            "foot": link([2.3, 0, 0.1]),
        },
        "slaves": {},
        "contacts": [],
        "joints": joints,
        "springs": [cg.Spring(("foot", "ground"), at=[[2.3, 0, 0], [3, 0, 1]], curve=20.0)],
        "gravity": [0, 0, -G],
        "end": 0.4,
        "step": 2e-3,
        "units": ("m", "kg", "s"),
    }
    return cg.Simulation(**(arguments | given))


def test_a_resumed_run_has_the_same_bits(
    stop_after: StopAfter, stop: type[Exception], tmp_path: Path
) -> None:
    for step in (4e-3, "auto"):
        folder = tmp_path / str(step)
        whole = swinging(step=step).run()
        with pytest.raises(stop):
            swinging(step=step).run(folder, progress=stop_after(57))
        resumed = swinging(step=step).run(folder, resume=True)
        same_history(whole.history, resumed.history)
        same_states(whole.state, resumed.state)
        for one, other in zip(whole.state.joints, resumed.state.joints, strict=True):
            assert one.tobytes() == other.tobytes()


def test_the_number_of_threads_changes_no_bit() -> None:
    before, most = numba.get_num_threads(), numba.config.NUMBA_NUM_THREADS
    histories = []
    for threads in (1, most):
        numba.set_num_threads(threads)
        histories.append(swinging(end=0.1).run().history)
    numba.set_num_threads(before)
    same_history(*histories)


def test_laws_are_in_the_ledger_and_joints_do_no_work() -> None:
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        history = swinging(step=step).run().history
        errors.append(np.abs(history["energy.error"]).max())
    assert errors[-1] < 1e-4 * history["energy.kinetic"].max()
    assert np.log2(errors[0] / errors[2]) > 3.0  # second order, but for where stops begin
    for loss, of in (("hysteresis", "hip"), ("damping", "hip"), ("friction", "hip")):
        assert history[f"{of}.angle_energy_{loss}"][-1] > 0.0
        told = [column for name, column in history.items() if name.endswith(f"_energy_{loss}")]
        np.testing.assert_allclose(history[f"energy.{loss}"], sum(told), rtol=1e-12)
    stored = [column for name, column in history.items() if name.endswith("energy_stored")]
    np.testing.assert_allclose(history["energy.strain"], sum(stored), rtol=1e-12, atol=1e-15)
    assert history["knee.angle_1"].min() < -0.2  # it ran into its stop
    assert history["knee.angle_1_force"].min() < -1.0


def test_reactions_have_no_power_at_the_end_of_a_step() -> None:
    simulation = swinging()
    state = simulation.start()
    for _ in range(100):
        state = simulation.step(state)
    joints, table = state.joints, simulation.linkage.table
    assert joints is not None
    for g, (first, second) in enumerate(table.bodies.tolist()):
        power = 0.0
        for body, sign in ((first, -1.0), (second, 1.0)):
            if body >= 0:
                v, w = state.bodies.twists[body, :3], state.bodies.twists[body, 3:]
                at = v + np.cross(w, joints.points[g] - state.bodies.poses[body, :3, 3])
                power += sign * (joints.reactions[g, :3] @ at + joints.reactions[g, 3:] @ w)
        assert abs(power) <= 1e-12 * np.abs(joints.reactions).max()


def test_steps_that_choose_themselves_keep_the_energy_and_are_bound_by_stops() -> None:
    history = swinging(step="auto").run().history
    assert np.abs(history["energy.error"]).max() <= 2e-4 * history["energy.kinetic"].max()
    stiff = cg.JointLaw(stops=(-1.0, 1.0), stop_curve=1e6)
    joint = cg.Joint("revolute", "ground", "upper", at=[0, 0, 0], axis=Y, angle=stiff, name="hip")
    given = {"joints": [joint], "springs": []}
    # k over the inertia about the axis: the body alone is held at its centre as if it turned there.
    critical = 2.0 / np.sqrt(1e6 / 0.1)
    with pytest.raises(RunError, match="angle of joint 'hip'"):
        swinging(step=1.01 * critical, **given).run()
    swinging(step=0.99 * critical, end=0.01, **given).run()
    told = swinging(step="auto", end=0.1, **given).run().history
    assert np.diff(told["time"]).max() <= 0.9 * critical * (1 + 1e-12)


def crank(table_end: float, step: float) -> cg.Simulation:
    """A sled that a smooth motion drives carries a pendulum."""

    class Swing:
        """x = 0.3 sin² 4t."""

        known_ahead = True

        def pose(self, t: float) -> FloatArray:
            X = np.eye(4)
            X[0, 3] = 0.3 * np.sin(4.0 * t) ** 2
            return X

        def twist(self, t: float) -> Any:
            return cg.motion.Twist(np.array([1.2 * np.sin(8.0 * t), 0.0, 0.0]), np.zeros(3))

    sled = cg.Body([cg.shapes.sphere(radius=0.1)])
    return cg.Simulation(
        bodies={"sled": (sled, Swing()), "bob": link([0, 0, -1.0])},
        slaves={},
        contacts=[],
        joints=[cg.Joint("revolute", "sled", "bob", at=[0, 0, 0], axis=Y)],
        gravity=[0, 0, -G],
        end=table_end,
        step=step,
    )


def test_a_driven_body_does_its_work_on_what_hangs_from_it() -> None:
    errors, ends = [], []
    for step in (4e-3, 2e-3, 1e-3, 5e-4):
        history = crank(1.0, step).run().history
        errors.append(np.abs(history["energy.error"]).max())
        ends.append(history["sled-bob.angle"][-1])
    # J θ'' = −m l (g sin θ ∓ a cos θ) about the pivot.
    from scipy.integrate import solve_ivp

    def rate(t: float, s: FloatArray) -> list[float]:
        a = 9.6 * np.cos(8.0 * t)
        return [s[1], (-G * np.sin(s[0]) + a * np.cos(s[0])) / 1.1]

    exact = solve_ivp(rate, (0, 1), [0, 0], "DOP853", rtol=1e-12, atol=1e-13).y[0, -1]
    off = np.abs(np.array(ends) - exact)
    np.testing.assert_allclose(np.log2(off[:-1] / off[1:]), 2.0, atol=0.1)
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.25)
    assert history["energy.external"].max() > 0.2


def test_work_is_right_where_a_driven_body_jumps_to_another_velocity() -> None:
    """What is welded to a sled goes from 1 to 3 at once: the sled's work is that of the impulse."""
    away = cg.motion.Translate([[0, 0, 0, 0], [0.1, 0.1, 0, 0], [0.2, 0.4, 0, 0]])
    sled = cg.Body([cg.shapes.sphere(radius=0.1, centre=[0, 0, 2])])
    history = (
        swinging(
            bodies={"sled": (sled, away), "upper": link([0.5, 0, 0], velocity=[1.0, 0, 0])},
            joints=[cg.Joint("weld", "sled", "upper", at=[0, 0, 0])],
            springs=[],
            gravity=[0, 0, 0],
            end=0.2,
        )
        .run()
        .history
    )
    np.testing.assert_allclose(history["energy.kinetic"][[0, 25, 75]], [0.5, 0.5, 4.5], rtol=1e-12)
    assert abs(history["energy.error"][-1]) < 1e-9
    assert history["energy.external"][-1] == pytest.approx(4.0)


def test_a_joint_on_what_is_attached_is_one_on_what_carries_it() -> None:
    hat = cg.Body([cg.shapes.sphere(radius=0.1, centre=[0, 0, 0.5])]), cg.motion.Attached("upper")
    histories = []
    for end in ("upper", "hat"):
        pin = cg.Joint("revolute", "ground", end, at=[0, 0, 0], axis=Y, angle=DAMPED, name="pin")
        given = {"bodies": {"upper": link([0.5, 0, 0]), "hat": hat}, "springs": []}
        histories.append(swinging(joints=[pin], end=0.1, **given).run().history)
    same_history(*histories)
    assert histories[0]["pin.angle"][-1] > 0.01


def test_a_chain_comes_to_rest_where_it_hangs_and_starts_from_there() -> None:
    law = cg.JointLaw(2.0, friction=0.05, friction_slope=10.0)
    joints = [
        cg.Joint("revolute", "ground", "upper", at=[0, 0, 0], axis=Y, angle=law, name="hip"),
        cg.Joint("revolute", "upper", "lower", at=[1, 0, 0], axis=Y, name="knee"),
    ]
    simulation = swinging(
        bodies={"upper": link([0.5, 0, 0]), "lower": link([1.5, 0, 0])},
        joints=joints,
        springs=[],
        settling=cg.Settle(bodies=["upper", "lower"], tolerance=1e-6),
        end=0.05,
        step=5e-4,
    )
    state = simulation.settle()
    angle = float(state.joints.values[0])
    told = state.joints.law(0)
    # The moment of both weights about the hip is that of its law; the knee hangs straight down.
    assert told.force == pytest.approx(G * 1.5 * np.cos(angle), rel=1e-5)
    assert state.joints.values[0] + state.joints.values[1] == pytest.approx(np.pi / 2, abs=1e-5)
    assert (told.friction, told.damping, told.hysteresis) == (0.0, 0.0, 0.0)
    history = simulation.run().history
    assert np.ptp(history["hip.angle"]) < 1e-4
    np.testing.assert_allclose(history["hip.fz"], 2 * G, rtol=1e-4)


def test_what_joints_have_nothing_to_do_with_settles_beside_them() -> None:
    hip = cg.Joint("revolute", "ground", "upper", at=[0, 0, 0], axis=Y, angle=DAMPED, name="hip")
    simulation = swinging(
        bodies={"upper": link([0.5, 0, 0]), "lower": link([1.5, 0, 0], hold=["rx", "ry", "rz"])},
        joints=[hip],
        springs=[cg.Spring(("lower", "ground"), at=[[1.5, 0, 0], [1.5, 0, 1]], curve=50.0)],
        settling=cg.Settle(bodies=["lower"]),
    )
    state = simulation.settle()
    assert state.springs["lower-ground"].force == pytest.approx(G, rel=2e-3)
    assert state.joints.law(0).force == 0.0
    history = simulation.run().history
    assert history["hip.angle"][-1] > 0.5  # what was not to settle falls when the run begins


def test_a_body_that_joints_move_and_that_is_not_to_settle_is_refused() -> None:
    joints = [
        cg.Joint("spherical", "ground", "upper", at=[[0, 0, 0.1], [0, 0, 0]], name="hip"),
        cg.Joint("revolute", "upper", "lower", at=[1, 0, 0], axis=Y, name="knee"),
    ]
    given = {"bodies": {"upper": link([0.5, 0, 0]), "lower": link([1.5, 0, 0])}, "springs": []}
    with pytest.raises(InputError, match="it is not to settle"):
        swinging(joints=joints, settling=cg.Settle(bodies=["lower"]), **given)


def test_lines_of_joints_are_their_axes_where_they_are_closed() -> None:
    joints = [
        cg.Joint("revolute", "ground", "upper", at=[[0, 0, 0.1], [0, 0, 0]], axis=Y, name="hip"),
        cg.Joint("spherical", "upper", "lower", at=[1, 0, 0], name="knee"),
    ]
    given = {"bodies": {"upper": link([0.5, 0, 0]), "lower": link([1.5, 0, 0])}, "springs": []}
    simulation = swinging(joints=joints, **given)
    lines = joint_lines(simulation)
    size = simulation.bodies["upper"].body.size
    np.testing.assert_allclose(
        lines["hip"], [[[0, -size / 2, 0.1], [0, size / 2, 0.1]]], atol=1e-12
    )
    knee = simulation.start().joints.points[1]
    np.testing.assert_allclose(lines["knee"].mean(axis=1), np.tile(knee, (3, 1)), atol=1e-12)
    np.testing.assert_allclose(np.ptp(lines["knee"], axis=1), size * np.eye(3), atol=0.1 * size)
    assert {tie.name: tie.kind for tie in stage_of(simulation).ties} == {
        "hip": "joint",
        "knee": "joint",
    }


def test_a_sensor_between_bodies_of_a_joint_measures_its_coordinates() -> None:
    sensor = cg.RelativeSensor("elbow", ("upper", "lower"), at=[[1, 0, 0], [1, 0, 0]])
    joints = [
        cg.Joint("revolute", "ground", "upper", at=[0, 0, 0], axis=Y, name="hip"),
        cg.Joint("revolute", "upper", "lower", at=[1, 0, 0], axis=Y, name="knee"),
    ]
    given = {"bodies": {"upper": link([0.5, 0, 0]), "lower": link([1.5, 0, 0])}, "springs": []}
    history = swinging(joints=joints, sensors=[sensor], **given).run().history
    np.testing.assert_allclose(history["elbow.distance"], 0.0, atol=1e-12)
    np.testing.assert_allclose(history["elbow.angle_y"], history["knee.angle"], atol=1e-10)
    assert abs(history["knee.angle"]).max() > 0.05


def test_check_tells_of_what_joints_move_and_notes_rows_that_follow_from_others() -> None:
    assert not [one for one in swinging().check() if one.rule == "joint"][1:]
    assert not joint_notes(swinging())
    joints = [
        cg.Joint("spherical", "ground", "upper", at=[[0, 0, 0.1], [0, 0, 0]], name="hip"),
        cg.Joint("weld", "upper", "lower", at=[1, 0, 0], name="one"),
        cg.Joint("spherical", "upper", "lower", at=[1, 0, 0], name="two"),
    ]
    given = {
        "bodies": {
            "upper": link([0.5, 0, 0]),
            "lower": link([1.5, 0, 0], velocity=[0, 2.0, 0]),
        },
        "springs": [],
    }
    found = swinging(joints=joints, **given).check()
    texts = [str(one) for one in found if one.rule == "joint"]
    assert len(texts) == 2
    assert "moves 2 free bodies from the places given" in texts[0]
    assert "do not allow the velocities and spins" in texts[1]
    [note] = joint_notes(swinging(joints=joints, **given))
    assert note.startswith("joints one, two: 3 of their constraints follow from the others")
    at_rest = [one for one in swinging(**given, joints=joints[1:2]).check() if one.rule == "joint"]
    assert len(at_rest) == 1


def test_initial_velocities_are_made_to_fit() -> None:
    state = swinging().start()
    moving = {"ground": np.zeros(3)}
    for g, (first, second) in enumerate((("ground", "upper"), ("upper", "lower"))):
        for name in (first, second):
            if name != "ground":
                (velocity, spin), pose = state.bodies[name].twist, state.bodies[name].pose
                arm = state.joints.points[g] - pose[:3, 3]
                moving[name] = velocity + np.cross(spin, arm)
        np.testing.assert_allclose(moving[first], moving[second], atol=1e-14)
    # The spin that was given goes on, but for what it takes to set the links in motion.
    assert 0.1 < state.bodies["lower"].twist.spin[2] < 0.9


@pytest.mark.parametrize(
    ("joint", "what"),
    [
        (cg.Joint("weld", "upper", "nobody", at=[0, 0, 0]), "no body of this name is there"),
        (cg.Joint("weld", "upper", "lower", at=[0, 0, 0], name="upper"), "name of its own"),
        (cg.Joint("weld", "wall", "ground", at=[0, 0, 0]), "no force moves either"),
        (cg.Joint("weld", "upper", "hat", at=[0, 0, 0]), "attached to the other"),
        (
            cg.Joint("spherical", "held", "ground", at=[[9, 0, 0], [9, 0, 0.5]], name="far"),
            r"cannot be closed at the start: a misfit of 0\.5 ",
        ),
    ],
    ids=["nobody", "name", "still", "attached", "far"],
)
def test_joints_that_cannot_be_are_refused_by_name(joint: cg.Joint, what: str) -> None:
    still = ["x", "y", "z", "rx", "ry", "rz"]
    wall = cg.Body([cg.shapes.sphere(radius=0.1, centre=[3, 0, 0])])
    with pytest.raises(InputError, match=what) as told:
        swinging(
            bodies={
                "upper": link([0.5, 0, 0]),
                "lower": link([1.5, 0, 0]),
                "held": link([9, 0, 0], hold=still),
                "wall": wall,
                "hat": (wall, cg.motion.Attached("upper")),
            },
            joints=[joint],
            springs=[],
        )
    assert joint.name in str(told.value)


def test_driven_bodies_that_pull_a_joint_apart_end_the_run() -> None:
    away = cg.motion.Translate([[0, 0, 0, 0], [1, 3, 0, 0]])
    sled = cg.Body([cg.shapes.sphere(radius=0.1, centre=[1, 0, 0])])
    joints = [
        cg.Joint("spherical", "ground", "upper", at=[0, 0, 0]),
        cg.Joint("spherical", "upper", "sled", at=[1, 0, 0], name="hook"),
    ]
    with pytest.raises(RunError, match="does not close"):
        swinging(
            bodies={"upper": link([0.5, 0, 0]), "sled": (sled, away)}, joints=joints, springs=[]
        ).run()
