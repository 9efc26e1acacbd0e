"""Devices of belts: limiter, retractor, pretensioner, slip ring, release and trigger."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import contiga as cg
from contiga.belts import LoadLimiter, Pretensioner, Retractor, SlipRing
from contiga_validation.closed_forms.case import (
    TOLERANCE,
    Answer,
    Cases,
    order_of,
    relative,
    zero,
)
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import ROTATIONS, History, ball, free_body, run_of
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Devices of belts")
EXACT = 1e-9
"""Relative error of forces."""
ALONG_X = ("y", "z", *ROTATIONS)
ENDS = ((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
UNITS = ("m", "kg", "s")


def _belt(first: str, second: str, **options: Any) -> cg.Spring:
    return cg.Spring((first, second), at=ENDS, **({"name": "belt"} | options))


# ---------------------------------------------------------------- load limiter

LIMIT, MASS, SPEED, WEBBING = 4000.0, 40.0, 10.0, 2e6


def _stopped() -> History:
    """Return the history of a mass that flies off an anchor, on webbing with a load limiter."""
    motion = cg.motion.Free(MASS, velocity=(SPEED, 0.0, 0.0), hold=ALONG_X)
    belt = _belt("ground", "body", curve=WEBBING, limiter=LoadLimiter(LIMIT))
    return free_body(motion, springs=[belt], end=0.11, step="auto", units=UNITS).run().history


@CASES.add(
    "device-limiter",
    "Mass stopped by a load limiter",
    "s = m v²/2F + F/2k = 0.500 m + F/2k, F = 4 kN, m = 40 kg, v = 10 m/s",
    "Webbing of stiffness k in series with a limiter of one stage.",
)
def _limiter() -> Answer:
    history = _stopped()
    x, force = history["body.x"], history["belt.force"]
    energy, elastic = 0.5 * MASS * SPEED**2, LIMIT / WEBBING
    checks = (
        relative("way, without that of the webbing", x.max() - 0.5 * elastic, energy / LIMIT),
        relative("paid out", history["belt.paid_out"][-1], energy / LIMIT - 0.5 * elastic),
        relative("largest force", force.max(), LIMIT, EXACT),
        relative("energy the limiter took", history["belt.energy_hysteresis"][-1],
                 energy - 0.5 * LIMIT * elastic),
        zero("energy balance", float(np.abs(history["energy.error"]).max()) / energy, 1e-5),
    )  # fmt: skip

    fine = np.linspace(0.0, energy / LIMIT, 50)
    draw = comparison(
        ("way", "force"), [("F", fine, np.full_like(fine, LIMIT))], [("run", x, force)]
    )
    return Answer(checks, draw)


# ---------------------------------------------------------------- retractor

SPOOL, STIFF, RATE, PULLED = 20.0, 1e5, 1.5, 50.0


def _pulled_out(step: float | str) -> History:
    """Return the history of a sled that pulls webbing off a retractor at constant acceleration."""
    away = cg.motion.Accelerated([[0.0, PULLED], [1.0, PULLED]], direction="x")
    film = [[0.0, 0.0], [0.01, 1000.0], [0.02, 6000.0]]
    belt = _belt("ground", "sled", curve=STIFF, retractor=Retractor(SPOOL, rate=RATE, film=film))
    bodies = {"sled": (ball(), away), "other": (ball(), cg.motion.Free(1.0, hold=ROTATIONS))}
    return run_of(bodies=bodies, springs=[belt], end=0.05, step=step, units=UNITS).history


@CASES.add(
    "device-retractor",
    "Retractor that locks where it is pulled out fast",
    "T = S while x' < v, x' = a t; then T/k + film(T) = S/k + film(S) + x − x_lock",
    "A spool of constant force, and a film of two slopes once it has locked.",
)
def _retractor() -> Answer:
    step = 1e-5
    history = _pulled_out(step)
    t, force = history["time"], history["belt.force"]
    lock = float(t[np.flatnonzero(history["belt.locked"])[0]])
    # Stretch of webbing and film over the tension.
    levels = np.array([0.0, 1000.0, 6000.0])
    stretch = levels / STIFF + np.array([0.0, 0.01, 0.02])
    initial_stretch = float(np.interp(SPOOL, levels, stretch))
    travel = 0.5 * PULLED * np.maximum(t**2 - lock**2, 0.0)
    exact = np.where(t > lock, np.interp(initial_stretch + travel, stretch, levels), SPOOL)
    on_film = travel + initial_stretch < stretch[-1]
    checks = (
        zero("time of the lock, by steps", max(0.0, lock - RATE / PULLED - step) / step, EXACT),
        zero("and not before", max(0.0, RATE / PULLED - lock) / step, EXACT),
        zero("force, by its largest", np.abs(force - exact)[on_film].max() / force[on_film].max(),
             EXACT),
    )  # fmt: skip
    draw = comparison(
        ("t", "force"), [("formula", t[on_film], exact[on_film])],
        [("run", t[on_film], force[on_film])],
    )  # fmt: skip
    return Answer(checks, draw)


# ---------------------------------------------------------------- pretensioner


def _pulled_in(step: float, device: Pretensioner) -> History:
    """Return the history of a fixed body on webbing whose pretensioner a sled's pulse fires."""
    pulse = cg.motion.Accelerated([[0.0, 0.0], [0.1, -100.0]], direction="y")
    sensor = cg.Sensor(
        "crash", "sled", trigger=cg.Trigger("ay", below=-10.0, lasting=0.002, delay=0.003)
    )
    free = cg.motion.Free(1.0, hold=("x", "y", "z", *ROTATIONS))
    belt = _belt("ground", "body", curve=STIFF, pretensioner=device)
    return run_of(
        bodies={"sled": (ball(), pulse), "body": (ball(), free)},
        springs=[belt], sensors=[sensor], end=0.04, step=step, units=UNITS,
    ).history  # fmt: skip


