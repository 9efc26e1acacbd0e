"""Faces whose edges are given only in space: the edges are projected and the loops closed.

Loops may cross the seams of closed surfaces: each p-curve starts where the one before ended,
shifted by whole turns if necessary. The patch is unrolled as far as the loops extend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import Assembly, warn
from contiga.io.cad.chart import Chart, flat_image, restrict_patch
from contiga.io.cad.loops import (
    OPEN_TOL,
    THIN_TOL,
    Loop,
    PCurve,
    align_loops,
    ends,
    exact_box,
    gaps,
    join_pcurves,
    rectangle_sides,
    translate,
    whole_periods,
)
from contiga.io.cad.warp import project_edge
from contiga.records import FloatArray

PER_SPAN = 6
"""Points of an edge per knot span and degree."""
MIN_POINTS = 33
"""Smallest number of points of an edge."""
MAX_TOLERANCES = 100.0
"""Edges farther off their surface than this many tolerances do not lie on it."""
MAX_SHARE = 5e-2
"""Edges farther off their surface than this share of its size do not lie on it either."""


class Trim(NamedTuple):
    """A piece of a loop in the file."""

    edge: int
    """Number of the edge, −1 at a pole."""
    reversed: bool


class ProjectedFace(NamedTuple):
    """A face in the file."""

    surface: NurbsSurface
    loops: list[list[Trim]]
    """The outer one first."""
    flip: bool
    """Whether its free side is the surface's other side."""
    where: str
    """Label for messages."""


def add_projected(
    assembly: Assembly, face: ProjectedFace, edges: Sequence[NurbsCurve], tolerance: float
) -> bool:
    """Project the edges of a face onto its surface and add it to `assembly`; False without area.

    `edges` are in space, by number; `tolerance` is their largest distance from the face according
    to the file, length. An edge lies on the surface up to `MAX_TOLERANCES` of that and `MAX_SHARE`
    of its size; on a parallelogram that is not examined. Each loop is shifted to begin within the
    domain; the patch is unrolled if needed.

    Warns
    -----
    ContigaWarning
        The face has no extent and is left out. Or an edge does not lie on the surface, and the
        whole surface is added. Or a loop is open by more than `OPEN_TOL` of the face, and the
        rectangle around the loops is added.
    """
    chart = Chart(face.surface)
    max_distance = min(MAX_TOLERANCES * tolerance, MAX_SHARE * chart.size)
    pcurves: dict[int, NurbsCurve] = {}
    missing: list[int] = []
    for number in {trim.edge for loop in face.loops for trim in loop}:
        if number >= 0:
            pcurve = _pcurve(chart, edges[number], max_distance)
            if pcurve is None:
                missing.append(number)
            else:
                pcurves[number] = pcurve
    if missing:
        warn(
            f"{face.where}: edge {missing[0]} does not lie on the surface to within "
            f"{max_distance:.3g}; the face is kept whole"
        )
        assembly.add_whole(face.surface, flip=face.flip)
        return True
    safe = np.where(chart.periods > 0.0, chart.periods, 1.0)
    shifted = []
    for loop in _close_loops(face.loops, pcurves, tolerance, chart):
        turns = np.floor((exact_box(loop)[0] - chart.low) / safe + 1e-9) * chart.periods
        shifted.append([translate(pcurve, -turns) for pcurve in loop])
    loops = align_loops(shifted, chart.periods)
    box = exact_box([pcurve for loop in loops for pcurve in loop])
    box = np.where(chart.periods == 0.0, np.clip(box, chart.low, chart.high), box)
    axes = [np.linspace(box[0, axis], box[1, axis], 4) for axis in range(2)]
    speed = chart.speed(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)).max(axis=0)
    extent = (box[1] - box[0]) * speed
    if extent.min() <= THIN_TOL * extent.max():
        warn(f"{face.where}: a face without extent was left out")
        return False
    patch = chart.unroll(box)
    low, high = np.array(patch.domain).T
    box = np.clip(box, low, high)
    max_gap = 0.0
    for loop in loops:
        # Gaps in space: at a pole there is none.
        last = np.array([ends(pcurve)[1] for pcurve in loop])
        distance = np.linalg.norm(chart.points(last) - chart.points(last + gaps(loop)), axis=1)
        max_gap = max(max_gap, float(distance.max()))
    sides = rectangle_sides(loops[0], box, speed) if len(loops) == 1 else None
    if max_gap > OPEN_TOL * float(np.linalg.norm(extent)):
        warn(
            f"{face.where}: a trimming loop is open by {max_gap:.3g}; the face is kept as the "
            "rectangle around its loops"
        )
        assembly.add_whole(restrict_patch(patch, box), flip=face.flip)
    elif sides is not None:
        assembly.add_whole(restrict_patch(patch, box), loops[0], sides, flip=face.flip)
    else:
        assembly.add_trimmed(patch, loops, face.where, flip=face.flip)
    return True


