"""Blocks that slide and stick, balls that come to roll."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import TOLERANCE, Answer, Cases, order_of, relative, zero
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.closed_forms.scenes import ball, crossing_time, floor, run_of, solid_ball
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Friction")
G, MASS = 9.81, 2.0
STIFF = 1e3
UPRIGHT = ("y", "rx", "ry", "rz")


def block(
    friction: cg.Coulomb, end: float, step: float | str, *, speed: float, slope: float = 0.0
) -> dict[str, FloatArray]:
    """Return the history of a block of four feet on a floor, sunk in by its weight at the start.

    The floor stays level and gravity is turned by the angle `slope`, rad: x points down a slope.
    """
    pull = G * np.array([math.sin(slope), 0.0, -math.cos(slope)])
    sink = -MASS * pull[2] / (4.0 * STIFF)
    corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    feet = cg.Slave([(x, y, -sink) for x, y in corners], area=np.ones(4), name="feet")
    plate = floor()
    motion = cg.motion.Free(MASS, velocity=(speed, 0.0, 0.0), centre=(0.0, 0.0, 1.0), hold=UPRIGHT)
    law = cg.PenaltyLaw(STIFF)
    return run_of(
        bodies={"floor": plate, "block": (ball(centre=(0.0, 0.0, 1.0)), motion)},
        slaves={"feet": (feet, cg.motion.Attached("block"))},
        contacts=[cg.Contact(plate, feet, law=law, friction=friction, search="penetration")],
        gravity=pull,
        end=end,
        step=step,
    ).history


# Coulomb's law sticks by springs as stiff as the normal ones: a foot that is pushed slides once its
# displacement is δ = μ N/k.


@CASES.add(
    "block-stops",
    "Block stopped by friction",
    "x = v²/(2 μ g) + δ/2, δ = μ N/k_t",
    "Four feet on a plane; each sticks by a spring that slides once it is stretched by δ.",
)
def _stops() -> Answer:
    mu, speed, soft = 0.3, 1.0, 0.25 * STIFF
    slide, lasts = speed**2 / (2.0 * mu * G), speed / (mu * G)
    # While the springs of the feet are stretched by δ, half of that counts.
    distance = slide + 0.5 * mu * MASS * G / (4.0 * soft)
    history = block(cg.Coulomb(mu, stiffness=soft), 1.1 * lasts, "auto", speed=speed)
    t, x = history["time"], history["block.x"]
    spent = history["energy.friction"] + history["energy.contact"]
    checks = (
        relative("way to the turn", x.max(), distance),
        relative("heat and energy of the springs at the turn",
                 (spent - spent[0])[int(np.argmax(x))], 0.5 * MASS * speed**2),
    )  # fmt: skip
    exact = np.where(t < lasts, speed * t - 0.5 * mu * G * t * t, slide)
    draw = comparison(("t", "x"), [("v t − μ g t²/2", t, exact)], [("run", t, x)])
    return Answer(checks, draw)


@CASES.add(
    "block-slips",
    "Block that slides down an incline",
    "a = g (sin θ − μ cos θ), from where the springs of its feet let it go",
    "θ = 30°, μ = 0.3; the block hangs on the springs of its feet first.",
)
def _slips() -> Answer:
    mu, slope, end = 0.3, math.radians(30.0), 0.5
    pull = G * (math.sin(slope) - mu * math.cos(slope))
    # It hangs on the springs of its feet until they slide.
    omega, sag = math.sqrt(4.0 * STIFF / MASS), MASS * G * math.sin(slope) / (4.0 * STIFF)
    reach = mu * MASS * G * math.cos(slope) / (4.0 * STIFF)
    begin = math.acos(1.0 - reach / sag) / omega
    first = sag * omega * math.sin(omega * begin)

    def exact(t: FloatArray | float) -> Any:
        late = np.asarray(t) - begin
        hangs = sag * (1.0 - np.cos(omega * np.asarray(t)))
        return np.where(late < 0.0, hangs, reach + first * late + 0.5 * pull * late**2)

    history = block(cg.Coulomb(mu), end, "auto", speed=0.0, slope=slope)
    t, x = history["time"], history["block.x"]

    def error(step: float) -> float:
        """Return the mean error of four steps about this one: it depends on where in a step a foot
        starts to slide."""
        total = 0.0
        for part in (0.85, 0.95, 1.05, 1.15):
            run = block(cg.Coulomb(mu), 0.5 * end, part * step, speed=0.0, slope=slope)
            total += abs(float(run["block.x"][-1] / exact(0.5 * end)) - 1.0)
        return 0.25 * total

    checks = (
        relative("way", x[-1], float(exact(end))),
        relative("speed", history["block.vx"][-1], first + pull * (end - begin)),
        relative("acceleration", history["block.ax"][-1], pull),
    )
    draw = comparison(("t", "x"), [("formula", t, exact(t))], [("run", t, x)])
    return Answer(
        checks, draw, order_of("way half way, mean of four steps about each", 0.01, error)
    )


@CASES.add(
    "block-sticks",
    "Block that sticks on an incline",
    "x = (m g sin θ/k_t) (1 − cos ω t), no heat",
    "θ = 15°, μ = 0.7: it swings on the springs of its feet, and never slides.",
)
def _sticks() -> Answer:
    mu, slope = 0.7, math.radians(15.0)
    sag, omega = MASS * G * math.sin(slope) / (4.0 * STIFF), math.sqrt(4.0 * STIFF / MASS)
    end = 2.0 * math.pi / omega
    history = block(cg.Coulomb(mu), 2.0 * end, "auto", speed=0.0, slope=slope)
    t, x = history["time"], history["block.x"]
    exact = sag * (1.0 - np.cos(omega * t))

    def error(step: float) -> float:
        run = block(cg.Coulomb(mu), 0.25 * end, step, speed=0.0, slope=slope)
        return abs(float(run["block.x"][-1]) / sag - 1.0)

    checks = (
        relative("largest way", x.max(), 2.0 * sag),
        zero("way in half a period, by the largest",
             np.abs(x - exact)[t <= 0.5 * end].max() / (2.0 * sag), TOLERANCE),
        zero("heat, by the energy in the springs",
             history["energy.friction"][-1] / (0.5 * 4.0 * STIFF * sag**2), TOLERANCE),
    )  # fmt: skip
    draw = comparison(("t", "x"), [("formula", t, exact)], [("run", t, x)])
    return Answer(checks, draw, order_of("way after a quarter of a period", end / 40, error))


# ---------------------------------------------------------------- a ball that comes to roll

DEPTH = 1e-4
"""Depth by its weight of a ball of radius 1; errors by it are of this size, too."""
SPACING = 5e-4
"""Angle between the points of the arc, rad."""


def roll(
    reach: tuple[float, float], end: float, step: float | str, *, speed: float, slope: float = 0.0,
    friction: float = 0.5,
) -> dict[str, FloatArray]:  # fmt: skip
    """Return the history of a ball on a plane, whose contact is an arc of points under its middle.

    The arc reaches from −reach[0] to reach[1], rad. The floor stays level and gravity is turned by
    the angle `slope`, rad: x points down a slope.
    """
    pull = G * np.array([math.sin(slope), 0.0, -math.cos(slope)])
    angle = np.arange(-reach[0], reach[1], SPACING) + 0.5 * SPACING
    points = np.column_stack([np.sin(angle), np.zeros(angle.size), -np.cos(angle)])
    depth = points[:, 2] - (DEPTH - 1.0)
    each = -MASS * pull[2] / np.maximum(-depth, 0.0).sum()
    points[:, 2] += 1.0 - DEPTH
    arc, plate = cg.Slave(points, area=np.ones(len(points)), name="arc"), floor()
    centre = (0.0, 0.0, 1.0 - DEPTH)
    motion = solid_ball(
        MASS, 1.0, centre=centre, velocity=(speed, 0.0, 0.0), hold=("y", "rx", "rz")
    )
    contact = cg.Contact(
        plate, arc, law=cg.PenaltyLaw(each), friction=cg.Coulomb(friction), search="penetration"
    )
    return run_of(
        bodies={"floor": plate, "ball": (ball(), motion)},
        slaves={"arc": (arc, cg.motion.Attached("ball"))},
        contacts=[contact],
        gravity=pull,
        end=end,
        step=step,
    ).history


@CASES.add(
    "roll-sliding",
    "Ball that slides and comes to roll",
    "v = 5/7 v₀ after 2 v₀/(7 μ g)",
    "Points on an arc under the ball; sunk in by 1e-4 of its radius. Until they slide, points "
    "go by μ λ: half of 4/5 of that counts as time.",
)
def _comes_to_roll() -> Answer:
    mu, speed = 0.5, 1.0
    slide = 2.0 * speed / (7.0 * mu * G)
    # Points take μ λ until they slide; weighted by their forces λ is 4/5 of the depth.
    lasts = slide + 0.5 * mu * 0.8 * DEPTH / speed
    history = roll((0.03, 0.06), 1.1 * slide, "auto", speed=speed, friction=mu)
    t, v, w = history["time"], history["ball.vx"], history["ball.wy"]
    slip = v - w
    rate = np.gradient(slip, t)
    meets = crossing_time(t, slip, rate)
    checks = (
        relative("speed as it begins to roll", float(np.interp(meets, t, v)), 5.0 / 7.0 * speed),
        relative("time until then", meets, lasts),
    )
    exact = np.maximum(speed - mu * G * t, 5.0 / 7.0 * speed)
    turning = np.minimum(2.5 * mu * G * t, 5.0 / 7.0 * speed)
    draw = comparison(
        ("t", "velocity"),
        [("v, formula", t, exact), ("ω R, formula", t, turning)],
        [("v, run", t, v), ("ω R, run", t, w)],
    )
    return Answer(checks, draw)


@CASES.add(
    "roll-down",
    "Ball that rolls down an incline",
    "a = 5/7 g sin θ",
    "sin θ = 0.02, 800 equal steps; on an elastic bed it creeps by a share of sin θ √(d/R).",
)
def _rolls_down() -> Answer:
    slope, end, step = 0.02, 0.4, 5e-4
    pull = 5.0 / 7.0 * G * math.sin(slope)
    history = roll((0.03, 0.04), end, step, speed=0.0, slope=slope)
    t, x = history["time"], history["ball.x"]
    angle = 2.0 * math.atan2(float(history["ball.qy"][-1]), float(history["ball.qw"][-1]))
    checks = (
        relative("way", x[-1], 0.5 * pull * end**2),
        relative("angle turned, times the radius", angle, 0.5 * pull * end**2),
    )
    return Answer(
        checks, comparison(("t", "x"), [("formula", t, 0.5 * pull * t * t)], [("run", t, x)])
    )
