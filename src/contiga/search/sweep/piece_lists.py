"""The pieces of a body near every voxel, listed once they are worth it.

They tell of most short paths beside a body that they cross nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.disk_cache import DiskCache
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.kept import Kept
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.kernels import side_pieces_nb
from contiga.search.sides.kernels.side_pieces_nb import PieceLimits
from contiga.search.sweep.kernels import piece_lists_nb
from contiga.search.sweep.kernels.hit_nb import GRAZING

# Paths asked of a body after which pieces are listed for them.
WORTH = 20_000
# Voxels along the longest side: the root of so many an element, within bounds.
FINE = 200.0
FEWEST, MOST = 24, 128
# How long a piece may be, in voxels, where nothing is trimmed and where it is cut; how thick.
WHOLE, CUT, THIN = 2.0, 1.0, 0.05
# Pieces above which none is halved any more.
PIECES = 200_000
# Elements below which pieces are listed sooner than lists are read.
FEW = 100
# Voxels that the boxes of all pieces meet at most: with wider edges nothing is listed.
CROWDED = 10_000_000
# By how much pieces are widened: a share of the size, and of the coordinates, which are rounded.
REACH = 1e-6
ROUNDING = 256.0 * float(np.finfo(float).eps)


@pass_by_pointer
class PieceLists(NamedTuple):
    """Pieces of a body near voxels; see `piece_lists_nb`."""

    origin: FloatArray
    """(3,) low corner of the grid, body frame."""
    scale: float
    """Voxels a length."""
    reach: float
    """How far beyond its ends a path may count, length."""
    voxels: IntArray
    """(3,) how many along each axis."""
    first: IntArray
    """(voxels + 1,) where the pieces of each begin in `listed`."""
    listed: IntArray
    """Rows of `pieces`."""
    pieces: FloatArray
    """(n, 11) their boxes and slabs about the origin, see `side_pieces_nb`."""


NONE = PieceLists(
    np.zeros(3),
    1.0,
    -1.0,
    np.zeros(3, np.int32),
    np.zeros(1, np.int32),
    np.zeros(0, np.int32),
    np.zeros((0, side_pieces_nb.COLUMNS)),
)
"""Of a body of which nothing is listed."""


def lists_of(tables: Tables, asked: int) -> PieceLists:
    """The lists of a body if they are worth it as `asked` paths are asked for, too; else `NONE`.

    Results are the same bits with them and without.
    """
    return _LISTS.if_worth(tables, asked, WORTH) or NONE


def build_lists(tables: Tables) -> PieceLists:
    """The lists of a body."""
    table, size = tables.elements.table, float(tables.scale[0])
    low, high = tables.tree["low"][0], tables.tree["high"][0]
    if not np.isfinite(low).all():  # a body without leaves
        return NONE
    wide = float((high - low).max())
    side = wide / float(min(max(np.sqrt(FINE * len(table)), FEWEST), MOST))
    voxels = np.ceil((high - low) / side).astype(np.int32) + 2
    origin = low - side
    reach = REACH * size
    rounding = ROUNDING * (float(np.abs([low, high]).max()) + size)
    # A path may meet the carrier of a face that far beyond its edge.
    margins = (GRAZING + 1.0) * table["edge_tolerance"] + table["noise"] + reach + rounding
    limits = PieceLimits(WHOLE * side, CUT * side, THIN * side, PIECES)
    pieces, _ = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, origin, margins, limits
    )
    low, high = np.floor(pieces[:, :6] / side).reshape(-1, 2, 3).clip(0, voxels - 1).swapaxes(0, 1)
    if (high - low + 1.0).prod(axis=1).sum() > CROWDED:
        return NONE
    first = np.zeros(int(np.prod(voxels)) + 1, np.int32)
    piece_lists_nb.list_pieces(pieces, side, voxels, first, np.zeros(0, np.int32))
    first = np.cumsum(first, dtype=np.int32)
    listed = np.zeros(max(int(first[-1]), 1), np.int32)
    piece_lists_nb.list_pieces(pieces, side, voxels, first.copy(), listed)
    return PieceLists(origin, 1.0 / side, reach, voxels, first, listed, pieces)


_LISTS = Kept(build_lists, DiskCache("lists", __file__), FEW)
