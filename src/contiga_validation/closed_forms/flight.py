"""Bodies under gravity and loads."""

from __future__ import annotations

import math

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import ROUNDING, Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.rotation import about
from contiga_validation.closed_forms.scenes import (
    ROTATIONS,
    free_body,
    positions,
    rotations,
    run_of,
    spins,
    velocities,
)
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Flight and loads")
G = 9.81


@CASES.add(
    "ballistic",
    "Flight with spin",
    "x = v t + g t²/2, R = exp(ω t) about a principal axis",
    'Moments 1, 2, 3; step "auto". Exact but for rounding.',
)
def _ballistic() -> Answer:
    v, g = np.array([3.0, 1.0, 4.0]), np.array([0.0, 0.0, -G])
    spin = np.array([0.0, 6.0, 0.0])
    motion = cg.motion.Free(2.0, inertia=np.diag([1.0, 2.0, 3.0]), velocity=v, spin=spin)
    history = free_body(motion, end=1.0, step="auto", gravity=g).run().history
    t = history["time"][:, None]
    path, exact = positions(history), v * t + 0.5 * g * t * t
    orientation = about(np.array([0.0, 1.0, 0.0]), 6.0 * t[:, 0])
    checks = (
        zero("way, all times", np.abs(path - exact).max(), ROUNDING),
        zero("velocity, all times", np.abs(velocities(history) - v - g * t).max(), ROUNDING),
        zero("orientation, all entries, all times", np.abs(rotations(history) - orientation).max(),
             ROUNDING),
        zero(
            "energy balance error, by the energy at the start",
            np.abs(history["energy.error"]).max() / history["energy.total"][0],
            ROUNDING
        ),
    )  # fmt: skip
    draw = comparison(
        ("x", "z"), [("parabola", exact[:, 0], exact[:, 2])], [("run", path[:, 0], path[:, 2])]
    )
    return Answer(checks, draw)


# ---------------------------------------------------------------- load over time


def _push(step: float | str) -> dict[str, FloatArray]:
    """Return the history of a free body under a force from a table, and a constant moment."""
    rise = [[0.0, 0.0, 0.0, 0.0], [0.4, 60.0, 0.0, -20.0], [1.0, 20.0, 0.0, 0.0]]
    load = cg.Load("body", force=rise, moment=[0.0, 0.0, 3.0])
    motion = cg.motion.Free(2.0, inertia=np.diag([1.0, 1.0, 1.5]))
    return free_body(motion, end=1.0, step=step, loads=[load]).run().history


@CASES.add(
    "load",
    "Load over time",
    "m Δv = ∫F dt, m Δx = ∫(T − t) F dt, C ω = ∫M dt",
    "Force from a table of three rows (0, 60, 20 N), and a constant moment.",
)
def _load() -> Answer:
    history = _push("auto")
    t, x = history["time"], history["body.x"]
    momentum_x, momentum_z, displacement = 36.0, -10.0, 8.6
    fine = np.linspace(0.0, 1.0, 400)
    after = fine - 0.4
    exact = np.where(
        after < 0.0, 12.5 * fine**3, 0.8 + 6.0 * after + 15.0 * after**2 - 100.0 / 18.0 * after**3
    )
    work = 0.5 * 2.0 * (velocities(history)[-1] ** 2).sum() + 0.5 * 1.5 * 4.0
    checks = (
        relative("momentum along x", 2.0 * history["body.vx"][-1], momentum_x),
        relative("momentum along z", 2.0 * history["body.vz"][-1], momentum_z),
        relative("way along x", x[-1], displacement),
        relative("spin by the moment", spins(history)[-1, 2], 3.0 / 1.5),
        relative("work of the loads", history["energy.external"][-1], work),
    )

    def error(step: float) -> float:
        return abs(float(_push(step)["body.x"][-1]) / displacement - 1.0)

    draw = comparison(("t", "way along x"), [("formula", fine, exact)], [("run", t, x)])
    return Answer(checks, draw, order_of("way along x", 0.05, error))


# ---------------------------------------------------------------- follower force


def _rocket(step: float | str) -> dict[str, FloatArray]:
    """Return the history of a turning body with a constant force along its own axis."""
    motion = cg.motion.Free(2.0, inertia=np.diag([1.0, 1.0, 1.5]), spin=(0.0, 0.0, 2.0))
    load = cg.Load("body", force=[10.0, 0.0, 0.0], follow=True)
    return free_body(motion, end=5.0, step=step, loads=[load]).run().history


