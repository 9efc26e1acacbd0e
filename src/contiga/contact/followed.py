"""Points that keep the wall that they came in by: `foot = "tracked"`, as in the thesis.

Their feet are followed as local minima of the distance. On a closed body a point that lies inside
and whose foot is lost, or that came in by another wall, starts anew from its closest point; on an
open one the followed foot alone decides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.foot_rows import (
    apart,
    at_border,
    continued,
    follow,
    take,
    take_inside,
    within_depth,
)
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import UNGUARDED, Guards
from contiga.contact.nearest import Judged, asked_of, find, found_of, write
from contiga.contact.search_records import BoolArray, Options, Rows, StepSearch
from contiga.contact.settle_records import Asked
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IntArray, Projection, rows_of
from contiga.statuses import Status


class Tracked(NamedTuple):
    """Feet continued from where they were, and what is to become of them."""

    feet: Projection
    solved: BoolArray
    at_border: BoolArray
    keep: BoolArray
    """Inside, and on the surface or (where the options hold it) on its border."""


def track(
    surface: Surface,
    path: tuple[FloatArray | None, FloatArray],
    start: tuple[IntArray, FloatArray],
    options: Options,
) -> Tracked:
    """Continue the feet of points that went along `path` from `start` = (patch, uv).

    `path` is (before, now); without a before feet are not certified. Those that fail are the
    closest points.
    """
    out = follow(surface, path, start)
    border = at_border(out)
    solved = (out.status == Status.OK) | (out.status == Status.BRANCH_EVENT) | border
    keep = solved & (out.gap <= 0.0) & (options.hold | ~border)
    return Tracked(out, solved, border, keep)


def detect(search: StepSearch, rows: Rows) -> Guards:
    """Tell what becomes of `rows`. No wall is opposite to one that a point came in by."""
    step, last, touching = search.step, search.last, rows.touching
    way, start = (
        (step.before[touching], step.now[touching]),
        (last.patch[touching], last.uv[touching]),
    )
    tracked = track(search.surface, way, start, search.options)
    if not search.options.closed:
        _detect_open(search, tracked, rows)
        return UNGUARDED
    asked = asked_of(search, tracked.feet, rows)
    if len(asked.rows):
        held = np.flatnonzero(asked.was)
        place = np.searchsorted(touching, asked.rows[held])
        asked.kept[held], asked.status[held] = tracked.keep[place], continued(tracked.feet)[place]
        judge(search, asked)
    return UNGUARDED


def judge(search: StepSearch, asked: Asked) -> None:
    """Tell what becomes of points of a closed body."""
    options = search.options
    needed = (asked.side == 0) | (~asked.was & options.penetration)
    find(search, asked, np.flatnonzero(needed))
    if straight(settle_nb.judge_plain)(asked, search.step, options.limits, search.detected):
        return
    standing = found_of(search.step, asked, needed, options)
    _, solved, inside, deep, free = standing
    was, kept = asked.was, asked.kept
    entered, new = _come_in(search, asked, inside)
    old = kept & ~new & (inside | ~solved)
    anew = deep & ~new & ~old & (was | entered)
    missed = deep & ~new & ~old & ~anew & ~free & (not options.penetration)
    at_closest = anew | missed | (new & ~was & options.penetration)
    which = np.flatnonzero(at_closest)
    find(search, asked, which)
    take(asked.feet, which, rows_of(asked.truth, which), at_closest[which])
    lost = at_closest & (asked.feet.status != Status.OK)
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[old] = asked.status[old]
    status[new] = ContactStatus.NEW
    status[anew] = ContactStatus.REACQUIRED
    status[missed] = ContactStatus.FOUND
    status[(~solved & ~kept) | lost] = ContactStatus.LOST
    touching = (old | new | anew | missed) & ~lost
    write(search, asked, standing, Judged(status, touching, lost))


def _come_in(search: StepSearch, asked: Asked, inside: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Tell which of the points inside have come in within the step, and with a foot that does.

    What counts is the last crossing: a point may leave by one wall and come in by another. It is
    not asked of points whose feet are the closest points. The feet of those that come in are
    written into `asked.feet`.
    """
    surface, step, options = search.surface, search.step, search.options
    rows, was = asked.rows, asked.was
    entered = ~was & within_depth(asked.truth, options) & options.penetration
    new = entered.copy()
    unsure = inside & ~_same(asked, options) & np.isfinite(step.way[rows])
    which = np.flatnonzero(unsure & (was | (not options.penetration)))
    if len(which) == 0:
        return entered, new
    hits, sense = surface.last_crossings(step.before, step.now, rows[which])
    back = np.flatnonzero(sense > 0)
    find(search, asked, which[back][asked.kept[which[back]] | options.penetration])
    back = back[~_same(asked, options)[which[back]]]
    which = which[back]
    entered[which] = True
    if options.penetration:
        take(asked.feet, which, rows_of(asked.truth, which), np.ones(len(which), dtype=bool))
        new[which] = True
        return entered, new
    way = hits.point[back], step.now[rows[which]]
    tracked = track(surface, way, (hits.patch[back], hits.uv[back]), options)
    new[which] = tracked.keep
    take(asked.feet, which, tracked.feet, tracked.keep)
    return entered, new


def _same(asked: Asked, options: Options) -> BoolArray:
    """Tell which of the feet that would do are known to be the closest points."""
    known = asked.kept & (asked.truth.status != settle_nb.NOT_ASKED)
    return known & (apart(asked.feet, asked.truth) <= options.limits.same_foot)


def _detect_open(search: StepSearch, tracked: Tracked, rows: Rows) -> None:
    surface, step, _, detected, options, _ = search
    touching, near = rows
    keep = tracked.keep
    slid_off = tracked.at_border & (not options.hold)
    gone = np.where(slid_off, ContactStatus.SLID_OFF, ContactStatus.RELEASED)
    status = np.where(keep, continued(tracked.feet), gone)
    detected.status[touching] = np.where(tracked.solved, status, ContactStatus.LOST)
    detected.safe_distance[touching] = 0.0
    take(detected.feet, touching, tracked.feet, keep)
    if options.penetration:
        take_inside(surface, step.now, near, detected, options)
        return
    # A point that left one sheet may have come through another one since.
    left = touching[detected.status[touching] == ContactStatus.RELEASED]
    free = np.concatenate((left, near))
    hits, sense = surface.last_crossings(step.before, step.now, free)
    detected.status[free[hits.status == Status.BUDGET]] = ContactStatus.LOST
    entered = np.flatnonzero(sense > 0)
    came = free[entered]
    way = hits.point[entered], step.now[came]
    new = track(surface, way, (hits.patch[entered], hits.uv[entered]), options)
    status = np.where(new.at_border, ContactStatus.HELD, ContactStatus.NEW)
    detected.status[came[new.keep]] = status[new.keep]
    detected.status[came[~new.solved]] = ContactStatus.LOST
    take(detected.feet, came, new.feet, new.keep)
    rest = near[detected.feet.patch[near] < 0]
    surface.safe_distance(step.now, rest, detected.safe_distance)