@CASES.add(
    "device-pretensioner",
    "Pretensioners of a way and of a force, fired by a sensor",
    "T = k u(t − t₀), T = P(t − t₀) as long as P rises; t₀ = time of the threshold + for + delay",
    "A pulse that rises evenly: its threshold is passed at a tenth of it.",
)
def _pretensioner() -> Answer:
    fires = 0.01 + 0.002 + 0.003
    pull, push = [[0.0, 0.0], [0.01, 0.05]], [[0.0, 500.0], [0.01, 3000.0], [0.02, 0.0]]
    histories = [
        _pulled_in(1e-4, Pretensioner("crash", pull=pull)),
        _pulled_in(1e-4, Pretensioner("crash", force=push)),
    ]
    t = histories[0]["time"]
    since = t - fires
    exact = [
        STIFF * np.interp(since, *np.transpose(pull)),
        np.where(since < -1e-9, 0.0, np.interp(np.minimum(since, 0.01), *np.transpose(push))),
    ]
    errors = [
        float(np.abs(run["belt.force"] - formula).max() / formula.max())
        for run, formula in zip(histories, exact, strict=True)
    ]
    checks = (
        zero("tension of a way, by its largest", errors[0], EXACT),
        zero("tension of a force, by its largest", errors[1], EXACT),
        relative("work of a way", histories[0]["belt.energy_pretension"][-1],
                 0.5 * STIFF * 0.05**2, EXACT),
    )  # fmt: skip
    draw = comparison(
        ("t", "tension"),
        [("k u", t, exact[0]), ("P", t, exact[1])],
        [("way", t, histories[0]["belt.force"]), ("force", t, histories[1]["belt.force"])],
    )
    return Answer(checks, draw)


# ---------------------------------------------------------------- slip ring

FRICTION = 0.3


