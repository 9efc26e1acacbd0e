"""Decide on points that the kernels of `settle` leave, where the nearest wall pushes.

A point is in contact if it has entered the body and not left it since. On a closed body the side of
every point is proved: a point enters where its path crosses the surface last; a point inside
without such a crossing is taken into contact at its closest point and marked FOUND. An open body
has no inside: points enter where their paths cross it last, from the front, and leave where their
walls release them (`deep_paths`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact import deep_paths
from contiga.contact.deep_paths import DeepPaths, WallStates
from contiga.contact.foot_rows import (
    at_border,
    blank,
    closest,
    copy_feet,
    distance_between,
    follow,
    free_distance,
    store_feet,
    take_into_contact,
    within_depth,
)
from contiga.contact.kernels import deep_path_nb, settle_nb
from contiga.contact.loads import UNGUARDED, Guards, merged
from contiga.contact.search_records import BoolArray, Options, Rows, Step, StepSearch
from contiga.contact.settle_records import Candidates
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

STATUS_OF_OUTCOME = np.array(
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
"""Statuses of points that were in contact, by the outcomes of their paths: see `deep_path_nb`."""


def candidates_of(search: StepSearch, feet: Projection | None, rows: Rows) -> Candidates:
    """Collect the points whose status is still open; decide on the others.

    On a closed body points known to be outside are released or stay free, and points inside since
    the start whose paths cross nothing stay free: both are written into `search.detected`, and last
    feet are forgotten where the side is known. `feet` are the continued feet of `rows.touching`;
    None if they are not needed. No closest point is searched yet.
    """
    surface, step, _, detected, options, _ = search
    points = np.concatenate(rows)
    was_touching = np.arange(len(points)) < len(rows.touching)
    side, reach = surface.sides(step.now, points)
    outside = side > 0
    detected.status[points[outside & was_touching]] = ContactStatus.RELEASED
    # Free points inside since the start stay free if their paths cross nothing; in a search by
    # penetration their depths decide.
    stays = np.zeros(len(points), dtype=bool)
    has_past = np.isfinite(step.path_length[points])
    unsure = np.flatnonzero(~was_touching & (side < 0) & step.inside_since_start[points] & has_past)
    if len(unsure) and not options.penetration:
        stays[unsure] = surface.clear_paths(step.before, step.now, points[unsure])
        unsure = unsure[~stays[unsure]]
        _, sense = search.last_crossings(points[unsure])
        stays[unsure] = sense == 0
    is_free = outside | stays
    detected.safe_distance[points[is_free]] = side[is_free] * (reach[is_free] - options.band)
    detected.last_patch[points[side != 0]] = -1
    open_rows = np.flatnonzero(~is_free)
    n, points, was_touching = len(open_rows), points[open_rows], was_touching[open_rows]
    closest_points, kept_feet = blank(n), blank(n)
    closest_points.status[:] = settle_nb.NOT_SEARCHED
    if feet is not None:
        rows_before = np.flatnonzero(was_touching)
        copy_feet(kept_feet, rows_before, rows_of(feet, open_rows[rows_before]))
    guard, depth, is_opposed = step.guard_states.at(points)
    return Candidates(
        rows=points,
        was_touching=was_touching,
        is_kept=np.zeros(n, np.bool_),
        status=np.full(n, ContactStatus.OLD, np.int8),
        side=side[open_rows],
        safe_distance=reach[open_rows],
        max_distance=np.full(n, np.inf),
        guard=guard,
        depth=depth,
        is_opposed=is_opposed,
        feet=kept_feet,
        closest=closest_points,
    )


def find_closest(search: StepSearch, candidates: Candidates, chosen: IndexArray) -> None:
    """Write unknown closest points of the chosen candidates into `candidates.closest`."""
    chosen = chosen[candidates.closest.status[chosen] == settle_nb.NOT_SEARCHED]
    if len(chosen):
        feet = closest(search.surface, search.step.now, candidates.rows[chosen])
        copy_feet(candidates.closest, chosen, feet)


def detect(search: StepSearch, rows: Rows) -> Guards:
    """Decide which points of `rows` touch; write statuses and feet into `search.detected`.

    Return the guards of points that another wall than the nearest pushes.
    """
    feet, touching = None, rows.touching
    if len(touching):
        start = search.last.patch[touching], search.last.uv[touching]
        now = np.ascontiguousarray(search.step.now[touching])
        feet = follow(search.surface, (None, now), start)
    if search.options.closed:
        return decide(search, candidates_of(search, feet, rows))
    return _detect_open(search, feet, rows)


class PointClasses(NamedTuple):
    """Classes of candidates on a closed body, one row each."""

    needs_closest: BoolArray
    """Whether the closest point was needed."""
    solved: BoolArray
    """Whether the side is known."""
    inside: BoolArray
    deep: BoolArray
    """Whether a point is inside by more than rounding."""
    may_be_free: BoolArray
    """Whether a free point may be inside without an entry: since the start, or without a past."""


def classify(
    step: Step, candidates: Candidates, needs_closest: BoolArray, options: Options
) -> PointClasses:
    """Return the classes of candidates, by their sides, or by `candidates.closest` if unknown.

    Closest points are found before. A point in `needs_closest`, which needed its closest point, is
    solved only if that has the status OK. Free points inside since the start, or without a past in
    `step`, may be free inside.
    """
    feet, has_side = candidates.closest, candidates.side != 0
    solved = ~needs_closest | (feet.status == Status.OK)
    inside = solved & np.where(has_side, candidates.side < 0, feet.gap <= 0.0)
    deep = inside & (has_side | (feet.gap < -options.band))
    has_past = np.isfinite(step.path_length[candidates.rows])
    may_be_free = ~candidates.was_touching & (step.inside_since_start[candidates.rows] | ~has_past)
    return PointClasses(needs_closest, solved, inside, deep, may_be_free)


def decide(search: StepSearch, candidates: Candidates) -> Guards:
    """Decide which points touch a closed body, and write that; return guards as `detect` does.

    If sides and closest points do not decide on all, points inside enter where their paths cross
    the surface last (in a search by penetration free points enter by depth), and points whose feet
    are not kept are followed along their paths. `candidates` is filled in: closest points, feet,
    and guards of points that entered.
    """
    step, detected, options = search.step, search.detected, search.options
    rows, was_touching = candidates.rows, candidates.was_touching
    needs_closest = (candidates.side <= 0) | (~was_touching & options.penetration)
    find_closest(search, candidates, np.flatnonzero(needs_closest))
    straight(settle_nb.take_closest)(candidates, step.path_length, options.limits)
    if straight(settle_nb.decide_all)(candidates, step, options.limits, detected):
        return UNGUARDED
    classes = classify(step, candidates, needs_closest, options)
    _, solved, inside, deep, may_be_free = classes
    starts = _path_starts(search, rows)
    entered = _find_entries(search, candidates, classes, starts)
    missed = deep & ~was_touching & ~entered & ~may_be_free & (not options.penetration)
    touching = inside & ((was_touching & (candidates.is_kept | deep)) | entered | missed)
    followed = np.flatnonzero(touching & ~candidates.is_kept)
    paths = _follow_paths(search, candidates, starts, followed)
    copy_feet(candidates.feet, followed, paths.feet)
    status = np.where(was_touching, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[candidates.is_kept & touching] = candidates.status[candidates.is_kept & touching]
    status[followed] = STATUS_OF_OUTCOME[paths.outcome]
    status[entered] = ContactStatus.NEW
    status[missed] = ContactStatus.FOUND
    status[~solved] = ContactStatus.LOST
    write_decision(search, candidates, classes, Decision(status, touching, ~solved))
    return _guards(rows[followed], paths, touching[followed])


class PathStarts(NamedTuple):
    """Starting points of the paths of points inside, one row each, with their feet there."""

    point: FloatArray
    patch: IntArray
    uv: FloatArray


def _path_starts(search: StepSearch, rows: IntArray) -> PathStarts:
    """Return positions before the step, relative to the surface in its present shape, and feet."""
    return PathStarts(search.path_starts(rows), search.last.patch[rows], search.last.uv[rows])


def _follow_paths(
    search: StepSearch, candidates: Candidates, starts: PathStarts, chosen: IndexArray
) -> DeepPaths:
    """Follow the paths of the chosen candidates from their starts to their present positions."""
    guards = candidates.guard[chosen], candidates.depth[chosen], candidates.is_opposed[chosen]
    walls = WallStates(*guards, starts.patch[chosen], starts.uv[chosen])
    ends = starts.point[chosen], search.step.now[candidates.rows[chosen]]
    nearest = rows_of(candidates.closest, chosen)
    return deep_paths.follow_paths(search.surface, ends, walls, nearest, search.options)


def _guards(rows: IntArray, paths: DeepPaths, pushed: BoolArray) -> Guards:
    """Return guards, rows ascending, of points that another wall than the nearest pushes.

    Only paths that are `pushed` count, whose points end in contact.
    """
    opposed = np.flatnonzero(paths.is_opposed & pushed)
    order = np.argsort(rows[opposed])
    return Guards(rows[opposed][order], paths.guard[opposed][order])


def _find_entries(
    search: StepSearch, candidates: Candidates, classes: PointClasses, starts: PathStarts
) -> BoolArray:
    """Return a mask (k,) of the candidates that are inside and have entered the body in the step.

    The place of their last entry and its wall replace their rows in `starts`, and their guards in
    `candidates`, where their depths become −∞ and no wall is opposed.
    Paths are examined for free points, and for points whose foot is not kept, as they may have left
    by one wall and entered by another. In a search by penetration free points within depth have
    entered, and have no guard.
    """
    surface, step, options = search.surface, search.step, search.options
    rows, was_touching = candidates.rows, candidates.was_touching
    if options.penetration:
        entered = classes.inside & ~was_touching & within_depth(candidates.closest, options)
        candidates.guard[~was_touching] = 0.0
    else:
        entered = np.zeros(len(rows), dtype=bool)
    unsure = classes.inside & ~candidates.is_kept & np.isfinite(step.path_length[rows])
    chosen = np.flatnonzero(unsure & (was_touching | (not options.penetration)))
    if len(chosen):
        hits, sense = search.last_crossings(rows[chosen])
        entering = np.flatnonzero(sense > 0)
        entered_rows, places = chosen[entering], np.ascontiguousarray(hits.point[entering])
        entered[entered_rows], starts.point[entered_rows] = True, places
        starts.patch[entered_rows] = hits.patch[entering]
        starts.uv[entered_rows] = hits.uv[entering]
        candidates.depth[entered_rows], candidates.is_opposed[entered_rows] = -np.inf, False
        candidates.guard[entered_rows] = closest(
            surface, places, np.arange(len(entering), dtype=np.int32)
        ).normal
    return entered


class Decision(NamedTuple):
    """Statuses of candidates, one row each."""

    status: ByteArray
    touching: BoolArray
    lost: BoolArray


def write_decision(
    search: StepSearch, candidates: Candidates, classes: PointClasses, decision: Decision
) -> None:
    """Write the decision on points of a closed body into `search.detected`.

    Points in contact get the feet of `candidates`, others their closest points as last feet, and
    all their safe distances: zero for lost points, and for points in contact that are not inside.
    """
    detected, rows, touching = search.detected, candidates.rows, decision.touching
    detected.status[rows] = decision.status
    copy_feet(detected.feet, rows, candidates.feet, touching)
    store_feet(detected, rows[~touching], candidates.closest, ~touching)
    distance = np.where(
        candidates.side != 0, candidates.safe_distance, np.abs(candidates.closest.gap)
    )
    distance = distance - search.options.band
    if_free = free_distance(candidates.closest, search.options)
    if_free = np.where(classes.needs_closest, if_free, candidates.side * distance)
    if_touching = np.where(classes.inside, np.fmax(distance, 0.0), 0.0)
    safe_distance = np.where(decision.lost, 0.0, np.where(touching, if_touching, if_free))
    detected.safe_distance[rows] = safe_distance


def _detect_open(search: StepSearch, feet: Projection | None, rows: Rows) -> Guards:
    """Write the decision on points of an open body; return guards as `detect` does.

    The closest point may take over; else a point that came out in front is released, and the path
    of any other is followed. With `hold` a point beyond a border keeps the foot that was followed.
    Free points, and the remaining paths of released ones, enter by their last crossings.
    """
    surface, step, _, detected, options, _ = search
    touching, free = rows
    candidates = candidates_of(search, feet, Rows(touching, free[:0]))
    find_closest(search, candidates, np.arange(len(touching)))
    straight(settle_nb.take_closest)(candidates, step.path_length, options.limits)
    status, share, is_kept = candidates.status.copy(), np.ones(len(touching)), candidates.is_kept
    # Beyond a border the nearest wall is the border: the foot that was followed keeps its normal.
    on_border = at_border(candidates.feet) & (candidates.feet.gap <= 0.0) & options.hold
    at_hold = on_border & ~is_kept & (candidates.closest.status != Status.OK)
    came_out = ~is_kept & ~at_hold & _are_in_front(search, candidates)
    status[came_out] = ContactStatus.RELEASED
    followed = np.flatnonzero(~is_kept & ~at_hold & ~came_out)
    paths = _follow_paths(search, candidates, _path_starts(search, touching), followed)
    status[followed], share[followed] = STATUS_OF_OUTCOME[paths.outcome], paths.progress
    pushed = paths.outcome <= deep_path_nb.RESTARTED
    copy_feet(candidates.feet, followed, paths.feet, pushed)
    slid_off = status == ContactStatus.SLID_OFF
    at_hold |= on_border & slid_off
    if options.hold:  # they come out beside the border that held them
        status[slid_off] = ContactStatus.RELEASED
    status[at_hold] = ContactStatus.HELD
    stays = is_kept | at_hold
    stays[followed[pushed]] = True
    detected.status[touching], detected.safe_distance[touching] = status, 0.0
    copy_feet(detected.feet, touching, candidates.feet, stays)
    guards = _guards(touching[followed], paths, pushed)
    if options.penetration:
        take_into_contact(surface, step.now, free, detected, options)
        return guards
    # A released point may enter through another sheet on the rest of its path.
    released = np.flatnonzero(~stays & ~came_out & (status != ContactStatus.LOST))
    new_guards = _enter_open(search, touching[released], share[released], free)
    still_free = free[detected.feet.patch[free] < 0]
    surface.safe_distance(step.now, still_free, detected.safe_distance)
    return merged(guards, new_guards)


def _are_in_front(search: StepSearch, candidates: Candidates) -> BoolArray:
    """Return a mask (k,) of points that came out in front and have entered no other sheet since.

    Their followed feet are the closest points, and the nearest wall held them. Points deeper before
    than their path is long do not count, as they cannot have come out.
    """
    step, options = search.step, search.options
    feet, in_front = candidates.closest, np.zeros(len(candidates.rows), np.bool_)
    may_be = (feet.status == Status.OK) & (feet.gap > 0.0) & ~candidates.is_opposed
    may_be &= distance_between(candidates.feet, feet) <= options.limits.same_foot
    # A deeper point cannot have come out within its path.
    depth_left = candidates.depth - step.path_length[candidates.rows]
    chosen = np.flatnonzero(may_be & (depth_left <= 2.0 * options.band))
    hits, sense = search.last_crossings(candidates.rows[chosen])
    in_front[chosen] = (sense <= 0) & (hits.status != Status.BUDGET)
    return in_front


def _enter_open(
    search: StepSearch, released: IntArray, share: FloatArray, free: IntArray
) -> Guards:
    """Take points of an open body into contact whose last crossings enter it; return guards.

    They are points `released` after a `share` (k,) of their paths, and `free` points. Statuses and
    feet are written into `search.detected`: NEW; HELD beyond a border, with `options.hold`; LOST if
    crossings or walls are not found within the budget of the search.
    """
    surface, step, _, detected, options, _ = search
    rows = np.concatenate((released, free))
    ends, numbers = step.now[rows], np.arange(len(rows), dtype=np.int32)
    hits, sense = search.last_crossings(free)
    if len(released):
        start = search.path_starts(released)
        start += share[:, None] * (step.now[released] - start)
        first, first_sense = surface.last_crossings(
            start, step.now[released], numbers[: len(released)]
        )
        both = ((getattr(first, name), getattr(hits, name)) for name in Hit._fields)
        hits = Hit._make(map(np.concatenate, both))
        sense = np.concatenate((first_sense, sense))
    detected.status[rows[hits.status == Status.BUDGET]] = ContactStatus.LOST
    entering = np.flatnonzero(sense > 0).astype(np.int32)
    n = len(entering)
    if n == 0:
        return UNGUARDED
    rows, ends, places = rows[entering], ends[entering], np.ascontiguousarray(hits.point[entering])
    guard = closest(surface, places, numbers[:n]).normal
    foot = hits.patch[entering], np.ascontiguousarray(hits.uv[entering])
    walls = WallStates(guard, np.zeros(n), np.zeros(n, np.bool_), *foot)
    nearest = closest(surface, step.now, rows)
    paths = deep_paths.follow_paths(surface, (places, ends), walls, nearest, options)
    pushed = paths.outcome <= deep_path_nb.RESTARTED
    status = np.where(pushed, np.int8(ContactStatus.NEW), detected.status[rows])
    if options.hold:
        followed = follow(surface, (None, ends), foot)
        held = ~pushed & at_border(followed) & (followed.gap <= 0.0)
        status[held] = ContactStatus.HELD
        copy_feet(detected.feet, rows, followed, held)
    status[paths.outcome == deep_path_nb.GIVEN_UP] = ContactStatus.LOST
    detected.status[rows] = status
    copy_feet(detected.feet, rows, paths.feet, pushed)
    return _guards(rows, paths, pushed)
