"""The usual points of a closed body, settled in one call: what needs more is left to the stages.

What a call does is what `contiga.contact.closed_body` has done stage by stage for the rows that are
left, and says why. Rows are left that the lanes of tracking leave, or that neither sides nor balls
tell anything of; nothing is said of them.
"""

from __future__ import annotations

from contiga.arrays.codes import MAX_ITERATIONS
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.contact.kernels.settle_nb import (
    KEPT,
    askable,
    face,
    leave,
    look,
    settle,
    starts,
    stay,
    tell,
)
from contiga.contact.settle_records import AskedFeet, FootBalls, FreeRows, TouchingRows
from contiga.jit import inner, kernel
from contiga.records import KnownSides, SurfacePlaces
from contiga.search.balls.kernels.ball_nb import radii
from contiga.search.sides.kernels.side_nb import clear_ways, places, sides
from contiga.search.track.kernels.track_nb import track_chunks


@inner(linked=False)
def _follow(tables, work, n):
    """Feet of the first n rows of `work` in lanes; those that need more have none."""
    start = work.starts
    m = track_chunks(
        tables.body, work.path, start, n, work.records, work.left, work.feet, (0, 1 if n else 0)
    )
    for j in range(m):
        blank_foot(work.feet, work.left.rows[j], MAX_ITERATIONS)


@inner(linked=False)
def _ask_balls(tables, work, m):
    """Radii of the balls at the first m feet that are asked for."""
    feet = SurfacePlaces(work.feet.patch, work.feet.uv)
    radii(tables.balls, tables.body.grid, feet, work.asked, work.which, work.radius, 0, m)


@inner(linked=False)
def settled(tables, step, last, rows, limits, work, detected, left):
    """Settle points that were in contact, `rows`; returns how many of `work.rows` are left, listed
    in `work.chosen`. `left` is memory. The rest is as of `settle_touching`."""
    n, band = rows.shape[0], limits.band
    side, reach = work.side, work.reach
    sides(tables.grid, step.now, rows, side, reach, 0, n)
    known, begun, path = KnownSides(side, reach), work.starts, work.path
    columns = TouchingRows(work.rows, side, reach, begun.patch, begun.uv, path.before, path.now)
    n = stay(rows, known, step, last, detected, band, columns)
    _follow(tables, work, n)
    staying, feet, mark = work.rows[:n], work.feet, work.mark
    asked = AskedFeet(work.asked, work.which)
    if limits.nearest:
        m = face(staying, feet, step.holds, step.way, band, mark, asked)
    else:
        ways, m = look(
            staying, feet, side, detected.safe_distance, limits, mark, work.chosen, asked
        )
        for j in range(ways):
            left[j] = staying[work.chosen[j]]
        clear_ways(tables.grid, step.before, step.now, left, work.clear, 0, ways)
        for j in range(ways):
            if work.clear[j]:
                mark[work.chosen[j]] |= KEPT
    _ask_balls(tables, work, m)
    balls = FootBalls(work.asked[:m], work.radius[:m])
    return settle(staying, feet, known, mark, balls, band, detected, work.chosen)


@kernel()
def settle_touching(tables, step, last, rows, limits, work, detected, left):
    """Settle points that were in contact, `rows`; returns how many are `left`, listed there.

    `tables` are `ContactTables`, `step` a `Step`, `last` the `SurfacePlaces` of all points,
    `limits` are `Limits`, `work` is `Work` for as many rows or more, `detected` is what was
    `Detected`.
    """
    n = settled(tables, step, last, rows, limits, work, detected, left)
    for j in range(n):
        left[j] = work.rows[work.chosen[j]]
    return n


@kernel()
def settle_free(tables, step, rows, limits, work, detected, left):
    """Settle free points near the surface that stay free; the rest as of `settle_touching`."""
    n, band = rows.shape[0], limits.band
    known = KnownSides(work.side, work.reach)
    places(tables.grid, step.now, rows, known, work.near, 0, n)
    columns = FreeRows(work.rows, work.starts.patch, work.starts.uv, work.path.now)
    m = starts(rows, work.side, work.near, step, detected.last_patch, limits.far, columns)
    _follow(tables, work, m)
    for j in range(m):
        k = rows[work.rows[j]]
        detected.last_patch[k] = work.feet.patch[j]
        detected.uv[k, 0], detected.uv[k, 1] = work.feet.uv[j, 0], work.feet.uv[j, 1]
    asked = askable(work.feet, m, band, AskedFeet(work.asked, work.which))
    _ask_balls(tables, work, asked)
    balls = FootBalls(work.asked[:asked], work.radius[:asked])
    tell(work.rows[:m], work.feet, work.path.now, balls, band, known, work.within)
    n = leave(rows, known, work.none, band, detected.safe_distance, work.chosen)
    for j in range(n):
        left[j] = rows[work.chosen[j]]
    return n
