"""Texts of the pictures of a preview: gaps, lengths and speeds with their units."""

from __future__ import annotations

import numpy as np

from contiga.previewing.stage import Arrow, Gap, Stage
from contiga.report.run_folder import Units
from contiga.report.style import number


def gap_text(gap: Gap, units: Units) -> str:
    """Return ``gap 2 mm``, or the depth at which the slave begins inside."""
    kind = "gap" if gap.value >= 0.0 else "starts inside by"
    return f"{kind} {number(abs(gap.value))} {units.length}".strip()


def gap_with_approach_text(gap: Gap, units: Units) -> str:
    """Return ``gap 2 mm``, with a lower bound of the distance over time if sides never meet."""
    if gap.approach is None:
        return gap_text(gap, units)
    distance = f"{number(gap.approach[0])} {units.length}".strip()
    when = f"{number(gap.approach[1])} {units.time}".strip()
    return f"{gap_text(gap, units)}, never closer than {distance} (t = {when})"


def speed_text(arrow: Arrow, units: Units) -> str:
    """Return the magnitude of a velocity with its unit: ``6.7 mm/ms``."""
    return f"{number(float(np.linalg.norm(arrow.vector)))} {units.velocity}".strip()


def span_text(axis: int, box: np.ndarray, units: Units) -> str:
    """Return two lines for an axis of a box (2, 3): ``x  300 mm``, then ``−150 to 150``."""
    low, high = (float(f"{v:.12g}") for v in box[:, axis])
    length = f"{'xyz'[axis]}  {number(high - low)} {units.length}".strip()
    return f"{length}\n{number(low)} to {number(high)}"


def legend(stage: Stage) -> list[tuple[str, str]]:
    """Return a description of each part, and its colour.

    It has the name, the number of a slave's points, the initial speed of free parts, and of driven
    ones the largest distance of their middle from its start.
    """
    speeds = {arrow.name: speed_text(arrow, stage.units) for arrow in stage.velocities}
    paths = {path.name: path.lines[0] for path in stage.paths}
    rows = []
    for part in stage.parts:
        text = part.name
        if not part.is_body:
            count, inactive = len(part.points), int((~part.active).sum())
            text += f": {number(float(count), 9)} point{'s' if count > 1 else ''}"
            if inactive:
                text += f", {number(float(inactive), 9)} of them inactive"
        if part.name in speeds:
            text += f", free, starts at {speeds[part.name]}"
        if part.name in paths:
            path = paths[part.name]
            distance = np.linalg.norm(path - path[0], axis=1).max()
            text += f", goes {number(float(distance))} {stage.units.length}".rstrip()
        rows.append((text, part.colour))
    return rows
