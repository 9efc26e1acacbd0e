"""Follow a motion by the search alone: entries, penetrations, and points inside at the start."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import row_lengths
from contiga.contact.curved import detect_on_curves
from contiga.contact.detect import detect_at_start
from contiga.contact.foot_rows import closest
from contiga.contact.search_records import BoolArray, Last, Options
from contiga.contact.thick import measure_reach
from contiga.masters.protocol import Surface
from contiga.records import FloatArray, IntArray, rows_of
from contiga.rigid.frames import to_body
from contiga.statuses import Status

_T = TypeVar("_T", np.float64, np.int32, np.int64)
# Share of the body's size within which a point counts as on the surface: the accuracy of models.
SURFACE_TOL = 1e-6
# Share of the body's size by which a path may deviate from its chord: steps are long, and the entry
# itself matters, not its time.
BULGE = 1e-3
# Largest number of points inside whose depths are computed.
MAX_DEPTHS = 20_000


class DryRun(NamedTuple):
    """Results of the search for one placement of points and master."""

    pose: FloatArray
    """(4, 4) X_WB of the master."""
    rows: IntArray
    """(k,) points in contact, of the followed ones."""
    penetration: FloatArray
    """(k,) their penetrations."""
    normal_B: FloatArray
    """(k, 3) master's normals there, body axes."""
    inside: IntArray
    """(j,) points on the contact side that are not in contact, as they never entered; only at the
    start."""
    deepest: float
    """Largest depth of these points."""
    from_behind: IntArray
    """(i,) points that came to an open body from behind since the last placement: points that
    passed it, and points in contact that did not enter."""


def dry_run(
    surface: Surface,
    placements: Iterable[tuple[FloatArray, FloatArray]],
    taking_part: tuple[BoolArray, int | None],
    options: Options,
) -> Iterator[DryRun]:
    """Yield the search's results for each placement, points (m, 3) in world axes and a pose.

    The first placement is the start. `taking_part` are the active points, and the largest number of
    them to follow, evenly spread; None for all. A search by intersection examines all active points
    at the start. Inside an open body is a point behind a face, no deeper than contact reaches.
    """
    active, max_points = taking_part
    options = replace(options, balls=False, bulge=BULGE)
    followed = spread(np.flatnonzero(active).astype(np.int32), max_points)
    all_options, half = options, options.half
    if half is not None:
        options = replace(options, half=half[followed])
    every = np.ones(len(followed), dtype=bool)
    last: Last | None = None
    pose, last_touching = np.eye(4), np.zeros(0, np.int32)
    for p_W, X_WB in placements:
        points_W = np.ascontiguousarray(p_W[followed])
        p_B = to_body(X_WB, points_W)
        inside, deepest = np.zeros(0, np.int32), 0.0
        behind = np.zeros(0, np.int32)
        if last is None:
            detected = detect_at_start(surface, p_B, every, options)
            if not options.penetration:
                inside, deepest = _rows_inside(surface, to_body(X_WB, p_W), active, all_options)
        else:
            poses = pose, X_WB
            detected = detect_on_curves(surface, p_B, last, every, options, poses)
            if not options.closed:
                behind = _rows_from_behind(
                    surface, (last.points_B, p_B), (last_touching, detected.touching), options
                )
        rows = last_touching = detected.touching
        feet = rows_of(detected.feet, rows)
        depth = np.maximum(-feet.gap, 0.0)
        yield DryRun(X_WB, followed[rows], depth, feet.normal, inside, deepest, followed[behind])
        last, pose = detected.last(p_B), X_WB


def _rows_from_behind(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    contacts: tuple[IntArray, IntArray],
    options: Options,
) -> IntArray:
    """Return points, ascending, that came to an open body from behind on `path` = (before, now).

    They were not in contact before, and either their first crossing leads out of the back, or they
    are in contact now without having crossed to the inside, and were behind a face before.
    `contacts` are the points in contact before and now.
    """
    before, now = path
    touching_before, touching_now = contacts
    free = np.setdiff1d(np.flatnonzero(np.isfinite(before + now).all(axis=1)), touching_before)
    free = free.astype(np.int32)
    distance = np.zeros(len(before))
    surface.safe_distance(before, free, distance)
    path_length = row_lengths(now - before)
    free = free[distance[free] <= path_length[free]]
    # The last crossing of the reversed path is the first one of the path, in the other sense.
    _, sense = surface.last_crossings(now, before, free)
    entered = free[sense < 0]
    late, _ = _rows_behind(
        surface,
        before,
        np.setdiff1d(touching_now, np.concatenate((touching_before, entered))),
        options,
    )
    return np.union1d(free[sense > 0], late).astype(np.int32)


def spread(values: NDArray[_T], most: int | None) -> NDArray[_T]:
    """Return at most `most` values, evenly spread, with the first and the last; None: all."""
    if most is None or len(values) <= most:
        return values
    return np.asarray(values[np.linspace(0, len(values) - 1, most).astype(np.intp)])


def _rows_inside(
    surface: Surface, p_B: FloatArray, active: BoolArray, options: Options
) -> tuple[IntArray, float]:
    """Return the points on the contact side, ascending, and their largest depth, 0 without any.

    Points no deeper than `SURFACE_TOL` do not count. Of the points in a closed body whose side is
    known, `MAX_DEPTHS` are measured, evenly spread: all count if one of these is deep enough.
    """
    rows = np.flatnonzero(active & np.isfinite(p_B).all(axis=1)).astype(np.int32)
    if options.half is not None:
        reached = measure_reach(closest(surface, p_B, rows), p_B, rows, options)
        deep = reached.within & (reached.feet.gap < -SURFACE_TOL * options.size)
        return rows[deep], float(-reached.feet.gap[deep].min(initial=0.0))
    if not options.closed:
        away = np.zeros(len(p_B))
        surface.safe_distance(p_B, rows, away)
        behind, gap = _rows_behind(surface, p_B, rows[away[rows] <= options.depth], options)
        in_depth = gap >= -options.depth
        return behind[in_depth], float(-gap[in_depth].min(initial=0.0))
    side, _ = surface.sides(p_B, rows)
    doubtful, above = _rows_behind(surface, p_B, rows[side == 0], options)
    within, gap = _rows_behind(surface, p_B, spread(rows[side < 0], MAX_DEPTHS), options)
    inside = rows[side < 0] if len(within) else within
    deepest = -min(float(gap.min(initial=0.0)), float(above.min(initial=0.0)))
    return np.union1d(inside, doubtful).astype(np.int32), deepest


def _rows_behind(
    surface: Surface, p_B: FloatArray, rows: IntArray, options: Options
) -> tuple[IntArray, FloatArray]:
    """Return the points among `rows` that are behind their feet, and their negative gaps.

    Points no deeper than `SURFACE_TOL`, and feet on borders, do not count.
    """
    feet = closest(surface, p_B, rows)
    behind = (feet.gap < -SURFACE_TOL * options.size) & (feet.status == Status.OK)
    return rows[behind], feet.gap[behind]
