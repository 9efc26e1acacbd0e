"""Joints of a run: the ranges of their coordinates, and their reactions."""

from __future__ import annotations

from html import escape

import numpy as np

from contiga.report.html_tables import named_row, named_table
from contiga.report.run_folder import Columns, Run
from contiga.report.style import number

_COORDINATES = ("angle", "travel", "angle_1", "angle_2", "cone", "twist")
_LOST = ("energy_hysteresis", "energy_damping", "energy_friction")


def joint_table(run: Run) -> str:
    """Return the table of joints: ranges of coordinates, largest reactions, and energy lost.

    Angles are in degrees; the energy lost is that to hysteresis, damping and friction at the end.
    The table is empty for a run without joints.
    """
    units, rows = run.units, []
    for name, columns in run.joints.items():
        facts = run.summary_part("joints").get(name) or {}
        ranges = []
        for key in _COORDINATES:
            if (values := columns.get(key)) is None:
                continue
            unit = f" {units.length}"
            if key != "travel":
                values, unit = np.degrees(values), "°"
            low, high = number(float(values.min())), number(float(values.max()))
            ranges.append(f"{key} {low} to {high}{unit}")
        lost = sum(float(column[-1]) for key, column in columns.items() if key.endswith(_LOST))
        cells = [
            str(facts.get("kind", "")),
            "; ".join(ranges) or "–",
            f"{number(_largest(columns, 'f'))} {units.force}",
            f"{number(_largest(columns, 'm'))} {units.moment}",
            f"{number(lost)} {units.energy}",
        ]
        between = " – ".join(facts.get("between") or ())
        rows.append(named_row(name, between, list(map(escape, cells))))
    heads = ("Joint", "Between", "Kind", "Goes over", "Largest force", "Largest moment", "Lost")
    return named_table(heads, rows) if rows else ""


def _largest(columns: Columns, letter: str) -> float:
    """Return the largest magnitude over time of the vector with columns `letter` x, y and z."""
    squares = sum(np.square(columns[f"{letter}{axis}"]) for axis in "xyz")
    return float(np.sqrt(squares).max())
