"""Trimming loops of CAD files: ordered, closed, shifted by periods, recognised.

Independent of any CAD library: p-curves come in as `NurbsCurve` in (u, v) with the edge they
belong to and leave as loops ready for a `Body`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray

STRAIGHT = 1e-12
"""Misses of this share of a face are rounding."""
CLOSED = 1e-6
"""Gaps of this share of a loop leave no doubt about its order."""
OPEN = 1e-3
"""A loop open by more than this share of the face is not a loop; below it is closed straight."""
THIN = 1e-10
"""Faces this much longer than wide are lines."""
LEVEL = 1e-7
"""Largest share of a face by which its border may miss the rectangle it is taken for."""


class PCurve(NamedTuple):
    """One p-curve of a loop, running in the loop's direction."""

    curve: NurbsCurve
    edge: int
    """Number of the edge in the file's topology, −1 for a collapsed side or a closing piece."""
    reversed: bool
    """Whether it runs against the edge's curve in space."""
    tolerance: float
    """Largest distance of the image from the edge, length."""


Loop = list[PCurve]


def ends(pcurve: PCurve) -> FloatArray:
    """Return start and end (2, 2) in (u, v)."""
    points = pcurve.curve.control_points
    return np.array([points[0, :2], points[-1, :2]])


def moved(pcurve: PCurve, shift: FloatArray) -> PCurve:
    """Return the p-curve translated by `shift` = (du, dv)."""
    if not shift.any():
        return pcurve
    return pcurve._replace(curve=pcurve.curve.translated([shift[0], shift[1], 0.0]))


def chained(loop: Loop, periods: FloatArray) -> Loop:
    """Return `loop` ordered head to tail, each p-curve shifted by whole periods to the last.

    Parameters
    ----------
    loop : the p-curves
    periods : (2,) of the surface in u and v, 0 where it is not periodic

    The order of the file is kept where it already closes; else the nearest start follows.
    """
    ordered = joined(loop, periods)
    reach = float(np.ptp(np.concatenate([ends(pcurve) for pcurve in ordered]), axis=0).max())
    if worst_gap(ordered) <= CLOSED * reach:
        return ordered
    # Only then: on a surface periodic in both directions any p-curve may follow any other.
    nearest = joined(_nearest_order(loop, periods), periods)
    return nearest if worst_gap(nearest) < 0.5 * worst_gap(ordered) else ordered


def joined(loop: Loop, periods: FloatArray) -> Loop:
    """Return `loop` in its order, each p-curve shifted by whole periods to the last."""
    result = [loop[0]]
    for pcurve in loop[1:]:
        step = ends(result[-1])[1] - ends(pcurve)[0]
        result.append(moved(pcurve, whole_periods(step, periods)))
    return result


def whole_periods(step: FloatArray, periods: FloatArray) -> FloatArray:
    """Return the part of `step` that is whole periods."""
    safe = np.where(periods > 0.0, periods, 1.0)
    return np.where(periods > 0.0, np.round(step / safe) * periods, 0.0)


def _nearest_order(loop: Loop, periods: FloatArray) -> Loop:
    rest = list(loop[1:])
    result = [loop[0]]
    while rest:
        here = ends(result[-1])[1]
        steps = [here - ends(pcurve)[0] for pcurve in rest]
        lengths = [float(np.abs(s - whole_periods(s, periods)).max()) for s in steps]
        result.append(rest.pop(int(np.argmin(lengths))))
    return result


def worst_gap(loop: Loop) -> float:
    """Return the largest distance in (u, v) between a p-curve's end and the next start."""
    return max(float(np.abs(gap).max()) for gap in gaps(loop))


def gaps(loop: Loop) -> FloatArray:
    """Return the vectors (n, 2) from each p-curve's end to the next start, around the loop."""
    points = np.array([ends(pcurve) for pcurve in loop])
    return np.roll(points[:, 0], -1, axis=0) - points[:, 1]


def loop_box(loop: Loop) -> FloatArray:
    """Return the box (2, 2) of the control points of a loop's Bézier segments."""
    lows, highs = [], []
    for pcurve in loop:
        if pcurve.curve.degree == 1:
            points = pcurve.curve.control_points[:, :2]
        else:
            coefs = extract_curve(pcurve.curve).coefs
            points = (coefs[..., :2] / coefs[..., 3:]).reshape(-1, 2)
        lows.append(points.min(axis=0))
        highs.append(points.max(axis=0))
    return np.array([np.min(lows, axis=0), np.max(highs, axis=0)])


