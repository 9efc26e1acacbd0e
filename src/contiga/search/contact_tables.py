"""Tables of a body that kernels of contact search directly."""

from __future__ import annotations

from typing import NamedTuple

from contiga.pointer_records import pass_by_pointer
from contiga.search.balls.ball_cells import Balls
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.side_grid import SideGrid


@pass_by_pointer
class ContactTables(NamedTuple):
    """The tables of a body of patches; sides are unknown on an open body."""

    body: Tables
    grid: SideGrid
    balls: Balls