def _around(step: float | str, turn: float = math.pi) -> History:
    """Return the history of a mass that pulls webbing from an anchor through a slip ring.

    The webbing turns by the angle `turn`, rad, in the ring.
    """
    direction = np.array([-math.cos(turn), math.sin(turn), 0.0])
    motion = cg.motion.Free(
        MASS, velocity=5.0 * direction, centre=direction, hold=("z", *ROTATIONS)
    )
    segments = [
        cg.Spring(("ground", "ring"), at=[[1, 0, 0], [0, 0, 0]], curve=2e5, name="anchored"),
        cg.Spring(
            ("ring", "body"), at=np.array([np.zeros(3), direction]), curve=3e5, name="pulled"
        ),
    ]
    ring = SlipRing(("anchored", "pulled"), friction=FRICTION, name="slip")
    bodies = {"ring": ball(0.1), "body": (ball(0.1, tuple(direction.tolist())), motion)}
    return run_of(
        bodies=bodies, springs=segments, slip_rings=[ring], end=0.02, step=step, units=UNITS
    ).history


@CASES.add(
    "device-ring",
    "Slip ring: the capstan",
    "T₂/T₁ = e^{μθ} while it slips: 2.566332 at θ = 180°, μ = 0.3; x = v/ω sin ω t, "
    "1/(m ω²) = 1/k₂ + e^{−μθ}/k₁",
    "A mass pulls webbing round a ring; three angles.",
)
def _ring() -> Answer:
    checks = []
    for degrees in (60.0, 120.0, 180.0):
        history = _around("auto", math.radians(degrees))
        slips = np.diff(history["slip.slipped"], prepend=0.0) > 0.0
        ratio = history["pulled.force"][slips] / history["anchored.force"][slips]
        deviation = np.abs(ratio / math.exp(FRICTION * math.radians(degrees)) - 1.0).max()
        checks.append(zero(f"ratio of the tensions at {degrees:g}°", float(deviation), EXACT))
    # What slips adds F e^{−μθ}/k₁ to F/k₂.
    stiffness = 1.0 / (1.0 / 3e5 + math.exp(-FRICTION * math.pi) / 2e5)
    omega = math.sqrt(stiffness / MASS)
    t = history["time"]
    pulling = t < 0.5 * math.pi / omega
    exact = 5.0 / omega * np.sin(omega * t)
    displacement = history["body.x"] - 1.0
    loss = (1.0 - math.exp(-FRICTION * math.pi)) * math.exp(-FRICTION * math.pi) / 2e5
    checks += [
        zero("way of the mass, by its largest",
             np.abs(displacement - exact)[pulling].max() / exact.max(), TOLERANCE),
        relative("energy lost in the ring, at the largest force",
                 history["slip.energy_friction"][int(np.argmax(history["pulled.force"]))],
                 0.5 * loss * history["pulled.force"].max() ** 2),
    ]  # fmt: skip

    def error(step: float) -> float:
        run = _around(step)
        return float(np.abs(run["energy.error"]).max()) / (0.5 * MASS * 25.0)

    draw = comparison(
        ("T₁", "T₂"),
        [("e^{μθ} T₁", history["anchored.force"],
          math.exp(FRICTION * math.pi) * history["anchored.force"])],
        [("run", history["anchored.force"], history["pulled.force"])],
    )  # fmt: skip
    return Answer(tuple(checks), draw, order_of("energy balance", 4e-5, error))


# ---------------------------------------------------------------- end release

SPRING = 80.0


def _let_go(step: float | str) -> History:
    """Return the history of a mass on a spring that is released while the mass swings back."""
    omega = math.sqrt(SPRING / MASS)
    motion = cg.motion.Free(MASS, velocity=(2.0, 0.0, 0.0), hold=ALONG_X)
    sensor = cg.Sensor("speed", "body", trigger=cg.Trigger("vx", below=-1.0))
    belt = _belt("ground", "body", curve=SPRING, release="speed")
    return free_body(
        motion, springs=[belt], sensors=[sensor], end=3.0 / omega, step=step, units=UNITS
    ).run().history  # fmt: skip


