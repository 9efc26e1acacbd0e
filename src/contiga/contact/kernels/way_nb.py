"""This decides which wall pushes a point at the end of its way, from the answers to the questions
that `contact.ways` asks; on exact geometry all is done in one call.

A way is gone along in parts. At the end of each part the nearest wall pushes, if the guard allows
it; else the nearest one that the guard allows; and where there is none the way is halved, down to a
thousandth, until that shows why (`docs/theory.md`).
"""

from __future__ import annotations

import math

from contiga.arrays.codes import BRANCH_EVENT, MAX_ITERATIONS, OK
from contiga.contact.kernels.settle_nb import (
    OPPOSITE_COSINE,
    distance,
    is_at_border,
    is_opposite,
    length_between,
    take_foot,
    turns,
)
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.records import FacingLimits, SurfacePlaces
from contiga.search.closest.kernels.facing_nb import project_facing
from contiga.search.closest.kernels.foot_nb import tracked_foot
from contiga.search.closest.kernels.nearest_nb import project_proved

SET_OUT, CLOSEST, STILL_ON_WALL, CLOSEST_BEFORE, FACING, FACING_BEFORE = range(6)
ENDS, ENDS_FARTHER, ON_WALL, FACING_ANYWHERE, GUARD_TURNS, DONE = range(6, 12)
"""A way asks one of these: nothing yet; the closest point; whether the wall that held the point
still has it behind; the foot on the nearest wall where the part begins; the closest foot that the
guard allows; its foot where the part begins; whether the wall that held the point has ended at a
border; whether it has in a shorter part; why no wall holds the point; the closest foot that the
guard allows, however far; what the wall that held the point has turned to; nothing any more."""
NEAREST_PUSHES, ANOTHER_PUSHES, ANEW, CAME_OUT, SLID_OFF, GIVEN_UP = range(6)
"""A way ends in one of these: the nearest wall pushes; another one does; a wall pushes that the
point did not come to step by step; the point is in front of its wall; its wall has ended at a
border; it is not told."""
SHORTEST = 2.0**-10
"""Share of a way that is halved no further."""
LOOKS = 256
"""Parts of a way, and halvings, at most."""
END = 1.0 - 1e-9
TRIES = 8
"""Minima that are asked for one after the other, where the nearest has been nearer all along."""
BEYOND = 1e-6
"""Slant from which a point is beyond a border; below it a border may be a foot like any other."""
ROUND = 2.0 + 1e-6
"""Times its way by which a foot's depth may exceed the least that it can have come to, and
rounding."""


@inner()
def _ask(ways, i, question, share):
    """Ask about the place at a share of way i."""
    ways.asks[i] = question
    for c in range(3):
        ways.point[i, c] = ways.end[i, c] - (1.0 - share) * (ways.end[i, c] - ways.start[i, c])
    return question


@inner()
def _ask_before(ways, i, question, feet):
    """Ask for the foot on the wall of foot i of `feet` where the part of way i begins."""
    ways.from_patch[i] = feet.patch[i]
    ways.from_uv[i, 0], ways.from_uv[i, 1] = feet.uv[i, 0], feet.uv[i, 1]
    return _ask(ways, i, question, ways.at[i])


@inner()
def _ask_wall(ways, i, question):
    """Ask for the foot on the wall that held the point where the part of way i ends."""
    ways.from_patch[i] = ways.patch[i]
    ways.from_uv[i, 0], ways.from_uv[i, 1] = ways.uv[i, 0], ways.uv[i, 1]
    return _ask(ways, i, question, ways.to[i])


@inner()
def _has_behind(feet, i, limits):
    """Tell whether a point lies behind its foot i; in a closed body it does, but for rounding."""
    return feet.status[i] == OK and feet.gap[i] <= (limits.band if limits.closed else 0.0)


@inner()
def _is_beyond_border(feet, i, points):
    """Tell whether a point lies aside of its foot i, which is at a border."""
    square, along = 0.0, 0.0
    for c in range(3):
        way = points[i, c] - feet.point[i, c]
        square += way * way
        along += way * feet.normal[i, c]
    return is_at_border(feet.status[i]) and square - along * along > BEYOND * BEYOND * square


@inner()
def _is_in_front(feet, i):
    """Tell whether a point is in front of its foot i."""
    found = feet.status[i] in (OK, BRANCH_EVENT) or is_at_border(feet.status[i])
    return found and feet.gap[i] > 0.0


@inner()
def _may_have_come_under(ways, i, gone, limits):
    """Return whether the border of a wall may have been nearer when the foot left it than the wall
    that held the point, though it is not at the beginning of a part of way i.

    Each distance changes by no more than the length `gone`.
    """
    if not _is_beyond_border(ways.followed, i, ways.point):
        return False
    more = length_between(ways.followed.point, ways.point, i) - ways.depth[i] + 2.0 * limits.band
    return 0.0 <= more < 2.0 * gone


