"""Forces come from an energy: closed loops of motion do no work, what falls comes back as high."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from examples import drop
from scipy.integrate import quad
from tests.sample import full
from tests.scenes import square_sheet
from tests.stress import solids

import contiga as cg

POSE = cg.motion.pose


def _sheet(side: float, n: int, wave: float = 0.0) -> cg.Slave:
    """A square sheet of n × n nodes about the origin, flat or wavy."""
    points, quads = square_sheet(side, n)
    points[:, 2] += wave * np.sin(10.0 * points[:, 0] / side) * np.cos(7.5 * points[:, 1] / side)
    return cg.Slave(points, quads)


def _bodies() -> dict[str, cg.Body]:
    return {
        "sphere": cg.Body([cg.shapes.sphere(radius=1.0)]),
        "torus": cg.Body([cg.shapes.torus()]),
        "filleted block": solids.solid("block, fillets 9").body,
    }


def _loop(body: cg.Body, slave: cg.Slave, steps: int, **options: object) -> tuple[float, float]:
    """Work of a closed loop, pressed in, moved about with a turn, and out; and of its loading."""
    size, (low, _), middle = body.size, body.bounds(), body.bounds().mean(axis=0)
    depth, side = 0.02 * size, 0.04 * size
    corners = np.array(
        [
            [0.0, 0.0, 0.5 * depth, 0.0],
            [0.0, 0.0, -depth, 0.0],
            [side, 0.0, -depth, 0.2],
            [side, side, -1.3 * depth, 0.1],
            [0.0, 0.0, -depth, 0.0],
            [0.0, 0.0, 0.5 * depth, 0.0],
        ]
    )
    share = np.arange(steps)[:, None] / steps
    way = np.concatenate([a + (b - a) * share for a, b in pairwise(corners)] + [corners[-1:]])
    contact = cg.Contact(body, slave, law=cg.StressLaw(1.0, thickness=0.2 * size), **options)
    state, work = None, []
    for x, y, z, angle in way:
        X_WB = POSE.compose(
            POSE.translation([x, y, z]),
            POSE.rotation("y", angle, [0.0, 0.0, middle[2] - low[2]]),
            POSE.translation([-middle[0], -middle[1], -low[2]]),
        )
        state = (
            contact.start(slave.points, X_WB)
            if state is None
            else contact.step(state, slave.points, X_WB)
        )
        work.append(state.energy.work)
    done = np.diff(work)
    return work[-1], float(done[done > 0.0].sum())


@pytest.mark.parametrize(
    ("name", "wave"),
    [
        ("sphere", 0.0),
        ("filleted block", 0.01),
        *full(("sphere", 0.01), ("filleted block", 0.0), ("torus", 0.0), ("torus", 0.01)),
    ],
)
def test_a_closed_loop_of_motion_does_no_work(name: str, wave: float) -> None:
    body = _bodies()[name]
    slave = _sheet(1.2 * body.size, 21, wave * body.size)
    # Points come in and go, so that the error of second order swings: the larger of two counts.
    coarse, fine = (
        max(abs(np.divide(*_loop(body, slave, steps))) for steps in pair)
        for pair in ((50, 70), (300, 400))
    )
    assert fine < 6e-6
    assert fine < coarse / 16.0


def test_measured_areas_as_weights_of_the_force_do() -> None:
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    slave = _sheet(1.2 * body.size, 21)
    work, loading = _loop(body, slave, 100, weights="area")
    assert abs(work) > 1e-3 * loading


@pytest.mark.parametrize(("step", "allowed"), [(0.02, 5e-5), *full((0.01, 1.3e-5))])
def test_a_free_ball_on_an_elastic_pad_keeps_its_energy(step: float, allowed: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=drop.RADIUS, centre=(0.0, 0.0, drop.RADIUS))])
    course = drop.drop(ball, drop.pad(10.0), cg.StressLaw(2.0, thickness=60.0), step)
    assert course.depth.max() > 30.0
    assert np.abs(course.error).max() < allowed


RADIUS, STRESS, THICKNESS, DEPTH = 82.5, 1.0, 10.0, 10.0


def _truth() -> float:
    """Force of the ball on a plane, F = ∫ σ(λ/t) n dA."""
    height = RADIUS - DEPTH

    def ring(r: float) -> float:
        far = np.hypot(r, height)
        return STRESS * (RADIUS - far) / THICKNESS * height / far * 2.0 * np.pi * r

    return float(quad(ring, 0.0, np.sqrt(RADIUS**2 - height**2), epsrel=1e-12)[0])


@pytest.mark.parametrize(("mesh", "nodes"), [(20.0, 2e-2), (10.0, 4e-3), (5.0, 7e-4)])
def test_the_force_hardly_depends_on_where_the_nodes_are(mesh: float, nodes: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=RADIUS)])
    pad = drop.pad(mesh, half=80.0)
    rng, turns = np.random.default_rng(1), []
    for _ in range(40):
        angle, shift = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, mesh, 2)
        placed = POSE.compose(POSE.rotation("z", angle), POSE.translation([*shift, RADIUS - DEPTH]))
        turns.append(POSE.apply(placed, pad.points))
    for quadrature, allowed in (("nodes", nodes), (6, nodes / 5.0)):
        contact = cg.Contact(
            ball,
            pad,
            law=cg.StressLaw(STRESS, thickness=THICKNESS),
            search="penetration",
            quadrature=quadrature,
        )
        forces = np.array([contact.start(points).total_force[2] for points in turns])
        assert np.sqrt(np.mean((forces / _truth() - 1.0) ** 2)) < allowed


@pytest.mark.parametrize("quadrature", ["nodes", 1, 3])
def test_going_deeper_the_force_never_drops(quadrature: str | int) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=RADIUS)])
    for mesh in (30.0, 10.0):
        pad = drop.pad(mesh, half=60.0)
        law = cg.StressLaw(STRESS, thickness=THICKNESS)
        contact = cg.Contact(ball, pad, law=law, search="penetration", quadrature=quadrature)
        places = [np.array([3.1, -2.7, RADIUS - depth]) for depth in np.linspace(0.0, 20.0, 81)]
        forces = [contact.start(pad.points + place).total_force[2] for place in places]
        assert (np.diff(forces) >= 0.0).all()