@CASES.add(
    "device-release",
    "End that is released",
    "v = v₀ cos ω t until v = −v₀/2, at ω t = 2π/3; then it stays; lost is ½ k x²",
    "A mass that swings back on webbing, which a trigger of its speed lets go.",
)
def _release() -> Answer:
    omega = math.sqrt(SPRING / MASS)
    step = 2e-3 / omega
    history = _let_go(step)
    t, v = history["time"], history["body.vx"]
    release_time = 2.0 * math.pi / 3.0 / omega
    released = float(t[np.flatnonzero(history["belt.released"])[0]])
    exact = 2.0 * np.cos(omega * np.minimum(t, release_time))
    displacement = 2.0 / omega * math.sin(2.0 * math.pi / 3.0)
    checks = (
        zero("time of the release, by steps", abs(released - release_time) / step, 2.0),
        zero("speed, by its largest", np.abs(v - exact).max() / 2.0, 2.0 * omega * step),
        zero("force after it", float(np.abs(history["belt.force"][t >= released]).max()), EXACT),
        relative("energy lost", history["belt.energy_hysteresis"][-1],
                 0.5 * SPRING * displacement**2, 4.0 * omega * step),
        zero("energy balance", float(np.abs(history["energy.error"]).max()) / (2.0 * MASS),
             (omega * step) ** 2),
    )  # fmt: skip
    draw = comparison(("t", "speed"), [("formula", t, exact)], [("run", t, v)])
    return Answer(checks, draw)


# ---------------------------------------------------------------- filter of a trigger


@CASES.add(
    "device-trigger",
    "Trigger of a filtered channel",
    "y = c (t − √2/ω + e^{−wt}/w cos w t), w = ω/√2, of the ramp c t; fires at the threshold of y",
    "A pulse that rises evenly, its acceleration filtered by CFC60 in one pass.",
)
def _trigger() -> Answer:
    corner, slope = 2.0 * math.pi * 2.0775 * 60.0, 2e4

    def run(step: float) -> History:
        pulse = cg.motion.Accelerated([[0.0, 0.0], [0.02, 0.02 * slope]], direction="x")
        sensor = cg.Sensor(
            "crash", "sled", filter="CFC60", trigger=cg.Trigger("ax", above=0.25 * slope * 0.02)
        )
        free = cg.motion.Free(1.0, hold=ROTATIONS)
        bodies = {"sled": (ball(), pulse), "body": (ball(), free)}
        return run_of(bodies=bodies, sensors=[sensor], end=0.02, step=step, units=UNITS).history

    def formula(t: FloatArray) -> FloatArray:
        w = corner / math.sqrt(2.0)
        return slope * (t - math.sqrt(2.0) / corner + np.exp(-w * t) / w * np.cos(w * t))

    def error(step: float) -> float:
        history = run(step)
        deviation = np.abs(history["crash.trigger"] - formula(history["time"]))
        return float(deviation.max()) / (slope * 0.02)

    step = 2e-5
    history = run(step)
    t, filtered = history["time"], history["crash.trigger"]
    exact = formula(t)
    fire_time = float(t[np.flatnonzero(history["crash.fired"])[0]])
    expected = float(np.interp(0.25 * slope * 0.02, exact, t))
    checks = (
        zero("filtered channel, by its largest", np.abs(filtered - exact).max() / exact.max(),
             TOLERANCE),
        zero("time that it fires at, by steps", max(0.0, abs(fire_time - expected) / step - 1.0),
             1e-2),
    )  # fmt: skip
    draw = comparison(
        ("t", "acceleration"), [("formula", t, exact)],
        [("filtered", t, filtered), ("raw", t, history["crash.ax"])],
    )  # fmt: skip
    return Answer(checks, draw, order_of("filtered channel", 2e-4, error))
