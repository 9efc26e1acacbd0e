"""Few points of a closed body whose feet do not tell, gathered in the step's buffers and judged.

`contiga.contact.judge` does the same for many, one question after the other.
"""

from __future__ import annotations

from contiga.contact.kernels.carrying_nb import at
from contiga.contact.kernels.judge_nb import NOT_ASKED, is_needed, judge_plain, take_nearest
from contiga.contact.kernels.settle_nb import KEEP, becomes, distance, take_foot
from contiga.jit import inner
from contiga.jit.pinned import reader
from contiga.num.kernels.query_nb import blank_foot
from contiga.search.kernels.nearest_nb import project_global, project_proved

tables_at = reader("contiga.search.table_types.Tables")
balls_at = reader("contiga.search.ball_cells.Balls")


@inner(linked=False)
def ask_touching(buffers, count, first, holds):
    """Put points that were in contact, the first of the buffers' `ways`, from row `first` on."""
    asked, place = buffers.doubtful, 0
    for j in range(count):
        i, m = buffers.ways[j], first + j
        asked.rows[m] = buffers.rows[i]
        asked.was[m] = True
        asked.kept[m] = buffers.mark[i] & KEEP > 0
        asked.status[m] = becomes(buffers.feet.status[i])
        asked.side[m] = buffers.own_side[i]
        asked.safe_distance[m] = buffers.own_reach[i]
        asked.within[m] = distance(buffers.feet, i, buffers.now[i])
        take_foot(asked.feet, m, buffers.feet, i)
        place = at(holds.rows, buffers.rows[i], place)
        there = place < holds.rows.shape[0] and holds.rows[place] == buffers.rows[i]
        asked.depth[m] = holds.depth[place] if there else 0.0
        asked.opposed[m] = there and holds.opposed[place]
        for c in range(3):
            buffers.stand[m, c] = buffers.now[i, c]
            asked.guard[m, c] = holds.guard[place, c] if there else 0.0


@inner(linked=False)
def ask_free(buffers, count, rows, now):
    """Put free points, the first of the buffers' `ways` in `rows`; `now` has all points."""
    asked = buffers.doubtful
    for m in range(count):
        i = buffers.ways[m]
        asked.rows[m] = rows[i]
        asked.was[m] = asked.kept[m] = False
        asked.guard[m, 0] = asked.guard[m, 1] = asked.guard[m, 2] = asked.depth[m] = 0.0
        asked.opposed[m] = False
        asked.status[m] = 0
        asked.side[m] = buffers.own_side[i]
        asked.safe_distance[m] = buffers.own_reach[i]
        asked.within[m] = buffers.reach[i]
        blank_foot(asked.feet, m, NOT_ASKED)
        for c in range(3):
            buffers.stand[m, c] = now[rows[i], c]


@inner(linked=False)
def _find(buffers, n, penetration, tables, balls):
    """Closest points of those of the first n that need theirs."""
    asked, needed, within = buffers.doubtful, buffers.needed, buffers.within
    m = 0
    for j in range(n):
        blank_foot(asked.truth, j, NOT_ASKED)
        if is_needed(asked.was[j], asked.side[j], penetration, True):
            needed[m], within[m] = j, asked.within[j]
            m += 1
    if balls.elements.shape[0] == 0:
        project_global(tables, buffers.stand, needed[:m], within[:m], asked.truth, 0, m)
    else:
        project_proved(tables, balls, buffers.stand, needed[:m], within[:m], asked.truth, 0, m)


@inner(linked=False)
def judge_asked(buffers, n, places, step, limits, found, taken):
    """Judge the first n as `judge_plain` does; whether all of them are plain."""
    asked = buffers.doubtful
    _find(buffers, n, limits[0], tables_at(places[0]), balls_at(places[2]))
    own = (asked.rows[:n], asked.was, asked.kept, asked.status)
    near = (limits[2], limits[4])
    held = (asked.guard, asked.depth, asked.opposed)
    take_nearest(own, asked.feet, asked.truth, held, step[0], near)
    columns = (
        asked.rows[:n],
        asked.was[:n],
        asked.kept[:n],
        asked.status[:n],
        asked.side[:n],
        asked.safe_distance[:n],
    )
    return judge_plain(columns, asked.feet, asked.truth, step, limits, found, taken)
