"""A grid of known sides: the side of a closed body that all points of a cell are on.

A cell that no piece of the surface meets contains points of one side only, and so do all such cells
that are connected. The test uses boxes and slabs that contain the pieces, widened by the width of
the edges and by the slits that are bridged, so that connections between cells are sound. One
closest point decides the side of a connected region; three are computed, and if they disagree
(faces that do not fit) the side stays unknown. Points in other cells, within about one cell of the
surface, need a closest point of their own.

Built once a body, from at most 6e5 cells and as many words of small cells: at most 25 MB.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Records
from contiga.jit import straight
from contiga.pointer_records import pass_by_pointer
from contiga.records import (
    FloatArray,
    IntArray,
    Sides,
    empty_projection,
)
from contiga.search.closest.closest import closest_of_rows
from contiga.search.hierarchy.table_cache import TableCache
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.kernels import side_grid_nb, side_nb, side_pieces_nb
from contiga.search.sides.kernels.side_grid_nb import SPLIT
from contiga.search.sides.kernels.side_pieces_nb import PieceLimits
from contiga.statuses import Feature, Status

CELLS_PER_ELEMENT = 1000.0
MIN_CELLS, MAX_CELLS = 3e4, 6e5
"""Number of cells of the grid."""
N_MARGIN = 3
"""Number of cells along each axis in addition to those of the box."""
MAX_LENGTH, MAX_TRIMMED_LENGTH = 4.0, 3.0
"""Largest length of a piece, and of one that a trim cuts, in cells."""
MAX_THICKNESS = 1.0
"""Largest thickness of a piece, in small cells."""
MAX_PIECES = 400_000
"""Number of pieces above which none is halved."""
SKIN = 1e-6
"""Distance from a cell without surface within which there is none either, as a share of a small
cell."""
ROUNDING = 256.0 * float(np.finfo(float).eps)
"""Bound of the rounding of coordinates, as a share of them and of the size."""
MAX_REGIONS = 256
"""Number of regions, the largest ones, whose side is computed."""
MIN_REGION_CELLS = 8
"""Least number of small cells of such a region."""
MIN_POINTS = 4096
"""Number of points below which a second thread does not pay."""
MIN_ELEMENTS = 100
"""Number of elements below which building a grid is faster than reading it from the disk."""


@pass_by_pointer
class SideGrid(NamedTuple):
    """The known sides of a closed body, in cells from a low corner on; see `side_nb`."""

    origin: FloatArray
    """(3,) low corner of the grid, body frame."""
    size: float
    """Size of a cell, length."""
    skin: float
    """Smallest distance of a cell without surface from the surface, length."""
    outer_side: int
    """Side of all points outside the grid; 0 if unknown."""
    cell: IntArray
    """(i, j, k) side times the number of cells to the next that may contain surface, 0 if unknown;
    FIRST_WORD + word in cells that may contain surface themselves."""
    masks: Records
    """(words, 2) bits of the small cells inside, and of those outside."""
    piece: IntArray
    """(words,) a piece of the surface that meets the cell."""
    patch: IntArray
    """(pieces,) patch of a piece."""
    uv: FloatArray
    """(pieces, 2) parameters of its middle."""


UNKNOWN = SideGrid(
    np.zeros(3),
    1.0,
    0.0,
    0,
    np.zeros((0, 0, 0), np.int32),
    np.zeros((0, 2), np.uint64),
    np.zeros(0, np.int32),
    np.zeros(0, np.int32),
    np.zeros((0, 2)),
)
"""The grid of a body that has no sides: every side is unknown."""


class Layout(NamedTuple):
    """The place and size of the cells of a grid."""

    origin: FloatArray
    """(3,) low corner, body frame."""
    size: float
    """Size of a cell, length."""
    shape: tuple[int, int, int]
    """Number of cells along each axis."""
    skin: float
    """Distance from a cell without surface within which there is none either, length."""

    @property
    def small(self) -> float:
        """Size of a small cell."""
        return self.size / SPLIT


def layout(bounds: FloatArray, n_elements: int) -> Layout:
    """Return the `Layout` of cells over the (2, 3) box `bounds` of a body of `n_elements` elements.

    Cells are cubes, about `CELLS_PER_ELEMENT` for each element, at most 1.3 `MAX_CELLS` in all.
    The grid is more than one cell larger than the box on all sides, so that its corners, and points
    outside of it, are away from the surface.
    """
    low, high = bounds
    extent = high - low
    size = float(np.linalg.norm(extent))
    extent = np.maximum(extent, 1e-3 * size)
    n_cells = min(max(CELLS_PER_ELEMENT * n_elements, MIN_CELLS), MAX_CELLS)
    cell = float((extent.prod() / n_cells) ** (1.0 / 3.0))
    # Thin boxes need more cells around them than in them.
    while (np.ceil(extent / cell) + N_MARGIN).prod() > 1.3 * n_cells:
        cell *= 1.02
    shape = np.ceil((high - low) / cell).astype(int) + N_MARGIN
    origin = 0.5 * (low + high) - 0.5 * shape * cell
    largest = float(np.abs(bounds).max())
    skin = max(SKIN * cell / SPLIT, ROUNDING * (largest + size))
    return Layout(origin, cell, (int(shape[0]), int(shape[1]), int(shape[2])), skin)


def sides_of(tables: Tables, slit: float) -> SideGrid:
    """Return the grid of a closed body, built at the first call and cached with the tables.

    `slit` is the largest distance of its faces where they meet, length; later calls ignore it.
    """
    return _SIDES.of(tables, slit)


def build_sides(tables: Tables, slit: float) -> SideGrid:
    """Build the grid of a closed body whose faces deviate by at most `slit` where they meet.

    A region of cells without surface has the side of its samples if they agree; only the
    `MAX_REGIONS` largest of at least `MIN_REGION_CELLS` small cells are sampled, all others stay
    unknown.
    """
    table, root = tables.elements.table, tables.tree[0]
    margins = table["edge_tolerance"] + table["noise"] + 2.0 * slit
    max_margin = margins.max()
    cells = layout(np.stack([root["low"] - max_margin, root["high"] + max_margin]), len(table))
    margins += 2.0 * cells.skin
    lengths = MAX_LENGTH * cells.size, MAX_TRIMMED_LENGTH * cells.size
    limits = PieceLimits(*lengths, MAX_THICKNESS * cells.small, MAX_PIECES)
    pieces, middles = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, cells.origin, margins, limits
    )
    # The words of cells that may contain surface, −1 in other cells.
    flat = np.zeros(np.prod(cells.shape), np.int32)
    no_words = np.zeros(0, np.uint64), np.zeros(0, np.int32)
    side_grid_nb.paint(pieces, cells.small, cells.shape, flat, *no_words)
    index = np.flatnonzero(flat)
    flat[:] = -1
    flat[index] = np.arange(len(index))
    # The small cells that may contain surface, and a piece in each word.
    surface_bits, piece = np.zeros(len(index), np.uint64), np.full(len(index), -1, np.int32)
    side_grid_nb.paint(pieces, cells.small, cells.shape, flat, surface_bits, piece)
    places = np.stack(np.unravel_index(index, cells.shape), axis=1).astype(np.int32)
    words = flat.reshape(cells.shape)
    labels, depth = side_grid_nb.label_regions(words < 0), side_grid_nb.depths(words < 0)
    first, mask = side_grid_nb.parts_of(surface_bits)
    parent = side_grid_nb.join(labels, words, places, first, mask)
    regions = (parent, labels, depth, places, first, mask)
    size, samples = side_grid_nb.sizes_and_samples(*regions)
    # The side of each region, by its samples: 1 outside, −1 inside, 0 unknown.
    roots = np.flatnonzero(size >= MIN_REGION_CELLS)
    roots = np.sort(roots[np.argsort(-size[roots], kind="stable")[:MAX_REGIONS]])
    points = cells.origin + cells.size * samples[roots].reshape(-1, 3)
    feet = empty_projection(len(points))
    closest_of_rows(tables, points, np.arange(len(points), dtype=np.int32), feet)
    side = np.where(feet.status == Status.OK, np.sign(feet.gap), 0.0).reshape(-1, 3)
    # Feet inside faces do not depend on how faces fit: where there are some, only they count.
    is_plain = ((feet.status == Status.OK) & (feet.feature == Feature.FACE)).reshape(-1, 3)
    counts = is_plain | ~is_plain.any(axis=1, keepdims=True)
    least_side = np.where(counts, side, 1.0).min(axis=1)
    largest_side = np.where(counts, side, -1.0).max(axis=1)
    sign = np.zeros(len(size), np.int8)
    sign[roots] = np.where(least_side == largest_side, least_side, 0.0)
    cell, masks = side_grid_nb.side_tables(parent, sign, labels, depth, words, first, mask)
    outer_side = int(sign[parent[labels[0, 0, 0] - 1]])
    # Patch and parameters of the middles of the pieces.
    element = middles[:, 0].astype(np.int64)
    box = table["box"][element]
    uv = np.ascontiguousarray(box[:, ::2] + (middles[:, 1:] + 0.5) * (box[:, 1::2] - box[:, ::2]))
    patch = table["patch"][element]
    return SideGrid(cells.origin, cells.size, cells.skin, outer_side, cell, masks, piece, patch, uv)


_SIDES = TableCache(build_sides, DiskCache("sides", __file__), MIN_ELEMENTS)


def side_of(grid: SideGrid, p_B: FloatArray, rows: IntArray) -> Sides:
    """Return the sides of p_B[rows], 1 outside, −1 inside, 0 unknown, and their safe distances.

    A safe distance, a length, is positive where the side is known, and no surface is that near; it
    is zero where the side is unknown. Both have one row for each of `rows`.
    """
    sides = Sides(np.empty(len(rows), np.int8), np.empty(len(rows)))
    run_ranges(straight(side_nb.sides), len(rows), MIN_POINTS, grid, p_B, rows, *sides)
    return sides


def clear_paths(grid: SideGrid, before: FloatArray, now: FloatArray, rows: IntArray) -> Records:
    """Return (len(rows),) whether paths before[rows] → now[rows] certainly meet no surface.

    False does not mean that a path meets it: see `side_nb.clear_paths`.
    """
    is_clear = np.empty(len(rows), bool)
    run_ranges(side_nb.clear_paths, len(rows), MIN_POINTS, grid, before, now, rows, is_clear)
    return is_clear
