"""Where the work of whole contacts goes, against areas between curves and integrals."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga.laws.deepest import WIDTH

pose = cg.motion.pose
FACE = 1.2 * 0.8


def grid(width: float, length: float, n: int, m: int) -> cg.Slave:
    """A sheet of quadrilaterals in the plane z = 0."""
    row = np.arange(n * m).reshape(n, m)
    quads = np.stack([row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]], axis=-1)
    sheet = cg.shapes.plane(width=width, length=length)
    return cg.Slave(cg.clouds.sample(sheet, n, m), quads.reshape(-1, 4))


# Stress over strain for a pad of unit thickness; force over penetration for the whole.
LOADING, UNLOADING = [(0.0, 0.0), (0.1, 1.0), (0.3, 7.0)], [(0.0, 0.0), (0.05, 0.0), (0.3, 4.0)]
SLOPE, DEPTH = 60.0, 0.2
PADS = {
    "stress": cg.StressLaw(LOADING, 1.0, unloading=UNLOADING, hysteresis_slope=SLOPE),
    "force": cg.ForceLaw(LOADING, unloading=UNLOADING, hysteresis_slope=SLOPE, share="penetration"),
    "deepest": cg.ForceLaw(LOADING, unloading=UNLOADING, hysteresis_slope=SLOPE),
}


def loss(depth: float) -> float:
    """Up along the loading curve, down a line to the unloading curve, and along that."""
    most, least = 1.0 + 30.0 * (depth - 0.1), 16.0 * (depth - 0.05)
    under = 0.05 + 0.5 * (depth - 0.1) * (1.0 + most) - 0.5 * (depth - 0.05) * least
    return under - 0.5 * (most - least) ** 2 / (SLOPE - 16.0)


LOSS = loss(DEPTH)
# All 35 nodes are the deepest: the greatest depth stands for that of as many.
DEEPEST = DEPTH / (1.0 - WIDTH * (1.0 - 35**-0.5))
LOSSES = {"stress": FACE * LOSS, "force": LOSS, "deepest": loss(DEEPEST)}


def press(law: object, steps: int, cycles: int = 1, quadrature: str | int = "nodes") -> cg.State:
    """A plate pressed DEPTH deep on a flat pad and lifted off."""
    pad = grid(1.2, 0.8, 7, 5)
    plate = cg.Body([cg.shapes.plane(width=2.0, length=2.0, axis=(0.0, 0.0, -1.0))])
    contact = cg.Contact(plate, pad, law=law, quadrature=quadrature)  # type: ignore[arg-type]
    s = np.linspace(0.0, cycles, 2 * cycles * steps + 1)
    heights = 0.01 - (0.01 + DEPTH) * (1.0 - np.abs(1.0 - 2.0 * (s % 1.0)))
    state = contact.start(pad.points, pose.translation([0.0, 0.0, 0.01]))
    for z in heights[1:]:
        state = contact.step(state, pad.points, pose.translation([0.0, 0.0, z]))
    return state


@pytest.mark.parametrize("name", PADS)
def test_a_cycle_of_a_plate_loses_the_area_between_the_curves(name) -> None:
    expected = LOSSES[name]
    for steps in (21, 42, 84):
        energy = press(PADS[name], steps).energy
        assert energy.hysteresis == pytest.approx(expected, rel=1e-12)
        assert (energy.stored, energy.damping, energy.friction) == (0.0, 0.0, 0.0)
        assert abs(energy.error) < 2.8 * energy.hysteresis / steps**2
    twice = press(PADS[name], 21, cycles=2).energy
    assert twice.hysteresis == pytest.approx(2.0 * expected, rel=1e-12)


@pytest.mark.parametrize("quadrature", [1, 3, 6])
def test_a_cycle_loses_the_same_at_points_of_the_facets(quadrature) -> None:
    energy = press(PADS["stress"], 21, quadrature=quadrature).energy
    assert energy.hysteresis == pytest.approx(FACE * LOSS, rel=1e-12)


PADS_OF_BALL = {
    "friction": (cg.StressLaw(40.0, 1.0), cg.Coulomb(0.4)),
    "falling": (cg.StressLaw(40.0, 1.0), cg.Coulomb(0.4, 0.2, decay=3.0)),
    "viscous": (cg.StressLaw(40.0, 1.0), cg.ViscousFriction(0.4, speed=0.05)),
    "damping": (cg.StressLaw(40.0, 1.0, damping=4.0), None),
    "hysteresis": (cg.StressLaw(40.0, 1.0, unloading=20.0, hysteresis_slope=90.0), None),
    "all": (
        cg.StressLaw(40.0, 1.0, damping=4.0, unloading=20.0, hysteresis_slope=90.0),
        cg.Coulomb(0.4),
    ),
}

# Measured: of the error of the ledger over the work, times the square of the steps.
BOUNDS = {
    "friction": 14.0,
    "falling": 12.0,
    "viscous": 11.0,
    "damping": 0.4,
    "hysteresis": 9.0,
    "all": 2.5,
}


def stroke(name: str, steps: int, quadrature: str | int = "nodes") -> cg.State:
    """A ball pressed into a pad, drawn along it, turned, and lifted: one smooth motion."""
    law, friction = PADS_OF_BALL[name]
    pad, ball = grid(1.6, 1.0, 25, 17), cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(ball, pad, law=law, friction=friction, quadrature=quadrature)
    dt, state = 1.0 / steps, None
    for t in np.linspace(0.0, 1.0, steps + 1):
        high = 1.01 - 0.1 * np.sin(np.pi * t) ** 2
        way = np.array([0.3 * np.sin(2.0 * t - 1.0), 0.05 * np.sin(5.0 * t), high])
        up, turn = 0.1 * np.pi * np.sin(2.0 * np.pi * t), 0.8
        v = np.array([0.6 * np.cos(2.0 * t - 1.0), 0.25 * np.cos(5.0 * t), -up])
        X_WB = pose.compose(pose.translation(way), pose.rotation("y", turn * t))
        if state is None:
            state = contact.start(pad.points, X_WB)
            continue
        rates = {"velocity": 0.0 * pad.points, "twist": (v, (0.0, turn, 0.0))}
        state = contact.step(state, pad.points, X_WB, dt, **rates)
    assert state is not None
    return state


@pytest.mark.parametrize(
    "name", ["all", "viscous", *full("friction", "falling", "damping", "hysteresis")]
)
def test_the_ledger_of_a_stroke_closes_at_second_order(name) -> None:
    steps = np.array([30, 60, 120])
    energies = [stroke(name, int(n)).energy for n in steps]
    for e in energies:
        assert e.stored == 0.0
        parts = {"friction": e.friction, "damping": e.damping, "hysteresis": e.hysteresis}
        has = {key for key, value in parts.items() if value > 0.1 * e.work}
        kinds = {"falling": "friction", "viscous": "friction"}
        assert has == (set(parts) if name == "all" else {kinds.get(name, name)})
    errors = np.array([abs(e.error) / e.work for e in energies])
    # Nodes that come and go between two steps: of second order in the mean, no more.
    assert (errors <= BOUNDS[name] / steps**2).all()
