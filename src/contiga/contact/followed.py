"""Decide on points that keep the wall by which they entered: `foot = "tracked"`, as in the thesis.

Their feet are followed as local minima of the distance. On a closed body a point inside whose foot
is lost, or that entered by another wall, restarts from its closest point; on an open body the
followed foot alone decides.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.foot_rows import (
    at_border,
    copy_feet,
    distance_between,
    follow,
    kept_statuses,
    take_into_contact,
    within_depth,
)
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import UNGUARDED, Guards
from contiga.contact.nearest import Decision, candidates_of, classify, find_closest, write_decision
from contiga.contact.search_records import BoolArray, Options, Rows, StepSearch
from contiga.contact.settle_records import Candidates
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IntArray, Projection, rows_of
from contiga.statuses import Status


class TrackedFeet(NamedTuple):
    """Feet continued from where they were, and whether their points stay in contact."""

    feet: Projection
    solved: BoolArray
    """Whether the foot has converged, to the surface or to a border."""
    at_border: BoolArray
    keep: BoolArray
    """Whether the point is inside, and its foot on the surface, or on a border that may hold it."""


def track(
    surface: Surface,
    path: tuple[FloatArray | None, FloatArray],
    start: tuple[IntArray, FloatArray],
    options: Options,
) -> TrackedFeet:
    """Continue the feet of points along `path` = (before, now) from `start` = (patch, uv).

    Feet are certified only with positions before. Feet that do not converge become the closest
    points; feet at borders stay there, and their points stay in contact only with `options.hold`.
    """
    out = follow(surface, path, start)
    border = at_border(out)
    solved = (out.status == Status.OK) | (out.status == Status.BRANCH_EVENT) | border
    keep = solved & (out.gap <= 0.0) & (options.hold | ~border)
    return TrackedFeet(out, solved, border, keep)


def detect(search: StepSearch, rows: Rows) -> Guards:
    """Write the decision on `rows` into `search.detected`; return no guards: none are needed."""
    step, last, touching = search.step, search.last, rows.touching
    path, start = (
        (step.before[touching], step.now[touching]),
        (last.patch[touching], last.uv[touching]),
    )
    tracked = track(search.surface, path, start, search.options)
    if not search.options.closed:
        _detect_open(search, tracked, rows)
        return UNGUARDED
    candidates = candidates_of(search, tracked.feet, rows)
    if len(candidates.rows):
        rows_before = np.flatnonzero(candidates.was_touching)
        position = np.searchsorted(touching, candidates.rows[rows_before])
        candidates.is_kept[rows_before], candidates.status[rows_before] = (
            tracked.keep[position],
            kept_statuses(tracked.feet)[position],
        )
        decide(search, candidates)
    return UNGUARDED


def decide(search: StepSearch, candidates: Candidates) -> None:
    """Write the decision on points of a closed body into `search.detected`.

    Closest points are searched where sides or depths are unknown, and where a foot has to restart;
    a point whose closest point is not found is LOST. Closest points and new feet are written into
    `candidates`.
    """
    options = search.options
    needs_closest = (candidates.side == 0) | (~candidates.was_touching & options.penetration)
    find_closest(search, candidates, np.flatnonzero(needs_closest))
    if straight(settle_nb.decide_all)(candidates, search.step, options.limits, search.detected):
        return
    classes = classify(search.step, candidates, needs_closest, options)
    _, solved, inside, deep, may_be_free = classes
    was_touching, is_kept = candidates.was_touching, candidates.is_kept
    entered, followed = _find_entries(search, candidates, inside)
    old = is_kept & ~followed & (inside | ~solved)
    restarted = deep & ~followed & ~old & (was_touching | entered)
    missed = deep & ~followed & ~old & ~restarted & ~may_be_free & (not options.penetration)
    at_closest = restarted | missed | (followed & ~was_touching & options.penetration)
    rows = np.flatnonzero(at_closest)
    find_closest(search, candidates, rows)
    copy_feet(candidates.feet, rows, rows_of(candidates.closest, rows), at_closest[rows])
    lost = at_closest & (candidates.feet.status != Status.OK)
    status = np.where(was_touching, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[old] = candidates.status[old]
    status[followed] = ContactStatus.NEW
    status[restarted] = ContactStatus.REACQUIRED
    status[missed] = ContactStatus.FOUND
    status[(~solved & ~is_kept) | lost] = ContactStatus.LOST
    touching = (old | followed | restarted | missed) & ~lost
    write_decision(search, candidates, classes, Decision(status, touching, lost))


def _find_entries(
    search: StepSearch, candidates: Candidates, inside: BoolArray
) -> tuple[BoolArray, BoolArray]:
    """Return which points inside have entered in the step, and which of these have a new foot.

    Both are masks (k,) of the candidates. The last crossing counts: a point may leave by one wall
    and enter by another. Points whose feet are the closest points, and points without a past, are
    not examined. In a search by penetration free points within depth have entered, at their closest
    points. New feet are written into `candidates.feet`.
    """
    surface, step, options = search.surface, search.step, search.options
    rows, was_touching = candidates.rows, candidates.was_touching
    entered = ~was_touching & within_depth(candidates.closest, options) & options.penetration
    has_new_foot = entered.copy()
    unsure = inside & ~_is_closest(candidates, options) & np.isfinite(step.path_length[rows])
    chosen = np.flatnonzero(unsure & (was_touching | (not options.penetration)))
    if len(chosen) == 0:
        return entered, has_new_foot
    hits, sense = surface.last_crossings(step.before, step.now, rows[chosen])
    entering = np.flatnonzero(sense > 0)
    find_closest(
        search,
        candidates,
        chosen[entering][candidates.is_kept[chosen[entering]] | options.penetration],
    )
    entering = entering[~_is_closest(candidates, options)[chosen[entering]]]
    chosen = chosen[entering]
    entered[chosen] = True
    if options.penetration:
        copy_feet(candidates.feet, chosen, rows_of(candidates.closest, chosen))
        has_new_foot[chosen] = True
        return entered, has_new_foot
    path = hits.point[entering], step.now[rows[chosen]]
    tracked = track(surface, path, (hits.patch[entering], hits.uv[entering]), options)
    has_new_foot[chosen] = tracked.keep
    copy_feet(candidates.feet, chosen, tracked.feet, tracked.keep)
    return entered, has_new_foot


def _is_closest(candidates: Candidates, options: Options) -> BoolArray:
    """Return a mask (k,) of kept feet known to be the closest points, within `same_foot`."""
    has_both = candidates.is_kept & (candidates.closest.status != settle_nb.NOT_SEARCHED)
    return has_both & (
        distance_between(candidates.feet, candidates.closest) <= options.limits.same_foot
    )


def _detect_open(search: StepSearch, tracked: TrackedFeet, rows: Rows) -> None:
    """Write the decision on points of an open body into `search.detected`.

    The followed foot decides on points in contact; free points, and points just released, enter
    where their paths cross the surface last, from the front. The body has no inside, so that a
    search by penetration takes free points at their closest points.
    """
    surface, step, _, detected, options, _ = search
    touching, free = rows
    slid_off = tracked.at_border & (not options.hold)
    status = np.where(slid_off, ContactStatus.SLID_OFF, ContactStatus.RELEASED)
    status = np.where(tracked.keep, kept_statuses(tracked.feet), status)
    detected.status[touching] = np.where(tracked.solved, status, ContactStatus.LOST)
    detected.safe_distance[touching] = 0.0
    copy_feet(detected.feet, touching, tracked.feet, tracked.keep)
    if options.penetration:
        take_into_contact(surface, step.now, free, detected, options)
        return
    # A released point may have entered through another sheet since.
    released = touching[detected.status[touching] == ContactStatus.RELEASED]
    candidates = np.concatenate((released, free))
    hits, sense = surface.last_crossings(step.before, step.now, candidates)
    detected.status[candidates[hits.status == Status.BUDGET]] = ContactStatus.LOST
    entered = np.flatnonzero(sense > 0)
    entering = candidates[entered]
    path = hits.point[entered], step.now[entering]
    new = track(surface, path, (hits.patch[entered], hits.uv[entered]), options)
    status = np.where(new.at_border, ContactStatus.HELD, ContactStatus.NEW)
    detected.status[entering[new.keep]] = status[new.keep]
    detected.status[entering[~new.solved]] = ContactStatus.LOST
    copy_feet(detected.feet, entering, new.feet, new.keep)
    still_free = free[detected.feet.patch[free] < 0]
    surface.safe_distance(step.now, still_free, detected.safe_distance)
