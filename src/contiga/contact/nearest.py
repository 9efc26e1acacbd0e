"""Points whose feet and sides do not tell what becomes of them, where the nearest wall pushes.

In contact means come in, and not come out since. Of a closed body the side of every point is
proved: it has come in where its path enters last, and one that did not come in anywhere is taken
into contact all the same, at its closest point, and marked FOUND. An open body has no inside: its
points come in where their paths cross it last, from the front, and come out where their walls let
go of them (`ways`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact import ways
from contiga.contact.foot_rows import (
    apart,
    at_border,
    blank,
    closest,
    follow,
    free_distance,
    remember,
    take,
    take_inside,
    within_depth,
)
from contiga.contact.kernels import settle_nb, way_nb
from contiga.contact.loads import UNGUARDED, Guards, merged
from contiga.contact.search_records import BoolArray, Detected, Options, Step
from contiga.contact.settle_records import Asked
from contiga.contact.ways import Start, Ways
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IndexArray, IntArray, Projection, rows_of
from contiga.statuses import Status

BECOMES = np.array(
    [
        ContactStatus.OLD,
        ContactStatus.OLD,
        ContactStatus.REACQUIRED,
        ContactStatus.RELEASED,
        ContactStatus.SLID_OFF,
        ContactStatus.LOST,
    ],
    np.int8,
)
"""What becomes of points in contact, by the outcome of their ways."""


def asked_of(
    surface: Surface,
    step: Step,
    feet: Projection | None,
    rows: tuple[IntArray, IntArray],
    detected: Detected,
    options: Options,
) -> Asked:
    """Points that were in contact and free ones, as far as it is not known what becomes of them.

    Points of a closed body that are known to be outside are released or stay free, and so do those
    that lie inside since the start and whose ways cross nothing. `feet` are those continued of the
    points that were in contact; None where they are not needed.
    """
    both = np.concatenate(rows)
    was = np.arange(len(both)) < len(rows[0])
    side, reach = surface.sides(step.now, both)
    out = side > 0
    detected.status[both[out & was]] = ContactStatus.RELEASED
    free = out | _stay_inside(surface, step, both, ~was & (side < 0), options)
    detected.safe_distance[both[free]] = side[free] * (reach[free] - options.band)
    detected.last_patch[both[side != 0]] = -1
    left = np.flatnonzero(~free)
    n, both, was = len(left), both[left], was[left]
    truth, own = blank(n), blank(n)
    truth.status[:] = settle_nb.NOT_ASKED
    if feet is not None:
        held = np.flatnonzero(was)
        take(own, held, rows_of(feet, left[held]), np.ones(len(held), np.bool_))
    none = np.zeros(n, np.bool_)
    within, status = np.full(n, np.inf), np.full(n, ContactStatus.OLD, np.int8)
    known = side[left], reach[left], within, *step.holds.at(both)
    return Asked(both, was, none, status, *known, own, truth)


def _stay_inside(
    surface: Surface, step: Step, rows: IntArray, inside: BoolArray, options: Options
) -> BoolArray:
    """Tell which free points lie inside since the start: they have not come in.

    A search by penetration asks how deep they are.
    """
    stay = np.zeros(len(rows), dtype=bool)
    unsure = np.flatnonzero(inside & step.ignored[rows] & np.isfinite(step.way[rows]))
    if len(unsure) == 0 or options.penetration:
        return stay
    stay[unsure] = surface.clear_ways(step.before, step.now, rows[unsure])
    rest = unsure[~stay[unsure]]
    _, sense = surface.last_crossings(step.before, step.now, rows[rest])
    stay[rest] = sense == 0
    return stay


def find(surface: Surface, step: Step, asked: Asked, which: IndexArray) -> None:
    """Ask for the closest points of some rows, where they are not known yet."""
    which = which[asked.truth.status[which] == settle_nb.NOT_ASKED]
    if len(which):
        out = closest(surface, step.now, asked.rows[which])
        take(asked.truth, which, out, np.ones(len(which), dtype=bool))


def detect(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: tuple[IntArray, IntArray],
    detected: Detected,
    options: Options,
) -> Guards:
    """Fill `detected` for points that were in contact and free ones that are near, `rows`; returns
    those that another wall than the nearest pushes. `last` is (patch, uv) of the feet of all."""
    touching, _ = rows
    feet = None
    if len(touching):
        start = last[0][touching], last[1][touching]
        feet = follow(surface, (None, np.ascontiguousarray(step.now[touching])), start)
    if options.closed:
        asked = asked_of(surface, step, feet, rows, detected, options)
        return judge(surface, step, last, asked, detected, options)
    return _detect_open(surface, step, last, feet, rows, detected, options)


class PointsFound(NamedTuple):
    """What closest points and sides tell of points of a closed body, a row each."""

    needed: BoolArray
    """Whose closest points were looked for."""
    solved: BoolArray
    """Whose place is known."""
    inside: BoolArray
    deep: BoolArray
    """Inside by more than rounding."""
    free: BoolArray
    """Free points that need not have come in: inside since the start, or without a past."""


def found_of(step: Step, asked: Asked, needed: BoolArray, options: Options) -> PointsFound:
    """Work it out from the closest points of those that are `needed`."""
    truth, sided = asked.truth, asked.side != 0
    solved = ~needed | (truth.status == Status.OK)
    inside = solved & np.where(sided, asked.side < 0, truth.gap <= 0.0)
    deep = inside & (sided | (truth.gap < -options.band))
    past = np.isfinite(step.way[asked.rows])
    free = ~asked.was & (step.ignored[asked.rows] | ~past)
    return PointsFound(needed, solved, inside, deep, free)


def judge(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    asked: Asked,
    detected: Detected,
    options: Options,
) -> Guards:
    """Fill `detected` for points of a closed body that are asked for."""
    limits, rows, was = options.limits, asked.rows, asked.was
    needed = (asked.side <= 0) | (~was & options.penetration)
    find(surface, step, asked, np.flatnonzero(needed))
    straight(settle_nb.take_nearest)(asked, step.way, limits)
    if straight(settle_nb.judge_plain)(asked, step, limits, detected):
        return UNGUARDED
    standing = found_of(step, asked, needed, options)
    _, solved, inside, deep, free = standing
    begin = Begin(step.before[rows], last[0][rows], last[1][rows])
    entered = _entries(surface, step, asked, standing, begin, options)
    missed = deep & ~was & ~entered & ~free & (not options.penetration)
    touching = inside & ((was & (asked.kept | deep)) | entered | missed)
    moved = np.flatnonzero(touching & ~asked.kept)
    gone = _gone(surface, step, asked, begin, moved, options)
    take(asked.feet, moved, gone.feet, np.ones(len(moved), dtype=bool))
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[asked.kept & touching] = asked.status[asked.kept & touching]
    status[moved] = BECOMES[gone.outcome]
    status[entered] = ContactStatus.NEW
    status[missed] = ContactStatus.FOUND
    status[~solved] = ContactStatus.LOST
    write(asked, standing, (status, touching, ~solved), detected, options)
    return _guards(rows[moved], gone, touching[moved])


class Begin(NamedTuple):
    """Where the ways of points begin, one row each, and the feet that they have there."""

    point: FloatArray
    patch: IntArray
    uv: FloatArray


def _gone(
    surface: Surface,
    step: Step,
    asked: Asked,
    begin: Begin,
    which: IndexArray,
    options: Options,
) -> Ways:
    """Go along the ways of some points, from where they begin to where the points are."""
    held = asked.guard[which], asked.depth[which], asked.opposed[which]
    start = Start(*held, begin.patch[which], begin.uv[which])
    path, nearest = (begin.point[which], step.now[asked.rows[which]]), rows_of(asked.truth, which)
    return ways.gone(surface, path, start, nearest, options.limits, options.balls)


def _guards(rows: IntArray, gone: Ways, pushed: BoolArray) -> Guards:
    """Of those points in contact that another wall than the nearest pushes at the ends of their
    ways."""
    opposed = np.flatnonzero(gone.opposed & pushed)
    order = np.argsort(rows[opposed])
    return Guards(rows[opposed][order], gone.guard[opposed][order])


def _entries(
    surface: Surface,
    step: Step,
    asked: Asked,
    standing: PointsFound,
    begin: Begin,
    options: Options,
) -> BoolArray:
    """Tell which of the points inside have come in within the step.

    Where their ways inside begin, and what holds them there, is written: the wall where their path
    enters last. It is looked at for free points, and for those whose nearest wall is opposite: they
    may have left by one wall and come in by another.
    """
    rows, was = asked.rows, asked.was
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
        came, there = which[back], np.ascontiguousarray(hits.point[back])
        entered[came], begin.point[came] = True, there
        begin.patch[came], begin.uv[came] = hits.patch[back], hits.uv[back]
        asked.depth[came], asked.opposed[came] = -np.inf, False
        asked.guard[came] = closest(surface, there, np.arange(len(back), dtype=np.int32)).normal
    return entered


def write(
    asked: Asked,
    standing: PointsFound,
    become: tuple[np.ndarray, BoolArray, BoolArray],
    detected: Detected,
    options: Options,
) -> None:
    """Fill `detected` with what becomes of points of a closed body; `become` is (status, in
    contact, lost)."""
    rows, truth = asked.rows, asked.truth
    status, touching, lost = become
    detected.status[rows] = status
    take(detected.feet, rows, asked.feet, touching)
    remember(detected, rows[~touching], truth, ~touching)
    known = np.where(asked.side != 0, asked.safe_distance, np.abs(truth.gap)) - options.band
    free_way = np.where(standing.needed, free_distance(truth, options), asked.side * known)
    held = np.where(standing.inside, np.fmax(known, 0.0), 0.0)
    detected.safe_distance[rows] = np.where(lost, 0.0, np.where(touching, held, free_way))


def _detect_open(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    feet: Projection | None,
    rows: tuple[IntArray, IntArray],
    detected: Detected,
    options: Options,
) -> Guards:
    """Fill `detected` for points of an open body."""
    touching, near = rows
    asked = asked_of(surface, step, feet, (touching, near[:0]), detected, options)
    find(surface, step, asked, np.arange(len(touching)))
    straight(settle_nb.take_nearest)(asked, step.way, options.limits)
    status, at, kept = asked.status.copy(), np.ones(len(touching)), asked.kept
    # Beyond a border the nearest wall is the border: the foot followed there keeps its normal.
    on_border = at_border(asked.feet) & (asked.feet.gap <= 0.0) & options.hold
    by_border = on_border & ~kept & (asked.truth.status != Status.OK)
    came_out = ~kept & ~by_border & _have_come_out(surface, step, asked, options)
    status[came_out] = ContactStatus.RELEASED
    which = np.flatnonzero(~kept & ~by_border & ~came_out)
    begin = Begin(step.before[touching], last[0][touching], last[1][touching])
    gone = _gone(surface, step, asked, begin, which, options)
    status[which], at[which] = BECOMES[gone.outcome], gone.at
    pushed = gone.outcome <= way_nb.ANEW
    take(asked.feet, which, gone.feet, pushed)
    slid_off = status == ContactStatus.SLID_OFF
    by_border |= on_border & slid_off
    if options.hold:  # they come out beside the border that held them
        status[slid_off] = ContactStatus.RELEASED
    status[by_border] = ContactStatus.HELD
    held = kept | by_border
    held[which[pushed]] = True
    detected.status[touching], detected.safe_distance[touching] = status, 0.0
    take(detected.feet, touching, asked.feet, held)
    guards = _guards(touching[which], gone, pushed)
    if options.penetration:
        take_inside(surface, step.now, near, detected, options)
        return guards
    # Whoever is let go of may come through another sheet on the rest of the way.
    left = np.flatnonzero(~held & ~came_out & (status != ContactStatus.LOST))
    start = step.place(touching[left], at[left])
    free = np.concatenate((touching[left], near)), np.concatenate((start, step.before[near]))
    new = _come_in(surface, step, free, detected, options)
    rest = near[detected.feet.patch[near] < 0]
    surface.safe_distance(step.now, rest, detected.safe_distance)
    return merged(guards, new)


def _have_come_out(surface: Surface, step: Step, asked: Asked, options: Options) -> BoolArray:
    """Tell which points are in front of the wall that was nearest, are led there by the foot that
    was followed, and have come through no other sheet since."""
    truth, out = asked.truth, np.zeros(len(asked.rows), np.bool_)
    front = (truth.status == Status.OK) & (truth.gap > 0.0) & ~asked.opposed
    front &= apart(asked.feet, truth) <= options.limits.same_foot
    which = np.flatnonzero(front & (asked.depth - step.way[asked.rows] <= 2.0 * options.band))
    hits, sense = surface.last_crossings(step.before, step.now, asked.rows[which])
    out[which] = (sense <= 0) & (hits.status != Status.BUDGET)
    return out


def _come_in(
    surface: Surface,
    step: Step,
    free: tuple[IntArray, FloatArray],
    detected: Detected,
    options: Options,
) -> Guards:
    """Take the points of an open body into contact whose paths come in last; `free` are their rows
    and where they start."""
    rows, start = free
    end, all_of_them = step.now[rows], np.arange(len(rows), dtype=np.int32)
    hits, sense = surface.last_crossings(start, end, all_of_them)
    detected.status[rows[hits.status == Status.BUDGET]] = ContactStatus.LOST
    came = np.flatnonzero(sense > 0).astype(np.int32)
    if len(came) == 0:
        return UNGUARDED
    rows, there, n = rows[came], np.ascontiguousarray(hits.point[came]), len(came)
    guard = closest(surface, there, all_of_them[:n]).normal
    place = hits.patch[came], np.ascontiguousarray(hits.uv[came])
    begin = Start(guard, np.zeros(n), np.zeros(n, np.bool_), *place)
    nearest, limits = closest(surface, step.now, rows), options.limits
    gone = ways.gone(surface, (there, end[came]), begin, nearest, limits, options.balls)
    pushed, feet = gone.outcome <= way_nb.ANEW, gone.feet
    status = np.where(pushed, np.int8(ContactStatus.NEW), detected.status[rows])
    if options.hold:
        followed = follow(surface, (None, end[came]), place)
        held = ~pushed & at_border(followed) & (followed.gap <= 0.0)
        status[held] = ContactStatus.HELD
        take(detected.feet, rows, followed, held)
    status[gone.outcome == way_nb.GIVEN_UP] = ContactStatus.LOST
    detected.status[rows] = status
    take(detected.feet, rows, feet, pushed)
    return _guards(rows, gone, pushed)