def exact_box(pcurves: Loop) -> FloatArray:
    """Return the exact box (2, 2) of the p-curves of one loop or several.

    It is found at their turning points.
    """
    from contiga.geometry.kernels.trim_build_nb import monotone_pieces

    points = []
    for pcurve in pcurves:
        coefs = np.ascontiguousarray(extract_curve(pcurve.curve).coefs[..., [0, 1, 3]])
        degrees = np.full(len(coefs), coefs.shape[1] - 1, dtype=np.int32)
        pieces = monotone_pieces(coefs, degrees)[0]
        points += [pieces[:, 0, :2] / pieces[:, 0, 2:], pieces[:, -1, :2] / pieces[:, -1, 2:]]
    stacked = np.concatenate(points)
    return np.array([stacked.min(axis=0), stacked.max(axis=0)])


def aligned(loops: list[Loop], periods: FloatArray) -> list[Loop]:
    """Return all loops shifted by whole periods into the box of the largest one."""
    if len(loops) < 2 or not periods.any():
        return loops
    boxes = [loop_box(loop) for loop in loops]
    main = boxes[int(np.argmax([np.prod(box[1] - box[0]) for box in boxes]))]
    result = []
    for loop, box in zip(loops, boxes, strict=True):
        middle = 0.5 * (box[0] + box[1])
        # The loop may touch the border of the largest one, so its middle decides, not its ends.
        shift = np.zeros(2)
        for axis in range(2):
            if periods[axis] > 0.0:
                slack = 1e-9 * periods[axis]
                turns = math.ceil((main[0, axis] - slack - middle[axis]) / periods[axis])
                shift[axis] = turns * periods[axis]
        result.append([moved(pcurve, shift) for pcurve in loop])
    return result


class Sides(NamedTuple):
    """A loop recognised as the border of a rectangle."""

    side: list[int]
    """Side 0 … 3 = u0, u1, v0, v1, by p-curve."""
    against: list[bool]
    """Whether it runs against the side's growing parameter, by p-curve."""
    span: list[tuple[float, float]]
    """Interval of the side's parameter, by p-curve."""


def _nearest_side(points: FloatArray, box: FloatArray, slack: FloatArray) -> tuple[float, int]:
    """Return the nearest side of `box`, and the points' distance from it over `slack` (2,)."""
    missed = np.abs(points[:, None, :] - box[None, :, :]).max(axis=0)
    # missed[k, axis]: how far the points are from the low (0) or high (1) line of an axis
    return min((missed[k, axis] / slack[axis], 2 * axis + k) for axis in range(2) for k in range(2))


def rectangle_sides(loop: Loop, box: FloatArray, speed: FloatArray) -> Sides | None:
    """Return the sides of `box` that the p-curves of `loop` lie on, or None if one does not.

    Parameters
    ----------
    loop : the p-curves
    box : (2, 2) low and high (u, v)
    speed : (2,) largest |S_u| and |S_v| on the face: turns misses in (u, v) into lengths

    A pcurve lies on a side if its control points miss it by no more than the pcurve's own
    tolerance and `LEVEL` of the face, and the pcurves must go round the whole border once.
    """
    span = box[1] - box[0]
    result = Sides([], [], [])
    travelled = np.zeros(2)
    for pcurve in loop:
        points = pcurve.curve.control_points[:, :2]
        slack = np.minimum(pcurve.tolerance / np.maximum(speed, 1e-300), LEVEL * span)
        ratio, side = _nearest_side(points, box, np.maximum(slack, STRAIGHT * span))
        if ratio > 1.0:
            return None
        along = 1 - side // 2
        a, b = float(points[0, along]), float(points[-1, along])
        if abs(a - b) < 0.5 * np.abs(np.diff(points[:, along])).sum():
            return None
        travelled[along] += abs(a - b)
        result.side.append(side)
        result.against.append(b < a)
        result.span.append((min(a, b), max(a, b)))
    if np.any(np.abs(travelled - 2.0 * span) > 1e-2 * span) or set(result.side) != {0, 1, 2, 3}:
        return None
    return result
