"""Decide which wall pushes a point at the end of its path inside a body: see `contact.deep_paths`.

A path is followed in parts. At the end of each part the nearest wall pushes, if the guard allows
it; otherwise the nearest wall that the guard allows. If there is none, the part is halved, down to
a thousandth of the path, until the reason is found (`docs/theory.md`). Each decision needs an
answer from the surface; on exact geometry one call of a kernel asks and answers all questions.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import BRANCH_EVENT, MAX_ITERATIONS, OK
from contiga.contact.kernels.settle_nb import (
    OPPOSITE_COSINE,
    distance_to_foot,
    is_at_border,
    is_opposite,
    is_other_wall,
    length_between,
    take_foot,
)
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.records import FacingLimits, SurfacePlaces
from contiga.search.closest.kernels.facing_nb import project_facing
from contiga.search.closest.kernels.foot_nb import tracked_foot
from contiga.search.closest.kernels.nearest_nb import project_proved

BEGIN_PART, CLOSEST, STILL_ON_WALL, CLOSEST_BEFORE, FACING, FACING_BEFORE = range(6)
ENDS, ENDS_FARTHER, ON_WALL, FACING_ANYWHERE, GUARD_TURNS, DONE = range(6, 12)
"""Questions about a path: none yet; the closest point; whether the wall that held the point still
has it behind; the foot on the nearest wall at the begin of the part; the closest foot that the
guard allows; the foot on that wall at the begin of the part; whether the wall that held the point
ends at a border; whether it does so in a shorter part; why no wall holds the point; the closest
foot that the guard allows at any distance; how the wall that held the point has turned; none any
more."""
NEAREST_PUSHES, ANOTHER_PUSHES, RESTARTED, CAME_OUT, SLID_OFF, GIVEN_UP = range(6)
"""Outcomes of a path: the nearest wall pushes; another wall pushes; a wall pushes that the point
did not reach step by step; the point is in front of its wall; its wall ended at a border;
unknown."""
MIN_PART = 2.0**-10
"""Shortest part, as a share of the path."""
MAX_PARTS = 256
"""Largest number of parts and halvings of a path."""
END_SHARE = 1.0 - 1e-9
MAX_TRIES = 8
"""Largest number of minima searched one after the other, if the nearer ones were nearer before."""
BORDER_SLANT = 1e-6
"""Smallest sine between arm and normal for a point to be beyond a border."""
DEPTH_FACTOR = 2.0 + 1e-6
"""Largest excess of the depth of a foot over its smallest possible depth, over the path length."""


@inner()
def _ask(paths, i, question, share):
    """Ask about the position at a share of path i; return the question."""
    paths.question[i] = question
    for c in range(3):
        paths.point[i, c] = paths.end[i, c] - (1.0 - share) * (paths.end[i, c] - paths.start[i, c])
    return question


@inner()
def _ask_at_begin(paths, i, question, feet):
    """Ask for the foot on the wall of foot i of `feet` at the begin of the present part."""
    paths.from_patch[i] = feet.patch[i]
    paths.from_uv[i, 0], paths.from_uv[i, 1] = feet.uv[i, 0], feet.uv[i, 1]
    return _ask(paths, i, question, paths.progress[i])


@inner()
def _ask_at_end(paths, i, question):
    """Ask for the foot on the wall that held the point at the end of the present part."""
    paths.from_patch[i] = paths.patch[i]
    paths.from_uv[i, 0], paths.from_uv[i, 1] = paths.uv[i, 0], paths.uv[i, 1]
    return _ask(paths, i, question, paths.target[i])


@inner()
def _has_behind(feet, i, limits):
    """Return whether a point is behind its foot i, in a closed body within rounding."""
    return feet.status[i] == OK and feet.gap[i] <= (limits.band if limits.closed else 0.0)


@inner()
def _is_beyond_border(feet, i, points):
    """Return whether a point is beside its foot i, which is at a border.

    The arm from the foot is then off the normal by more than the sine `BORDER_SLANT`.
    """
    square, height = 0.0, 0.0
    for c in range(3):
        offset = points[i, c] - feet.point[i, c]
        square += offset * offset
        height += offset * feet.normal[i, c]
    return (
        is_at_border(feet.status[i])
        and square - height * height > BORDER_SLANT * BORDER_SLANT * square
    )


@inner()
def _is_in_front(feet, i):
    """Return whether a point is in front of its foot i, on a face or on a border."""
    has_foot = feet.status[i] in (OK, BRANCH_EVENT) or is_at_border(feet.status[i])
    return has_foot and feet.gap[i] > 0.0


@inner()
def _may_have_passed_under(paths, i, length, limits):
    """Return whether the border of a wall may have been nearer than the wall that held the point.

    The followed foot is at that border, beside the point at the begin of the part. It is not nearer
    there; each distance changes by at most the `length` of the part.
    """
    if not _is_beyond_border(paths.followed, i, paths.point):
        return False
    excess = (
        length_between(paths.followed.point, paths.point, i) - paths.depth[i] + 2.0 * limits.band
    )
    return 0.0 <= excess < 2.0 * length


@inner()
def _was_farther(paths, i, limits):
    """Return whether a wall was no nearer than the one that held the point, along a part of path i.

    A wall that was nearer at the begin of the part has been so all along, even if the part is long
    enough for equal distances. A foot on an edge that leads back to an opposite wall does not
    count. On an open body a wall with the point in front of it has been crossed, and one with a
    nearer border has been passed under: they were nearer then.
    """
    foot, depth_then = paths.followed, paths.depth[i] - 2.0 * limits.band
    if is_at_border(foot.status[i]):
        return length_between(foot.point, paths.point, i) >= depth_then
    distance = distance_to_foot(foot, i, paths.point)
    is_farther = distance >= depth_then or is_opposite(foot, i, paths.guard, i)
    return is_farther and (limits.closed or distance == math.inf or foot.gap[i] <= limits.band)


@inner()
def _put_on_wall(paths, i, feet, opposed):
    """Put path i on the wall of foot i, whose normal becomes the guard unless it is `opposed`."""
    paths.depth[i], paths.patch[i] = -feet.gap[i], feet.patch[i]
    paths.uv[i, 0], paths.uv[i, 1] = feet.uv[i, 0], feet.uv[i, 1]
    paths.is_opposed[i] = opposed
    if not opposed:
        for c in range(3):
            paths.guard[i, c] = feet.normal[i, c]


@inner()
def _end(paths, i, outcome):
    """End path i with this outcome; return DONE."""
    paths.outcome[i] = outcome
    paths.question[i] = DONE
    return DONE


@inner()
def _may_have_turned(paths, i, min_depth, length):
    """Return whether the nearest wall may have become opposite by a gradual rotation.

    Both distances change by at most the `length` of the part: if they differ by more than twice
    that, the wall has been opposite all along. No wall turns while an opposite one is nearest, nor
    where the nearest is less deep than `min_depth`.
    """
    nearest, other = paths.nearest, paths.other
    is_farther = other.status[i] == OK and nearest.gap[i] - other.gap[i] > 2.0 * length
    return not paths.is_opposed[i] and not is_farther and -nearest.gap[i] >= min_depth


@inner()
def _max_depth(min_depth, length, band):
    """Return the largest depth of a foot that a point reaches step by step.

    It is infinite where the wall that held the point has vanished, as other walls are deeper.
    """
    return min_depth + DEPTH_FACTOR * length + 4.0 * band if math.isfinite(min_depth) else math.inf


@inner()
def _restart(paths, limits, i):
    """Put a point that no wall holds step by step on another wall; return whether there is one.

    On an open body it is the facing wall, if there is one, or else the nearest wall if the point is
    behind it; on a closed body it is the nearest.
    """
    if not limits.closed and paths.other.status[i] == OK:
        _put_on_wall(paths, i, paths.other, True)
    elif limits.closed or _has_behind(paths.nearest, i, limits):
        _put_on_wall(paths, i, paths.nearest, False)
    else:
        return False
    paths.is_restarted[i] = True
    return True


@inner()
def _halve(paths, i):
    """Halve the present part of path i, to begin it again; return BEGIN_PART."""
    paths.part[i] *= 0.5
    return BEGIN_PART


@inner()
def _begin_next_part(paths, i, share):
    """Begin the next part, of twice the length, at a `share` of path i; end the path at its end.

    Returns BEGIN_PART or DONE.
    """
    paths.progress[i] = share
    paths.part[i] = min(2.0 * paths.part[i], paths.max_part[i])
    if share < 1.0:
        return BEGIN_PART
    if paths.is_restarted[i]:
        return _end(paths, i, RESTARTED)
    return _end(paths, i, ANOTHER_PUSHES if paths.is_opposed[i] else NEAREST_PUSHES)


@inner()
def _begin_part(paths, i, limits):
    """Begin a part of path i; return whether its closest point is known, as at the path's end.

    Otherwise the next question is written into `paths`. After `MAX_PARTS` parts that is DONE: the
    nearest wall at the end pushes if it has the point behind.
    """
    paths.n_parts[i] += 1
    if paths.n_parts[i] > MAX_PARTS:
        paths.is_opposed[i] = False
        has_wall = limits.closed or _has_behind(paths.end_feet, i, limits)
        _end(paths, i, RESTARTED if has_wall else GIVEN_UP)
        return False
    target = paths.progress[i] + paths.part[i]
    paths.target[i] = target = 1.0 if target > END_SHARE else target
    if target < 1.0:
        _ask(paths, i, CLOSEST, target)
        return False
    take_foot(paths.nearest, i, paths.end_feet, i)
    return True


@inner()
def _take_facing(paths, i, limits, min_depth, length):
    """Put path i on the facing wall that was found, or decide why there is none.

    Returns the next question, BEGIN_PART or DONE. `length` is that of the part, and `min_depth` the
    least depth that the wall that held the point can have now. A part that is not the shortest is
    halved first if the nearest wall may have turned, or if no wall holds the point on an open body.
    """
    other, closed = paths.other, limits.closed
    max_depth = _max_depth(min_depth, length, limits.band)
    is_held = other.status[i] == OK and -other.gap[i] <= max_depth
    is_unclear = not is_held and not closed
    if paths.part[i] > MIN_PART and (is_unclear or _may_have_turned(paths, i, min_depth, length)):
        return _halve(paths, i)
    if is_held:
        _put_on_wall(paths, i, other, True)
    elif closed:
        _restart(paths, limits, i)
    else:
        return _ask_at_end(paths, i, ON_WALL)
    return _begin_next_part(paths, i, paths.target[i])


@inner()
def _next_in_part(paths, limits, i, question):
    """Return the next question after the answer to one of the present part, and update `paths`.

    It is BEGIN_PART if the part is done or has to be halved.
    """
    band, closed = limits.band, limits.closed
    nearest, other, target = paths.nearest, paths.other, paths.target[i]
    length = (target - paths.progress[i]) * paths.length[i]
    min_depth = paths.depth[i] - length - 2.0 * band
    is_short, pushes = paths.part[i] <= MIN_PART, False
    if question == CLOSEST and not closed and paths.depth[i] - length <= 2.0 * band:
        return _ask_at_end(paths, i, STILL_ON_WALL)
    if question == STILL_ON_WALL and _is_in_front(paths.followed, i):
        # The point came out before any other wall was as near.
        return _end(paths, i, CAME_OUT) if is_short else _halve(paths, i)
    if question in (CLOSEST, STILL_ON_WALL, GUARD_TURNS):
        pushes = _has_behind(nearest, i, limits) and -nearest.gap[i] >= min_depth
        pushes = pushes and not is_opposite(nearest, i, paths.guard, i)
        # The guard may have rotated with its wall before this wall became as near.
        if pushes and not paths.is_opposed[i] and paths.patch[i] >= 0 and not is_short:
            if question == GUARD_TURNS and is_opposite(nearest, i, paths.followed.normal, i):
                return _halve(paths, i)
            if question != GUARD_TURNS and is_other_wall(nearest, i, paths.guard, i):
                return _ask_at_end(paths, i, GUARD_TURNS)
        if pushes and (paths.is_opposed[i] or not closed):
            return _ask_at_begin(paths, i, CLOSEST_BEFORE, nearest)
    elif (
        question in (CLOSEST_BEFORE, FACING_BEFORE)
        and not is_short
        and _may_have_passed_under(paths, i, length, limits)
    ):
        return _halve(paths, i)
    elif question == CLOSEST_BEFORE:
        pushes = _was_farther(paths, i, limits)
    elif question == FACING:
        if other.status[i] == OK and (paths.is_opposed[i] or not closed):
            return _ask_at_begin(paths, i, FACING_BEFORE, other)
    elif question in (ENDS, ENDS_FARTHER):
        # The search for a missing wall costs a hundred times as much as a foot.
        if not is_short and _is_beyond_border(paths.followed, i, paths.point):
            paths.part[i] *= 0.5
            paths.target[i] = paths.progress[i] + paths.part[i]
            return _ask_at_end(paths, i, ENDS_FARTHER)
        return _ask(paths, i, FACING, target) if question == ENDS else BEGIN_PART
    elif question == FACING_BEFORE and not _was_farther(paths, i, limits):
        paths.n_tries[i] += 1
        if paths.n_tries[i] < MAX_TRIES:
            paths.min_distance[i] = 2.0 * band - other.gap[i]
            return _ask(paths, i, FACING, target)
        other.status[i] = MAX_ITERATIONS
    if question in (CLOSEST, STILL_ON_WALL, GUARD_TURNS, CLOSEST_BEFORE):
        if pushes:
            _put_on_wall(paths, i, nearest, False)
            return _begin_next_part(paths, i, target)
        paths.n_tries[i], paths.min_distance[i] = 0, min_depth
        # On an open body farther walls are of no use, and mostly there is none.
        paths.max_distance[i] = math.inf if closed else _max_depth(min_depth, length, band)
        return _ask(paths, i, FACING, target) if closed else _ask_at_end(paths, i, ENDS)
    if question == ON_WALL:
        # The foot shows why no wall holds the point.
        if _is_in_front(paths.followed, i):
            return _end(paths, i, CAME_OUT)
        if is_at_border(paths.followed.status[i]):
            return _end(paths, i, SLID_OFF)
        paths.max_distance[i] = math.inf
        return _ask(paths, i, FACING_ANYWHERE, target)
    if question == FACING_ANYWHERE:
        if not _restart(paths, limits, i):
            return _end(paths, i, CAME_OUT)
        return _begin_next_part(paths, i, target)
    return _take_facing(paths, i, limits, min_depth, length)


@inner(linked=False)
def next_question(paths, limits, i):
    """Return the next question about path i, given the answer at `paths.point` to the present one.

    The question is written into `paths`, with all that follows from the answer. `limits` are
    `Limits`.
    """
    question = paths.question[i]
    while True:
        if question == BEGIN_PART:
            if not _begin_part(paths, i, limits):
                return paths.question[i]
            question = CLOSEST
        question = _next_in_part(paths, limits, i, question)
        if question != BEGIN_PART:
            return question


@kernel()
def next_questions(paths, limits, rows):
    """Write the next questions of the paths `rows` into `paths.question`."""
    for j in range(rows.shape[0]):
        next_question(paths, limits, rows[j])


@kernel()
def follow_paths(tables, paths, limits, start, stop):
    """Follow the paths start … stop of a body with these `ContactTables` to their ends.

    Questions are asked and answered in turn, into `paths`; `limits` are `Limits`.
    """
    body, h, nearest = tables.body, scratch(4, 6), scratch(4)
    facing, places = (
        FacingLimits(OPPOSITE_COSINE, paths.min_distance, paths.max_distance),
        SurfacePlaces(paths.patch, paths.uv),
    )
    points = paths.point
    for i in range(start, stop):
        question = next_question(paths, limits, i)
        while question != DONE:
            if question == CLOSEST:
                project_proved(
                    body, tables.balls, points, paths.rows, paths.unbounded, paths.nearest, i, i + 1
                )
            elif question in (FACING, FACING_ANYWHERE):
                project_facing(body, points, paths.guard, facing, places, paths.other, i, i + 1)
            else:
                point = (points[i, 0], points[i, 1], points[i, 2])
                foot = locate(
                    body.grid, paths.from_patch[i], paths.from_uv[i, 0], paths.from_uv[i, 1]
                )
                tracked_foot(body, i, foot, point, paths.followed, nearest, h)
            question = next_question(paths, limits, i)
