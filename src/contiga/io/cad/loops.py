"""Trimming loops of CAD files: order, gaps, shifts by periods, and rectangles.

Independent of any CAD library: a p-curve is a `NurbsCurve` in (u, v) with the number of its edge.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray

ROUNDING = 1e-12
"""Rounding of parameters, as a share of a face."""
CLOSED_TOL = 1e-6
"""Largest gap, as a share of a loop, that leaves no doubt about its order."""
OPEN_TOL = 1e-3
"""Largest gap, as a share of the face, that is closed by a straight line."""
THIN_TOL = 1e-10
"""Ratio of width to length up to which a face is a line."""
RECTANGLE_TOL = 1e-7
"""Largest distance of a border from a rectangle, as a share of the face."""


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


def translate(pcurve: PCurve, shift: FloatArray) -> PCurve:
    """Return the p-curve translated by `shift` = (du, dv); for (0, 0) the same object."""
    if not shift.any():
        return pcurve
    return pcurve._replace(curve=pcurve.curve.translated([shift[0], shift[1], 0.0]))


def chain_pcurves(loop: Loop, periods: FloatArray) -> Loop:
    """Return `loop` ordered head to tail, each p-curve shifted by whole periods to the one before.

    The order of the file is kept unless it leaves a gap of more than `CLOSED_TOL` of the loop, and
    taking the nearest start next more than halves the worst one. Gaps may remain: see `gaps`. The
    first p-curve stays; none is reversed.

    Parameters
    ----------
    loop : one p-curve or more
    periods : (2,) of the surface in u and v, 0 where it is not periodic
    """
    in_order = join_pcurves(loop, periods)
    extent = float(np.ptp(np.concatenate([ends(pcurve) for pcurve in in_order]), axis=0).max())
    if worst_gap(in_order) <= CLOSED_TOL * extent:
        return in_order
    # Only then: on a surface periodic in both directions any p-curve may follow any other.
    remaining = list(loop[1:])
    by_distance = [loop[0]]
    while remaining:
        end = ends(by_distance[-1])[1]
        steps = [end - ends(pcurve)[0] for pcurve in remaining]
        lengths = [float(np.abs(s - whole_periods(s, periods)).max()) for s in steps]
        by_distance.append(remaining.pop(int(np.argmin(lengths))))
    nearest = join_pcurves(by_distance, periods)
    return nearest if worst_gap(nearest) < 0.5 * worst_gap(in_order) else in_order


def join_pcurves(loop: Loop, periods: FloatArray) -> Loop:
    """Return `loop` in its order, each p-curve shifted by whole periods to the one before.

    The first one stays. Gaps of up to half a period remain, and any in directions without one.
    """
    result = [loop[0]]
    for pcurve in loop[1:]:
        step = ends(result[-1])[1] - ends(pcurve)[0]
        result.append(translate(pcurve, whole_periods(step, periods)))
    return result


def whole_periods(step: FloatArray, periods: FloatArray) -> FloatArray:
    """Return the multiple of the periods (2,) nearest to `step` (..., 2); 0 without a period."""
    safe = np.where(periods > 0.0, periods, 1.0)
    return np.where(periods > 0.0, np.round(step / safe) * periods, 0.0)


def worst_gap(loop: Loop) -> float:
    """Return the largest gap of a loop, the maximum of |du| and |dv|, also from last to first."""
    return max(float(np.abs(gap).max()) for gap in gaps(loop))


def gaps(loop: Loop) -> FloatArray:
    """Return the vectors (n, 2) from each p-curve's end to the next start, around the loop."""
    points = np.array([ends(pcurve) for pcurve in loop])
    return np.roll(points[:, 0], -1, axis=0) - points[:, 1]


def exact_box(pcurves: Loop) -> FloatArray:
    """Return the exact box (2, 2) of p-curves, low and high (u, v), from their turning points."""
    from contiga.geometry.kernels.trim_build_nb import monotone_pieces

    points = []
    for pcurve in pcurves:
        coefs = np.ascontiguousarray(extract_curve(pcurve.curve).coefs[..., [0, 1, 3]])
        degrees = np.full(len(coefs), coefs.shape[1] - 1, dtype=np.int32)
        pieces = monotone_pieces(coefs, degrees)[0]
        points += [pieces[:, 0, :2] / pieces[:, 0, 2:], pieces[:, -1, :2] / pieces[:, -1, 2:]]
    stacked = np.concatenate(points)
    return np.array([stacked.min(axis=0), stacked.max(axis=0)])


