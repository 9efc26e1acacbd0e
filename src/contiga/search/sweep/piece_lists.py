"""Lists of the pieces of a body near every voxel, built once enough paths have been searched.

They show that most short paths near a body cross nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.disk_cache import DiskCache
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.kernels import side_pieces_nb
from contiga.search.sides.kernels.side_pieces_nb import PieceLimits
from contiga.search.sweep.kernels import piece_lists_nb
from contiga.search.sweep.kernels.hit_nb import GRAZING

MIN_PATHS = 20_000
"""Number of searched paths of a body from which on lists pay."""
VOXELS_PER_ELEMENT = 200.0
"""Its square root, times that of the number of elements, is the number of voxels along the longest
side, within `MIN_VOXELS` and `MAX_VOXELS`."""
MIN_VOXELS, MAX_VOXELS = 24, 128
MAX_LENGTH, MAX_TRIMMED_LENGTH, MAX_THICKNESS = 2.0, 1.0, 0.05
"""Largest length of a piece, the same where it is trimmed, and largest thickness, in voxels."""
MAX_PIECES = 200_000
"""Number of pieces above which none is halved."""
MIN_ELEMENTS = 100
"""Number of elements below which building the lists is faster than reading them from the disk."""
MAX_ENTRIES = 10_000_000
"""Largest number of voxels in the boxes of all pieces; with wider edges nothing is listed."""
REACH = 1e-6
"""Largest distance beyond the ends of a path at which a crossing counts, as a share of the size."""
ROUNDING = 256.0 * float(np.finfo(float).eps)
"""Bound of the rounding of coordinates, as a share of them."""


@pass_by_pointer
class PieceLists(NamedTuple):
    """Lists of the pieces of a body near every voxel; see `piece_lists_nb`."""

    origin: FloatArray
    """(3,) low corner of the grid, body frame."""
    scale: float
    """Number of voxels per length."""
    reach: float
    """Largest distance beyond the ends of a path at which a crossing counts, length."""
    voxels: IntArray
    """(3,) number along each axis."""
    first: IntArray
    """(voxels + 1,) row of `listed` at which the pieces of each voxel begin."""
    listed: IntArray
    """Rows of `pieces`."""
    pieces: FloatArray
    """(n, 11) boxes and slabs of the pieces relative to `origin`, see `side_pieces_nb`."""


NO_LISTS = PieceLists(
    np.zeros(3),
    1.0,
    -1.0,
    np.zeros(3, np.int32),
    np.zeros(1, np.int32),
    np.zeros(0, np.int32),
    np.zeros((0, side_pieces_nb.COLUMNS)),
)
"""The lists of a body without lists."""


def lists_of(tables: Tables, n_paths: int) -> PieceLists:
    """Return the lists of a body once `MIN_PATHS` paths have been searched; before, `NO_LISTS`.

    `n_paths` is the number of paths of this search. Results of searches have the same bits with
    lists and without.
    """
    return _LISTS.if_pays(tables, n_paths, MIN_PATHS) or NO_LISTS


def build_lists(tables: Tables) -> PieceLists:
    """Build the lists of a body; `NO_LISTS` if it has no leaves, or they exceed `MAX_ENTRIES`."""
    table, size = tables.elements.table, float(tables.scale[0])
    low, high = tables.tree["low"][0], tables.tree["high"][0]
    if not np.isfinite(low).all():  # a body without leaves
        return NO_LISTS
    extent = float((high - low).max())
    n = np.sqrt(VOXELS_PER_ELEMENT * len(table))
    side = extent / float(min(max(n, MIN_VOXELS), MAX_VOXELS))
    voxels = np.ceil((high - low) / side).astype(np.int32) + 2
    origin = low - side
    reach = REACH * size
    rounding = ROUNDING * (float(np.abs([low, high]).max()) + size)
    # A path may cross the carrier of a face as far as this beyond its edge.
    margins = (GRAZING + 1.0) * table["edge_tolerance"] + table["noise"] + reach + rounding
    lengths = MAX_LENGTH * side, MAX_TRIMMED_LENGTH * side
    limits = PieceLimits(*lengths, MAX_THICKNESS * side, MAX_PIECES)
    pieces, _ = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, origin, margins, limits
    )
    low, high = np.floor(pieces[:, :6] / side).reshape(-1, 2, 3).clip(0, voxels - 1).swapaxes(0, 1)
    if (high - low + 1.0).prod(axis=1).sum() > MAX_ENTRIES:
        return NO_LISTS
    first = np.zeros(int(np.prod(voxels)) + 1, np.int32)
    piece_lists_nb.list_pieces(pieces, side, voxels, first, np.zeros(0, np.int32))
    first = np.cumsum(first, dtype=np.int32)
    listed = np.zeros(max(int(first[-1]), 1), np.int32)
    piece_lists_nb.list_pieces(pieces, side, voxels, first.copy(), listed)
    return PieceLists(origin, 1.0 / side, reach, voxels, first, listed, pieces)


_LISTS = TableCache(build_lists, DiskCache("lists", __file__), MIN_ELEMENTS)
