"""A motion gone through by the search alone: who comes in, how deep, who is inside at the start."""

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
from contiga.contact.thick import reach
from contiga.masters.protocol import Surface
from contiga.records import FloatArray, IntArray, rows_of
from contiga.rigid.frames import to_body
from contiga.statuses import Status

_T = TypeVar("_T", np.float64, np.int32, np.int64)
# Share of the body's size below which a point lies on the surface, as people build models.
ON_IT = 1e-6
# Share of the body's size by which a path may be off its chord: steps are long, and who comes in is
# asked for, not when.
BULGE = 1e-3
# Points inside whose depth is asked for, at most.
MAX_DEPTHS = 20_000


class DryRun(NamedTuple):
    """The findings of a search where the points of contact and the master stand."""

    pose: FloatArray
    """(4, 4) X_WB of the master."""
    rows: IntArray
    """(k,) points in contact, of those that are followed."""
    penetration: FloatArray
    """(k,) of them."""
    normal_B: FloatArray
    """(k, 3) master's normals there, body axes."""
    inside: IntArray
    """(j,) points that lie on the contact side and are not taken, as they never came in; told of
    the start only."""
    deepest: float
    """How deep the deepest of them lies."""
    from_behind: IntArray
    """(i,) points that have come to an open body from behind since the standing before: those that
    passed it, and those that are in contact although they did not come in."""


def dry_run(
    surface: Surface,
    standing: Iterable[tuple[FloatArray, FloatArray]],
    taking_part: tuple[BoolArray, int | None],
    options: Options,
) -> Iterator[DryRun]:
    """Search from one of `standing`, points (m, 3) and pose, to the next; the first is the start.

    `taking_part` are the active points, and how many of them are followed at most, spread evenly
    over them. At the start all are looked at. Inside an open body are points behind the inner of a
    face, no deeper than contact reaches.
    """
    active, most = taking_part
    options = replace(options, balls=False, bulge=BULGE)
    followed = spread(np.flatnonzero(active).astype(np.int32), most)
    whole, half = options, options.half
    if half is not None:
        options = replace(options, half=half[followed])
    all_of_them = np.ones(len(followed), dtype=bool)
    last, pose, was_held = None, np.eye(4), np.zeros(0, np.int32)
    for p_W, X_WB in standing:
        own_W = np.ascontiguousarray(p_W[followed])
        p_B = to_body(X_WB, own_W)
        inside, deepest = np.zeros(0, np.int32), 0.0
        behind = np.zeros(0, np.int32)
        if last is None:
            detected = detect_at_start(surface, p_B, all_of_them, options)
            if not options.penetration:
                inside, deepest = _inside(surface, to_body(X_WB, p_W), active, whole)
        else:
            poses = pose, X_WB
            detected = detect_on_curves(surface, p_B, last, all_of_them, options, poses)
            if not options.closed:
                behind = _from_behind(
                    surface, (last.points_B, p_B), (was_held, detected.held), options
                )
        rows = was_held = detected.held
        feet = rows_of(detected.feet, rows)
        depth = np.maximum(-feet.gap, 0.0)
        yield DryRun(X_WB, followed[rows], depth, feet.normal, inside, deepest, followed[behind])
        place = detected.feet.patch, detected.uv, detected.last_patch
        last = Last(p_B, *place, detected.safe_distance, detected.holds)
        pose = X_WB


def _from_behind(
    surface: Surface,
    way: tuple[FloatArray, FloatArray],
    held: tuple[IntArray, IntArray],
    options: Options,
) -> IntArray:
    """Find points that came from behind on their way from (m, 3) to (m, 3) and were not in contact.

    `held` are the points that were in contact, and those that are.
    """
    before, now = way
    was, is_now = held
    free = np.setdiff1d(np.flatnonzero(np.isfinite(before + now).all(axis=1)), was)
    free = free.astype(np.int32)
    away = np.zeros(len(before))
    surface.safe_distance(before, free, away)
    gone = row_lengths(now - before)
    free = free[away[free] <= gone[free]]
    # What the way back meets last is what the way met first, from the other side.
    _, sense = surface.last_crossings(now, before, free)
    came_in = free[sense < 0]
    taken, _ = _behind(
        surface, before, np.setdiff1d(is_now, np.concatenate((was, came_in))), options
    )
    return np.union1d(free[sense > 0], taken).astype(np.int32)


def spread(values: NDArray[_T], most: int | None) -> NDArray[_T]:
    """Choose at most `most` of the values, evenly spread, with the first and the last.

    All are chosen if it is None.
    """
    if most is None or len(values) <= most:
        return values
    return np.asarray(values[np.linspace(0, len(values) - 1, most).astype(np.intp)])


def _inside(
    surface: Surface, p_B: FloatArray, active: BoolArray, options: Options
) -> tuple[IntArray, float]:
    """Find the points on the contact side, and how deep the deepest of them lies."""
    rows = np.flatnonzero(active & np.isfinite(p_B).all(axis=1)).astype(np.int32)
    if options.half is not None:
        reached = reach(closest(surface, p_B, rows), p_B, rows, options)
        deep = reached.within & (reached.feet.gap < -ON_IT * options.size)
        return rows[deep], float(-reached.feet.gap[deep].min(initial=0.0))
    if not options.closed:
        away = np.zeros(len(p_B))
        surface.safe_distance(p_B, rows, away)
        behind, gap = _behind(surface, p_B, rows[away[rows] <= options.depth], options)
        near = gap >= -options.depth
        return behind[near], float(-gap[near].min(initial=0.0))
    side, _ = surface.sides(p_B, rows)
    doubtful, above = _behind(surface, p_B, rows[side == 0], options)
    within, gap = _behind(surface, p_B, spread(rows[side < 0], MAX_DEPTHS), options)
    inside = rows[side < 0] if len(within) else within
    deepest = -min(float(gap.min(initial=0.0)), float(above.min(initial=0.0)))
    return np.union1d(inside, doubtful).astype(np.int32), deepest


def _behind(
    surface: Surface, p_B: FloatArray, rows: IntArray, options: Options
) -> tuple[IntArray, FloatArray]:
    """Find those of `rows` that lie behind their feet, and their gaps."""
    feet = closest(surface, p_B, rows)
    behind = (feet.gap < -ON_IT * options.size) & (feet.status == Status.OK)
    return rows[behind], feet.gap[behind]
