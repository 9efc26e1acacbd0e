"""Faces whose edges are given in space alone: their p-curves are computed and loops closed.

Loops are followed over the seams of closed surfaces: each p-curve goes on where the one before
ended, whole turns further on if need be. The patch is unrolled as far as the loops go.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.assemble import Assembly, warn
from contiga.io.cad.chart import Chart, cut_down, flat_image
from contiga.io.cad.loops import (
    OPEN,
    THIN,
    Loop,
    PCurve,
    aligned,
    ends,
    exact_box,
    gaps,
    joined,
    moved,
    rectangle_sides,
    whole_periods,
)
from contiga.io.cad.warp import on_edge
from contiga.records import FloatArray

PER_SPAN = 6
"""Points of an edge per knot span and degree."""
FEWEST = 33
FAR = 100.0
"""Edges farther off their surface than this many tolerances do not lie on it."""
FARTHEST = 5e-2
"""Edges farther off their surface than this share of its size do not lie on it either."""


class Trim(NamedTuple):
    """A piece of a loop in the file."""

    edge: int
    """Number of the edge, −1 at a pole."""
    reversed: bool


class DrawnFace(NamedTuple):
    """A face in the file."""

    surface: NurbsSurface
    loops: list[list[Trim]]
    """The outer one first."""
    turned: bool
    """Whether its free side is the surface's other side."""
    where: str
    """Label for messages."""


class _Runs(NamedTuple):
    """The p-curves of a loop from pole to pole; all of them if it passes none."""

    runs: list[Loop]
    over_poles: bool


def add_drawn(
    assembly: Assembly, face: DrawnFace, edges: Sequence[NurbsCurve], tolerance: float
) -> bool:
    """Add a face if it has an area; return whether it has.

    `edges` are in space; `tolerance` is their largest distance from the face, length.

    Warns
    -----
    ContigaWarning
        The face has no extent and is left out; its loops do not close or an edge does not lie on
        it, and it is kept as the rectangle around its loops.
    """
    chart = Chart(face.surface)
    far = min(FAR * tolerance, FARTHEST * chart.size)
    drawn = {
        number: _pcurve(chart, edges[number], far)
        for number in {trim.edge for loop in face.loops for trim in loop}
        if number >= 0
    }
    lost = [number for number, curve in drawn.items() if curve is None]
    if lost:
        warn(
            f"{face.where}: edge {lost[0]} does not lie on the surface to within "
            f"{far:.3g}; the face is kept whole"
        )
        assembly.add_whole(face.surface, flip=face.turned)
        return True
    known = {number: curve for number, curve in drawn.items() if curve is not None}
    loops = _close_loops([_runs(loop, known, tolerance) for loop in face.loops], chart)
    return _add_closed(assembly, face, loops, chart)


def _pcurve(chart: Chart, edge: NurbsCurve, far: float) -> NurbsCurve | None:
    """Return the p-curve of an edge, on any turn of the surface; None if it is off the surface."""
    flat = flat_image(chart.surface, edge)
    if flat is not None:
        return flat
    breaks = np.unique(edge.knots)
    count = max(PER_SPAN * edge.degree * (len(breaks) - 1) + 1, FEWEST)
    t = np.interp(np.linspace(0, len(breaks) - 1, count), range(len(breaks)), breaks)
    track = chart.continued(chart.located(edge.evaluate(t)))
    rough = NurbsCurve(1, np.concatenate([t[:1], t, t[-1:]]), track)
    return on_edge(rough, edge, chart.surface, far)


def _runs(loop: list[Trim], drawn: dict[int, NurbsCurve], tolerance: float) -> _Runs:
    poles = [k for k, trim in enumerate(loop) if trim.edge < 0]
    first = poles[0] if poles else 0
    runs: list[Loop] = [[]]
    for trim in loop[first:] + loop[:first]:
        if trim.edge < 0:
            runs.append([])
            continue
        curve = drawn[trim.edge]
        curve = curve.reversed() if trim.reversed else curve
        runs[-1].append(PCurve(curve, trim.edge, trim.reversed, tolerance))
    return _Runs([run for run in runs if run], len(poles) > 0)


def _close_loops(loops: list[_Runs], chart: Chart) -> list[Loop]:
    """Return loops of consecutive p-curves, closed over poles and around the surface."""
    periods = chart.periods
    closed: list[Loop] = []
    endless: list[Loop] = []
    for runs, over_poles in loops:
        if runs:
            loop = _close_over_poles([joined(run, periods) for run in runs], periods)
            goes_round = not over_poles and _turns(loop, periods).any()
            (endless if goes_round else closed).append(loop)
    while endless:
        loop = endless.pop()
        turns = _turns(loop, periods)
        back = [k for k, one in enumerate(endless) if not (_turns(one, periods) + turns).any()]
        if back:  # a band between two loops
            band = joined([*loop, *endless.pop(back[0])], periods)
            first, second = band[: len(loop)], band[len(loop) :]
            closed.append(
                [*first, *_connection(first, second), *second, *_connection(second, first)]
            )
        else:
            closed.append(_close_at_side(loop, chart))
    return closed


