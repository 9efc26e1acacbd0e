"""Texts of the pictures of a preview: gaps, lengths and speeds with their units."""

from __future__ import annotations

import numpy as np

from contiga.previewing.stage import Arrow, Drawn, Gap, Stage
from contiga.report.run_folder import Units
from contiga.report.style import number


def gap_text(gap: Gap, units: Units) -> str:
    """Return ``gap 2 mm``, or the depth at which the slave begins inside."""
    kind = "gap" if gap.value >= 0.0 else "starts inside by"
    return f"{kind} {number(abs(gap.value))} {units.length}".strip()


def way_in_text(gap: Gap, units: Units) -> str:
    """Return ``gap 2 mm``, and the smallest distance of sides that never meet."""
    if gap.approach is None:
        return gap_text(gap, units)
    distance = f"{number(gap.approach[0])} {units.length}".strip()
    when = f"{number(gap.approach[1])} {units.time}".strip()
    return f"{gap_text(gap, units)}, never closer than {distance} (t = {when})"


def speed_text(arrow: Arrow, units: Units) -> str:
    """Return ``6.7 mm/ms``."""
    return f"{number(float(np.linalg.norm(arrow.vector)))} {units.velocity}".strip()


def span_text(axis: int, box: np.ndarray, units: Units) -> str:
    """Return ``x 300 mm (−150 to 150)``."""
    low, high = (float(f"{v:.12g}") for v in box[:, axis])
    length = f"{'xyz'[axis]}  {number(high - low)} {units.length}".strip()
    return f"{length}\n{number(low)} to {number(high)}"


def way_text(stage: Stage, name: str) -> str:
    """Return the largest distance of a part's middle from its start."""
    way = next(way for way in stage.ways if way.name == name)
    far = np.linalg.norm(way.lines[0] - way.lines[0, 0], axis=1).max()
    return f"goes {number(float(far))} {stage.units.length}".strip()


def legend(stage: Stage) -> list[tuple[str, str]]:
    """Return the description of each part, and its colour."""
    speeds = {arrow.name: speed_text(arrow, stage.units) for arrow in stage.velocities}
    ways = {way.name for way in stage.ways}
    rows = []
    for part in stage.parts:
        said = [part.name if part.is_body else f"{part.name}: {_points(part)}"]
        if part.name in speeds:
            said.append(f"free, starts at {speeds[part.name]}")
        if part.name in ways:
            said.append(way_text(stage, part.name))
        rows.append((", ".join(said), part.colour))
    return rows


def _points(part: Drawn) -> str:
    idle = int((~part.active).sum())
    count = len(part.points)
    points = f"{number(float(count), 9)} point{'s' if count > 1 else ''}"
    return points + (f", {number(float(idle), 9)} of them inactive" if idle else "")
