"""What becomes of points of a closed body whose feet do not tell: did they come in, and where?

A point that lies outside is free. One that lies inside has come in where its path enters last; one
that did not come in anywhere is taken into contact all the same, at its closest point, and marked
FOUND. Closest points are looked for only where nothing else tells the side, or where they are the
foot.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.contact.desk import Asked
from contiga.contact.kernels import judge_nb
from contiga.contact.kernels.judge_nb import NOT_ASKED
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
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    rows_of,
)
from contiga.statuses import Status

# Feet closer than this, relative to the body's size, are one.
SAME_FOOT = 1e-9


def asked_of(
    rows: IntArray,
    known: tuple[ByteArray, FloatArray],
    within: FloatArray,
    tracked: tuple[BoolArray, ByteArray, Projection] | None = None,
) -> Asked:
    """Points of which known = (side, reach) is; tracked = (kept, status, feet) of those that were
    in contact."""
    n = len(rows)
    truth = blank(n)
    truth.status[:] = NOT_ASKED
    if tracked is None:
        none = np.zeros(n, dtype=bool)
        return Asked(rows, none, none, np.zeros(n, np.int8), *known, within, blank(n), truth)
    kept, status, feet = tracked
    return Asked(rows, np.ones(n, dtype=bool), kept, status, *known, within, feet, truth)


def joined(first: Asked, second: Asked) -> Asked:
    """Two in one."""
    columns: list[Any] = [
        np.concatenate((getattr(first, name), getattr(second, name))) for name in Asked._fields[:7]
    ]
    columns += [_both(first.feet, second.feet), _both(first.truth, second.truth)]
    return Asked(*columns)


def _both(first: Projection, second: Projection) -> Projection:
    columns: Any = zip(first, second, strict=True)
    return Projection(*(np.concatenate(pair) for pair in columns))


def judge(surface: Surface, step: Step, asked: Asked, found: Detected, options: Options) -> None:
    """Fill `found` for the points that are asked for."""
    rows, was, kept, truth = asked.rows, asked.was, asked.kept, asked.truth
    told = asked.side != 0
    needed = ~told | (~was & options.penetration)
    _find(surface, step, asked, np.flatnonzero(needed))
    columns, limits = asked[:6], (options.penetration, options.band, options.depth)
    into = found.status, found.safe_distance, found.near, found.uv
    if judge_nb.judge_plain(
        *(columns, asked.feet, truth, (step.way, step.ignored)),
        *((*limits, SAME_FOOT * options.size), into, found.feet),
    ):
        return
    solved = ~needed | (truth.status == Status.OK)
    inside = solved & np.where(told, asked.side < 0, truth.gap <= 0.0)
    deep = inside & (told | (truth.gap < -options.band))
    entered, new = _come_in(surface, step, asked, inside, options)
    old = kept & ~new & (inside | ~solved)
    # A point that has lain inside since the start, or has no past, need not have come in.
    free = ~was & (step.ignored[rows] | ~np.isfinite(step.way[rows]))
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
    found.status[rows] = status
    touching = (old | new | anew | missed) & ~lost
    take(found.feet, rows, asked.feet, touching)
    remember(found, rows[~touching], rows_of(truth, np.flatnonzero(~touching)))
    known = np.where(told, asked.safe_distance, np.abs(truth.gap)) - options.band
    free_way = np.where(needed, free_distance(truth, options), asked.side * known)
    held = np.where(inside, np.fmax(known, 0.0), 0.0)
    found.safe_distance[rows] = np.where(lost, 0.0, np.where(touching, held, free_way))


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
    apart = np.sqrt(np.square(asked.feet.point - asked.truth.point).sum(axis=1))
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
