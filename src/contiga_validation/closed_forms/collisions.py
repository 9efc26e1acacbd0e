"""Two balls that meet, one exact, the points of the other on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.case import ROUNDING, TOLERANCE, Answer, Cases, relative, zero
from contiga_validation.closed_forms.pictures import comparison, errors_over
from contiga_validation.closed_forms.scenes import (
    ROTATIONS,
    ball,
    positions,
    run_of,
    solid_ball,
    spins,
    velocities,
)
from contiga_validation.engine.arrays import FloatArray

CASES = Cases("Collisions")
RADIUS, GAP = 1.0, 1e-3
ANGLE = math.radians(30.0)
STIFFNESS = 4000.0


RINGS, RAYS, CAP = 250, 4, 0.5


def cap(line: FloatArray) -> cg.Slave:
    """Return points on a ball about the origin, in rings about the unit direction `line`.

    Rings bound equal areas up to the angle `CAP`. The forces of a ball that comes along the line
    have no component across it.
    """
    first = np.cross(line, (0.0, 1.0, 0.0))
    first /= np.linalg.norm(first)
    second = np.cross(line, first)
    height = 1.0 - (1.0 - math.cos(CAP)) * (np.arange(RINGS) + 0.5) / RINGS
    angle = 2.0 * math.pi * np.arange(RAYS) / RAYS
    direction = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    radius = np.sqrt(1.0 - height**2)
    points = height[:, None, None] * line + radius[:, None, None] * direction
    cap_area = 2.0 * math.pi * RADIUS**2 * (1.0 - math.cos(CAP))
    area = np.full(RINGS * RAYS, cap_area / (RINGS * RAYS))
    return cg.Slave(RADIUS * points.reshape(-1, 3), area=area, name="cap")


@cache
def skin() -> cg.Slave:
    """Return a triangulated ball about the origin, the same slave at each call."""
    mesh = ball(RADIUS).tessellate(0.02)
    return cg.Slave(mesh.vertices, mesh.triangles, name="skin")


class Meeting(NamedTuple):
    """A run of two balls, "one" exact and "two" sampled."""

    masses: tuple[float, float]
    history: dict[str, FloatArray]

    def momentum(self) -> FloatArray:
        """Return the total momentum (n, 3) of both balls."""
        one, two = (velocities(self.history, name) for name in ("one", "two"))
        return self.masses[0] * one + self.masses[1] * two

    def turning(self) -> FloatArray:
        """Return the total angular momentum (n, 3) of both balls about the origin."""
        total = np.zeros_like(velocities(self.history, "one"))
        for mass, name in zip(self.masses, ("one", "two"), strict=True):
            arm, speed = positions(self.history, name), velocities(self.history, name)
            total += mass * np.cross(arm, speed)
            total += 0.4 * mass * RADIUS**2 * spins(self.history, name)
        return total


def meet(
    masses: tuple[float, float],
    velocity: FloatArray,
    line: FloatArray,
    *,
    step: float | str = "auto",
    hold: Sequence[str] = (),
    points: cg.Slave | None = None,
    **options: Any,
) -> Meeting:
    """Run two balls: the first flies with `velocity` (3,) at the second, at rest along `line`.

    The first is exact; the second carries `points`, a `cap` if omitted. `options` are those of
    `cg.Contact`.
    """
    one, towards = ball(RADIUS), (2.0 * RADIUS + GAP) * line
    sampled = cap(-line) if points is None else points
    slave = cg.Slave(sampled.points + towards, sampled.facets, area=sampled.area, name="points")
    law = cg.PenaltyLaw(STIFFNESS, per_area=True)
    free = [
        solid_ball(masses[0], RADIUS, velocity=velocity, hold=hold),
        solid_ball(masses[1], RADIUS, centre=towards, hold=hold),
    ]
    run = run_of(
        bodies={"one": (one, free[0]), "two": (ball(), free[1])},
        slaves={"points": (slave, cg.motion.Attached("two"))},
        contacts=[cg.Contact(one, slave, law=law, **options)],
        end=0.3,
        step=step,
    )
    return Meeting(masses, run.history)


DOWN = np.array([0.0, 0.0, -1.0])
_PAIR = "One ball is exact, the points on the other ride with it (Attached)"


def _head_on(masses: tuple[float, float], speed: float = 2.0) -> Answer:
    """Compare a central collision of smooth balls with its closed form."""
    run = meet(masses, speed * DOWN, DOWN)
    history, (m, M) = run.history, masses
    t, one, two = history["time"], history["one.vz"], history["two.vz"]
    expected = -speed * (m - M) / (m + M), -speed * 2.0 * m / (m + M)
    momentum = run.momentum()
    checks = (
        relative("speed of the first after it", one[-1], expected[0], scale=speed),
        relative("speed of the second after it", two[-1], expected[1], scale=speed),
        zero("momentum, all times", np.abs(momentum - momentum[0]).max() / (m * speed), ROUNDING),
        zero("energy balance error after it, by that at the start",
             abs(history["energy.error"][-1]) / (0.5 * m * speed**2), TOLERANCE),
    )  # fmt: skip
    ends = np.array([t[0], t[-1]])
    draw = comparison(
        ("t", "velocity along the line of centres"),
        [("first, after it", ends, np.full(2, expected[0])),
         ("second, after it", ends, np.full(2, expected[1]))],
        [("first, run", t, one), ("second, run", t, two)],
    )  # fmt: skip
    return Answer(checks, draw)


@CASES.add(
    "collision-equal",
    "Equal balls exchange their velocities",
    "v₁' = 0, v₂' = v₁",
    f"{_PAIR}, in rings about the line of centres.",
)
def _equal() -> Answer:
    return _head_on((1.5, 1.5))


@CASES.add(
    "collision-unequal",
    "Unequal balls",
    "v₁' = v (m − M)/(m + M), v₂' = 2 m v/(m + M)",
    f"{_PAIR}; the second has three times the mass.",
)
def _unequal() -> Answer:
    return _head_on((1.5, 4.5))


@CASES.add(
    "collision-oblique",
    "Oblique collision of equal balls",
    "v₁' · v₂' = 0: smooth balls that do not turn part at a right angle",
    f"{_PAIR}; the line of centres is 30° off the way.",
)
def _oblique() -> Answer:
    speed, mass = 2.0, 1.5
    line = np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])
    run = meet((mass, mass), speed * DOWN, line, hold=ROTATIONS)
    one, two = velocities(run.history, "one"), velocities(run.history, "two")
    sizes = np.linalg.norm(one, axis=1), np.linalg.norm(two, axis=1)
    between = math.degrees(math.acos(one[-1] @ two[-1] / sizes[0][-1] / sizes[1][-1]))
    momentum = run.momentum()
    checks = (
        relative("angle between the ways after it, degrees", between, 90.0),
        relative("v₁² + v₂²", sizes[0][-1] ** 2 + sizes[1][-1] ** 2, speed**2),
        zero("momentum, all times", np.abs(momentum - momentum[0]).max() / (mass * speed),
             ROUNDING),
    )  # fmt: skip
    t = run.history["time"]
    draw = comparison(
        ("t", "velocity"), [],
        [("first, along", t, -one[:, 2]), ("first, across", t, one[:, 0]),
         ("second, along", t, -two[:, 2]), ("second, across", t, two[:, 0])],
    )  # fmt: skip
    return Answer(checks, draw)


@CASES.add(
    "closed-system",
    "Momentum of a closed system",
    "Σ m v and Σ (x × m v + I ω) constant",
    f"{_PAIR}, a mesh all over it; with friction, spin and an oblique way.",
)
def _closed_system() -> Answer:
    speed, masses = 2.0, (1.5, 2.5)
    line = np.array([0.4, 0.1, -0.9])
    line /= np.linalg.norm(line)
    run = meet(
        masses, np.array([0.0, 0.3, -speed]), line, points=skin(), friction=cg.Coulomb(0.3)
    )  # fmt: skip
    history, t = run.history, run.history["time"]
    momentum, turning = run.momentum(), run.turning()
    size = masses[0] * speed
    p = np.abs(momentum - momentum[0]).max(axis=1) / size
    L = np.abs(turning - turning[0]).max(axis=1) / size / RADIUS
    checks = (
        zero("momentum, all times", p.max(), ROUNDING),
        zero("angular momentum, all times", L.max(), ROUNDING),
        zero("energy balance error at the end, by that at the start",
             abs(history["energy.error"][-1]) / history["energy.total"][0], TOLERANCE),
    )  # fmt: skip
    draw = errors_over(("t", "error"), [("momentum", t, p), ("angular momentum", t, L)])
    return Answer(checks, draw)
