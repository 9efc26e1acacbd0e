"""Few points of a closed body whose feet do not tell, gathered on the desk, and judged there.

`contiga.contact.judge` does the same for many, one question after the other.
"""

from __future__ import annotations

from contiga.contact.kernels.carrying_nb import at
from contiga.contact.kernels.judge_nb import NOT_ASKED, is_needed, judge_plain, take_nearest
from contiga.contact.kernels.settle_nb import KEEP, becomes, distance, take_foot
from contiga.jit import inner
from contiga.jit.resident import reader
from contiga.num.kernels.query_nb import blank_foot
from contiga.search.kernels.nearest_nb import project_global, project_proved

tables_at = reader("contiga.search.table_types.Tables")
balls_at = reader("contiga.search.ball_cells.Balls")


@inner(linked=False)
def ask_touching(desk, count, first, holds):
    """Put points that were in contact, the first of the desk's `ways`, from row `first` on."""
    asked, place = desk.doubtful, 0
    for j in range(count):
        i, m = desk.ways[j], first + j
        asked.rows[m] = desk.rows[i]
        asked.was[m] = True
        asked.kept[m] = desk.mark[i] & KEEP > 0
        asked.status[m] = becomes(desk.feet.status[i])
        asked.side[m] = desk.own_side[i]
        asked.safe_distance[m] = desk.own_reach[i]
        asked.within[m] = distance(desk.feet, i, desk.now[i])
        take_foot(asked.feet, m, desk.feet, i)
        place = at(holds.rows, desk.rows[i], place)
        there = place < holds.rows.shape[0] and holds.rows[place] == desk.rows[i]
        asked.depth[m] = holds.depth[place] if there else 0.0
        asked.opposed[m] = there and holds.opposed[place]
        for c in range(3):
            desk.stand[m, c] = desk.now[i, c]
            asked.guard[m, c] = holds.guard[place, c] if there else 0.0


@inner(linked=False)
def ask_free(desk, count, rows, now):
    """Put free points, the first of the desk's `ways` in `rows`; they are `now` at (all points)."""
    asked = desk.doubtful
    for m in range(count):
        i = desk.ways[m]
        asked.rows[m] = rows[i]
        asked.was[m] = asked.kept[m] = False
        asked.guard[m, 0] = asked.guard[m, 1] = asked.guard[m, 2] = asked.depth[m] = 0.0
        asked.opposed[m] = False
        asked.status[m] = 0
        asked.side[m] = desk.own_side[i]
        asked.safe_distance[m] = desk.own_reach[i]
        asked.within[m] = desk.reach[i]
        blank_foot(asked.feet, m, NOT_ASKED)
        for c in range(3):
            desk.stand[m, c] = now[rows[i], c]


@inner(linked=False)
def _find(desk, n, penetration, tables, balls):
    """Closest points of those of the first n that need theirs."""
    asked, needed, within = desk.doubtful, desk.needed, desk.within
    m = 0
    for j in range(n):
        blank_foot(asked.truth, j, NOT_ASKED)
        if is_needed(asked.was[j], asked.side[j], penetration, True):
            needed[m], within[m] = j, asked.within[j]
            m += 1
    if balls.elements.shape[0] == 0:
        project_global(tables, desk.stand, needed[:m], within[:m], asked.truth, 0, m)
    else:
        project_proved(tables, balls, desk.stand, needed[:m], within[:m], asked.truth, 0, m)


@inner(linked=False)
def judge_asked(desk, n, places, step, limits, found, taken):
    """Judge the first n as `judge_plain` does; whether all of them are plain."""
    asked = desk.doubtful
    _find(desk, n, limits[0], tables_at(places[0]), balls_at(places[2]))
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
