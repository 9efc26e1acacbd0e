"""The balls that touch a body from inside and outside, as large as can be proved.

Once per body every element is divided into cells, and every cell gets four values per side that
bound the radius of the touching ball at each of its points (`ball_nb`). They prove, for Q inside a
face with outward normal n and P = Q − d n (Federer 1959, reach of a set):

* 0 < d < 2 ρ_in: P is inside, whatever the rest of the body is;
* d ≤ ρ_in: Q is the closest point of the whole surface;
* the same outside with ρ_out.
"""

from __future__ import annotations

from contiga.arrays.disk_cache import DiskCache
from contiga.search.balls import ball_cells
from contiga.search.balls.ball_cells import Balls, build_balls
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.hierarchy.table_types import Tables

MIN_POINTS = 200_000
"""Number of closest points of a body from which on its balls pay: computing them takes as long."""

_BALLS = TableCache(build_balls, DiskCache("balls", ball_cells.__file__))


def balls_of(tables: Tables) -> Balls:
    """Return the touching balls of a body, computed at the first call."""
    return _BALLS.of(tables)


def balls_if_they_pay(tables: Tables, n_points: int) -> Balls | None:
    """Return the balls if they are computed, or pay with `n_points` more closest points; else None.

    Results have the same bits with them and without.
    """
    return _BALLS.if_pays(tables, n_points, MIN_POINTS)
