"""Points that lie deeper than the balls at their feet tell: settled by their closest points.

What is found is what `contiga.contact.judge` finds for all points that are left. Points are left
here whose feet need more than the lanes of tracking, whose paths have to be looked at, or that
another wall than the nearest may hold.
"""

from __future__ import annotations

from contiga.arrays.codes import MAX_ITERATIONS
from contiga.contact.asked_records import Asked
from contiga.contact.kernels.carrying_nb import at
from contiga.contact.kernels.judge_nb import is_plain, take_nearest, write_plain
from contiga.contact.kernels.settle_nb import KEEP, becomes, distance, take_foot
from contiga.contact.kernels.usual_nb import settled
from contiga.jit import inner, kernel
from contiga.search.closest.kernels.nearest_nb import project_proved


@inner()
def _ask(asked, m, work, i, holds, j):
    """Fill row m of the points that are asked for with row i of those settled; what held it is
    that of row j, where there is one."""
    asked.rows[m], asked.side[m] = work.rows[i], work.side[i]
    asked.safe_distance[m] = work.reach[i]
    asked.was[m], asked.kept[m] = True, work.mark[i] & KEEP > 0
    asked.status[m] = becomes(work.feet.status[i])
    asked.within[m] = distance(work.feet, i, work.path.now[i])
    held = j < holds.rows.shape[0] and holds.rows[j] == work.rows[i]
    asked.depth[m] = holds.depth[j] if held else 0.0
    asked.opposed[m] = held and holds.opposed[j]
    for c in range(3):
        asked.guard[m, c] = holds.guard[j, c] if held else 0.0
    take_foot(asked.feet, m, work.feet, i)


@inner()
def _first(asked, m):
    """The first m points that are asked for: kernels go by `rows`."""
    return Asked(
        asked.rows[:m],
        asked.was,
        asked.kept,
        asked.status,
        asked.side,
        asked.safe_distance,
        asked.within,
        asked.guard,
        asked.depth,
        asked.opposed,
        asked.feet,
        asked.truth,
    )


@kernel()
def settle_deep(tables, step, last, rows, limits, judging, work, deep, detected, left):
    """As `settle_touching`, where the nearest wall pushes.

    `judging` are `JudgeLimits`, `deep` are `DeepRows` for as many rows or more.
    """
    n = settled(tables, step, last, rows, limits, work, detected, left)
    holds, m, j = step.holds, 0, 0
    for a in range(n):
        i = work.chosen[a]
        deep.place[a] = -1
        if work.feet.status[i] == MAX_ITERATIONS:
            continue
        j = at(holds.rows, work.rows[i], j)
        _ask(deep.asked, m, work, i, holds, j)
        for c in range(3):
            deep.now[m, c] = work.path.now[i, c]
        deep.place[a] = m
        m += 1
    asked = _first(deep.asked, m)
    project_proved(tables.body, tables.balls, deep.now, deep.which, asked.within, asked.truth, 0, m)
    take_nearest(asked, step.way, judging)
    k = 0
    for a in range(n):
        i = deep.place[a]
        if i >= 0 and is_plain(asked, step, judging, i):
            write_plain(asked, judging, detected, i)
        else:
            left[k] = work.rows[work.chosen[a]]
            k += 1
    return k
