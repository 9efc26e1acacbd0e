"""Masses on springs and dampers, belts that unload by another curve, and the critical step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import contiga as cg
from contiga.errors import RunError
from contiga_validation.closed_forms.case import (
    ROUNDING,
    TOLERANCE,
    Answer,
    Cases,
    order_of,
    relative,
    zero,
)
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import (
    ROTATIONS,
    ball,
    crossing_time,
    free_body,
    positions,
    run_of,
    velocities,
)
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Springs and the critical step")
STIFFNESS, MASS = 80.0, 5.0
OMEGA = math.sqrt(STIFFNESS / MASS)
ALONG_X = ("y", "z", *ROTATIONS)
ENDS = ((-3.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def _on_spring(damping: float = 0.0, speed: float = 2.0, **options: Any) -> cg.Simulation:
    """Return a simulation of a mass on a spring to the ground, which starts at its rest length.

    `speed` is along the spring; `options` are those of `cg.Simulation`.
    """
    motion = cg.motion.Free(MASS, velocity=(speed, 0.0, 0.0), hold=ALONG_X)
    spring = cg.Spring(("ground", "body"), at=ENDS, curve=STIFFNESS, damping=damping)
    return free_body(motion, springs=[spring], **options)


@CASES.add(
    "spring",
    "Mass on a spring",
    "x = v₀/ω sin ω t, ω = √(k/m)",
    'One mass, one spring to the ground; step "auto" lags by some 3e-5 of the time.',
)
def _swing() -> Answer:
    period = 2.0 * math.pi / OMEGA
    history = _on_spring(end=2.0 * period, step="auto").run().history
    t, x, v, a = (history[name] for name in ("time", "body.x", "body.vx", "body.ax"))
    size, half = 2.0 / OMEGA, t <= 0.5 * period
    exact = size * np.sin(OMEGA * t)
    # It stands still after a quarter of a period and each half one that follows.
    last = crossing_time(t, v, a, after=int(np.searchsorted(t, 1.6 * period)))

    def error(step: float) -> float:
        run = _on_spring(end=2.0 * period, step=step).run().history
        return abs(float(run["body.x"][-1])) / size

    checks = (
        zero("way in the first half period, by the amplitude",
             np.abs(x - exact)[half].max() / size, TOLERANCE),
        relative("period", (last - crossing_time(t, v, a)) / 1.5, period),
        relative("amplitude", np.abs(x).max(), size),
        relative("energy, at the end", history["energy.total"][-1], history["energy.total"][0]),
    )  # fmt: skip
    draw = comparison(("t", "x"), [("formula", t, exact)], [("run", t, x)])
    return Answer(checks, draw, order_of("way after two periods", period / 50, error))


@CASES.add(
    "damper",
    "Mass on a spring and a damper",
    "x = v₀/β e^(−δ t) sin β t, δ = c/2m, β = √(ω² − δ²)",
    "As before, with a damper of 15 % of the critical one.",
)
def _decay() -> Answer:
    damping, end = 6.0, 3.0
    rate = 0.5 * damping / MASS
    beat = math.sqrt(OMEGA**2 - rate**2)

    def exact(t: FloatArray | float) -> Any:
        return 2.0 / beat * np.exp(-rate * np.asarray(t)) * np.sin(beat * np.asarray(t))

    history = _on_spring(damping, end=end, step="auto").run().history
    t, x = history["time"], history["body.x"]
    size = float(exact(t).max())
    loss = 0.5 * MASS * 4.0 - history["energy.total"][-1]

    def error(step: float) -> float:
        run = _on_spring(damping, end=end, step=step).run().history
        return abs(float(run["body.x"][-1] - exact(end))) / size

    checks = (
        zero("way in the first half period, by its largest",
             np.abs(x - exact(t))[t <= math.pi / beat].max() / size, TOLERANCE),
        relative("energy the damper took", history["energy.damping"][-1], loss),
    )  # fmt: skip
    draw = comparison(("t", "x"), [("formula", t, exact(t))], [("run", t, x)])
    return Answer(checks, draw, order_of("way at the end", 0.05, error))


def _pendulum_run(end: float, step: float | str) -> dict[str, FloatArray]:
    """Return the history of a mass under gravity on a spring of no length at rest."""
    motion = cg.motion.Free(MASS, velocity=(0.0, 4.0, 0.0), hold=ROTATIONS)
    spring = cg.Spring(
        ("ground", "body"), at=[[-1.0, 0.0, 2.0], [0.0, 0.0, 0.0]], curve=STIFFNESS, length=0.0
    )
    return (
        free_body(motion, springs=[spring], end=end, step=step, gravity=(0.0, 0.0, -9.81))
        .run()
        .history
    )


@CASES.add(
    "pendulum",
    "Spring pendulum",
    "x = x₀ + (x(0) − x₀) cos ω t + v₀/ω sin ω t, x₀ = hook − g m/k",
    "A spring of no length at rest under gravity: the mass goes on an ellipse.",
)
def _pendulum() -> Answer:
    end = math.pi / OMEGA
    history = _pendulum_run(end, "auto")
    t, path = history["time"], positions(history)
    equilibrium = np.array([-1.0, 0.0, 2.0 - 9.81 / OMEGA**2])
    push = np.array([0.0, 4.0, 0.0])

    def exact(s: FloatArray | float) -> FloatArray:
        phase = OMEGA * np.asarray(s)[..., None]
        return np.asarray(equilibrium - equilibrium * np.cos(phase) + push / OMEGA * np.sin(phase))

    size = float(np.abs(exact(t) - equilibrium).max())
    arm = path - equilibrium
    momentum = np.cross(arm, velocities(history))
    drift = np.abs(momentum - momentum[0]).max() / np.linalg.norm(momentum[0])

    def error(step: float) -> float:
        return float(np.abs(positions(_pendulum_run(end, step))[-1] - exact(end)).max()) / size

    checks = (
        zero("place in half a period, by the swing", np.abs(path - exact(t)).max() / size,
             TOLERANCE),
        zero("angular momentum about the rest", drift, ROUNDING),
    )  # fmt: skip
    draw = comparison(
        ("y", "z"),
        [("ellipse", exact(t)[:, 1], exact(t)[:, 2])],
        [("run", path[:, 1], path[:, 2])],
    )
    return Answer(checks, draw, order_of("place at the end", end / 100, error))


# ---------------------------------------------------------------- two bodies


def _pair_run(end: float, step: float | str) -> dict[str, FloatArray]:
    """Return the history of two bodies on a spring, of which one starts with a speed of 3."""
    spring = cg.Spring(("one", "two"), at=[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], curve=STIFFNESS)
    one = cg.motion.Free(2.0, velocity=(3.0, 0.0, 0.0), hold=ROTATIONS)
    two = cg.motion.Free(6.0, centre=(3.0, 0.0, 0.0), hold=ROTATIONS)
    bodies = {"one": (ball(), one), "two": (ball(centre=(3.0, 0.0, 0.0)), two)}
    return run_of(bodies=bodies, springs=[spring], end=end, step=step).history


@CASES.add(
    "spring-pair",
    "Two bodies and a spring",
    "s = s₀ sin ω t, ω² = k (1/m₁ + 1/m₂); m₁ v₁ + m₂ v₂ constant",
    "One is pushed, the other follows.",
)
def _pair() -> Answer:
    omega = math.sqrt(STIFFNESS * (1.0 / 2.0 + 1.0 / 6.0))
    end = math.pi / omega
    history = _pair_run(end, "auto")
    t, one, two = history["time"], history["one.x"], history["two.x"]
    stretch, exact = two - one - 3.0, -3.0 / omega * np.sin(omega * t)
    momentum = 2.0 * velocities(history, "one") + 6.0 * velocities(history, "two")

    def error(step: float) -> float:
        run = _pair_run(end, step)
        return abs(float(run["two.x"][-1] - run["one.x"][-1] - 3.0)) * omega / 3.0

    checks = (
        zero("stretch in half a period, by its largest",
             np.abs(stretch - exact).max() * omega / 3.0, TOLERANCE),
        zero("momentum", np.abs(momentum - momentum[0]).max() / 6.0, ROUNDING),
        relative("way of the centre of mass", (2.0 * one[-1] + 6.0 * two[-1]) / 8.0,
                 2.25 + 0.75 * end, ROUNDING),
    )  # fmt: skip
    draw = comparison(("t", "stretch"), [("formula", t, exact)], [("run", t, stretch)])
    return Answer(checks, draw, order_of("stretch at the end", end / 50, error))


# ---------------------------------------------------------------- Kelvin restraint

PULSE, BELT, SOFT, STEEP = 0.2, 30.0, 6.0, 90.0
DUMMY = 75.0


def _restraint_run(step: float | str, end: float) -> cg.Result:
    """Run a body on an evenly braked sled, held by a belt that unloads softer than it loads."""
    brake = cg.motion.Accelerated(
        [[0.0, -PULSE], [end, -PULSE]], direction="x", velocity=(15.0, 0.0, 0.0)
    )
    body = cg.motion.Free(DUMMY, velocity=(15.0, 0.0, 0.0), hold=ALONG_X)
    belt = cg.Spring(
        ("sled", "body"), at=[[-50.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        curve=[[0.0, 0.0], [10.0, 10.0 * BELT]], unloading=[[0.0, 0.0], [10.0, 10.0 * SOFT]],
        hysteresis_slope=STEEP,
    )  # fmt: skip
    bodies = {"sled": (ball(), brake), "body": (ball(), body)}
    return run_of(bodies=bodies, springs=[belt], end=end, step=step, keep=1)


@CASES.add(
    "restraint",
    "Body held by a belt on a braked sled",
    "x = a/ω² (1 − cos ω t), x_max = 2 a/ω², F_max = 2 m a; loss between the curves",
    "A belt with loading and unloading lines, that carries tension only.",
)
def _restraint() -> Answer:
    omega = math.sqrt(BELT / DUMMY)
    farthest = 2.0 * PULSE / omega**2
    quarter = math.pi / omega
    # What an unloading gives back: under the steep line down to the soft curve, and under that.
    meet = farthest * (STEEP - BELT) / (STEEP - SOFT)
    returned = 0.5 * SOFT * meet**2 + 0.5 * (SOFT * meet + BELT * farthest) * (farthest - meet)
    result = _restraint_run("auto", 1.35 * quarter)
    history = result.history
    t = history["time"]
    sled = np.array([state.bodies["sled"].pose[0, 3] for state in result.states])
    stretch = history["body.x"] - sled
    force = -DUMMY * history["body.ax"]
    loading = t <= quarter
    fine = np.linspace(0.0, quarter, 100)
    exact = PULSE / omega**2 * (1.0 - np.cos(omega * fine))
    balance = history["energy.total"] + history["energy.hysteresis"] - history["energy.external"]
    checks = (
        relative("largest stretch of the belt", stretch.max(), farthest),
        relative("largest force of the belt", force.max(), 2.0 * DUMMY * PULSE),
        zero(
            "stretch until then, all times, by its largest",
            np.abs(stretch - 0.5 * farthest * (1.0 - np.cos(omega * t)))[loading].max() / farthest,
            TOLERANCE
        ),
        relative("energy the belt kept", history["energy.hysteresis"].max(),
                 0.5 * BELT * farthest**2 - returned),
        relative("energies against the work of the sled", balance[-1], balance[0]),
    )  # fmt: skip

    def error(step: float) -> float:
        run = _restraint_run(step, 0.75 * quarter)
        stretch_at_end = run.history["body.x"][-1] - run.state.bodies["sled"].pose[0, 3]
        angle = 0.75 * math.pi
        return abs(float(stretch_at_end) / (PULSE / omega**2 * (1.0 - math.cos(angle))) - 1.0)

    draw = comparison(
        ("stretch of the belt", "force"),
        [("loading", exact, BELT * exact),
         ("unloading", np.array([0.0, meet, farthest]),
          np.array([0.0, SOFT * meet, BELT * farthest]))],
        [("run", stretch, force)],
    )  # fmt: skip
    return Answer(checks, draw, order_of("stretch at three quarters", quarter / 40, error))


# ---------------------------------------------------------------- a damper that does not pull


def _belt_run(zeta: float, end: float, step: float | str) -> dict[str, FloatArray]:
    """Return the history of a mass that pulls a belt with a damper, `zeta` of the critical one."""
    motion = cg.motion.Free(MASS, velocity=(2.0, 0.0, 0.0), hold=ALONG_X)
    line = [[0.0, 0.0], [10.0, 10.0 * STIFFNESS]]
    belt = cg.Spring(
        ("ground", "body"), at=ENDS, curve=line, unloading=line, hysteresis_slope=STIFFNESS,
        damping=2.0 * zeta * MASS * OMEGA,
    )  # fmt: skip
    return free_body(motion, springs=[belt], end=end, step=step).run().history


@CASES.add(
    "restitution",
    "Restitution of a damper that does not pull",
    "e = exp(−ζ θ), θ = ω T = (1/β) atan2(2 ζ β, 2 ζ² − 1), β = √(1 − ζ²)",
    "A belt of spring and damper, ζ = 0.2, that lets go where its force is zero.",
)
def _restitution(zeta: float = 0.2) -> Answer:
    beat = math.sqrt(1.0 - zeta * zeta)
    # k x + c v is zero first, before x is: tan(β θ) = −2 ζ β/(1 − 2 ζ²).
    angle = math.atan2(2.0 * zeta * beat, 2.0 * zeta * zeta - 1.0) / beat
    e, end = math.exp(-zeta * angle), 1.5 * angle / OMEGA
    history = _belt_run(zeta, end, "auto")
    t, v, a = (history[name] for name in ("time", "body.vx", "body.ax"))
    fine = np.linspace(0.0, angle, 200)
    swing = np.cos(beat * fine) - zeta / beat * np.sin(beat * fine)
    exact = 2.0 * np.exp(-zeta * fine) * swing

    def error(step: float) -> float:
        return abs(float(_belt_run(zeta, end, step)["body.vx"][-1]) / (-2.0 * e) - 1.0)

    checks = (
        relative("restitution", -v[-1] / 2.0, e),
        relative("energy the damper took", history["energy.damping"][-1],
                 0.5 * MASS * 4.0 * (1.0 - e * e)),
        zero("pull of the damper after its end, by its largest",
             max(float(a.max()), 0.0) / float(np.abs(a).max()), ROUNDING),
    )  # fmt: skip
    draw = comparison(("t", "velocity"), [("formula", fine / OMEGA, exact)], [("run", t, v)])
    return Answer(checks, draw, order_of("speed after it", angle / OMEGA / 25, error))


# ---------------------------------------------------------------- critical step

INITIAL_SPEED = 1e-6
"""Initial speed of the runs near the critical step."""


def _is_refused(step: float, damping: float) -> bool:
    """Return whether a first step of this length raises a RunError."""
    simulation = _on_spring(damping, speed=1.0, end=10.0 * step, step=step)
    try:
        simulation.step(simulation.start())
    except RunError:
        return True
    return False


def _bound(damping: float) -> float:
    """Return the longest step that is not refused, by bisection from 0.1/ω to 4/ω."""
    low, high = 0.1 / OMEGA, 4.0 / OMEGA
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _is_refused(middle, damping) else (middle, high)
    return low


def _swings(share: float, count: int = 120) -> FloatArray:
    """Return |x| (count + 1,) of a mass run at a `share` of the critical step.

    Amplitudes start so small that growth does not reach the anchor.
    """
    step = share * 2.0 / OMEGA
    simulation = _on_spring(speed=INITIAL_SPEED, end=count * step, step=step, allow_unstable=True)
    return np.abs(simulation.run().history["body.x"])


@CASES.add(
    "critical-step",
    "Critical step",
    "h = 2/ω; with a damper 2/(γ + √(γ² + ω²)), γ = c/m; growth μ + √(μ² − 1) beyond",
    "The bound is found by bisection of what is refused; then runs just below and just above.",
)
def _critical() -> Answer:
    damping = 20.0
    decay = damping / MASS
    damped_limit = 2.0 / (decay + math.sqrt(decay**2 + OMEGA**2))
    below, above = _swings(0.999), _swings(1.001)
    # The step matrix has the eigenvalues −(μ ± √(μ² − 1)) with μ = ω² h²/2 − 1.
    mu = 2.0 * 1.001**2 - 1.0
    growth = mu + math.sqrt(mu * mu - 1.0)
    # Under the critical step ways stay below v/(ω √(1 − ω² h²/4)).
    largest = INITIAL_SPEED / OMEGA / math.sqrt(1.0 - 0.999**2)
    checks = (
        relative("longest step that is let pass, spring", _bound(0.0), 2.0 / OMEGA, 1e-9),
        relative(
            "longest step that is let pass, spring and damper", _bound(damping), damped_limit, 1e-9
        ),
        relative("largest way at 0.999 of it", below.max(), largest, 1e-3),
        relative("growth a step at 1.001 of it", above[-1] / above[-2], growth, 1e-6),
    )
    n = np.arange(len(above), dtype=float)
    draw = comparison(
        ("step", "|x|"),
        [],
        [("0.999 of the critical step", n, below),
         ("1.001 of it", n, above)],
    )  # fmt: skip
    return Answer(checks, draw)