def _turns(loop: Loop, periods: FloatArray) -> FloatArray:
    """Return the whole periods (2,) between the start and the end of a loop."""
    gap = ends(loop[-1])[1] - ends(loop[0])[0]
    near = whole_periods(gap, periods)
    meets = np.abs(gap - near).max() <= 1e-3 * periods.max(initial=0.0)
    return np.where(meets, near, 0.0)


def _close_over_poles(runs: list[Loop], periods: FloatArray) -> Loop:
    """Return one loop of runs between poles, which may be any number of turns apart.

    Outer loops have their face on the left, so that the smallest positive area is it.
    """
    ways = {tuple(np.array(way) * periods) for way in product((0, 1, -1), repeat=2)}
    result = runs[0]
    for run in runs[1:]:
        choices = [[*result, *(moved(pcurve, np.array(way)) for pcurve in run)] for way in ways]
        areas = np.array([_area(choice) for choice in choices])
        positive = areas > 1e-9 * np.abs(areas).max()
        result = choices[int(np.where(positive, areas, np.inf).argmin())]
    return result


def _area(loop: Loop) -> float:
    """Return twice the area of a loop in (u, v), positive if anticlockwise, by chords."""
    x, y = np.concatenate(
        [s.curve.evaluate(np.linspace(*s.curve.domain, FEWEST))[:, :2] for s in loop]
    ).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _close_at_side(loop: Loop, chart: Chart) -> Loop:
    """Close a loop around the surface along the side that bounds its face, on its left."""
    start, end = ends(loop[0])[0], ends(loop[-1])[1]
    axis = int(np.argmax(np.abs(end - start)))
    onward = end[axis] > start[axis]
    side = chart.high if onward == (axis == 0) else chart.low
    corners = [end, end.copy(), start.copy(), start]
    for corner in corners[1:3]:
        corner[1 - axis] = side[1 - axis]
    return [*loop, *(line for pair in pairwise(corners) for line in _line(*pair))]


def _connection(one: Loop, other: Loop) -> Loop:
    """Return the connection from the end of some p-curves to the start of others."""
    return _line(ends(one[-1])[1], ends(other[0])[0])


def _line(start: FloatArray, end: FloatArray) -> Loop:
    """Return a straight piece without edge; empty between equal points."""
    if not (start != end).any():
        return []
    curve = NurbsCurve(1, [0.0, 0.0, 1.0, 1.0], np.array([start, end]))
    return [PCurve(curve, -1, False, 0.0)]


def _add_closed(assembly: Assembly, face: DrawnFace, loops: list[Loop], chart: Chart) -> bool:
    loops = [_shift_into_domain(loop, chart) for loop in loops]
    loops = aligned(loops, chart.periods)
    box = exact_box([pcurve for loop in loops for pcurve in loop])
    open_ways = chart.periods == 0.0
    box = np.where(open_ways, np.clip(box, chart.low, chart.high), box)
    speed = _speed(chart, box)
    extent = (box[1] - box[0]) * speed
    if extent.min() <= THIN * extent.max():
        warn(f"{face.where}: a face without extent was left out")
        return False
    patch = chart.unrolled(box)
    low, high = np.array(patch.domain).T
    box = np.clip(box, low, high)
    worst = max(_largest_gap(loop, chart) for loop in loops)
    sides = rectangle_sides(loops[0], box, speed) if len(loops) == 1 else None
    if worst > OPEN * float(np.linalg.norm(extent)):
        warn(
            f"{face.where}: a trimming loop is open by {worst:.3g}; the face is kept as the "
            "rectangle around its loops"
        )
        assembly.add_whole(cut_down(patch, box), flip=face.turned)
    elif sides is not None:
        assembly.add_whole(cut_down(patch, box), loops[0], sides, flip=face.turned)
    else:
        assembly.add_trimmed(patch, loops, face.where, flip=face.turned)
    return True


def _shift_into_domain(loop: Loop, chart: Chart) -> Loop:
    """Return a loop shifted by whole turns so that it begins within the domain."""
    low = exact_box(loop)[0]
    safe = np.where(chart.periods > 0.0, chart.periods, 1.0)
    turns = np.floor((low - chart.low) / safe + 1e-9) * chart.periods
    return [moved(pcurve, -turns) for pcurve in loop]


def _speed(chart: Chart, box: FloatArray) -> FloatArray:
    """Return the largest |S_u| and |S_v| (2,) over a box."""
    axes = [np.linspace(box[0, axis], box[1, axis], 4) for axis in range(2)]
    largest: FloatArray = chart.speed(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)).max(
        axis=0
    )
    return largest


def _largest_gap(loop: Loop, chart: Chart) -> float:
    """Return the largest gap of a loop in space; poles are no gaps."""
    last = np.array([ends(pcurve)[1] for pcurve in loop])
    apart = chart.points(last) - chart.points(last + gaps(loop))
    return float(np.linalg.norm(apart, axis=1).max())
