"""Whole contacts with friction against closed forms: blocks, inclines, a ball, a rope."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad
from tests.sample import FULL, full

import contiga as cg

pose = cg.motion.pose
GRAVITY = 10.0
SINK = 1e-6  # that the weight presses a block into its base


def grid(width: float, length: float, n: int, m: int, z: float = 0.0) -> cg.Slave:
    """A sheet of quadrilaterals at height `z`."""
    sheet = cg.shapes.plane(width=width, length=length, centre=(0.0, 0.0, z))
    row = np.arange(n * m).reshape(n, m)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    return cg.Slave(cg.clouds.sample(sheet, n, m), quads.reshape(-1, 4))


class Slide(NamedTuple):
    """How a block slides, one row a step."""

    way: np.ndarray
    velocity: np.ndarray
    states: list[cg.State]

    @property
    def far(self) -> np.ndarray:
        """Distance from the start."""
        return np.linalg.norm(self.way, axis=1)


def slide(
    friction: cg.Coulomb,
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    angle: float = 0.0,
    steps: int,
    dt: float = 2e-4,
    quadrature: str | int = "nodes",
) -> Slide:
    """A block of unit mass and face on a base that is inclined by `angle` about y, let go with
    `velocity` (3,) where its weight has pressed it in: velocity Verlet."""
    base, X_WB = cg.Body([cg.shapes.plane(width=4.0, length=4.0)]), pose.rotation("y", angle)
    block = grid(1.0, 1.0, 3, 3, SINK)
    load = GRAVITY * np.cos(angle)
    law = cg.PenaltyLaw(load / SINK, per_area=True)
    contact = cg.Contact(base, block, law=law, friction=friction, quadrature=quadrature)
    R = X_WB[:3, :3]
    pressed = (block.points - [0.0, 0.0, 2.0 * SINK]) @ R.T
    state = contact.start(block.points @ R.T, X_WB)
    state = contact.step(state, pressed, X_WB, dt)
    place, v = np.zeros(3), R @ velocity
    rows, weight = [], np.array([0.0, 0.0, -GRAVITY])
    for _ in range(steps):
        v = v + 0.5 * dt * (state.total_force + weight)
        place = place + dt * v
        now = v + 0.5 * dt * (state.total_force + weight)
        state = contact.step(state, pressed + place, X_WB, dt, velocity=np.tile(now, (9, 1)))
        v = v + 0.5 * dt * (state.total_force + weight)
        rows.append((place, v, state))
    way, speed, states = zip(*rows, strict=True)
    return Slide(np.array(way) @ R, np.array(speed) @ R, list(states))


@pytest.mark.parametrize("quadrature", ["nodes", *full(6)])
def test_a_block_stops_after_the_square_of_its_speed_over_twice_the_friction(quadrature) -> None:
    mu, stops = 0.3, 1e-7  # what a step before and after the turn may miss of the way
    run = slide(cg.Coulomb(mu), (0.6, 0.8, 0.0), steps=1800, quadrature=quadrature)
    start, speed = run.far[0], np.linalg.norm(run.velocity[0])
    assert run.far.max() - start == pytest.approx(speed**2 / (2 * mu * GRAVITY), rel=stops)
    along = run.way[-1] / run.far[-1]
    np.testing.assert_allclose(along, [0.6, 0.8, 0.0], rtol=0, atol=1e-9)
    lost, give = [s.energy.friction for s in run.states], mu * SINK
    assert lost[-1] - lost[0] == pytest.approx(0.5 * speed**2, rel=1e-9)
    # What its springs held as it slid, the block keeps: it swings to where they hold nothing.
    assert run.far[-100:] == pytest.approx(run.far.max() - give, abs=1.01 * give)


def test_a_coefficient_that_falls_with_the_speed_stops_a_block_later() -> None:
    friction = cg.Coulomb(0.5, 0.3, decay=2.0)

    def part(v: float) -> float:
        return v / (GRAVITY * float(friction.coefficient(np.array(v))))

    run = slide(friction, (1.0, 0.0, 0.0), steps=1600)
    start, speed = run.far[0], float(run.velocity[0, 0])
    assert run.far.max() - start == pytest.approx(quad(part, 0.0, speed)[0], rel=3e-6)
    lost = run.states[-1].energy.friction - run.states[0].energy.friction
    assert lost == pytest.approx(0.5 * speed**2, rel=3e-6)


@pytest.mark.parametrize("share", [0.9, *full(0.45)])
def test_below_the_friction_angle_a_block_sticks_and_does_not_creep(share) -> None:
    mu = 0.4
    angle = np.arctan(share * mu)
    run = slide(cg.Coulomb(mu), angle=angle, steps=2000)
    give = mu * SINK
    # Let go without a load in its springs it swings to twice the elastic slip, or so far that the
    # energy it has where they slip is gone.
    reach = 2.0 * share if share <= 0.5 else 1.0 + (share - 0.5) / (1.0 - share)
    assert run.far.max() == pytest.approx(reach * give, rel=0.02)
    # From then on the swing is the same for ever.
    early, late = run.way[200:1100, 0], run.way[1100:, 0]
    assert late.max() <= early.max() + 2e-3 * give
    assert late.min() >= early.min() - 2e-3 * give
    lost, load = run.states[-1].energy.friction, GRAVITY * np.cos(angle)
    assert lost - run.states[200].energy.friction < 1e-5 * load * give
    assert lost == pytest.approx(mu * load * give * max(reach - 1.0, 0.0), abs=0.1 * load * give)


@pytest.mark.parametrize("quadrature", ["nodes", 6])
def test_above_the_friction_angle_a_block_accelerates(quadrature) -> None:
    mu, angle, dt = 0.4, 0.6, 2e-4
    run = slide(cg.Coulomb(mu), angle=angle, steps=600, dt=dt, quadrature=quadrature)
    speed = run.velocity[:, 0]
    gained = (speed[-1] - speed[100]) / (499 * dt)
    assert gained == pytest.approx(GRAVITY * (np.sin(angle) - mu * np.cos(angle)), rel=1e-9)
    np.testing.assert_allclose(run.velocity[:, 1:], 0.0, rtol=0, atol=1e-9)


CURVES = {
    "constant stiffness": cg.PenaltyLaw(1000.0),
    "rising stiffness": cg.StressLaw([(0.0, 0.0), (0.01, 5.0), (0.02, 20.0)], 1.0),
}


@pytest.mark.parametrize("law", CURVES.values(), ids=CURVES)
def test_a_point_that_sticks_does_not_creep_over_a_thousand_cycles(law) -> None:
    mu, n = 0.3, 4
    base = cg.Body([cg.shapes.plane()])
    start = np.array([[-0.3 + 0.2 * i, 0.0, 0.001] for i in range(n)])
    contact = cg.Contact(base, cg.Slave(start, area=np.ones(n)), law=law, friction=cg.Coulomb(mu))
    state = contact.start(start)
    # Normal loads: constant, in step with the tangential load, against it, twice as fast.
    turn = 0.5 * np.pi * np.arange(4)
    swing = np.array([0.0 * turn, np.sin(turn), -np.sin(turn), np.cos(2.0 * turn)])
    depth = 0.015 + 0.004 * swing
    place = start.copy()
    place[:, 2] = -depth.min(axis=1)
    state = contact.step(state, place)
    least = state.normal_force
    place[:, 2] = -depth.max(axis=1)  # the springs are as stiff as they get
    state = contact.step(state, place)
    load = 0.95 * mu * least[:, None] * np.array([0.6, 0.8])
    ends = []
    for _ in range(1000 if FULL else 200):
        for k in range(4):
            # To where the springs balance the load.
            gap = np.sin(turn[k]) * load + state.friction[:, :2]
            place[:, :2] += gap / state.tangential[:, None]
            place[:, 2] = -depth[:, k]
            state = contact.step(state, place)
        ends.append(place.copy())
    np.testing.assert_allclose(state.friction[:, :2], load, rtol=1e-12)
    assert np.abs(np.array(ends) - ends[0]).max() < 1e-15
    assert np.abs(place - start)[:, :2].max() > 1e-4
    assert state.energy.friction < 1e-15


class Thrown(NamedTuple):
    """A ball on its bed, one row a step."""

    centre: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    energy: np.ndarray


def throw(mu: float, speed: float, sink: float, *, dt: float, steps: int) -> Thrown:
    """A ball of unit mass and radius thrown along a bed it sinks into, without a spin."""
    bed = grid(0.4, 0.16, 41, 17)
    law = cg.PenaltyLaw(GRAVITY / (np.pi * sink**2), per_area=True)
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(ball, bed, law=law, friction=cg.Coulomb(mu))
    centre, turn = np.array([-0.12, 0.0, 1.0 + sink]), np.eye(4)
    state = contact.start(bed.points, pose.translation(centre))
    centre = centre - [0.0, 0.0, 2.0 * sink]
    state = contact.step(state, bed.points, pose.translation(centre), dt)
    v, w, inertia = np.array([speed, 0.0, 0.0]), np.zeros(3), 0.4
    weight, rows = np.array([0.0, 0.0, -GRAVITY]), []
    for _ in range(steps):
        v = v + 0.5 * dt * (state.wrench[:3] + weight)
        w = w + 0.5 * dt * state.wrench[3:] / inertia
        centre = centre + dt * v
        turn = pose.compose(pose.rotation(w, dt * float(np.linalg.norm(w))), turn)
        X_WB = pose.compose(pose.translation(centre), turn)
        state = contact.step(state, bed.points, X_WB, dt)
        v = v + 0.5 * dt * (state.wrench[:3] + weight)
        w = w + 0.5 * dt * state.wrench[3:] / inertia
        rows.append((centre, v, w, state.energy))
    return Thrown(*map(np.array, zip(*rows, strict=True)))


def test_a_ball_thrown_along_a_bed_rolls_at_five_sevenths_of_its_speed() -> None:
    mu, thrown, sink, dt = 0.3, 1.0, 0.002, 1e-3
    run = throw(mu, thrown, sink, dt=dt, steps=170)
    v, w = run.velocity[:, 0], run.spin[:, 1]
    # About the bed its angular momentum stays.
    np.testing.assert_allclose((1.0 - sink) * v + 0.4 * w, (1.0 - sink) * thrown, atol=4e-4)
    assert np.argmax(v < w) * dt == pytest.approx(2.0 * thrown / (7.0 * mu * GRAVITY), abs=dt)
    # The springs it rolls on swing about that.
    assert v[-60:].mean() == pytest.approx(5.0 / 7.0 * thrown, rel=2e-3)
    np.testing.assert_allclose(v[-60:], 5.0 / 7.0, rtol=0.02)
    _, stored, _, _, lost = run.energy.T
    assert lost[-1] == pytest.approx(thrown**2 / 7.0, rel=2e-3)
    kinetic = 0.5 * (run.velocity**2).sum(axis=1) + 0.2 * (run.spin**2).sum(axis=1)
    whole = kinetic + GRAVITY * run.centre[:, 2] + stored + lost
    np.testing.assert_allclose(whole, whole[0], rtol=0, atol=5e-5)
    assert np.abs(run.centre[:, 1]).max() < 1e-6


ROUND = np.array([(3, -0.5, 0), (2.5, 2, 0), (0, 3, 0), (-2.5, 1.5, 0), (-2, -1, 0)], float)
# A spline is convex where its control polygon is.
PROFILES = {
    "circle": (cg.shapes.circle(radius=1.0), 0.05, 0.45),
    "ellipse": (cg.shapes.ellipse(axes=(2.0, 1.0)), 0.05, 0.45),
    "spline": (cg.NurbsCurve(3, [0, 0, 0, 0, 0.5, 1, 1, 1, 1], ROUND), 0.1, 0.9),
}


def pull(name: str, mu: float, n: int, steps: int) -> tuple[float, float]:
    """Ratio of the tensions in a rope of `n` nodes that slides round a profile, and the angle
    between where they are taken.

    One end is held back with a force of one, the other goes on slowly. Drag against the motion of
    all, and dampers beside the springs, bring it to rest in that motion.
    """
    curve, first, last = PROFILES[name]
    low, high = curve.domain
    t = low + (high - low) * np.linspace(first, last, 2001)
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(curve.evaluate(t), axis=0), axis=1)))
    x = curve.evaluate(np.interp(np.linspace(0.0, arc[-1], n), arc, t))
    span = arc[-1] / (n - 1)
    stiff, mass = 2e4 / span, 1.0
    rest = np.linalg.norm(np.diff(x, axis=0), axis=1) - 1.0 / stiff
    dt, damper = 0.7 / np.sqrt(stiff / mass), 0.3 * np.sqrt(stiff * mass)
    drag = np.pi * mass * span * np.sqrt(stiff / mass) / arc[-1]
    law = cg.PenaltyLaw(0.3 * stiff, damping=damper)
    rope = cg.Slave(x, area=np.ones(n))
    contact = cg.Contact(cg.Body.from_profile(curve), rope, law=law, friction=cg.Coulomb(mu))
    state, v = contact.start(x * (1.0 + 1e-6)), np.zeros((n, 3))
    speed = 4e-4 / (steps * dt)
    for _ in range(steps):
        d, tension = strands(x, stiff, rest)
        along = np.vstack([d[:1], d[1:] + d[:-1], d[-1:]])
        along /= np.linalg.norm(along, axis=1)[:, None]
        pulled = (tension + damper * (np.diff(v, axis=0) * d).sum(axis=1))[:, None] * d
        ends = np.vstack([d[:1], pulled, pulled[-1:]])
        v = v + dt / mass * (np.diff(ends, axis=0) + state.force - drag * (v - speed * along))
        v[-1] = speed * along[-1]
        x = x + dt * v
        state = contact.step(state, x, dt=dt)
    d, tension = (values[3:-3] for values in strands(x, stiff, rest))
    angle = np.arccos((d[1:] * d[:-1]).sum(axis=1)).sum()
    return float(tension[-1] / tension[0]), float(angle)


def strands(x: np.ndarray, stiff: float, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions and tensions between the nodes of a rope."""
    d = np.diff(x, axis=0)
    length = np.linalg.norm(d, axis=1)
    return d / length[:, None], stiff * (length - rest)


@pytest.mark.parametrize("name", ["circle", *full("ellipse", "spline")])
def test_a_rope_round_a_convex_profile_pulls_by_the_capstan_equation(name) -> None:
    mu = 0.3
    ratio, angle = pull(name, mu, 41, 2000)
    assert angle > 1.2
    # 40 chords; the error falls with the square of their number.
    assert ratio == pytest.approx(np.exp(mu * angle), rel=6e-4)
