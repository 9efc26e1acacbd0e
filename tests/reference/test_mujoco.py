"""The same collision through MuJoCo and through contiga's own integrator; what closed forms say."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full
from tests.scenes import square_sheet

import contiga as cg
from contiga.couple import MujocoCoupling

mujoco = pytest.importorskip("mujoco")

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
VELOCITY, SPIN = [0.4, 0.1, -1.0], [0.3, 0.5, -0.2]
ROUND = (0.8, 0.8, 0.8)
FLAT = (2.0, 3.0, 4.5)
STRESS = cg.StressLaw(200.0, thickness=0.5)
DAMPED = cg.StressLaw(200.0, thickness=0.5, damping=2.0)


def scene(law: cg.StressLaw, friction: cg.Coulomb | None) -> tuple[cg.Slave, cg.Contact]:
    """The ball just above a sheet, whose middle is not that of what carries it."""
    points, quads = square_sheet(3.0, 13)
    sheet = cg.Slave(points + np.array([0.2, 0.1, -1.01]), quads)
    return sheet, cg.Contact(BALL, sheet, law=law, friction=friction)


def by_mujoco(
    step: float,
    law: cg.StressLaw = STRESS,
    friction: cg.Coulomb | None = None,
    *,
    plate: tuple[float, float, float] = FLAT,
    integrator: str = "Euler",
) -> dict[str, np.ndarray]:
    """History of a ball of mass 2 that falls on a free plate of mass 5."""
    text = f"""<mujoco><option gravity="0 0 0" timestep="{step!r}" integrator="{integrator}"/>
    <worldbody>
    <body name="ball"><freejoint/>
      <inertial pos="0 0 0" mass="2" diaginertia="{" ".join(map(str, ROUND))}"/></body>
    <body name="plate"><freejoint/>
      <inertial pos="0 0 0" mass="5" diaginertia="{" ".join(map(str, plate))}"/></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:6] = VELOCITY + SPIN
    sheet, contact = scene(law, friction)
    coupling = MujocoCoupling(
        model,
        data,
        masters={"ball": BALL},
        slaves={"sheet": (sheet, "plate")},
        contacts=[contact],
    )
    return coupling.run(1.0).history


def by_contiga(
    step: float, law: cg.StressLaw = STRESS, friction: cg.Coulomb | None = None
) -> dict[str, np.ndarray]:
    """The same by `contiga.Simulation`; the plate's own shape touches nothing."""
    sheet, contact = scene(law, friction)
    free = cg.motion.Free
    return (
        cg.Simulation(
            bodies={
                "ball": (BALL, free(2.0, inertia=np.diag(ROUND), velocity=VELOCITY, spin=SPIN)),
                "plate": (BALL, free(5.0, inertia=np.diag(FLAT))),
            },
            slaves={"sheet": (sheet, cg.motion.Attached("plate"))},
            contacts=[contact],
            end=1.0,
            step=step,
        )
        .run()
        .history
    )


MOVED = [f"{body}.{name}" for body in ("ball", "plate") for name in ("x", "y", "z", "vx", "vy")]
MOVED += [f"{body}.{name}" for body in ("ball", "plate") for name in ("vz", "wx", "wy", "wz")]


@pytest.mark.parametrize(
    ("law", "friction"),
    [(DAMPED, cg.Coulomb(0.3)), *full((STRESS, None))],
    ids=["damping and friction", "elastic"],
)
def test_a_collision_is_that_of_contigas_own_integrator(
    law: cg.StressLaw, friction: cg.Coulomb | None
) -> None:
    """They differ in the spin that MuJoCo takes for gyroscopic forces: half a step old."""
    apart = []
    for step in (0.02, 0.01, 0.005):
        ours, theirs = by_contiga(step, law, friction), by_mujoco(step, law, friction)
        np.testing.assert_allclose(theirs["time"], ours["time"], atol=1e-12)
        assert ours["force"].max() > 15.0
        forces = np.abs(theirs["force"] - ours["force"]).max() / ours["force"].max()
        moved = max(np.abs(theirs[name] - ours[name]).max() for name in MOVED)
        apart.append((forces, moved))
        # What moves the plate has its own mass: all of it is there.
        assert theirs["plate.vz"][-1] < -0.3
        for name in ("friction", "damping", "contact", "kinetic"):
            a, b = ours[f"energy.{name}"], theirs[f"energy.{name}"]
            np.testing.assert_allclose(b, a, atol=2e-3 * step, err_msg=name)
    assert apart[-1][0] < 2e-5
    assert apart[-1][1] < 2e-5
    assert (np.log2(np.array(apart[0]) / np.array(apart[-1])) / 2.0 > 0.9).all()


def test_columns_are_those_of_a_simulation() -> None:
    assert list(by_mujoco(0.02)) == list(by_contiga(0.02))


