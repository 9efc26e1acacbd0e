"""What kernels of contact ask of a body themselves."""

from __future__ import annotations

from typing import NamedTuple

from contiga.pointer_records import pass_by_pointer
from contiga.search.ball_cells import Balls
from contiga.search.side_grid import SideGrid
from contiga.search.table_types import Tables


@pass_by_pointer
class ContactTables(NamedTuple):
    """The tables of a closed body of patches."""

    body: Tables
    grid: SideGrid
    balls: Balls
