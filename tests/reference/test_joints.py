"""Mechanisms against equations of motion in other coordinates, integrated by DOP853 to 1e-12.

Planar ones in the angles of their bodies, or with multipliers in (x, z, θ); tops in Euler's angles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import contiga as cg
from contiga.records import FloatArray

G = 9.81
Y = (0.0, 1.0, 0.0)


class Rod(NamedTuple):
    """A uniform rod in the plane y = 0."""

    first: tuple[float, float]
    second: tuple[float, float]
    mass: float = 1.0

    @property
    def centre(self) -> FloatArray:
        return 0.5 * (np.array(self.first) + np.array(self.second))

    @property
    def inertia(self) -> float:
        return self.mass * float(np.sum(np.subtract(self.first, self.second) ** 2)) / 12.0


def in_space(point: Sequence[float]) -> list[float]:
    return [point[0], 0.0, point[1]]


def body_of(rod: Rod, **given: Any) -> tuple[cg.Body, Any]:
    """A free body with the rod's mass; about y its inertia is the rod's."""
    centre = in_space(rod.centre)
    shape = cg.Body([cg.shapes.sphere(radius=0.1, centre=centre)])
    inertia = np.diag([0.3, 1.0, 0.8]) * rod.inertia
    return shape, cg.motion.Free(rod.mass, inertia=inertia, centre=centre, **given)


def chain_of(rods: Sequence[Rod], step: float, end: float) -> cg.Simulation:
    """Rods that hang on one another, the first on the ground."""
    names = ["ground", *(f"rod {k}" for k in range(len(rods)))]
    return cg.Simulation(
        bodies={name: body_of(rod) for name, rod in zip(names[1:], rods, strict=True)},
        slaves={},
        contacts=[],
        joints=[
            cg.Joint("revolute", *pair, at=in_space(rod.first), axis=Y)
            for *pair, rod in zip(names, names[1:], rods, strict=False)
        ],
        gravity=[0.0, 0.0, -G],
        end=end,
        step=step,
    )


def straight_chain(count: int) -> list[Rod]:
    return [Rod((float(k), 0.0), (k + 1.0, 0.0)) for k in range(count)]


def chain_angles(count: int, end: float) -> FloatArray:
    """(count,) angles below the horizontal of a chain of rods of unit mass and length at `end`,
    let go from there: Lagrange's equations in these angles.

    Rod k has M_ij = (count − max(i, j) − 1/2) cos(θ_i − θ_j) off the diagonal.
    """
    k = np.arange(count)
    below = count - np.maximum.outer(k, k) - 0.5
    np.fill_diagonal(below, count - k - 1.0 + 1.0 / 3.0)
    weight = G * (count - k - 0.5)

    def rate(_: float, state: FloatArray) -> FloatArray:
        angles, speeds = state[:count], state[count:]
        apart = np.subtract.outer(angles, angles)
        force = weight * np.cos(angles) - (below * np.sin(apart)) @ speeds**2
        return np.concatenate([speeds, np.linalg.solve(below * np.cos(apart), force)])

    solved = solve_ivp(rate, (0.0, end), np.zeros(2 * count), "DOP853", rtol=1e-12, atol=1e-13)
    angles: FloatArray = solved.y[:count, -1]
    return angles


def centres_of(angles: FloatArray) -> FloatArray:
    """(count, 2) centres of the rods of `chain_angles`."""
    ways = np.stack([np.cos(angles), -np.sin(angles)], axis=1)
    return np.cumsum(ways, axis=0) - 0.5 * ways


def final_centres(result: Any, names: Sequence[str]) -> FloatArray:
    return np.array([[result.history[f"{n}.x"][-1], result.history[f"{n}.z"][-1]] for n in names])


def orders_of(errors: Sequence[float]) -> FloatArray:
    """Orders of convergence between steps that are halved each time."""
    return np.asarray(np.log2(np.divide(errors[:-1], errors[1:])))


def misfit(simulation: cg.Simulation, state: Any) -> float:
    """How far the points of all joints are apart at most, by the poses alone."""
    worst, start = 0.0, simulation.start()
    for joint in simulation.joints.values():
        ends = []
        for name, at in zip(joint.between, joint.at, strict=True):
            X = np.eye(4) if name == "ground" else state.bodies[name].pose
            X0 = np.eye(4) if name == "ground" else start.bodies[name].pose
            ends.append(X[:3, :3] @ X0[:3, :3].T @ (at - X0[:3, 3]) + X[:3, 3])
        worst = max(worst, float(np.abs(ends[1] - ends[0]).max()))
    return worst


@pytest.mark.parametrize(("count", "end"), [(1, 0.6), (2, 0.6), (20, 0.2)])
def test_a_chain_converges_with_second_order_to_lagranges_equations(count: int, end: float) -> None:
    exact = centres_of(chain_angles(count, end))
    errors, rods = [], straight_chain(count)
    for step in (2e-3, 1e-3, 5e-4):
        simulation = chain_of(rods, step, end)
        result = simulation.run()
        errors.append(np.abs(final_centres(result, list(simulation.bodies)) - exact).max())
    assert errors[-1] < 1e-4 * count
    np.testing.assert_allclose(orders_of(errors), 2.0, atol=0.1)


def test_joints_of_a_chain_stay_closed_to_rounding_and_its_energy_stays() -> None:
    simulation = chain_of(straight_chain(20), 5e-4, 0.5)
    result = simulation.run(keep=100)
    size = 20.0
    assert max(misfit(simulation, state) for state in result.states) <= 1e-12 * size
    most = (result.history["energy.kinetic"]).max()
    assert np.abs(result.history["energy.error"]).max() <= 1e-5 * most


def planar(
    rods: Sequence[Rod], rows: Callable[[FloatArray], FloatArray], end: float
) -> tuple[FloatArray, FloatArray]:
    """Centres and angles (n, 3) at `end` and speeds, of rods let go at rest with `rows` held zero.

    In (x, z, θ) of all rods with multipliers; derivatives of the rows by complex steps.
    """
    masses = np.array([[rod.mass, rod.mass, rod.inertia] for rod in rods]).ravel()
    weight = np.array([[0.0, -G * rod.mass, 0.0] for rod in rods]).ravel()
    start = np.array([[*rod.centre, 0.0] for rod in rods]).ravel()
    n, tiny = len(start), 1e-200

    def derivative(q: FloatArray) -> FloatArray:
        return np.array([rows(q + 1j * tiny * e).imag / tiny for e in np.eye(n)]).T

    def rate(_: float, state: FloatArray) -> FloatArray:
        q, v = state[:n], state[n:]
        A, h = derivative(q), 1e-6
        turning = (derivative(q + h * v) - derivative(q - h * v)) @ v / (2.0 * h)
        m = len(A)
        matrix = np.block([[np.diag(masses), A.T], [A, np.zeros((m, m))]])
        solved = np.linalg.solve(matrix, np.concatenate([weight, -turning]))
        return np.concatenate([v, solved[:n]])

    state = np.concatenate([start, np.zeros(n)])
    solved = solve_ivp(rate, (0.0, end), state, "DOP853", rtol=1e-10, atol=1e-11).y[:, -1]
    return solved[:n].reshape(-1, 3), solved[n:].reshape(-1, 3)


def end_of(rod: Rod, q: FloatArray, point: Sequence[float]) -> FloatArray:
    """Return where the point of a rod is that was at `point`, for (x, z, θ); θ turns x to z."""
    x, z = np.subtract(point, rod.centre)
    c, s = np.cos(q[2]), np.sin(q[2])
    return np.array([q[0] + c * x - s * z, q[1] + s * x + c * z])


CRANK = Rod((0.0, 0.0), (0.0, 1.0))
COUPLER = Rod((0.0, 1.0), (2.0, 1.5), 2.0)
ROCKER = Rod((2.0, 1.5), (2.5, 0.0), 1.5)


def four_bar(step: float, end: float, crank: Any = CRANK) -> cg.Simulation:
    return cg.Simulation(
        bodies={
            "crank": body_of(crank),
            "coupler": body_of(COUPLER),
            "rocker": body_of(ROCKER),
        },
        slaves={},
        contacts=[],
        joints=[
            cg.Joint("revolute", "ground", "crank", at=in_space(CRANK.first), axis=Y),
            cg.Joint("revolute", "crank", "coupler", at=in_space(CRANK.second), axis=Y),
            cg.Joint("revolute", "coupler", "rocker", at=in_space(ROCKER.first), axis=Y),
            cg.Joint("revolute", "rocker", "ground", at=in_space(ROCKER.second), axis=Y),
        ],
        gravity=[0.0, 0.0, -G],
        end=end,
        step=step,
    )


def test_a_planar_four_bar_of_revolutes_converges_though_three_rows_are_redundant() -> None:
    end, rods = 0.5, (CRANK, COUPLER, ROCKER)

    def rows(q: FloatArray) -> FloatArray:
        a, b, c = q.reshape(3, 3)
        return np.concatenate(
            [
                end_of(CRANK, a, CRANK.first) - CRANK.first,
                end_of(COUPLER, b, CRANK.second) - end_of(CRANK, a, CRANK.second),
                end_of(ROCKER, c, ROCKER.first) - end_of(COUPLER, b, ROCKER.first),
                end_of(ROCKER, c, ROCKER.second) - ROCKER.second,
            ]
        )

    exact = planar(rods, rows, end)[0][:, :2]
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        simulation = four_bar(step, end)
        result = simulation.run(keep=50)
        errors.append(np.abs(final_centres(result, list(simulation.bodies)) - exact).max())
        assert max(misfit(simulation, state) for state in result.states) <= 1e-12
    assert simulation.joint_fit.redundant == 3
    assert all("joint" not in str(finding) for finding in simulation.check())
    [note] = result.summary["notes"]
    assert "3 of their constraints follow from the others" in note
    np.testing.assert_allclose(orders_of(errors), 2.0, atol=0.05)


def test_a_slider_crank_converges_with_second_order() -> None:
    """The slider is a translational joint to the ground; the crank is let go at 60°."""
    end = 0.5
    top = (0.5, 0.75**0.5)
    crank, rod = Rod((0.0, 0.0), top), Rod(top, (2.5, 0.0), 1.5)
    slider = Rod((2.4, 0.0), (2.6, 0.0), 0.7)

    def rows(q: FloatArray) -> FloatArray:
        a, b, c = q.reshape(3, 3)
        return np.concatenate(
            [
                end_of(crank, a, crank.first) - crank.first,
                end_of(rod, b, top) - end_of(crank, a, top),
                end_of(slider, c, rod.second) - end_of(rod, b, rod.second),
                c[1:],
            ]
        )

    rods = {"crank": crank, "rod": rod, "slider": slider}
    q, v = planar(list(rods.values()), rows, end)
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        simulation = cg.Simulation(
            bodies={name: body_of(one) for name, one in rods.items()},
            slaves={},
            contacts=[],
            joints=[
                cg.Joint("revolute", "ground", "crank", at=[0, 0, 0], axis=Y),
                cg.Joint("spherical", "crank", "rod", at=in_space(top)),
                cg.Joint("revolute", "rod", "slider", at=in_space(rod.second), axis=Y),
                cg.Joint("translational", "ground", "slider", at=[2.5, 0, 0], axis=[1, 0, 0]),
            ],
            gravity=[0.0, 0.0, -G],
            end=end,
            step=step,
        )
        history = simulation.run().history
        travel = history["ground-slider.travel"][-1] - (q[2, 0] - 2.5)
        speed = history["slider.vx"][-1] - v[2, 0]
        errors.append(max(abs(travel), abs(speed)))
        most = history["energy.kinetic"].max()
    assert np.abs(history["energy.error"]).max() < 1e-4 * most
    np.testing.assert_allclose(orders_of(errors), 2.0, atol=0.1)


def top_of(step: float, end: float, spin: FloatArray) -> cg.Simulation:
    """A top of unit mass, its centre at 0.5 on its axis, which leans by 0.6 in the plane y = 0."""
    axis = np.array([np.sin(0.6), 0.0, np.cos(0.6)])
    inertia = 0.1 * np.eye(3) + (0.05 - 0.1) * np.outer(axis, axis)
    shape = cg.Body([cg.shapes.sphere(radius=0.3, centre=0.5 * axis)])
    moves = cg.motion.Free(
        1.0,
        inertia=inertia,
        centre=0.5 * axis,
        spin=spin,
        velocity=np.cross(spin, 0.5 * axis),
    )
    return cg.Simulation(
        bodies={"top": (shape, moves)},
        slaves={},
        contacts=[],
        joints=[cg.Joint("spherical", "ground", "top", at=[0, 0, 0])],
        gravity=[0.0, 0.0, -G],
        end=end,
        step=step,
    )


def test_a_heavy_top_nutates_as_eulers_angles_have_it() -> None:
    """Lagrange's top: A = 0.1 + 0.25 about its point, C = 0.05, spun at 60 about its axis."""
    A, C, spin, lean = 0.35, 0.05, 60.0, 0.6
    along = C * spin + 0.0  # angular momentum about its axis
    upright = along * np.cos(lean)  # and about the vertical

    def rate(_: float, state: FloatArray) -> FloatArray:
        theta, _, speed = state
        s, c = np.sin(theta), np.cos(theta)
        precession = (upright - along * c) / (A * s * s)
        force = A * precession**2 * s * c - along * precession * s + G * 0.5 * s
        return np.array([speed, precession, force / A])

    end = 1.0
    solved = solve_ivp(rate, (0, end), [lean, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-13)
    theta, phi = solved.y[:2, -1]
    exact = 0.5 * np.array(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    )
    axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
    errors = []
    for step in (2e-3, 1e-3, 5e-4):
        history = top_of(step, end, spin * axis).run().history
        errors.append(np.abs([history[f"top.{k}"][-1] for k in "xyz"] - exact).max())
    np.testing.assert_allclose(orders_of(errors), 2.0, atol=0.1)
    assert errors[-1] < 1e-4


def test_a_gyroscope_precesses_steadily_as_its_closed_form_says() -> None:
    """C n Ω − (A − C) Ω² cos θ = m g l, with n the spin about its axis without Ω."""
    A, C, omega = 0.35, 0.05, 2.0
    own = (G * 0.5 + (A - C) * omega**2 * np.cos(0.6)) / (C * omega)
    axis = np.array([np.sin(0.6), 0.0, np.cos(0.6)])
    history = top_of(5e-4, 1.0, own * axis + [0.0, 0.0, omega]).run().history
    angle = np.unwrap(np.arctan2(history["top.y"], history["top.x"]))
    np.testing.assert_allclose(history["top.z"], 0.5 * np.cos(0.6), atol=2e-5)
    assert angle[-1] == pytest.approx(omega, rel=2e-4)
    # The point carries the weight and turns the centre on a circle.
    pull = 0.5 * np.sin(0.6) * omega**2
    across = np.hypot(history["ground-top.fx"], history["ground-top.fy"])
    np.testing.assert_allclose(across[1:], pull, rtol=2e-3)
    np.testing.assert_allclose(history["ground-top.fz"][1:], G, rtol=2e-4)


def test_the_reaction_of_a_pendulum_is_that_of_its_closed_form() -> None:
    """At the lowest point a rod let go from the horizontal has ω² = 3 g/l and pulls 5/2 m g."""
    history = chain_of(straight_chain(1), 5e-4, 0.8).run().history
    lowest = int(np.argmin(history["rod 0.z"]))
    assert history["ground-rod 0.fz"][lowest] == pytest.approx(2.5 * G, rel=1e-5)
    assert history["ground-rod 0.angle"][lowest] == pytest.approx(np.pi / 2, abs=1e-2)


def test_energy_of_a_chain_stays_a_hundred_times_better_than_in_mujoco() -> None:
    """MuJoCo runs the same chain of 20 with the same step and its default integrator (Euler)."""
    mujoco = pytest.importorskip("mujoco")
    step, end = 1e-3, 0.5
    simulation = chain_of(straight_chain(20), step, end)
    rods, inner = straight_chain(20), ""
    for rod in reversed(rods):
        inertia = " ".join(f"{f * rod.inertia:.17g}" for f in (0.3, 1.0, 0.8))
        inner = (
            f'<body pos="{0 if rod is rods[0] else 1} 0 0"><joint type="hinge" axis="0 1 0"/>'
            f'<inertial pos="0.5 0 0" mass="1" diaginertia="{inertia}"/>{inner}</body>'
        )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler balanceinertia="true"/><option gravity="0 0 -{G}" timestep="{step}">'
        f'<flag energy="enable"/></option><worldbody>{inner}</worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    first, worst = float(data.energy.sum()), 0.0
    for _ in range(round(end / step)):
        mujoco.mj_step(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        worst = max(worst, abs(float(data.energy.sum()) - first))
    own = float(np.abs(simulation.run().history["energy.error"]).max())
    assert own <= 0.01 * worst