def _pcurve(chart: Chart, edge: NurbsCurve, max_distance: float) -> NurbsCurve | None:
    """Return the p-curve of an edge, on any turn of the surface: exact on a parallelogram.

    None if a point of the edge is farther off the surface than `max_distance`, length; on a
    parallelogram that is not examined.
    """
    flat = flat_image(chart.surface, edge)
    if flat is not None:
        return flat
    breaks = np.unique(edge.knots)
    count = max(PER_SPAN * edge.degree * (len(breaks) - 1) + 1, MIN_POINTS)
    t = np.interp(np.linspace(0, len(breaks) - 1, count), range(len(breaks)), breaks)
    path = chart.unwrap(chart.project(edge.evaluate(t)))
    rough = NurbsCurve(1, np.concatenate([t[:1], t, t[-1:]]), path)
    return project_edge(rough, edge, chart.surface, max_distance)


def _close_loops(
    loops: list[list[Trim]], curves: Mapping[int, NurbsCurve], tolerance: float, chart: Chart
) -> list[Loop]:
    """Return loops of consecutive p-curves, closed over poles and around the surface.

    Two loops that go around the surface in opposite senses become one, the border of a band; a
    single one is closed along a side of the patch. A loop of poles alone is left out. `curves` are
    the p-curves by number of the edge, `tolerance` their largest distance from it.
    """
    periods = chart.periods
    closed: list[Loop] = []
    around: list[Loop] = []
    """Loops that go around the surface and do not close in (u, v)."""
    for trims in loops:
        # A loop is cut into runs from pole to pole; without poles it is one run.
        poles = [k for k, trim in enumerate(trims) if trim.edge < 0]
        start = poles[0] if poles else 0
        runs: list[Loop] = [[]]
        for trim in trims[start:] + trims[:start]:
            if trim.edge < 0:
                runs.append([])
                continue
            curve = curves[trim.edge]
            curve = curve.reversed() if trim.reversed else curve
            runs[-1].append(PCurve(curve, trim.edge, trim.reversed, tolerance))
        runs = [join_pcurves(run, periods) for run in runs if run]
        if runs:
            loop = _close_over_poles(runs, periods)
            is_around = not poles and _turns(loop, periods).any()
            (around if is_around else closed).append(loop)
    while around:
        loop = around.pop()
        turns = _turns(loop, periods)
        back = [k for k, other in enumerate(around) if not (_turns(other, periods) + turns).any()]
        if back:  # a band between two loops
            band = join_pcurves([*loop, *around.pop(back[0])], periods)
            first, second = band[: len(loop)], band[len(loop) :]
            to_second = _line(ends(first[-1])[1], ends(second[0])[0])
            to_first = _line(ends(second[-1])[1], ends(first[0])[0])
            closed.append([*first, *to_second, *second, *to_first])
            continue
        # along the side that bounds the face, on the left of the loop
        start, end = ends(loop[0])[0], ends(loop[-1])[1]
        axis = int(np.argmax(np.abs(end - start)))
        is_forward = end[axis] > start[axis]
        side = chart.high if is_forward == (axis == 0) else chart.low
        corners = [end, end.copy(), start.copy(), start]
        for corner in corners[1:3]:
            corner[1 - axis] = side[1 - axis]
        closed.append([*loop, *(line for pair in pairwise(corners) for line in _line(*pair))])
    return closed


def _turns(loop: Loop, periods: FloatArray) -> FloatArray:
    """Return the whole periods (2,) between start and end of a loop; 0 if it does not close so.

    It closes if the rest is at most 1e-3 of the larger period.
    """
    gap = ends(loop[-1])[1] - ends(loop[0])[0]
    turns = whole_periods(gap, periods)
    meets = np.abs(gap - turns).max() <= 1e-3 * periods.max(initial=0.0)
    return np.where(meets, turns, 0.0)


def _close_over_poles(runs: list[Loop], periods: FloatArray) -> Loop:
    """Return one loop of runs between poles, each shifted by up to one turn in u and v.

    Outer loops have their face on the left, so the shift with the smallest positive area in (u, v)
    is the right one; areas are those of chords. Gaps at the poles remain.
    """
    shifts = {tuple(np.array(turns) * periods) for turns in product((0, 1, -1), repeat=2)}
    result = runs[0]
    for run in runs[1:]:
        choices = []
        areas = []
        for shift in shifts:
            choice = [*result, *(translate(pcurve, np.array(shift)) for pcurve in run)]
            # Twice the signed area in (u, v), by chords.
            x, y = np.concatenate(
                [s.curve.evaluate(np.linspace(*s.curve.domain, MIN_POINTS))[:, :2] for s in choice]
            ).T
            choices.append(choice)
            areas.append(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()))
        is_positive = np.array(areas) > 1e-9 * np.abs(areas).max()
        result = choices[int(np.where(is_positive, areas, np.inf).argmin())]
    return result


def _line(start: FloatArray, end: FloatArray) -> Loop:
    """Return a straight piece without edge; empty between equal points."""
    if not (start != end).any():
        return []
    curve = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], np.array([start, end]))
    return [PCurve(curve, -1, False, 0.0)]
