"""Free bodies with sharp edges: what they keep, where they stop, and that they stay at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from tests.sample import full
from tests.scenes import box, grid_quads
from tests.stress.subjects import plane_body

import contiga as cg
from contiga.rigid import rigid_lanes as lanes

POSE = cg.motion.pose
DENSITY = 1e-3
GRAVITY = 9.81e-3
"""mm, g, ms."""


def block() -> cg.Body:
    """40 × 40 × 20 about the origin: 32 g."""
    return box((-20.0, -20.0, -10.0), (20.0, 20.0, 10.0))


def bed(half: float, spacing: float, shift: float = 0.0) -> cg.Slave:
    """A sheet in z = 0."""
    n = round(2.0 * half / spacing) + 1
    x, y = np.meshgrid(*2 * [np.linspace(-half, half, n) + shift])
    return cg.Slave(np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)]), grid_quads(n))


def lifted(body: cg.Body, turn: np.ndarray, gap: float) -> cg.Body:
    """A body turned, with its lowest point `gap` above z = 0."""
    lowest = POSE.apply(turn, body.tessellate(0.1).vertices)[:, 2].min()
    return body.transformed(POSE.compose(POSE.translation([0.0, 0.0, gap - lowest]), turn))


def skin(body: cg.Body, spacing: float) -> cg.Slave:
    """Points all over a box with axes along x, y and z, its corners among them."""
    low, high = body.bounds()
    axes = [np.linspace(a, b, round((b - a) / spacing) + 1) for a, b in zip(low, high, strict=True)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    p = p[((p == low) | (p == high)).any(axis=1)]
    return cg.Slave(p, area=np.full(len(p), spacing**2))


FALLS = {
    "flat": (np.eye(4), (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)),
    "on an edge": (POSE.rotation("y", 0.25 * np.pi), (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)),
    "on a corner": (
        POSE.rotation((1.0, -1.0, 0.0), np.arctan(np.sqrt(2.0))), (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)
    ),
    "tumbling": (POSE.rotation((1.0, 2.0, 0.5), 0.9), (0.6, 0.2, -0.8), (0.02, 0.05, -0.01)),
}  # fmt: skip


@pytest.mark.parametrize("name", ["on an edge", "tumbling", *full("flat", "on a corner")])
def test_a_block_that_falls_on_a_bed_keeps_its_energy(name) -> None:
    turn, velocity, spin = FALLS[name]
    body, pad = lifted(block(), turn, 0.5), bed(60.0, 3.0)
    motion = cg.motion.Free(body.mass_properties(DENSITY), velocity=velocity, spin=spin)
    simulation = cg.Simulation(
        bodies={"block": (body, motion)},
        slaves={"bed": pad},
        contacts=[cg.Contact(body, pad, law=cg.PenaltyLaw(0.03, per_area=True))],
        end=25.0,
        step="auto",
        gravity=(0.0, 0.0, -GRAVITY),
    )
    history = simulation.run().history
    touching = history["n_contact"] > 0
    assert touching.sum() > 20
    assert history["max_penetration"].max() < 9.0
    # While it touches, its kinetic energy stands apart by what a leapfrog lends, and comes back.
    size, error = np.abs(history["energy.total"]).max(), np.abs(history["energy.error"])
    assert error.max() < 2e-4 * size
    assert error[~touching].max() < 1e-4 * size


def test_two_blocks_that_meet_corner_first_keep_their_momentum() -> None:
    first = block()
    turn = POSE.compose(POSE.translation([17.0, 14.0, 26.0]), POSE.rotation((1.0, -1.0, 0.3), 0.8))
    second = first.transformed(turn)
    points = skin(first, 2.5)
    points = cg.Slave(POSE.apply(turn, points.points), area=points.area)
    motions = [
        cg.motion.Free(body.mass_properties(DENSITY), velocity=v, spin=w)
        for body, v, w in (
            (first, (0.0, 0.1, 0.5), (0.01, 0.0, 0.02)),
            (second, (-0.1, 0.0, -0.5), (0.0, -0.03, 0.01)),
        )
    ]
    simulation = cg.Simulation(
        bodies={"first": (first, motions[0]), "second": (second, motions[1])},
        slaves={"skin": (points, cg.motion.Attached("second"))},
        contacts=[cg.Contact(first, points, law=cg.PenaltyLaw(0.05, per_area=True))],
        end=30.0,
        step="auto",
    )
    result = simulation.run(keep=1)
    assert result.history["n_contact"].max() > 3
    assert result.history["n_contact"][-1] == 0
    mass = np.array([[motion.mass] for motion in motions])
    whole = []
    for state in result.states:
        linear = mass * state.rigid[:, lanes.VELOCITY :][:, :3]
        angular = np.cross(state.rigid[:, :3], linear) + state.rigid[:, lanes.MOMENTUM :][:, :3]
        whole.append(np.concatenate([linear.sum(axis=0), angular.sum(axis=0)]))
    off = np.abs(np.array(whole) - whole[0])
    assert off[:, :3].max() < 1e-12 * float(mass.sum())
    assert off[:, 3:].max() < 1e-12 * float(mass.sum()) * 60.0
    energy = result.history["energy.total"]
    assert np.abs(result.history["energy.error"]).max() < 1e-4 * energy.max()


def test_a_brick_slides_to_rest_after_the_square_of_its_speed_over_twice_the_friction() -> None:
    """The points that its front edge runs over hold it back by what its rear edge gives back."""
    mu, speed, sink = 0.3, 0.35, 0.1
    body, pad = block(), bed(60.0, 4.0, 0.37)
    mass = body.mass_properties(DENSITY).mass
    body = lifted(body, np.eye(4), -sink)
    motion = cg.motion.Free(
        body.mass_properties(DENSITY), velocity=(speed, 0.0, 0.0), hold=("rx", "ry", "rz")
    )
    law = cg.PenaltyLaw(mass * GRAVITY / (1600.0 * sink), per_area=True)
    simulation = cg.Simulation(
        bodies={"brick": (body, motion)},
        slaves={"bed": pad},
        contacts=[cg.Contact(body, pad, law=law, friction=cg.Coulomb(mu), search="penetration")],
        end=1.1 * speed / (mu * GRAVITY),
        step="auto",
        gravity=(0.0, 0.0, -GRAVITY),
    )
    history = simulation.run().history
    way = history["brick.x"] - history["brick.x"][0]
    assert way[-1] == pytest.approx(speed**2 / (2.0 * mu * GRAVITY), rel=2e-3)
    # It swings in the hollow that the points beside its edges make, no wider than it is deep.
    assert way.max() < way[-1] + sink
    assert np.abs(history["brick.y"]).max() < 1e-9
    started = history["energy.kinetic"][0]
    assert history["energy.friction"][-1] == pytest.approx(started, rel=2e-3)
    assert np.abs(history["energy.error"]).max() < 1e-4 * started


@pytest.mark.full
def test_a_hexagonal_bar_rolls_over_its_edges_and_comes_to_rest_without_creep() -> None:
    """Let go where it leans on an edge just past the balance."""
    body = plane_body("hexagonal bar").transformed(POSE.rotation("x", 0.5 * np.pi))
    body = lifted(body, POSE.rotation("y", np.radians(31.0)), 0.0)
    x, y = np.meshgrid(np.arange(-20.0, 61.0), [-15.0, -5.0, 5.0, 15.0])
    pad = cg.Slave(
        np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()]), area=np.full(x.size, 10.0)
    )
    motion = cg.motion.Free(
        body.mass_properties(DENSITY), spin=(0.0, 0.004, 0.0), hold=("y", "rx", "rz")
    )
    law = cg.PenaltyLaw(0.005, per_area=True, damping=0.06)
    simulation = cg.Simulation(
        bodies={"bar": (body, motion)},
        slaves={"bed": pad},
        contacts=[cg.Contact(body, pad, law=law, friction=cg.Coulomb(0.6))],
        end=340.0,
        step=0.08,
        gravity=(0.0, 0.0, -GRAVITY),
    )
    history = simulation.run().history
    assert np.ptp(history["bar.x"]) > 4.0
    _stays_at_rest(history, ["bar"])


def test_a_stack_of_boxes_stands_still() -> None:
    """Flush faces and corners: points of each box on the edges of the next one."""
    stiffness, spacing = 0.002, 10.0
    base = box((-40.0, -40.0, -10.0), (40.0, 40.0, 0.0))
    first = box((-20.0, -20.0, 0.0), (20.0, 20.0, 20.0))
    weight = first.mass_properties(DENSITY).mass * GRAVITY
    # Of the 25 points below each box those on an edge of the next are no deeper than that.
    carrying = np.array([25.0, 9.0, 9.0]) * spacing**2
    sinks = np.array([3.0, 2.0, 1.0]) * weight / (carrying * stiffness)
    heights = np.array([0.0, 20.0, 40.0]) - np.cumsum(sinks)
    names = ("low", "middle", "high")
    boxes = [first.transformed(POSE.translation([0.0, 0.0, z])) for z in heights]
    skins = [skin(body, spacing) for body in boxes]
    law = cg.PenaltyLaw(stiffness, per_area=True, damping=0.01)
    contacts = {
        name: cg.Contact(master, points, law=law, friction=cg.Coulomb(0.5), search="penetration")
        for name, master, points in zip(names, [base, *boxes], skins, strict=False)
    }
    free = [cg.motion.Free(body.mass_properties(DENSITY)) for body in boxes]
    simulation = cg.Simulation(
        bodies={"base": base, **dict(zip(names, zip(boxes, free, strict=True), strict=True))},
        slaves={
            f"skin of {name}": (points, cg.motion.Attached(name))
            for name, points in zip(names, skins, strict=True)
        },
        contacts=contacts,
        end=30.0,
        step=0.1,
        gravity=(0.0, 0.0, -GRAVITY),
    )
    history = simulation.run().history
    for name in names:
        for axis in "xyz":
            assert np.ptp(history[f"{name}.{axis}"]) < 1e-9
    assert history["energy.kinetic"].max() < 1e-18
    _stays_at_rest(history, names)


def _stays_at_rest(history: dict[str, np.ndarray], names: Sequence[str]) -> None:
    """In the end nothing moves, and at no time energy is made."""
    late = history["time"] > 0.93 * history["time"][-1]
    for name in names:
        for axis in "xyz":
            assert np.ptp(history[f"{name}.{axis}"][late]) < 1e-3
            assert np.abs(history[f"{name}.w{axis}"][late]).max() < 1e-4
    size = np.abs(history["energy.total"]).max()
    assert np.abs(history["energy.error"]).max() < 1e-4 * size
