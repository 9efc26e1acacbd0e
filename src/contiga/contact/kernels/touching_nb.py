"""Few points in contact with a closed exact body, or near it: all that is asked, in one call.

`closed_body` says what follows from what; of few points its calls, one after the other, take longer
than what is done in them. The results are the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.kernels.place_nb import held, place
from contiga.contact.kernels.settle_nb import (
    KEPT,
    askable,
    leave,
    look,
    remember_foot,
    settle,
    starts,
    stay,
    tell,
)
from contiga.num.codes import MAX_ITERATIONS
from contiga.num.jit import inner, kernel
from contiga.num.kernels.rigid_nb import to_body
from contiga.num.resident import reader
from contiga.search.kernels.ball_nb import radii
from contiga.search.kernels.bins_nb import FOUND, HANDED
from contiga.search.kernels.side_nb import clear_ways, sides
from contiga.search.kernels.side_nb import places as places_of
from contiga.search.kernels.track_nb import track_chunks

tables_at = reader("contiga.search.table_types.Tables")
sides_at = reader("contiga.search.side_grid.SideGrid")
balls_at = reader("contiga.search.ball_cells.Balls")
desk_at = reader("contiga.contact.desk.Desk")

NO_BALLS, NOT_SOLVED, MANY, NOT_IN = -1, -2, -3, -4
"""Answers in place of a number of rows: balls are needed, and not worked out; the feet of some rows
have to be looked for elsewhere; there are more rows than the desk has; some may lie inside since
the start. What has been written is written again then."""


@inner(linked=False)
def _follow(tables, desk, n, certified):
    """Feet of the first n rows; whether all are solved."""
    path = (desk.before[: n * certified], desk.now[:n], desk.nobody)
    starts = (desk.patch[:n], desk.uv[:n])
    desk.flags[:n] = 0
    room = np.empty((n, HANDED)), np.empty((n, FOUND))
    track_chunks(tables, path, starts, n, room, (desk.feet, desk.flags[:n]), 0, 1)
    failed = 0
    for i in range(n):
        failed += desk.feet.status[i] == MAX_ITERATIONS
    return failed == 0


@inner(linked=False)
def _keep_clear(grid, desk, path, n):
    """Mark the first n of the rows whose ways are looked at, where they meet no surface."""
    now, before = path
    for j in range(n):
        desk.way[j] = desk.rows[desk.ways[j]]
    clear_ways(grid, before, now, desk.way[:n], desk.clear[:n], 0, n)
    for j in range(n):
        if desk.clear[j]:
            desk.mark[desk.ways[j]] |= KEPT


@inner(linked=False)
def _ask_balls(places, desk, n):
    """Radii of the balls at the first n feet that are asked for; whether there are any balls."""
    if n == 0:
        return True
    balls = balls_at(places[2])
    if balls.elements.shape[0] == 0:
        return False
    feet = (desk.feet.patch, desk.feet.uv)
    grid = tables_at(places[0]).grid
    radii(balls, grid, feet, desk.asked[:n], desk.which[:n], desk.radius, 0, n)
    return True


@kernel()
def touch(rows, path, last, found, feet, limits, places):
    """Settle the points `rows` that were in contact; returns how many are on the desk, those that
    are not outside, and how many of them are left, listed in its `ways`.

    `path` is (now, before), `last` (patch, uv) of the last feet, `found` (status, safe distance,
    near, uv) and `feet` of this step, all of all points; `limits` is (whether points are held on
    borders, whether balls are asked, band), `places` where to find (tables, sides, balls, desk).
    """
    tables, grid, desk = tables_at(places[0]), sides_at(places[1]), desk_at(places[3])
    hold, with_balls, band = limits
    now, before = path
    n = rows.shape[0]
    sides(grid, now, rows, desk.side, desk.reach, 0, n)
    known, own = (desk.side, desk.reach), (desk.own_side, desk.own_reach)
    work = (desk.rows, desk.own_side, desk.own_reach, desk.patch, desk.uv, desk.before, desk.now)
    n = stay(rows, known, (before, now), last, (found[0], found[1]), band, work)
    if n == 0:
        return 0, 0
    if not _follow(tables, desk, n, 1):
        return n, NOT_SOLVED
    own_rows, mark = desk.rows[:n], desk.mark[:n]
    asked, limited = (desk.asked, desk.which), (hold, band)
    ways, balls = look(
        own_rows, desk.feet, desk.own_side, found[1], limited, mark, desk.ways, asked
    )
    if ways > 0:
        _keep_clear(grid, desk, path, ways)
    balls = balls if with_balls else 0
    if not _ask_balls(places, desk, balls):
        return n, NO_BALLS
    told = (desk.asked[:balls], desk.radius[:balls])
    return n, settle(own_rows, desk.feet, own, mark, told, band, found, feet, desk.ways)


@kernel()
def stay_free(rows, step, old, found, limits, places):
    """Settle the free points `rows` that stay so; returns how many are left, listed in the desk's
    `ways`, with what is known of all: sides, reaches (both its own) and distances (its `reach`).

    `step` is (way, ignored, now), `old` (near, uv) of the last step and `found` as `touch` has it,
    all of all points; `limits` is (search by penetration, whether balls are asked, band, how far a
    point may have gone for its last foot to be near), `places` as of `touch`.
    """
    tables, grid, desk = tables_at(places[0]), sides_at(places[1]), desk_at(places[3])
    way, ignored, now = step
    penetration, with_balls, band, far = limits
    n = rows.shape[0]
    known, spots = (desk.own_side, desk.own_reach), (desk.way, desk.spot)
    places_of(grid, now, rows, known, spots, 0, n)
    desk.reach[:n] = math.inf
    work = (desk.rows, desk.patch, desk.uv, desk.now)
    m = starts(rows, known, spots, (way, now), old, found[2], far, work)
    if m > 0:
        if not _follow(tables, desk, m, 0):
            return NOT_SOLVED
        for j in range(m):
            remember_foot(found, rows[desk.rows[j]], desk.feet, j)
        balls = askable(desk.feet, m, band, (desk.asked, desk.which)) if with_balls else 0
        if not _ask_balls(places, desk, balls):
            return NO_BALLS
        told = (desk.asked[:balls], desk.radius[:balls])
        tell(desk.rows[:m], desk.feet, desk.now[:m], told, band, known, desk.reach)
    for i in range(n):
        k = rows[i]
        desk.clear[i] = False
        if not penetration and desk.own_side[i] < 0 and ignored[k] and math.isfinite(way[k]):
            return NOT_IN
    return leave(rows, known, desk.clear[:n], band, found[1], desk.ways)


@kernel()
def advance(path, pose, last, active, found, feet, rows, how):
    """The step of all points of a closed body, if few were in contact, up to what is left to judge.

    `path` is (now in the world, now, before), body axes from the pose on; `last`, `active` and
    `found` are as `place` has them, for one chunk of all points, `feet` the columns of `touch`,
    `rows` (3, n) for lists. `how` is (hold, whether balls are asked, band, most points that are
    few, and the four places of `touch`).

    Returns how many points were in contact and how many others are near, listed in the first rows,
    how many of the first are left (see `touch`), and, where none is left and none near, how many
    are in contact, listed in the last row. Of many that were in contact nothing is settled.
    """
    hold, with_balls, band, most, tables, grid, balls, desk = how
    outside, now, before = path
    n = now.shape[0]
    to_body(outside, pose, now, 0, n)
    counts = desk_at(desk).counts
    place((before, now), last, active, found, (rows, counts), max(n, 1), 0, 1)
    touching, near = counts[0, 0], counts[0, 1]
    if touching > most:
        return touching, near, MANY, 0
    left = 0
    if touching > 0:
        _, left = touch(
            rows[0][:touching],
            (now, before),
            (last[0], last[1]),
            (found[0], found[1], found[2], found[3]),
            feet,
            (hold, with_balls, band),
            (tables, grid, balls, desk),
        )
    if left != 0 or near > 0:
        return touching, near, left, 0
    lists = (rows[0][:touching], rows[1][:near])
    return touching, near, left, held(lists, feet.patch, feet.uv, (found[2], found[3]), rows[2])
