"""What becomes of points of a closed body whose feet do not tell: did they come in, and where?

A point that lies outside is free. One that lies inside has come in where its path enters last; one
that did not come in anywhere is taken into contact all the same, at its closest point, and marked
FOUND. Closest points are looked for only where nothing else tells the side, or where they are the
foot.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths
from contiga.contact.asked_records import Asked
from contiga.contact.kernels import judge_nb
from contiga.contact.kernels.judge_nb import NOT_ASKED
from contiga.contact.loads import UNGUARDED, UNHELD, Guards
from contiga.contact.tracked import (
    BoolArray,
    Detected,
    Options,
    Step,
    blank,
    closest,
    remember,
    take,
    track,
)
from contiga.contact.usual_records import SAME_FOOT, judge_limits_of
from contiga.contact.walls import Known, hold
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    KnownSides,
    Projection,
    rows_of,
    stacked,
)
from contiga.statuses import Status


def asked_of(
    rows: IntArray,
    known: KnownSides,
    within: FloatArray,
    tracked: tuple[BoolArray, ByteArray, Known, Projection] | None = None,
) -> Asked:
    """Points whose sides are known so far; tracked = (kept, status, what held them, feet) of those
    that were in contact."""
    n = len(rows)
    truth = blank(n)
    truth.status[:] = NOT_ASKED
    if tracked is None:
        none = np.zeros(n, dtype=bool)
        free = none.copy(), np.zeros(n, np.int8), *known, within
        return Asked(rows, none, *free, *UNHELD.at(rows), blank(n), truth)
    kept, status, (guard, depth, opposed), feet = tracked
    was = np.ones(n, dtype=bool)
    return Asked(rows, was, kept, status, *known, within, guard, depth, opposed, feet, truth)


def joined(first: Asked, second: Asked) -> Asked:
    """Two in one."""
    columns: list[Any] = [
        np.concatenate((getattr(first, name), getattr(second, name))) for name in Asked._fields[:-2]
    ]
    columns += [stacked(first.feet, second.feet), stacked(first.truth, second.truth)]
    return Asked(*columns)


class PointsFound(NamedTuple):
    """What closest points and sides tell of the points that are asked for, a row each."""

    needed: BoolArray
    """Whose closest points were looked for."""
    solved: BoolArray
    """Whose place is known."""
    inside: BoolArray
    deep: BoolArray
    """Inside by more than rounding."""
    free: BoolArray
    """Free points that need not have come in: inside since the start, or without a past."""


def judge(
    surface: Surface, step: Step, asked: Asked, detected: Detected, options: Options
) -> Guards:
    """Fill `detected` for the points that are asked for; returns those whose nearest wall is
    opposite to the one that pushes them."""
    truth, sided = asked.truth, asked.side != 0
    needed = ~sided | (~asked.was & options.penetration)
    if options.nearest:
        needed |= asked.side < 0
    _find(surface, step, asked, np.flatnonzero(needed))
    limits = judge_limits_of(options)
    if options.nearest:
        straight(judge_nb.take_nearest)(asked, step.way, limits)
    if straight(judge_nb.judge_plain)(asked, step, limits, detected):
        return UNGUARDED
    solved = ~needed | (truth.status == Status.OK)
    inside = solved & np.where(sided, asked.side < 0, truth.gap <= 0.0)
    deep = inside & (sided | (truth.gap < -options.band))
    past = np.isfinite(step.way[asked.rows])
    free = ~asked.was & (step.ignored[asked.rows] | ~past)
    standing = PointsFound(needed, solved, inside, deep, free)
    if options.nearest:
        return _judge_nearest(surface, step, asked, standing, detected, options)
    _judge_tracked(surface, step, asked, standing, detected, options)
    return UNGUARDED


def _judge_tracked(
    surface: Surface,
    step: Step,
    asked: Asked,
    standing: PointsFound,
    detected: Detected,
    options: Options,
) -> None:
    """Fill `detected` where a point keeps the wall that it came in by."""
    was, kept = asked.was, asked.kept
    _, solved, inside, deep, free = standing
    entered, new = _come_in(surface, step, asked, inside, options)
    old = kept & ~new & (inside | ~solved)
    anew = deep & ~new & ~old & (was | entered)
    missed = deep & ~new & ~old & ~anew & ~free & (not options.penetration)
    at_closest = anew | missed | (new & ~was & options.penetration)
    lost = _give_feet(surface, step, asked, at_closest)
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[old] = asked.status[old]
    status[new] = ContactStatus.NEW
    status[anew] = ContactStatus.REACQUIRED
    status[missed] = ContactStatus.FOUND
    status[(~solved & ~kept) | lost] = ContactStatus.LOST
    _write(asked, standing, (status, (old | new | anew | missed) & ~lost, lost), detected, options)


def _judge_nearest(
    surface: Surface,
    step: Step,
    asked: Asked,
    standing: PointsFound,
    detected: Detected,
    options: Options,
) -> Guards:
    """Fill `detected` where the nearest wall that is not opposite pushes; see `judge`."""
    rows, was, truth = asked.rows, asked.was, asked.truth
    _, solved, inside, deep, free = standing
    entered, start = _entries(surface, step, asked, standing, options)
    missed = deep & ~was & ~entered & ~free & (not options.penetration)
    touching = inside & ((was & (asked.kept | deep)) | entered | missed)
    moved = np.flatnonzero(touching & ~asked.kept)
    way = start[moved], step.now[rows[moved]]
    known = asked.guard[moved], asked.depth[moved], asked.opposed[moved]
    feet, nearest = rows_of(asked.feet, moved), rows_of(truth, moved)
    held = hold(surface, way, known, feet, nearest, options.band)
    take(asked.feet, moved, held.feet, np.ones(len(moved), dtype=bool))
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[asked.kept & touching] = asked.status[asked.kept & touching]
    status[moved] = np.where(held.anew, ContactStatus.REACQUIRED, ContactStatus.OLD)
    status[entered] = ContactStatus.NEW
    status[missed] = ContactStatus.FOUND
    status[~solved] = ContactStatus.LOST
    _write(asked, standing, (status, touching, ~solved), detected, options)
    opposed = moved[held.opposed]
    order = np.argsort(rows[opposed])
    return Guards(rows[opposed][order], held.guard[held.opposed][order])


def _entries(
    surface: Surface, step: Step, asked: Asked, standing: PointsFound, options: Options
) -> tuple[BoolArray, FloatArray]:
    """Which of the points inside have come in within the step, and where ways inside start.

    Guards of those that do are written: of the wall where their path enters last. It is looked at
    for free points, and for those whose nearest wall is opposite: they may have left by one wall
    and come in by another.
    """
    rows, was = asked.rows, asked.was
    start = step.before[rows]
    if options.penetration:
        entered = standing.inside & ~was & within_depth(asked.truth, options)
        asked.guard[~was] = 0.0
    else:
        entered = np.zeros(len(rows), dtype=bool)
    unsure = standing.inside & ~asked.kept & np.isfinite(step.way[rows])
    which = np.flatnonzero(unsure & (was | (not options.penetration)))
    if len(which):
        hits, sense = surface.last_crossings(step.before, step.now, rows[which])
        back = np.flatnonzero(sense > 0)
        rows_back, there = which[back], np.ascontiguousarray(hits.point[back])
        entered[rows_back], start[rows_back] = True, there
        asked.depth[rows_back], asked.opposed[rows_back] = -np.inf, False
        feet = asked.feet
        feet.patch[rows_back], feet.uv[rows_back], feet.status[rows_back] = (
            hits.patch[back],
            hits.uv[back],
            Status.OK,
        )
        asked.guard[rows_back] = closest(
            surface, there, np.arange(len(rows_back), dtype=np.int32)
        ).normal
    return entered, start


def _write(
    asked: Asked,
    standing: PointsFound,
    become: tuple[ByteArray, BoolArray, BoolArray],
    detected: Detected,
    options: Options,
) -> None:
    """Fill `detected` with what becomes of points; `become` is (status, in contact, lost)."""
    rows, truth = asked.rows, asked.truth
    status, touching, lost = become
    detected.status[rows] = status
    take(detected.feet, rows, asked.feet, touching)
    remember(detected, rows[~touching], rows_of(truth, np.flatnonzero(~touching)))
    known = np.where(asked.side != 0, asked.safe_distance, np.abs(truth.gap)) - options.band
    free_way = np.where(standing.needed, free_distance(truth, options), asked.side * known)
    held = np.where(standing.inside, np.fmax(known, 0.0), 0.0)
    detected.safe_distance[rows] = np.where(lost, 0.0, np.where(touching, held, free_way))


def _come_in(
    surface: Surface, step: Step, asked: Asked, inside: BoolArray, options: Options
) -> tuple[BoolArray, BoolArray]:
    """Which of the points inside have come in within the step, and with a foot that does.

    What counts is the last crossing: a point may leave by one wall and come in by another. It is
    not asked of points whose feet are the closest points. The feet of those that come in are
    written into `asked.feet`.
    """
    rows, was = asked.rows, asked.was
    entered = ~was & within_depth(asked.truth, options) & options.penetration
    new = entered.copy()
    unsure = inside & ~_same(asked, options) & np.isfinite(step.way[rows])
    which = np.flatnonzero(unsure & (was | (not options.penetration)))
    if len(which) == 0:
        return entered, new
    hits, sense = surface.last_crossings(step.before, step.now, rows[which])
    back = np.flatnonzero(sense > 0)
    _find(surface, step, asked, which[back][asked.kept[which[back]] | options.penetration])
    back = back[~_same(asked, options)[which[back]]]
    which = which[back]
    entered[which] = True
    if options.penetration:
        take(asked.feet, which, rows_of(asked.truth, which), np.ones(len(which), dtype=bool))
        new[which] = True
        return entered, new
    tracked = track(
        surface,
        (hits.point[back], step.now[rows[which]]),
        (hits.patch[back], hits.uv[back]),
        options,
    )
    new[which] = tracked.keep
    take(asked.feet, which, tracked.feet, tracked.keep)
    return entered, new


def _same(asked: Asked, options: Options) -> BoolArray:
    """Which of the feet that would do are known to be the closest points."""
    apart = row_lengths(asked.feet.point - asked.truth.point)
    known = asked.kept & (asked.truth.status != NOT_ASKED)
    return known & (apart <= SAME_FOOT * options.size)


def _find(surface: Surface, step: Step, asked: Asked, which: IndexArray) -> None:
    """Ask for the closest points of some rows, where they are not known yet."""
    which = which[asked.truth.status[which] == NOT_ASKED]
    if len(which) == 0:
        return
    out = closest(surface, step.now, asked.rows[which], asked.within[which])
    take(asked.truth, which, out, np.ones(len(which), dtype=bool))


def _give_feet(surface: Surface, step: Step, asked: Asked, at_closest: BoolArray) -> BoolArray:
    """Closest points for feet; returns which of the points have none.

    Those of points that come anew do not depend on what was known of the surface near them.
    """
    which = np.flatnonzero(at_closest)
    lost = np.zeros(len(at_closest), dtype=bool)
    if len(which) == 0:
        return lost
    _find(surface, step, asked, which[asked.was[which]])
    anew = which[~asked.was[which]]
    out = closest(surface, step.now, asked.rows[anew])
    better = (out.status == Status.OK) | (asked.truth.status[anew] != Status.OK)
    take(asked.truth, anew, out, better)
    feet = rows_of(asked.truth, which)
    take(asked.feet, which, feet, np.ones(len(which), dtype=bool))
    lost[which] = feet.status != Status.OK
    return lost


def within_depth(out: Projection, options: Options) -> BoolArray:
    """Points that a search by penetration takes."""
    inside: BoolArray = (out.status == Status.OK) & (out.gap <= 0.0) & (out.gap >= -options.depth)
    return inside


def free_distance(out: Projection, options: Options) -> FloatArray:
    """`safe_distance` of free points by their closest points: zero where those were not found.

    By penetration what lies too deep is as far from contact as from that depth.
    """
    skip = max(options.band, options.depth if options.penetration else 0.0)
    safe_distance = np.where(
        out.gap > 0.0,
        np.maximum(out.gap - options.band, 0.0),
        -np.maximum(-out.gap - skip, 0.0),
    )
    return np.where(out.status == Status.OK, safe_distance, 0.0)