@pytest.mark.parametrize("integrator", ["Euler", *full("implicitfast")])
def test_force_and_ledger_are_of_second_order(integrator: str) -> None:
    fine = by_mujoco(1.0 / 800.0, integrator=integrator)
    errors, missing = [], []
    for n in (50, 100, 200):
        course = by_mujoco(1.0 / n, integrator=integrator)
        errors.append(np.abs(course["force"] - fine["force"][:: 800 // n]).max())
        missing.append(np.abs(course["energy.error"]).max())
    # Points come in between steps, whatever the order of the integrator: not from one to the next.
    assert np.log2(errors[0] / errors[-1]) / 2.0 > 1.7
    assert np.log2(missing[0] / missing[-1]) / 2.0 > 1.7
    assert errors[-1] < 5e-4 * fine["force"].max()
    assert missing[-1] < 4e-4 * fine["energy.total"][0]


def test_momentum_and_moment_of_momentum_stay() -> None:
    """To rounding, with friction and damping; of round bodies, whose spins MuJoCo turns exactly."""
    course = by_mujoco(0.01, DAMPED, cg.Coulomb(0.3), plate=(2.0, 2.0, 2.0))
    linear, angular = np.zeros((2, len(course["time"]), 3))
    for body, mass, inertia in (("ball", 2.0, 0.8), ("plate", 5.0, 2.0)):
        place, speed, spin = (
            np.stack([course[f"{body}.{kind}{axis}"] for axis in "xyz"], axis=1)
            for kind in ("", "v", "w")
        )
        linear += mass * speed
        angular += mass * np.cross(place, speed) + inertia * spin
    assert course["force"].max() > 15.0
    np.testing.assert_allclose(linear - linear[0], 0.0, atol=1e-13)
    # The arms are those of the places at the time, the speeds the means of both sides of it.
    np.testing.assert_allclose(angular - angular[0], 0.0, atol=1e-12)


def pendulum(step: float, *, coupled: bool, springs: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Angles and speeds of two links under gravity, a damper and a motor."""
    text = f"""<mujoco><option timestep="{step!r}"/><worldbody>
    <body name="upper" pos="0 0 2"><joint name="a" axis="0 1 0" damping="0.05" {springs}/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.05"/>
      <body name="lower" pos="0.5 0 0"><joint name="b" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/></body></body>
    </worldbody><actuator><motor joint="b" gear="1"/></actuator></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0], data.qfrc_applied[0], data.xfrc_applied[2] = 2.0, 0.5, [1, 0, 0, 0, 0.3, 0]
    course = []
    if not coupled:
        for _ in range(round(1.0 / step)):
            mujoco.mj_step(model, data)
            course.append((*data.qpos, *data.qvel))
        return np.array(course), np.zeros(0)
    far = cg.Slave([[0.0, 0.0, -9.0]], area=[1.0])
    coupling = MujocoCoupling(
        model,
        data,
        masters={"lower": BALL},
        slaves={"far": (far, "world")},
        contacts=[cg.Contact(BALL, far, law=cg.PenaltyLaw(1.0))],
    )

    def keep(one: MujocoCoupling) -> None:
        course.append((*one.data.qpos, *one.data.qvel))

    history = coupling.run(1.0, on_step=keep).history
    assert data.qfrc_applied.tolist() == [0.5, 0.0]
    for axis in "xz":  # links swing round: their frames' own accelerations are in it
        change = np.gradient(history[f"lower.v{axis}"], step)[2:-2]
        told = history[f"lower.a{axis}"][2:-2]
        np.testing.assert_allclose(told, change, atol=20.0 * step * np.abs(change).max())
    whole = np.abs(history["energy.external"]).max()
    assert history["energy.damping"][-1] > 0.01 * whole
    if springs:
        assert history["energy.strain"].max() > 0.01 * whole
    return np.array(course[1:]), history["energy.error"] / whole


def test_without_contact_mujoco_keeps_its_own_bits() -> None:
    own, _ = pendulum(0.005, coupled=False)
    coupled, _ = pendulum(0.005, coupled=True)
    assert np.abs(own).max() > 1.0
    assert coupled.tobytes() == own.tobytes()


def test_joints_springs_dampers_motors_and_weights_are_in_the_ledger() -> None:
    """Of first order: MuJoCo takes speeds of half a step ago for its velocity forces."""
    errors = [
        np.abs(pendulum(step, coupled=True, springs='stiffness="3" springref="20"')[1]).max()
        for step in (0.004, 0.002, 0.001)
    ]
    assert errors[-1] < 1e-3
    assert errors[0] / errors[1] > 1.8
    assert errors[1] / errors[2] > 1.8


@pytest.mark.parametrize("held", [False, True])
def test_the_critical_step_of_a_point_on_a_body(held: bool) -> None:
    """2 √(m/k): m of a free ball and a free plate their reduced mass; of a hinge I/r²."""
    joint, inertia = ("<joint axis='0 1 0' pos='-2 0 0'/>", 1.5) if held else ("<freejoint/>", 1.5)
    text = f"""<mujoco><option gravity="0 0 0" timestep="0.01"/><worldbody>
    <body name="ball">{joint}
      <inertial pos="0 0 0" mass="2" diaginertia="{inertia} {inertia} {inertia}"/></body>
    <body name="plate"><freejoint/>
      <inertial pos="0 0 0" mass="5" diaginertia="1 1 1"/></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0 if held else 2] = 0.2 if held else -0.2
    point = cg.Slave([[0.0, 0.0, -1.001]], area=[1.0])
    coupling = MujocoCoupling(
        model,
        data,
        masters={"ball": BALL},
        slaves={"point": (point, "plate")},
        contacts=[cg.Contact(BALL, point, law=cg.PenaltyLaw(500.0))],
    )
    coupling.start()
    assert coupling.critical_step == np.inf
    for _ in range(5):
        coupling.step()
    assert coupling.contacts["ball-point"].n_contact == 1
    one = 2.0**2 / (inertia + 2.0 * 2.0**2) if held else 1.0 / 2.0
    exact = 2.0 / np.sqrt(500.0 * (one + 1.0 / 5.0))
    assert coupling.critical_step == pytest.approx(exact, rel=2e-3)
