"""Find springs that went beyond their tables in a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import BEYOND, end_of
from contiga.simulation.checks.scene import Scene

# Elongation past the end of a table by rounding, relative.
_TABLE_TOL = 1e-9


def check_springs_ran(scene: Scene, history: Mapping[str, FloatArray]) -> Iterator[Finding]:
    """Report springs that went past an end of their tables, each once.

    A spring that is slack below its first row is not reported there.
    """
    for name, spring in scene.model.mechanism.springs.items():
        elongation = history[f"{name}.elongation"]
        unloading = None if spring.hysteresis is None else spring.hysteresis.unloading
        for curve in (spring.curve, unloading):
            if curve is None or end_of(curve) is None:
                continue
            first, last = float(curve.x[0]), float(curve.x[-1])
            rounding = _TABLE_TOL * (last - first)
            row, end, verb = int(np.argmax(elongation)), last, "ends"
            if elongation[row] <= last + rounding:
                row, end, verb = int(np.argmin(elongation)), first, "begins"
                # Below its first row a spring may be slack.
                slack = spring.hysteresis is not None or float(curve(elongation[row])) == 0.0
                if slack or elongation[row] >= first - rounding:
                    continue
            fmt = scene.fmt
            yield Finding(
                "table",
                f"spring {name}",
                f"the elongation reaches {fmt(float(elongation[row]))} at t = "
                f"{fmt(float(history['time'][row]), 'time')}, and its {curve.name} {verb} at "
                f"{fmt(end)}: beyond that it is {BEYOND[curve.extrapolation]}",
                "Let the table go as far as the spring does; what is to be slack or to hold its "
                'force has rows that say so, or extrapolation = "constant"',
            )
            break