def _circling(t: FloatArray | float) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the body of `_rocket` at times: a cycloid."""
    a, w = 10.0 / 2.0, 2.0
    phase = w * np.asarray(t)
    return a / w**2 * (1.0 - np.cos(phase)), a / w**2 * (phase - np.sin(phase))


@CASES.add(
    "follower",
    "Follower force on a body that turns",
    "x = F/(m ω²) (1 − cos ω t), y = F/(m ω²) (ω t − sin ω t)",
    "The force stays along an axis of the body.",
)
def _follower() -> Answer:
    history = _rocket("auto")
    t, path = history["time"], positions(history)
    exact = np.stack(_circling(t), axis=1)
    size = float(np.abs(exact).max())

    def error(step: float) -> float:
        return (
            float(np.hypot(*(positions(_rocket(step))[-1, :2] - np.array(_circling(5.0))))) / size
        )

    checks = (
        zero("way, all times, by its largest", np.abs(path[:, :2] - exact).max() / size, 1e-4),
        relative("speed at the end", np.hypot(*velocities(history)[-1, :2]),
                 10.0 / 2.0 / 2.0 * 2.0 * abs(math.sin(5.0))),
    )  # fmt: skip
    draw = comparison(
        ("x", "y"), [("cycloid", exact[:, 0], exact[:, 1])], [("run", path[:, 0], path[:, 1])]
    )
    return Answer(checks, draw, order_of("way at the end", 0.05, error))


# ---------------------------------------------------------------- load off the centre


@CASES.add(
    "off-centre",
    "Force beside the centre of mass",
    "C ω' = F e",
    "The body's frame is not at its centre of mass; one axis is free.",
)
def _off_centre() -> Answer:
    motion = cg.motion.Free(
        2.0, inertia=np.diag([1.0, 1.0, 1.5]), hold=["z", "rx", "ry"], centre=(0.3, 0.0, 0.0)
    )
    load = cg.Load("body", force=[0.0, 10.0, 0.0], at=(0.8, 0.0, 0.0), follow=True)
    history = free_body(motion, end=1.5, step="auto", loads=[load]).run().history
    t, w = history["time"], spins(history)[:, 2]
    exact = 10.0 * 0.5 / 1.5 * t
    energy = history["energy.total"] - history["energy.external"]
    checks = (
        relative("spin, a follower force has a constant moment", w[-1], exact[-1]),
        relative(
            "angle turned",
            2.0 * math.atan2(abs(history["body.qz"][-1]), abs(history["body.qw"][-1])),
            math.pi - abs(0.5 * exact[-1] * t[-1] - math.pi),
        ),
        zero(
            "energy less the work of the force",
            np.abs(energy).max() / history["energy.total"][-1],
            1e-4,
        ),
    )
    return Answer(checks, comparison(("t", "spin"), [("formula", t, exact)], [("run", t, w)]))


# ---------------------------------------------------------------- sled


@CASES.add(
    "sled",
    "Sled pulse",
    "Δv = ∫a dt, Δx = v₀ T + ∬a dt²; ΔE = work of the sled",
    "A trapezoid of deceleration, ms and mm-based units; a body of 75 kg held by a belt.",
)
def _sled() -> Answer:
    rows = [[0.0, 0.0], [20.0, -0.15], [60.0, -0.15], [80.0, 0.0]]
    pulse = cg.motion.Accelerated(rows, direction="x", velocity=[12.0, 0.0, 0.0])
    body = cg.Body([cg.shapes.sphere()])
    occupant = cg.motion.Free(75.0, velocity=(12.0, 0.0, 0.0), hold=ROTATIONS)
    # A belt that is stiff enough to hold the body at the sled, and a damper that calms it.
    spring = cg.Spring(
        ("sled", "body"), at=[[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], curve=60.0, damping=60.0
    )
    bodies = {"sled": (body, pulse), "body": (body, occupant)}
    result = run_of(bodies=bodies, springs=[spring], end=80.0, step="auto", keep=1)
    history = result.history
    t = history["time"]
    sled = np.array([state.bodies["sled"].twist.velocity[0] for state in result.states])
    position = np.array([state.bodies["sled"].pose[0, 3] for state in result.states])
    fine = np.linspace(0.0, 80.0, 81)
    rates = np.interp(fine, *np.array(rows).T)
    # Exact: the rates are straight between these times.
    exact = 12.0 + np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]))])
    balance = history["energy.total"] + history["energy.damping"] - history["energy.external"]
    checks = (
        relative("Δv of the sled", sled[-1] - sled[0], -0.15 * 60.0, ROUNDING),
        relative("way of the sled", position[-1], 12.0 * 80.0 - 9.0 * 40.0, ROUNDING),
        relative("energy of the held body against the work of the pulse", balance[-1], balance[0]),
    )
    draw = comparison(
        ("t", "velocity"),
        [("sled, formula", fine, exact)],
        [("sled, run", t, sled), ("held body, run", t, history["body.vx"])],
    )
    return Answer(checks, draw)
