"""The grid of known sides of a body of patches."""

from __future__ import annotations

import numpy as np

from contiga.arrays.disk_cache import DiskCache
from contiga.records import FloatArray, IntArray, Projection
from contiga.search.closest.closest import closest_of_rows
from contiga.search.hierarchy.kept import Kept
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.kernels import side_pieces_nb
from contiga.search.sides.side_grid import CUT, PIECES, THIN, WHOLE, SideGrid, build, layout
from contiga.search.sides.side_records import PieceLimits

FEW = 100
"""Elements below which a grid is built sooner than it is read."""


def sides_of(tables: Tables, slit: float) -> SideGrid:
    """The grid of the closed body that `tables` are of, built at the first call.

    `slit` is how far its faces may be apart where they meet, length.
    """
    return _SIDES.of(tables, slit)


def _build(tables: Tables, slit: float) -> SideGrid:
    table = tables.elements.table
    root = tables.tree[0]
    margins = table["edge_tolerance"] + table["noise"] + 2.0 * slit
    wide = margins.max()
    place = layout(np.stack([root["low"] - wide, root["high"] + wide]), len(table))
    margins += 2.0 * place.skin
    limits = PieceLimits(WHOLE * place.size, CUT * place.size, THIN * place.small, PIECES)
    pieces, middles = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, place.origin, margins, limits
    )
    element = middles[:, 0].astype(np.int64)
    box = table["box"][element]
    uv = box[:, ::2] + (middles[:, 1:] + 0.5) * (box[:, 1::2] - box[:, ::2])

    def closest(points: FloatArray, rows: IntArray, out: Projection) -> None:
        closest_of_rows(tables, points, rows, out)

    return build(place, pieces, (table["patch"][element], np.ascontiguousarray(uv)), closest)


_SIDES = Kept(_build, DiskCache("sides", __file__), FEW)
