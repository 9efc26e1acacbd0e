"""Vibrations of slaves that deform: the first frequencies of a cantilever and a drum."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.special import j0

import contiga as cg
from contiga_validation.closed_forms.at_rest import disc
from contiga_validation.closed_forms.case import Answer, Cases, order_of, relative
from contiga_validation.closed_forms.foam import bricks
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import Drawing, comparison
from contiga_validation.closed_forms.scenes import run_of
from contiga_validation.engine.arrays import FloatArray

CASES = Cases(GROUP)

YOUNG, DENSITY = 3.0, 2.0
BEAM = 1.8751040687
"""The first root of cosh x cos x = −1."""
LENGTH, HEIGHT = 10.0, 0.5
DRUM = 2.404825558
"""The first root of J₀."""
POISSON, STRAIN, THICKNESS = 0.3, 1e-3, 0.1
"""Drum of radius 1: Poisson's ratio, uniform strain at rest, and thickness."""
AMPLITUDE = 1e-5
"""Amplitude over the length or the radius: all is linear."""
PERIODS = 0.75
"""Duration of a run, periods of the formula."""


class Vibration(NamedTuple):
    """Vibration of one node."""

    times: FloatArray
    displacements: FloatArray
    """Displacements (n,) over the amplitude of the formula."""
    frequency: float
    """Measured frequency over that of the formula."""


def cantilever_mode(x: FloatArray) -> FloatArray:
    """Return the first mode at `x` of a cantilever of length 1, clamped at 0, with 1 at its end."""
    b = BEAM
    share = (math.cosh(b) + math.cos(b)) / (math.sinh(b) + math.sin(b))
    mode = np.cosh(b * x) - np.cos(b * x) - share * (np.sinh(b * x) - np.sin(b * x))
    return np.asarray(mode / 2.0)


def _vibrate(
    slave: cg.Slave, motion: cg.motion.Deforming, at: FloatArray, exact: float, largest: float
) -> Vibration:
    """Run a slave that starts undisplaced with the velocities of a mode, for `PERIODS`.

    The node nearest to `at` is measured along the axis of its largest displacement. Its frequency
    follows from the last time at which it returns to zero from above. `exact` is the circular
    frequency and `largest` the amplitude of the formula.
    """
    end = PERIODS * 2.0 * math.pi / exact
    sensor = cg.NodeSensor("node", "it", at=at)
    run = run_of(slaves={"it": (slave, motion)}, end=end, step="auto", sensors=[sensor])
    history = run.history
    axis = int(np.argmax([np.abs(history[f"node.{name}"]).max() for name in "xyz"]))
    times, displacements = history["time"], history[f"node.{'xyz'[axis]}"] / largest
    (last,) = np.flatnonzero((displacements[1:-1] > 0.0) & (displacements[2:] <= 0.0))[-1:] + 1
    share = displacements[last] / (displacements[last] - displacements[last + 1])
    passed = times[last] + share * (times[last + 1] - times[last])
    # It goes up from its place at the start, so it comes down through it after n + ½ periods.
    count = round(passed * exact / math.pi)
    return Vibration(times, displacements, count * math.pi / (passed * exact))


def _cantilever_of(cells: int) -> Vibration:
    """Run a cantilever of `cells` hexahedra along it, and a tenth of them over its height."""
    across = max(cells // 10, 1)
    lines = (
        np.linspace(0.0, LENGTH, cells + 1),
        np.linspace(0.0, HEIGHT, across + 1),
        np.linspace(0.0, HEIGHT, 2),
    )
    points, elements = bricks(lines)
    exact = BEAM**2 * math.sqrt(YOUNG * HEIGHT**2 / 12.0 / DENSITY / LENGTH**4)
    speeds = np.zeros_like(points)
    speeds[:, 1] = AMPLITUDE * LENGTH * exact * cantilever_mode(points[:, 0] / LENGTH)
    fixed = np.zeros(points.shape, np.bool_)
    fixed[:, 2], fixed[points[:, 0] == 0.0] = True, True
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=YOUNG), density=DENSITY, fixed=fixed, velocity=speeds
    )
    end = elements[-1, [1, 2, 6, 5]]
    slave = cg.Slave(points, [end], elements={"hexahedron": elements})
    return _vibrate(slave, motion, np.array([LENGTH, 0.0, 0.0]), exact, AMPLITUDE * LENGTH)


def _drum_of(rings: int) -> Vibration:
    """Run a drum of `rings` rings of triangles, stretched evenly and held at the border."""
    rest, facets = disc(rings)
    tension = YOUNG * THICKNESS * STRAIN / (1.0 - POISSON)
    exact = DRUM * math.sqrt(tension / (DENSITY * THICKNESS))
    radii = np.hypot(rest[:, 0], rest[:, 1])
    speeds = np.zeros_like(rest)
    speeds[:, 2] = AMPLITUDE * exact * j0(DRUM * radii)
    stretched = rest * math.sqrt(1.0 + 2.0 * STRAIN)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=YOUNG, poisson=POISSON),
        density=DENSITY,
        thickness=THICKNESS,
        rest=rest,
        fixed=radii > 1.0 - 1e-9,
        velocity=speeds,
    )
    return _vibrate(cg.Slave(stretched, facets), motion, np.zeros(3), exact, AMPLITUDE)


def _swings(what: str, swing: Vibration) -> Drawing:
    """Return a drawing of a vibration, named `what`, over the sine of the formula."""
    curve = np.linspace(0.0, PERIODS, 200)
    times = PERIODS / swing.times[-1] * swing.times
    return comparison(
        ("t/T", "way over the largest"),
        [("formula", curve, np.sin(2.0 * math.pi * curve))],
        [(what, times, swing.displacements)],
    )


@CASES.add(
    "matter-cantilever",
    "A cantilever swings",
    "ω = 1.8751² √(E I/(ρ A L⁴))",
    "One layer of hexahedra of ν = 0, twenty times as long as high, held at one end; it starts "
    "with the speeds of its first mode. The formula is Bernoulli's: shear and the turning of "
    "sections slow the beam by a thousandth.",
)
def _cantilever() -> Answer:
    coarse, fine = _cantilever_of(10), _cantilever_of(20)
    checks = (
        relative("frequency over the formula's, 20 × 2 hexahedra", fine.frequency, 1.0, 5e-3),
        relative("from 10 × 1 and 20 × 2", (4.0 * fine.frequency - coarse.frequency) / 3.0,
                 1.0, 3e-3),
    )  # fmt: skip
    return Answer(checks, _swings("20 × 2 hexahedra", fine))


@CASES.add(
    "matter-drum",
    "A drum swings",
    "ω = 2.404826/a √(N/(ρ t))",
    "A round membrane of triangles, stretched by a thousandth and held at its border; it "
    "starts with the speeds of its first mode.",
)
def _drum() -> Answer:
    swings = {rings: _drum_of(rings) for rings in (3, 6, 12)}
    fine, coarse = swings[12].frequency, swings[6].frequency
    checks = (
        relative("frequency over the formula's, 12 rings", fine, 1.0, 4e-3),
        relative("from 6 and 12 rings", (4.0 * fine - coarse) / 3.0, 1.0, 1e-3),
    )
    order = order_of(
        "frequency, by the width of a ring",
        1.0 / 3.0,
        lambda width: abs(swings[round(1.0 / width)].frequency - 1.0),
    )
    return Answer(checks, _swings("12 rings", swings[12]), order)
