"""Checks of springs after a run: elongations that their tables do not know."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.laws.characteristic import Characteristic
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import BEYOND, end_of
from contiga.simulation.checks.scene import Scene

# Of the length of a table: what an elongation may be past its end by rounding.
_PAST = 1e-9


def check_springs_ran(scene: Scene, history: Mapping[str, FloatArray]) -> Iterator[Finding]:
    """Springs that went past an end of their tables."""
    for name, spring in scene.model.mechanism.springs.items():
        elongation = history[f"{name}.elongation"]
        unloading = None if spring.hysteresis is None else spring.hysteresis.unloading
        for curve in (spring.curve, unloading):
            if curve is None or end_of(curve) is None:
                continue
            passed = _passed(curve, elongation, slack=spring.hysteresis is not None)
            if passed is None:
                continue
            at, end, what = passed
            said = scene.said
            yield Finding(
                "table",
                f"spring {name}",
                f"the elongation reaches {said(float(elongation[at]))} at t = "
                f"{said(float(history['time'][at]), 'time')}, and its {curve.name} {what} at "
                f"{said(end)}: beyond that it is {BEYOND[curve.extrapolation]}",
                "Let the table go as far as the spring does; what is to be slack or to hold its "
                'force has rows that say so, or extrapolation = "constant"',
            )
            break


def _passed(
    curve: Characteristic, elongation: FloatArray, *, slack: bool
) -> tuple[int, float, str] | None:
    """Row at which an elongation is farthest past a table, the end that it passed, and a word for
    that end. Below its start a spring may carry nothing, as one that is `slack` there does."""
    first, last = float(curve.x[0]), float(curve.x[-1])
    rounding = _PAST * (last - first)
    low, high = int(np.argmin(elongation)), int(np.argmax(elongation))
    if elongation[high] > last + rounding:
        return high, last, "ends"
    if not slack and elongation[low] < first - rounding and float(curve(elongation[low])) != 0.0:
        return low, first, "begins"
    return None
