"""Find springs that went beyond their tables in a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import BEYOND, end_of
from contiga.simulation.checks.scene import Scene

# Of the length of a table: what an elongation may be past its end by rounding.
_PAST = 1e-9


def check_springs_ran(scene: Scene, history: Mapping[str, FloatArray]) -> Iterator[Finding]:
    """Report springs that went past an end of their tables."""
    for name, spring in scene.model.mechanism.springs.items():
        elongation = history[f"{name}.elongation"]
        unloading = None if spring.hysteresis is None else spring.hysteresis.unloading
        for curve in (spring.curve, unloading):
            if curve is None or end_of(curve) is None:
                continue
            first, last = float(curve.x[0]), float(curve.x[-1])
            rounding = _PAST * (last - first)
            at, end, what = int(np.argmax(elongation)), last, "ends"
            if elongation[at] <= last + rounding:
                at, end, what = int(np.argmin(elongation)), first, "begins"
                # Below its start a spring may carry nothing, as one that is slack there does.
                slack = spring.hysteresis is not None or float(curve(elongation[at])) == 0.0
                if slack or elongation[at] >= first - rounding:
                    continue
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