@inner()
def _was_off(ways, i, limits):
    """Tell whether a wall was no nearer than the one that held the point, along a part of way i.

    A wall that was nearer where the part begins has been so all along, even if the part is long
    enough for both to be as near. Where a foot on an edge leads back to an opposite wall it was not
    that one. On an open body a wall that the point was in front of has been come through, and one
    whose border was nearer has been come under: they were nearer then.
    """
    before, nearest_then = ways.followed, ways.depth[i] - 2.0 * limits.band
    if is_at_border(before.status[i]):
        return length_between(before.point, ways.point, i) >= nearest_then
    away = distance(before, i, ways.point)
    off = away >= nearest_then or is_opposite(before, i, ways.guard, i)
    return off and (limits.closed or away == math.inf or before.gap[i] <= limits.band)


@inner()
def _stand(ways, i, feet, opposed):
    """Put way i on the wall of foot i, whose normal is the guard unless its wall is `opposed`."""
    ways.depth[i], ways.patch[i] = -feet.gap[i], feet.patch[i]
    ways.uv[i, 0], ways.uv[i, 1] = feet.uv[i, 0], feet.uv[i, 1]
    ways.opposed[i] = opposed
    if not opposed:
        for c in range(3):
            ways.guard[i, c] = feet.normal[i, c]


@inner()
def _end(ways, i, outcome):
    ways.outcome[i] = outcome
    ways.asks[i] = DONE
    return DONE


@inner()
def _turned_on_the_way(ways, i, least, gone):
    """Tell whether the nearest wall may have turned to be opposite little by little.

    Both distances change by no more than the way: where they differ by more than twice that, it has
    been opposite all along.
    """
    nearest, other = ways.nearest, ways.other
    differ = other.status[i] == OK and nearest.gap[i] - other.gap[i] > 2.0 * gone
    return not ways.opposed[i] and not differ and -nearest.gap[i] >= least


@inner()
def _deepest(least, gone, band):
    """Return how deep a foot may be that a point has come to step by step; where the wall that held
    it has vanished, others are deeper."""
    return least + ROUND * gone + 4.0 * band if math.isfinite(least) else math.inf


@inner()
def _take_anew(ways, limits, i):
    """Put a point that no wall holds step by step on another wall; whether there is one."""
    if not limits.closed and ways.other.status[i] == OK:
        _stand(ways, i, ways.other, True)
    elif limits.closed or _has_behind(ways.nearest, i, limits):
        _stand(ways, i, ways.nearest, False)
    else:
        return False
    ways.is_anew[i] = True
    return True


@inner()
def _halve(ways, i):
    """Begin the part of way i again, half as long."""
    ways.part[i] *= 0.5
    return SET_OUT


@inner()
def _go_on(ways, i, place):
    """Begin the next part of way i from the share `place`, if it has not ended there."""
    ways.at[i] = place
    ways.part[i] = min(2.0 * ways.part[i], ways.longest[i])
    if place < 1.0:
        return SET_OUT
    if ways.is_anew[i]:
        return _end(ways, i, ANEW)
    return _end(ways, i, ANOTHER_PUSHES if ways.opposed[i] else NEAREST_PUSHES)


