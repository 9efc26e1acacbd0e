"""A cable that hangs between two points: a chain of bars comes to rest as a catenary."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.closed_forms.at_rest import resting
from contiga_validation.closed_forms.case import Answer, Cases, absolute, order_of, relative
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import comparison
from contiga_validation.engine.arrays import FloatArray

CASES = Cases(GROUP)

SPAN, LENGTH = 1.0, 1.2
YOUNG = 1e4
"""Modulus times section, over the weight per length; the tension at the ends is 8e-5 of it."""
BARS = 40


def _parabola(bars: int) -> FloatArray:
    """Return points (bars + 1, 3) of a chain of `LENGTH` on a parabola, from which it settles."""
    x = np.linspace(-0.5 * SPAN, 0.5 * SPAN, bars + 1)

    def chain(depth: float) -> FloatArray:
        return np.stack([x, 0.0 * x, depth * (4.0 * x * x / SPAN**2 - 1.0)], axis=1)

    def too_long(depth: float) -> float:
        return float(np.linalg.norm(np.diff(chain(depth), axis=0), axis=1).sum()) - LENGTH

    return chain(float(brentq(too_long, 0.01, 1.0)))


def hung(bars: int, young: float, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Return nodes (bars + 1, 3) of a chain at rest, and the force (3,) of its first support on it.

    The weight per length is 1; the force is without half the weight of a bar, which the support
    carries, too.
    """
    line = np.linspace(0.0, LENGTH, bars + 1)
    first = np.arange(bars, dtype=np.int32)
    ends = np.stack([first, first + 1], axis=1)
    cable = cg.materials.Elastic(young=young)
    motion = cg.motion.Deforming(
        parts=[
            cg.matter.Part(kind="bar2", elements=ends, material=cable, density=1.0, section=1.0)
        ],
        fixed=[0, bars],
        rest=np.stack([line, 0.0 * line, 0.0 * line], axis=1),
    )
    state = resting(cg.Slave(_parabola(bars)), motion, tolerance, gravity_size=1.0).slaves["it"]
    weight = np.array([0.0, 0.0, -0.5 * LENGTH / bars])
    return state.points, -(state.matter["force"][0] + weight)


def stretched_sag(young: float) -> float:
    """Return the sag of a cable of axial stiffness `young`, which stretches by tension over it.

    H. M. Irvine, Cable Structures, 1981.
    """
    half = 0.5 * LENGTH

    def span(pull: float) -> float:
        return 2.0 * pull * (half / young + math.asinh(half / pull))

    pull = float(brentq(lambda h: span(h) - SPAN, 0.05, 5.0))
    return 0.5 * half**2 / young + math.hypot(pull, half) - pull


@CASES.add(
    "matter-catenary",
    "A cable hangs between two points",
    "z = a (cosh(x/a) − cosh(½/a)),  H = a w,  2 a sinh(½/a) = 1.2",
    f"{BARS} bars of 1.2 in all over a span of 1, from a parabola; they stretch by 6e-5. The "
    "order is that of a cable ten times as soft beside the closed form of one that stretches.",
)
def _catenary() -> Answer:
    points, end = hung(BARS, YOUNG, 1e-4)
    # H/w of a cable that does not stretch: 2 a sinh(span/2a) = length.
    a = float(brentq(lambda a: 2.0 * a * math.sinh(0.5 * SPAN / a) - LENGTH, 0.1, 10.0))
    checks = (
        relative("sag", -points[BARS // 2, 2], a * (math.cosh(0.5 * SPAN / a) - 1.0), 1e-3),
        relative("H over the weight a length", abs(end[0]), a, 1e-3),
        relative("pull at the ends, by that", float(np.linalg.norm(end)),
                 a * math.cosh(0.5 * SPAN / a), 1e-3),
        absolute("what the ends carry less half the weight", end[2], 0.5 * LENGTH, 1e-4),
    )  # fmt: skip
    soft = 0.1 * YOUNG
    exact = stretched_sag(soft)

    def error(length: float) -> float:
        bars = round(LENGTH / length)
        return abs(-hung(bars, soft, 1e-6)[0][bars // 2, 2] - exact)

    x = np.linspace(-0.5 * SPAN, 0.5 * SPAN, 200)
    curve = a * (np.cosh(x / a) - math.cosh(0.5 * SPAN / a))
    draw = comparison(
        ("x", "z"), [("catenary", x, curve)], [(f"{BARS} bars", points[:, 0], points[:, 2])]
    )
    order = order_of("sag of a cable that stretches, by the length of bars", 0.3, error)
    return Answer(checks, draw, order)
