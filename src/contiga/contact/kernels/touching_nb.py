"""Few points in contact with a closed exact body, or near it: the search of a step in one call.

`closed_body` says what follows from what; of few points its calls, one after the other, take longer
than what is done in them. The results are the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.kernels.asked_nb import ask_free, ask_touching, judge_asked
from contiga.contact.kernels.carrying_nb import gather
from contiga.contact.kernels.place_nb import held, place
from contiga.contact.kernels.settle_nb import (
    askable,
    face,
    leave,
    remember_foot,
    settle,
    starts,
    stay,
    tell,
)
from contiga.jit import inner, kernel
from contiga.jit.pinned import reader
from contiga.num.codes import MAX_ITERATIONS
from contiga.num.kernels.rigid_nb import to_body
from contiga.search.kernels.ball_nb import radii
from contiga.search.kernels.lanes_nb import RECORD
from contiga.search.kernels.side_nb import places as places_of
from contiga.search.kernels.side_nb import sides
from contiga.search.kernels.track_nb import continue_left, track_chunks
from contiga.search.track_records import Path, Starts

tables_at = reader("contiga.search.table_types.Tables")
sides_at = reader("contiga.search.side_grid.SideGrid")
balls_at = reader("contiga.search.ball_cells.Balls")
buffers_at = reader("contiga.contact.step_buffers.StepBuffers")

NO_BALLS, NOT_SOLVED, MANY, NOT_IN, TURNED = -1, -2, -3, -4, -5
"""Answers in place of a number of rows: balls are needed, and not worked out; the feet of some rows
have to be looked for elsewhere; the rows are more than the buffers hold; some may lie inside since
the start; the body turns. What has been written is written again then."""


@inner(linked=False)
def _follow(tables, buffers, n):
    """Feet of the first n rows; whether all are solved."""
    path = Path(buffers.before[:0], buffers.now[:n], buffers.nobody)
    starts = Starts(buffers.patch[:n], buffers.uv[:n])
    records = np.empty((n, RECORD))
    m = track_chunks(tables, path, starts, n, records, buffers.left, buffers.feet, (0, 1))
    if m > 0:
        continue_left(tables, path.now, buffers.left, m, buffers.feet)
    failed = 0
    for i in range(n):
        failed += buffers.feet.status[i] == MAX_ITERATIONS
    return failed == 0


@inner(linked=False)
def _ask_balls(places, buffers, n):
    """Radii of the balls at the first n feet that are asked for; whether there are any balls."""
    if n == 0:
        return True
    balls = balls_at(places[2])
    if balls.elements.shape[0] == 0:
        return False
    feet = (buffers.feet.patch, buffers.feet.uv)
    grid = tables_at(places[0]).grid
    radii(balls, grid, feet, buffers.asked[:n], buffers.which[:n], buffers.radius, 0, n)
    return True


@kernel()
def touch(rows, path, last, found, feet, limits, places):
    """Settle the points `rows` that were in contact; returns how many are in the buffers, those
    that are not outside, and how many of them are left, listed in `ways` there.

    `path` is (now, before, way), `last` (patch, uv, holds), `found` (status, safe distance, near,
    uv) and `feet` of this step, all of all points; `limits` is (whether balls are asked, band),
    `places` where to find (tables, sides, balls, buffers).
    """
    tables, grid, buffers = tables_at(places[0]), sides_at(places[1]), buffers_at(places[3])
    with_balls, band = limits
    now, before, way = path
    n = rows.shape[0]
    sides(grid, now, rows, buffers.side, buffers.reach, 0, n)
    known, own = (buffers.side, buffers.reach), (buffers.own_side, buffers.own_reach)
    work = (
        buffers.rows,
        buffers.own_side,
        buffers.own_reach,
        buffers.patch,
        buffers.uv,
        buffers.before,
        buffers.now,
    )
    n = stay(rows, known, (before, now), (last[0], last[1]), (found[0], found[1]), band, work)
    if n == 0:
        return 0, 0
    if not _follow(tables, buffers, n):
        return n, NOT_SOLVED
    own_rows, mark = buffers.rows[:n], buffers.mark[:n]
    balls = face(own_rows, buffers.feet, last[2], way, band, mark, (buffers.asked, buffers.which))
    balls = balls if with_balls else 0
    if not _ask_balls(places, buffers, balls):
        return n, NO_BALLS
    told = (buffers.asked[:balls], buffers.radius[:balls])
    return n, settle(own_rows, buffers.feet, own, mark, told, band, found, feet, buffers.ways)


@kernel()
def stay_free(rows, step, old, found, limits, places):
    """Settle the free points `rows` that stay so; returns how many are left, listed in the buffers'
    `ways`, with what is known of all: sides, reaches (both `own_…`) and distances (`reach`).

    `step` is (way, ignored, now), `old` (near, uv) of the last step and `found` as `touch` has it,
    all of all points; `limits` is (search by penetration, whether balls are asked, band, how far a
    point may have gone for its last foot to be near), `places` as of `touch`.
    """
    tables, grid, buffers = tables_at(places[0]), sides_at(places[1]), buffers_at(places[3])
    way, ignored, now = step
    penetration, with_balls, band, far = limits
    n = rows.shape[0]
    known, spots = (buffers.own_side, buffers.own_reach), (buffers.way, buffers.spot)
    places_of(grid, now, rows, known, spots, 0, n)
    buffers.reach[:n] = math.inf
    work = (buffers.rows, buffers.patch, buffers.uv, buffers.now)
    m = starts(rows, known, spots, (way, now), old, found[2], far, work)
    if m > 0:
        if not _follow(tables, buffers, m):
            return NOT_SOLVED
        for j in range(m):
            remember_foot(found, rows[buffers.rows[j]], buffers.feet, j)
        balls = askable(buffers.feet, m, band, (buffers.asked, buffers.which)) if with_balls else 0
        if not _ask_balls(places, buffers, balls):
            return NO_BALLS
        told = (buffers.asked[:balls], buffers.radius[:balls])
        tell(buffers.rows[:m], buffers.feet, buffers.now[:m], told, band, known, buffers.reach)
    for i in range(n):
        k = rows[i]
        buffers.clear[i] = False
        if not penetration and buffers.own_side[i] < 0 and ignored[k] and math.isfinite(way[k]):
            return NOT_IN
    return leave(rows, known, buffers.clear[:n], band, found[1], buffers.ways)


@inner(linked=False)
def _settle(lists, path, last, found, feet, limits, places):
    """Settle points that were in contact and free ones near by; how many are left to judge.

    `lists` is (those in contact, those near), `path` (now, before), `last` what `place` is given
    and what held them, all else as of `advance`.
    """
    with_balls, penetration, band, depth, far, same_foot = limits
    touching, near = lists
    now, buffers = path[0], buffers_at(places[3])
    into, left = (found[0], found[1], found[2], found[3]), 0
    # The free ones first: what has become of them does not hinder that all is done anew.
    if near.shape[0] > 0:
        moved, old = (found[4], found[5], now), (last[2], last[1])
        how = (penetration, with_balls, band, far)
        left = stay_free(near, moved, old, into, how, places)
        ask_free(buffers, left, near, now)
    if touching.shape[0] > 0 and left >= 0:
        held, how = (last[0], last[1], last[4]), (with_balls, band)
        _, own = touch(touching, (*path, found[4]), held, into, feet, how, places)
        ask_touching(buffers, own, left, last[4])
        left = left + own if own >= 0 else own
    if left > 0:
        step, bounds = (found[4], found[5]), (penetration, True, band, depth, same_foot)
        if judge_asked(buffers, left, places, step, bounds, into, feet):
            left = 0
    return left


@inner()
def _is_turned(pose, was):
    """Whether two poses (4, 4) differ in more than where they are."""
    for i in range(3):
        for j in range(3):
            if pose[i, j] != was[i, j]:
                return True
    return False


@kernel()
def advance(path, last, active, found, feet, rows, speed, how):
    """The step of all points of a closed body, if few were in contact or are near.

    `path` is (now in the world, pose, last pose, now, before), the last two in body axes. `last`,
    `active` and `found` are as `place` has them, of one chunk; `last` goes on with the rows and
    depths of `gather` and holds, `speed` is its (velocity, dt). `feet` are the columns of `touch`
    and `rows` (3, n) for lists. `how` is (limits, the four places of `touch`), the first of these
    (whether balls are asked, search by penetration, band, depth, how far a point may have gone for
    its last foot to be near, how far feet that are one may be apart).

    Returns how many points were in contact and how many others are near, listed in the first rows,
    how many of all these are left (`doubtful` of the buffers), and, where none is left, how many
    are in contact, listed in the last row and in the buffers with what is known of them before
    forces. Of many nothing is settled, and of a body that turns nothing is done.
    """
    outside, pose, was, now, before = path
    limits, places = how
    if _is_turned(pose, was):
        return 0, 0, TURNED, 0
    buffers = buffers_at(places[3])
    n = now.shape[0]
    to_body(outside, pose, now, 0, n)
    known, lists = (last[0], last[1], last[2], last[3]), (rows, buffers.counts)
    place((before, now), known, active, found, lists, max(n, 1), 0, 1)
    touching, near = buffers.counts[0, 0], buffers.counts[0, 1]
    if max(touching, near) > buffers.rows.shape[0]:
        return touching, near, MANY, 0
    lists = (rows[0][:touching], rows[1][:near])
    of_last = (*known, last[6])
    left = _settle(lists, (now, before), of_last, found, feet, limits, places)
    if left != 0:
        return touching, near, left, 0
    k = held(lists, feet.patch, feet.uv, (found[2], found[3]), rows[2])
    deep, out = (last[0], last[4], last[5]), buffers.carried
    out = (out.depth, out.normal, out.foot, out.path, out.old, out.rate)
    gather(rows[2][:k], feet, (now, before), deep, speed[0], speed[1], out)
    return touching, near, left, k
