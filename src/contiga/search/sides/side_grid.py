"""A grid of known sides: on which side of a closed body all points of a cell are.

A cell that no piece of the surface meets holds points of one side only, and so do all such cells
that are joined. Pieces are told to meet a cell by boxes and slabs that hold them, widened by the
width of the edges and by the slits that are bridged: what two cells are joined through is sound.
One closest point tells the side of all of them; three are asked, and where they disagree (faces
that do not fit) nothing is said. Points in other cells, within about one of the surface, are to be
asked themselves.

Built once a body, from at most 6e5 cells and as many words of small cells: 25 MB at the very most.
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
    KnownSides,
    empty_projection,
)
from contiga.search.closest.closest import closest_of_rows
from contiga.search.hierarchy.kept import Kept
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sides.kernels import side_grid_nb, side_nb, side_pieces_nb
from contiga.search.sides.kernels.side_grid_nb import SPLIT
from contiga.search.sides.kernels.side_pieces_nb import PieceLimits
from contiga.statuses import Feature, Status

# Cells of the whole grid: so many an element, within these bounds.
CELLS = 1000.0
MIN_CELLS, MAX_CELLS = 3e4, 6e5
# Cells more than the box takes.
AROUND = 3
# How thick a piece may be, in small cells; how long, in cells, where it is cut and where not.
THIN = 1.0
CUT, WHOLE = 3.0, 4.0
# Pieces above which none is halved any more.
PIECES = 400_000
# Cells hold no surface within so much of them: a share of a small one, and of the coordinates
# and the size, which are rounded.
SKIN = 1e-6
ROUNDING = 256.0 * float(np.finfo(float).eps)
# Regions whose side is asked for: the largest, of so many small cells at least.
REGIONS = 256
MIN_REGION_CELLS = 8
# Points below which a second thread does not pay.
POINTS = 4096
# Elements below which a grid is built sooner than it is read.
WORTH = 100


@pass_by_pointer
class SideGrid(NamedTuple):
    """The known sides of a closed body, in cells about its low corner; see `side_nb`."""

    origin: FloatArray
    """(3,) low corner of the grid, body frame."""
    size: float
    """Of a cell, length."""
    skin: float
    """What a cell without surface is away from it at least, length."""
    far: int
    """Side of all points outside the grid; 0 if not known."""
    cell: IntArray
    """(i, j, k) side times the cells to the next that may hold surface, 0 if not known; in cells
    that may hold surface themselves FIRST_WORD and a word."""
    masks: Records
    """(words, 2) small cells inside and outside, one a bit."""
    piece: IntArray
    """(words,) a piece of the surface that meets the cell."""
    patch: IntArray
    """(pieces,) its patch."""
    uv: FloatArray
    """(pieces, 2) the parameters of its middle."""


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
"""Of a body that has no sides: nothing is known anywhere."""


class Layout(NamedTuple):
    """The place and size of the cells of a grid."""

    origin: FloatArray
    size: float
    shape: tuple[int, int, int]
    skin: float

    @property
    def small(self) -> float:
        """Size of a small cell."""
        return self.size / SPLIT


def layout(bounds: FloatArray, elements: int) -> Layout:
    """Return the cells over the (2, 3) box `bounds` of a body with so many elements.

    There is more than one cell around: all that is outside the grid, and its corners, are far from
    the surface.
    """
    low, high = bounds
    wide = high - low
    size = float(np.linalg.norm(wide))
    wide = np.maximum(wide, 1e-3 * size)
    cells = min(max(CELLS * elements, MIN_CELLS), MAX_CELLS)
    cell = float((wide.prod() / cells) ** (1.0 / 3.0))
    # Thin boxes need more cells around them than they hold.
    while (np.ceil(wide / cell) + AROUND).prod() > 1.3 * cells:
        cell *= 1.02
    shape = np.ceil((high - low) / cell).astype(int) + AROUND
    origin = 0.5 * (low + high) - 0.5 * shape * cell
    most = float(np.abs(bounds).max())
    skin = max(SKIN * cell / SPLIT, ROUNDING * (most + size))
    return Layout(origin, cell, (int(shape[0]), int(shape[1]), int(shape[2])), skin)


def sides_of(tables: Tables, slit: float) -> SideGrid:
    """The grid of the closed body that `tables` are of, built at the first call.

    `slit` is how far its faces may be apart where they meet, length.
    """
    return _SIDES.of(tables, slit)


def build_sides(tables: Tables, slit: float) -> SideGrid:
    """The grid of a closed body."""
    table, root = tables.elements.table, tables.tree[0]
    margins = table["edge_tolerance"] + table["noise"] + 2.0 * slit
    wide = margins.max()
    place = layout(np.stack([root["low"] - wide, root["high"] + wide]), len(table))
    margins += 2.0 * place.skin
    limits = PieceLimits(WHOLE * place.size, CUT * place.size, THIN * place.small, PIECES)
    pieces, middles = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, place.origin, margins, limits
    )
    # Words of the cells that may hold surface, −1 in others.
    flat = np.zeros(np.prod(place.shape), np.int32)
    nothing = np.zeros(0, np.uint64), np.zeros(0, np.int32)
    side_grid_nb.paint(pieces, place.small, place.shape, flat, *nothing)
    index = np.flatnonzero(flat)
    flat[:] = -1
    flat[index] = np.arange(len(index))
    # Their small cells that may, and a piece of each.
    near, piece = np.zeros(len(index), np.uint64), np.full(len(index), -1, np.int32)
    side_grid_nb.paint(pieces, place.small, place.shape, flat, near, piece)
    places = np.stack(np.unravel_index(index, place.shape), axis=1).astype(np.int32)
    words = flat.reshape(place.shape)
    labels, depth = side_grid_nb.labelled(words < 0), side_grid_nb.depths(words < 0)
    first, mask = side_grid_nb.parts_of(near)
    parent = side_grid_nb.join(labels, words, places, first, mask)
    regions = (parent, labels, depth, places, first, mask)
    size, samples = side_grid_nb.sizes_and_samples(*regions)
    # The side of each joined region, by its samples: 1 outside, −1 inside, 0 not known.
    roots = np.flatnonzero(size >= MIN_REGION_CELLS)
    roots = np.sort(roots[np.argsort(-size[roots], kind="stable")[:REGIONS]])
    points = place.origin + place.size * samples[roots].reshape(-1, 3)
    feet = empty_projection(len(points))
    closest_of_rows(tables, points, np.arange(len(points), dtype=np.int32), feet)
    side = np.where(feet.status == Status.OK, np.sign(feet.gap), 0.0).reshape(-1, 3)
    # Feet inside faces do not hang on how faces fit: where there are some, they alone count.
    plain = ((feet.status == Status.OK) & (feet.feature == Feature.FACE)).reshape(-1, 3)
    counts = plain | ~plain.any(axis=1, keepdims=True)
    least = np.where(counts, side, 1.0).min(axis=1)
    most = np.where(counts, side, -1.0).max(axis=1)
    sign = np.zeros(len(size), np.int8)
    sign[roots] = np.where(least == most, least, 0.0)
    cell, masks = side_grid_nb.known_sides(parent, sign, labels, depth, words, first, mask)
    far = int(sign[parent[labels[0, 0, 0] - 1]])
    # Where the middles of the pieces are: patch and parameters.
    element = middles[:, 0].astype(np.int64)
    box = table["box"][element]
    uv = np.ascontiguousarray(box[:, ::2] + (middles[:, 1:] + 0.5) * (box[:, 1::2] - box[:, ::2]))
    patch = table["patch"][element]
    return SideGrid(place.origin, place.size, place.skin, far, cell, masks, piece, patch, uv)


_SIDES = Kept(build_sides, DiskCache("sides", __file__), WORTH)


def side_of(grid: SideGrid, p_B: FloatArray, rows: IntArray) -> KnownSides:
    """Return the side of p_B[rows]: 1 outside, −1 inside, 0 not known; and a free way.

    The way, a length, is greater than zero where the side is known, and leads to no surface.
    """
    known = KnownSides(np.empty(len(rows), np.int8), np.empty(len(rows)))
    run_ranges(straight(side_nb.sides), len(rows), POINTS, grid, p_B, rows, *known)
    return known


def clear_ways(grid: SideGrid, before: FloatArray, now: FloatArray, rows: IntArray) -> Records:
    """Return (len(rows),) True where before[rows] → now[rows] is proved to meet no surface."""
    clear = np.empty(len(rows), bool)
    run_ranges(side_nb.clear_ways, len(rows), POINTS, grid, before, now, rows, clear)
    return clear
