"""The balls that touch a body from inside and outside, as large as can be proved.

Once per body every element is cut into cells, and every cell gets four values a side that bound
the radius of the touching ball at each of its points (`ball_nb`). What follows from it, for Q
inside a face with outward normal n and P = Q − d n (Federer 1959, reach of a set):

* 0 < d < 2 ρ_in: P is inside, whatever else the body does;
* d ≤ ρ_in: Q is the closest point of the whole surface;
* the same outside with ρ_out.
"""

from __future__ import annotations

from contiga.arrays.disk_cache import DiskCache
from contiga.search.balls import ball_cells
from contiga.search.balls.ball_cells import Balls, build_balls
from contiga.search.hierarchy.kept import Kept
from contiga.search.hierarchy.table_types import Tables

# Closest points asked of a body after which its balls are worked out for them: these take as long.
WORTH = 200_000

_BALLS = Kept(build_balls, DiskCache("balls", ball_cells.__file__))


def balls_of(tables: Tables) -> Balls:
    """The touching balls of the body that `tables` are of, worked out at the first call."""
    return _BALLS.of(tables)


def known_balls(tables: Tables, asked: int) -> Balls | None:
    """The balls if they are worked out, or worth it as `asked` closest points are asked for, too.

    Results are the same bits with them and without.
    """
    return _BALLS.if_worth(tables, asked, WORTH)
