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
from contiga.contact.search_records import BoolArray, Options, Rows, Step, StepSearch
from contiga.contact.settle_records import Asked
from contiga.contact.ways import Start, Ways
from contiga.jit import straight
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    Hit,
    IndexArray,
    IntArray,
    Projection,
    rows_of,
)
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


def asked_of(search: StepSearch, feet: Projection | None, rows: Rows) -> Asked:
    """Collect the points of which it is not known what becomes of them.

    Points of a closed body that are known to be outside are released or stay free, and so do those
    that lie inside since the start and whose ways cross nothing. `feet` are those continued of the
    points that were in contact; None where they are not needed.
    """
    surface, step, _, detected, options, _ = search
    both = np.concatenate(rows)
    was = np.arange(len(both)) < len(rows.touching)
    side, reach = surface.sides(step.now, both)
    out = side > 0
    detected.status[both[out & was]] = ContactStatus.RELEASED
    free = out | _stay_inside(search, both, ~was & (side < 0))
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


def _stay_inside(search: StepSearch, rows: IntArray, inside: BoolArray) -> BoolArray:
    """Tell which free points lie inside since the start: they have not come in.

    A search by penetration asks how deep they are.
    """
    surface, step = search.surface, search.step
    stay = np.zeros(len(rows), dtype=bool)
    unsure = np.flatnonzero(inside & step.ignored[rows] & np.isfinite(step.way[rows]))
    if len(unsure) and not search.options.penetration:
        stay[unsure] = surface.clear_ways(step.before, step.now, rows[unsure])
        rest = unsure[~stay[unsure]]
        _, sense = search.last_crossings(rows[rest])
        stay[rest] = sense == 0
    return stay


def find(search: StepSearch, asked: Asked, which: IndexArray) -> None:
    """Ask for the closest points of some rows, where they are not known yet."""
    which = which[asked.truth.status[which] == settle_nb.NOT_ASKED]
    if len(which):
        out = closest(search.surface, search.step.now, asked.rows[which])
        take(asked.truth, which, out, np.ones(len(which), dtype=bool))


def detect(search: StepSearch, rows: Rows) -> Guards:
    """Tell what becomes of `rows`; returns those that another wall than the nearest pushes."""
    feet, touching = None, rows.touching
    if len(touching):
        start = search.last.patch[touching], search.last.uv[touching]
        now = np.ascontiguousarray(search.step.now[touching])
        feet = follow(search.surface, (None, now), start)
    if search.options.closed:
        return judge(search, asked_of(search, feet, rows))
    return _detect_open(search, feet, rows)


class PointsFound(NamedTuple):
    """The classes of points of a closed body by closest points and sides, a row each."""

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
    """Classify points by the closest points of those that are `needed`."""
    truth, sided = asked.truth, asked.side != 0
    solved = ~needed | (truth.status == Status.OK)
    inside = solved & np.where(sided, asked.side < 0, truth.gap <= 0.0)
    deep = inside & (sided | (truth.gap < -options.band))
    past = np.isfinite(step.way[asked.rows])
    free = ~asked.was & (step.ignored[asked.rows] | ~past)
    return PointsFound(needed, solved, inside, deep, free)


def judge(search: StepSearch, asked: Asked) -> Guards:
    """Tell what becomes of points of a closed body."""
    step, detected, options = search.step, search.detected, search.options
    rows, was = asked.rows, asked.was
    needed = (asked.side <= 0) | (~was & options.penetration)
    find(search, asked, np.flatnonzero(needed))
    straight(settle_nb.take_nearest)(asked, step.way, options.limits)
    if straight(settle_nb.judge_plain)(asked, step, options.limits, detected):
        return UNGUARDED
    standing = found_of(step, asked, needed, options)
    _, solved, inside, deep, free = standing
    begin = _begin(search, rows)
    entered = _entries(search, asked, standing, begin)
    missed = deep & ~was & ~entered & ~free & (not options.penetration)
    touching = inside & ((was & (asked.kept | deep)) | entered | missed)
    moved = np.flatnonzero(touching & ~asked.kept)
    gone = _gone(search, asked, begin, moved)
    take(asked.feet, moved, gone.feet, np.ones(len(moved), dtype=bool))
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[asked.kept & touching] = asked.status[asked.kept & touching]
    status[moved] = BECOMES[gone.outcome]
    status[entered] = ContactStatus.NEW
    status[missed] = ContactStatus.FOUND
    status[~solved] = ContactStatus.LOST
    write(search, asked, standing, Judged(status, touching, ~solved))
    return _guards(rows[moved], gone, touching[moved])


class Begin(NamedTuple):
    """The places where the ways of points begin, one row each, and their feet there."""

    point: FloatArray
    patch: IntArray
    uv: FloatArray


def _begin(search: StepSearch, rows: IntArray) -> Begin:
    """Return where points were at the last step, on the surface as it is now."""
    return Begin(search.begins(rows), search.last.patch[rows], search.last.uv[rows])


def _gone(search: StepSearch, asked: Asked, begin: Begin, which: IndexArray) -> Ways:
    """Go along the ways of some points, from where they begin to where the points are."""
    held = asked.guard[which], asked.depth[which], asked.opposed[which]
    start = Start(*held, begin.patch[which], begin.uv[which])
    path = begin.point[which], search.step.now[asked.rows[which]]
    return ways.gone(search.surface, path, start, rows_of(asked.truth, which), search.options)


def _guards(rows: IntArray, gone: Ways, pushed: BoolArray) -> Guards:
    """Return the guards of points that end in contact with another wall than the nearest."""
    opposed = np.flatnonzero(gone.opposed & pushed)
    order = np.argsort(rows[opposed])
    return Guards(rows[opposed][order], gone.guard[opposed][order])