@inner(linked=False)
def answered(ways, limits, i):
    """Return what way i asks next, now that its question has been answered, at `ways.point`.

    `limits` are `Limits`.
    """
    band, closed = limits.band, limits.closed
    question, nearest, other = ways.asks[i], ways.nearest, ways.other
    pushes = False
    while True:
        if question == SET_OUT:
            ways.looks[i] += 1
            if ways.looks[i] > LOOKS:
                ways.opposed[i] = False
                found = closed or _has_behind(ways.last, i, limits)
                return _end(ways, i, ANEW if found else GIVEN_UP)
            place = ways.at[i] + ways.part[i]
            ways.to[i] = place = 1.0 if place > END else place
            if place < 1.0:
                return _ask(ways, i, CLOSEST, place)
            take_foot(nearest, i, ways.last, i)
            question = CLOSEST
        place, gone = ways.to[i], (ways.to[i] - ways.at[i]) * ways.length[i]
        least = ways.depth[i] - gone - 2.0 * band
        if question == CLOSEST and not closed and ways.depth[i] - gone <= 2.0 * band:
            return _ask_wall(ways, i, STILL_ON_WALL)
        if question == STILL_ON_WALL and _is_in_front(ways.followed, i):
            # It has come out before any other wall was as near.
            if ways.part[i] <= SHORTEST:
                return _end(ways, i, CAME_OUT)
            question = _halve(ways, i)
            continue
        if question in (CLOSEST, STILL_ON_WALL, GUARD_TURNS):
            pushes = _has_behind(nearest, i, limits) and -nearest.gap[i] >= least
            pushes = pushes and not is_opposite(nearest, i, ways.guard, i)
            # The guard may have rotated with its wall before this wall became as near.
            may_turn = not ways.opposed[i] and ways.patch[i] >= 0 and ways.part[i] > SHORTEST
            if pushes and may_turn:
                if question == GUARD_TURNS and is_opposite(nearest, i, ways.followed.normal, i):
                    question = _halve(ways, i)
                    continue
                if question != GUARD_TURNS and turns(nearest, i, ways.guard, i):
                    return _ask_wall(ways, i, GUARD_TURNS)
            if pushes and (ways.opposed[i] or not closed):
                return _ask_before(ways, i, CLOSEST_BEFORE, nearest)
        elif (
            question in (CLOSEST_BEFORE, FACING_BEFORE)
            and ways.part[i] > SHORTEST
            and _may_have_come_under(ways, i, gone, limits)
        ):
            question = _halve(ways, i)
            continue
        elif question == CLOSEST_BEFORE:
            pushes = _was_off(ways, i, limits)
        elif question == FACING:
            if other.status[i] == OK and (ways.opposed[i] or not closed):
                return _ask_before(ways, i, FACING_BEFORE, other)
        elif question in (ENDS, ENDS_FARTHER):
            # A search for a wall that is not there costs a hundred times as much as a foot.
            if ways.part[i] > SHORTEST and _is_beyond_border(ways.followed, i, ways.point):
                ways.part[i] *= 0.5
                ways.to[i] = ways.at[i] + ways.part[i]
                return _ask_wall(ways, i, ENDS_FARTHER)
            if question == ENDS:
                return _ask(ways, i, FACING, place)
            question = SET_OUT
            continue
        elif question == FACING_BEFORE and not _was_off(ways, i, limits):
            ways.tries[i] += 1
            if ways.tries[i] < TRIES:
                ways.floor[i] = 2.0 * band - other.gap[i]
                return _ask(ways, i, FACING, place)
            other.status[i] = MAX_ITERATIONS
        if question in (CLOSEST, STILL_ON_WALL, GUARD_TURNS, CLOSEST_BEFORE):
            if not pushes:
                ways.tries[i], ways.floor[i] = 0, least
                # On an open body no farther one is of use, and most often there is none.
                ways.ceiling[i] = math.inf if closed else _deepest(least, gone, band)
                return _ask(ways, i, FACING, place) if closed else _ask_wall(ways, i, ENDS)
            _stand(ways, i, nearest, False)
            question = _go_on(ways, i, place)
        elif question == ON_WALL:
            # It is why no wall holds the point.
            if _is_in_front(ways.followed, i):
                return _end(ways, i, CAME_OUT)
            if is_at_border(ways.followed.status[i]):
                return _end(ways, i, SLID_OFF)
            ways.ceiling[i] = math.inf
            return _ask(ways, i, FACING_ANYWHERE, place)
        elif question == FACING_ANYWHERE:
            if not _take_anew(ways, limits, i):
                return _end(ways, i, CAME_OUT)
            question = _go_on(ways, i, place)
        else:
            holds = other.status[i] == OK and -other.gap[i] <= _deepest(least, gone, band)
            short = ways.part[i] <= SHORTEST
            if not short and not holds and not closed:
                again = True
            else:
                again = not short and _turned_on_the_way(ways, i, least, gone)
            if again:
                question = _halve(ways, i)
                continue
            if holds:
                _stand(ways, i, other, True)
            elif closed:
                _take_anew(ways, limits, i)
            else:
                return _ask_wall(ways, i, ON_WALL)
            question = _go_on(ways, i, place)
        if question == DONE:
            return DONE


@kernel()
def go_on(ways, limits, rows):
    """Write what the ways `rows` ask next into `ways.asks`, now that they have been answered."""
    for j in range(rows.shape[0]):
        answered(ways, limits, rows[j])


@kernel()
def go_all_the_way(tables, ways, limits, start, stop):
    """Go along the ways start … stop of a body with these `ContactTables` to their ends."""
    body, h, nearest = tables.body, scratch(4, 6), scratch(4)
    facing, places = (
        FacingLimits(OPPOSITE_COSINE, ways.floor, ways.ceiling),
        SurfacePlaces(ways.patch, ways.uv),
    )
    points = ways.point
    for i in range(start, stop):
        question = answered(ways, limits, i)
        while question != DONE:
            if question == CLOSEST:
                project_proved(
                    body, tables.balls, points, ways.rows, ways.within, ways.nearest, i, i + 1
                )
            elif question in (FACING, FACING_ANYWHERE):
                project_facing(body, points, ways.guard, facing, places, ways.other, i, i + 1)
            else:
                point = (points[i, 0], points[i, 1], points[i, 2])
                foot = locate(body.grid, ways.from_patch[i], ways.from_uv[i, 0], ways.from_uv[i, 1])
                tracked_foot(body, i, foot, point, ways.followed, nearest, h)
            question = answered(ways, limits, i)
