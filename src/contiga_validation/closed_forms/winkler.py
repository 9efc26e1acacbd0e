"""Balls on a Winkler bed: depth and time of contact, bounces, dampers, hysteresis."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.closed_forms.case import (
    TOLERANCE,
    Answer,
    Cases,
    absolute,
    order_of,
    relative,
    zero,
)
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import (
    ROTATIONS,
    ball,
    crossing_time,
    run_of,
    solid_ball,
    value_at,
)
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Contact with an elastic bed")
RADIUS, MASS = 80.0, 4500.0
RINGS, RAYS = 400, 2
UPRIGHT = ("x", "y", *ROTATIONS)


def bed(reach: float) -> cg.Slave:
    """Return points of a flat bed of radius `reach` under a ball about the origin, in rings.

    Rings bound equal areas and have their points half way in area. This is the midpoint rule in the
    squared radius, whose error falls with the square of the number of rings.
    """
    radii = reach * np.sqrt((np.arange(RINGS) + 0.5) / RINGS)
    angles = 0.3 + 2.0 * math.pi * np.arange(RAYS) / RAYS
    flat = np.outer(radii, np.exp(1j * angles)).ravel()
    points = np.column_stack([flat.real, flat.imag, np.full(flat.size, -RADIUS)])
    area = np.full(flat.size, math.pi * reach**2 / flat.size)
    return cg.Slave(points, area=area, name="bed")


def stored(stiffness: float, d: float) -> float:
    """Return the energy of a bed under a ball at depth d: ∫ k λ²/2 dA, λ along its normal."""
    return math.pi * stiffness * (RADIUS * d**3 / 3.0 - d**4 / 4.0)


def force(stiffness: float, d: FloatArray | float) -> Any:
    """Return the force of the bed on a ball at depth d, the derivative of `stored`; 0 above it."""
    d = np.maximum(d, 0.0)
    return math.pi * stiffness * (RADIUS - d) * d**2


def deepest(stiffness: float, speed: float) -> float:
    """Return the depth at which a ball that hits the bed with `speed` stops."""
    energy = 0.5 * MASS * speed**2
    return float(brentq(lambda d: stored(stiffness, d) - energy, 0.0, RADIUS, xtol=1e-13))


def duration(stiffness: float, speed: float) -> float:
    """Return the time of contact 2 ∫ dd/v, by 80 Gauss points in the angle φ of d = d_max sin φ.

    The substitution removes the singularity at the largest depth.
    """
    end = deepest(stiffness, speed)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    angle = 0.25 * math.pi * (1.0 + nodes)
    d = end * np.sin(angle)
    square_speed = speed**2 - 2.0 / MASS * np.array([stored(stiffness, x) for x in d])
    return float(
        2.0 * (0.25 * math.pi * weights * end * np.cos(angle) / np.sqrt(square_speed)).sum()
    )


def dropped(speed: float, step: float | str, end: float, reach: float, law: Any) -> dict[str, Any]:
    """Return the history of a ball that starts at the bed and moves down into it with `speed`."""
    master, slave = ball(RADIUS), bed(reach)
    motion = solid_ball(MASS, RADIUS, velocity=(0.0, 0.0, -speed), hold=UPRIGHT)
    return run_of(
        bodies={"ball": (master, motion)},
        slaves={"bed": slave},
        contacts=[cg.Contact(master, slave, law=law)],
        end=end,
        step=step,
    ).history


def _sphere(stiffness: float, speed: float) -> Answer:
    """Compare a ball on the bed with its closed form: depth, time of contact, energy, speed."""
    max_depth, contact_time = deepest(stiffness, speed), duration(stiffness, speed)
    reach = 1.02 * math.sqrt(2.0 * RADIUS * max_depth - max_depth**2)
    law = cg.PenaltyLaw(stiffness, per_area=True)
    end = 1.05 * contact_time
    history = dropped(speed, "auto", end, reach, law)
    t, depth = history["time"], -history["ball.z"]
    rate, pull = -history["ball.vz"], -history["ball.az"]
    turn = crossing_time(t, rate, pull)
    separation = crossing_time(t, depth, rate, after=int(np.searchsorted(t, turn)))
    peak = value_at(t, depth, rate, turn)

    def course(times: FloatArray) -> FloatArray:
        answer = solve_ivp(
            lambda _, y: (y[1], -force(stiffness, y[0]) / MASS), (0.0, times[-1]), (0.0, speed),
            t_eval=times, rtol=1e-10, atol=1e-10, method="DOP853",
        )  # fmt: skip
        return np.asarray(answer.y[0])

    middle = 0.7 * contact_time
    exact = float(course(np.array([0.0, middle]))[-1])

    def error(step: float) -> float:
        run = dropped(speed, step, middle, reach, law)
        return abs(float(-run["ball.z"][-1]) - exact) / max_depth

    k = int(np.argmax(depth))
    checks = (
        relative("energy in the bed, rings against the integral",
                 history["energy_stored"][k], stored(stiffness, float(depth[k])), 2e-5),
        relative("largest depth", peak, max_depth),
        relative("time of contact", separation, contact_time),
        relative("speed after it", -rate[-1], speed),
    )  # fmt: skip
    fine = np.linspace(0.0, contact_time, 200)
    draw = comparison(
        ("t", "depth"), [("formula", fine, course(fine))], [("run", t, np.maximum(depth, 0.0))]
    )
    return Answer(checks, draw, order_of("depth on the way back", middle / 25, error))


@CASES.add(
    "winkler-shallow",
    "Ball on a Winkler bed, shallow",
    "m v²/2 = π k (R d³/3 − d⁴/4), T = 2 ∫ dd / √(v² − 2 U(d)/m)",
    f"{RINGS} rings of points stand for the bed; what they miss is a line of its own below.",
)
def _shallow() -> Answer:
    return _sphere(2.0, 0.5)


@CASES.add(
    "winkler-deep",
    "Ball on a Winkler bed, deep",
    "F = π k (R − d) d², m v²/2 = π k (R d³/3 − d⁴/4)",
    "A headform's mass, radius and speed; it sinks to some 0.4 of its radius.",
)
def _deep() -> Answer:
    return _sphere(0.05, 6.7)


# ---------------------------------------------------------------- a point that is bounced on

SPRING = 1000.0


def on_a_point(
    law: Any, end: float, step: float | str, *, height: float = 0.0, **more: Any
) -> dict[str, FloatArray]:
    """Return the history of a ball of mass 1 that moves along z over one point, as over a spring.

    It starts `height` above the point; `more` are options of `run_of`, and its `speed` downwards.
    """
    master, slave = ball(RADIUS), cg.Slave([[0.0, 0.0, -RADIUS - height]], area=[1.0])
    motion = cg.motion.Free(1.0, velocity=(0.0, 0.0, -more.pop("speed", 0.0)), hold=UPRIGHT)
    return run_of(
        bodies={"ball": (master, motion)},
        slaves={"point": slave},
        contacts=[cg.Contact(master, slave, law=law)],
        end=end,
        step=step,
        **more,
    ).history


@CASES.add(
    "bounce",
    "Bounces without gain",
    "period 2 v/g + 2 (π − atan(ω v/g))/ω, height constant",
    'A ball over one elastic point, under gravity, held upright; step "auto".',
)
def _bounces() -> Answer:
    g, height, count = 1.0, 5.0, 12
    omega = math.sqrt(SPRING)
    speed = math.sqrt(2.0 * g * height)
    # In flight 2 v/g; in the spring from −v to v about its rest at g/ω².
    flight, touch = 2.0 * speed / g, 2.0 / omega * (math.pi - math.atan(omega * speed / g))
    period = flight + touch
    history = on_a_point(
        cg.PenaltyLaw(SPRING), count * period, "auto", height=height, gravity=(0.0, 0.0, -g)
    )
    t, v, a = (history[name] for name in ("time", "ball.vz", "ball.az"))
    energy = history["energy.total"] - history["energy.external"] + g * height
    # Where it turns round below.
    up = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    bottoms = np.array([crossing_time(t, v, a, after=int(i)) for i in up])
    tops = history["ball.z"] + height
    last = tops[t > (count - 0.5) * period].max()
    checks = (
        absolute("bounces", len(bottoms), count, 0.0),
        relative("time from bounce to bounce", np.diff(bottoms).mean(), period),
        relative("height after the last", last, height),
        zero("energy at the end, by that at the start", abs(energy[-1] / (g * height) - 1.0),
             TOLERANCE),
        zero("gain in any flight, by the energy at the start",
             max(float((energy[a == -g]).max()) / (g * height) - 1.0, 0.0), TOLERANCE),
    )  # fmt: skip
    fine = np.linspace(0.0, 3.0 * period, 600)
    phase = (fine + 0.5 * period) % period - 0.5 * period
    exact = np.where(np.abs(phase) < 0.5 * flight, height - 0.5 * g * phase**2, 0.0)
    early = t <= 3.0 * period
    draw = comparison(
        ("t", "height"), [("formula, flights", fine, exact)], [("run", t[early], tops[early])]
    )
    return Answer(checks, draw)


# ---------------------------------------------------------------- hysteresis


@CASES.add(
    "hysteresis",
    "Loss in a bed that unloads softer than it loads",
    "E_lost = area between the curves without the corner that the line of slope K cuts",
    "Loading 1000, unloading 300, slope 3000; one bounce.",
)
def _hysteresis() -> Answer:
    soft, steep, speed = 300.0, 3000.0, 2.0
    law = cg.StressLaw(
        [[0.0, 0.0], [10.0, 10.0 * SPRING]], thickness=1.0,
        unloading=[[0.0, 0.0], [10.0, 10.0 * soft]], hysteresis_slope=steep,
    )  # fmt: skip
    # Down: a quarter of a swing on the loading line. Back: along the steep line, then the soft.
    omega, energy = math.sqrt(SPRING), 0.5 * speed**2
    deepest_point = speed / omega
    meet = deepest_point * (steep - SPRING) / (steep - soft)
    back = 0.5 * soft * meet**2 + 0.5 * (soft * meet + SPRING * deepest_point) * (
        deepest_point - meet
    )
    out = math.sqrt(2.0 * back)
    history = on_a_point(law, 0.2, "auto", speed=speed)
    depth, push = -history["ball.z"], history["ball.az"]

    def error(step: float) -> float:
        """Return the mean error of four starts, by parts of a step above the bed.

        The error of one depends on where in a step it meets the corner of the curve.
        """
        heights = speed * step * np.array([0.125, 0.375, 0.625, 0.875])
        ends = [on_a_point(law, 0.2, step, speed=speed, height=h)["ball.vz"][-1] for h in heights]
        return float(np.abs(np.array(ends) / out - 1.0).mean())

    checks = (
        relative("largest depth", depth.max(), deepest_point),
        relative("energy lost", history["energy.hysteresis"][-1], energy - back),
        relative("speed after it", history["ball.vz"][-1], out),
    )
    draw = comparison(
        ("depth", "force"),
        [("formula", np.array([0.0, deepest_point, meet, 0.0]),
          np.array([0.0, SPRING * deepest_point, soft * meet, 0.0]))],
        [("run", np.maximum(depth, 0.0), push)],
    )  # fmt: skip
    return Answer(checks, draw, order_of("speed after it, mean of four starts", 0.004, error))