def align_loops(loops: list[Loop], periods: FloatArray) -> list[Loop]:
    """Return all loops, each shifted by whole periods to the largest one.

    The middle of a loop's box then lies less than a period above the low bound of the largest box,
    by area in (u, v); boxes are those of Bézier control points. A single loop stays as it is.
    """
    if len(loops) < 2 or not periods.any():
        return loops
    boxes = []
    for loop in loops:
        nets = []
        for pcurve in loop:
            net = pcurve.curve.control_points[:, :2]
            if pcurve.curve.degree > 1:
                coefs = extract_curve(pcurve.curve).coefs
                net = (coefs[..., :2] / coefs[..., 3:]).reshape(-1, 2)
            nets.append(net)
        points = np.concatenate(nets)
        boxes.append(np.array([points.min(axis=0), points.max(axis=0)]))
    largest = boxes[int(np.argmax([np.prod(box[1] - box[0]) for box in boxes]))]
    result = []
    for loop, box in zip(loops, boxes, strict=True):
        # The loop may touch the border of the largest one, so its middle decides, not its ends.
        middle = 0.5 * (box[0] + box[1])
        shift = np.zeros(2)
        for axis in range(2):
            if periods[axis] > 0.0:
                slack = 1e-9 * periods[axis]
                turns = math.ceil((largest[0, axis] - slack - middle[axis]) / periods[axis])
                shift[axis] = turns * periods[axis]
        result.append([translate(pcurve, shift) for pcurve in loop])
    return result


class Sides(NamedTuple):
    """A loop recognised as the border of a rectangle."""

    side: list[int]
    """Side 0 … 3 = u0, u1, v0, v1, by p-curve."""
    against: list[bool]
    """Whether it runs against the side's growing parameter, by p-curve."""
    span: list[tuple[float, float]]
    """Interval of the side's parameter, by p-curve."""


def rectangle_sides(loop: Loop, box: FloatArray, speed: FloatArray) -> Sides | None:
    """Return the sides of `box` that the p-curves of `loop` lie on, or None if one does not.

    Parameters
    ----------
    loop : the p-curves
    box : (2, 2) low and high (u, v)
    speed : (2,) largest |S_u| and |S_v| on the face: turns misses in (u, v) into lengths

    A p-curve lies on a side if its control points miss it by no more than the p-curve's own
    tolerance and `RECTANGLE_TOL` of the face; rounding is always allowed. If it fits several, the
    best one relative to the allowed miss counts. None also unless the p-curves go round the whole
    border once, to within 1 % of its length, and none runs back and forth.
    """
    span = box[1] - box[0]
    result = Sides([], [], [])
    path_length = np.zeros(2)
    for pcurve in loop:
        points = pcurve.curve.control_points[:, :2]
        slack = np.minimum(pcurve.tolerance / np.maximum(speed, 1e-300), RECTANGLE_TOL * span)
        slack = np.maximum(slack, ROUNDING * span)
        # miss[k, axis]: distance of the points from the low (0) or high (1) line of an axis
        miss = np.abs(points[:, None, :] - box[None, :, :]).max(axis=0)
        ratio, side = min(
            (miss[k, axis] / slack[axis], 2 * axis + k) for axis in range(2) for k in range(2)
        )
        if ratio > 1.0:
            return None
        axis = 1 - side // 2
        a, b = float(points[0, axis]), float(points[-1, axis])
        if abs(a - b) < 0.5 * np.abs(np.diff(points[:, axis])).sum():
            return None
        path_length[axis] += abs(a - b)
        result.side.append(side)
        result.against.append(b < a)
        result.span.append((min(a, b), max(a, b)))
    if np.any(np.abs(path_length - 2.0 * span) > 1e-2 * span) or set(result.side) != {0, 1, 2, 3}:
        return None
    return result