def _entries(search: StepSearch, asked: Asked, standing: PointsFound, begin: Begin) -> BoolArray:
    """Tell which of the points inside have come in within the step.

    Where their ways inside begin, and what holds them there, is written: the wall where their path
    enters last. It is looked at for free points, and for those whose nearest wall is opposite: they
    may have left by one wall and come in by another.
    """
    surface, step, options = search.surface, search.step, search.options
    rows, was = asked.rows, asked.was
    if options.penetration:
        entered = standing.inside & ~was & within_depth(asked.truth, options)
        asked.guard[~was] = 0.0
    else:
        entered = np.zeros(len(rows), dtype=bool)
    unsure = standing.inside & ~asked.kept & np.isfinite(step.way[rows])
    which = np.flatnonzero(unsure & (was | (not options.penetration)))
    if len(which):
        hits, sense = search.last_crossings(rows[which])
        back = np.flatnonzero(sense > 0)
        came, there = which[back], np.ascontiguousarray(hits.point[back])
        entered[came], begin.point[came] = True, there
        begin.patch[came], begin.uv[came] = hits.patch[back], hits.uv[back]
        asked.depth[came], asked.opposed[came] = -np.inf, False
        asked.guard[came] = closest(surface, there, np.arange(len(back), dtype=np.int32)).normal
    return entered


class Judged(NamedTuple):
    """Statuses that the search gives points, one row each."""

    status: ByteArray
    touching: BoolArray
    lost: BoolArray


def write(search: StepSearch, asked: Asked, standing: PointsFound, become: Judged) -> None:
    """Write what becomes of points of a closed body into `search.detected`."""
    detected, rows, truth, touching = search.detected, asked.rows, asked.truth, become.touching
    detected.status[rows] = become.status
    take(detected.feet, rows, asked.feet, touching)
    remember(detected, rows[~touching], truth, ~touching)
    sided = np.where(asked.side != 0, asked.safe_distance, np.abs(truth.gap))
    known = sided - search.options.band
    free_way = free_distance(truth, search.options)
    free_way = np.where(standing.needed, free_way, asked.side * known)
    held = np.where(standing.inside, np.fmax(known, 0.0), 0.0)
    distance = np.where(become.lost, 0.0, np.where(touching, held, free_way))
    detected.safe_distance[rows] = distance


def _detect_open(search: StepSearch, feet: Projection | None, rows: Rows) -> Guards:
    """Tell what becomes of points of an open body."""
    surface, step, _, detected, options, _ = search
    touching, near = rows
    asked = asked_of(search, feet, Rows(touching, near[:0]))
    find(search, asked, np.arange(len(touching)))
    straight(settle_nb.take_nearest)(asked, step.way, options.limits)
    status, at, kept = asked.status.copy(), np.ones(len(touching)), asked.kept
    # Beyond a border the nearest wall is the border: the foot followed there keeps its normal.
    on_border = at_border(asked.feet) & (asked.feet.gap <= 0.0) & options.hold
    by_border = on_border & ~kept & (asked.truth.status != Status.OK)
    came_out = ~kept & ~by_border & _have_come_out(search, asked)
    status[came_out] = ContactStatus.RELEASED
    which = np.flatnonzero(~kept & ~by_border & ~came_out)
    gone = _gone(search, asked, _begin(search, touching), which)
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
    new = _come_in(search, touching[left], at[left], near)
    rest = near[detected.feet.patch[near] < 0]
    surface.safe_distance(step.now, rest, detected.safe_distance)
    return merged(guards, new)


def _have_come_out(search: StepSearch, asked: Asked) -> BoolArray:
    """Tell which points are in front of the wall that was nearest.

    The foot that was followed leads them there, and they have come through no other sheet since.
    """
    step, options = search.step, search.options
    truth, out = asked.truth, np.zeros(len(asked.rows), np.bool_)
    front = (truth.status == Status.OK) & (truth.gap > 0.0) & ~asked.opposed
    front &= apart(asked.feet, truth) <= options.limits.same_foot
    which = np.flatnonzero(front & (asked.depth - step.way[asked.rows] <= 2.0 * options.band))
    hits, sense = search.last_crossings(asked.rows[which])
    out[which] = (sense <= 0) & (hits.status != Status.BUDGET)
    return out


def _come_in(search: StepSearch, let_go: IntArray, share: FloatArray, free: IntArray) -> Guards:
    """Take the points of an open body into contact whose paths enter last.

    They are points released after a `share` (k,) of their paths, and free points.
    """
    surface, step, _, detected, options, _ = search
    rows = np.concatenate((let_go, free))
    end, all_of_them = step.now[rows], np.arange(len(rows), dtype=np.int32)
    hits, sense = search.last_crossings(free)
    if len(let_go):
        start = search.begins(let_go)
        start += share[:, None] * (step.now[let_go] - start)
        first, turn = surface.last_crossings(start, step.now[let_go], all_of_them[: len(let_go)])
        both = ((getattr(first, name), getattr(hits, name)) for name in Hit._fields)
        hits = Hit._make(map(np.concatenate, both))
        sense = np.concatenate((turn, sense))
    detected.status[rows[hits.status == Status.BUDGET]] = ContactStatus.LOST
    came = np.flatnonzero(sense > 0).astype(np.int32)
    if len(came) == 0:
        return UNGUARDED
    rows, there, n = rows[came], np.ascontiguousarray(hits.point[came]), len(came)
    guard = closest(surface, there, all_of_them[:n]).normal
    place = hits.patch[came], np.ascontiguousarray(hits.uv[came])
    begin = Start(guard, np.zeros(n), np.zeros(n, np.bool_), *place)
    nearest = closest(surface, step.now, rows)
    gone = ways.gone(surface, (there, end[came]), begin, nearest, options)
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
