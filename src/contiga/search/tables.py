"""Everything the search knows about a body, worked out once: elements, neighbours, hierarchy.

The tables of a body are kept as long as the body lives; what certificates of tracked feet need
beside them is worked out when the first are asked for (`contiga.search.certify.neighbourhoods`).
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import BORDER, SHARED
from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.once import once
from contiga.elements.element_arrays import Elements
from contiga.elements.extraction import elements_of
from contiga.elements.neighbours import join
from contiga.errors import GeometryError
from contiga.geometry import trim
from contiga.geometry.body_key import key_of
from contiga.geometry.faces import Faces
from contiga.geometry.slits import gaping_edges, stitches
from contiga.records import FloatArray
from contiga.search.certify import neighbourhoods
from contiga.search.closest.widths import edge_widths
from contiga.search.hierarchy.build import build_hierarchy, empty_seeds, items_of
from contiga.search.hierarchy.table_types import Tables

# Tangential miss accepted at a foot, relative to the body's size.
RELATIVE_TOLERANCE = 1e-12
# Sizes of bodies whose lengths can be taken to the fourth power and back.
SMALLEST, LARGEST = 1e-60, 1e60
# A trimming curve this close to a side of its patch's rectangle, as a share of it, runs along it.
NEAR = 1e-3

_DISK = DiskCache("tables", __file__)


@once
def tables_of(body: Faces) -> Tables:
    """The search tables of `body` but for neighbourhoods, built at the first call."""
    check_size(body)
    tables = _DISK.kept(key_of(body), lambda: _build(body))
    return tables._replace(trims=body.trim_tables)


def check_size(body: Faces) -> None:
    """Refuse a body that is a point, or so large or small that products of lengths are lost.

    Raises
    ------
    GeometryError
        As said.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        size = body.size
    check_extent(size, body.name)


def check_extent(size: float, name: str) -> None:
    """Check as `check_size` does, for a body `name` of this size."""
    if not SMALLEST <= size <= LARGEST:
        raise GeometryError(
            "the body's size cannot be computed with",
            where=name,
            found=size,
            allowed=f"{SMALLEST:g} to {LARGEST:g}",
        )


def _build(body: Faces) -> Tables:
    trims = body.trim_tables
    elements, grid = elements_of(body, trims)
    grid = join(elements, grid, body)
    joined = np.array([len(edge.uses) > 1 for edge in body.edges], dtype=bool) & ~gaping_edges(body)
    of_edge = np.flatnonzero(trims.piece_edge >= 0)
    is_open = stitches(body)[1].astype(np.float64)
    is_open[of_edge] = ~joined[trims.piece_edge[of_edge]]
    _share_trimmed_sides(elements, trims, is_open)
    piece_width = edge_widths(body, elements, trims)
    hierarchy = build_hierarchy(elements, grid, trims)
    scale = np.array([body.size, RELATIVE_TOLERANCE * body.size])
    items = items_of(hierarchy, elements, trims, scale[1])
    leaves, plates, tree = hierarchy.leaves, hierarchy.plates, hierarchy.tree
    known = elements, grid, leaves, plates, tree, items, empty_seeds(tree), trims
    return Tables(*known, is_open, piece_width, scale, neighbourhoods.none())


def _share_trimmed_sides(elements: Elements, trims: trim.TrimTables, is_open: FloatArray) -> None:
    """Sides of a trimmed patch's rectangle end the surface where its open trimming curves run.

    Elsewhere another face goes on, across the edge of the trimming curve that runs there.
    """
    table = elements.table
    ends = trims.piece_ends.reshape(-1, 2, 2)
    for k in np.unique(table["patch"][trims.trimmed[table["patch"]] != 0]):
        rows = np.flatnonzero(table["patch"] == k)
        low, high = trims.domain[k].reshape(2, 2).T
        open_ends = ends[np.flatnonzero((trims.piece_patch == k) & (is_open != 0.0))]
        for side in range(4):
            along, end = side // 2, (low, high)[side % 2][side // 2]
            near = np.abs(open_ends[:, :, along] - end).max(axis=1) <= NEAR * (high - low)[along]
            first, last = np.sort(open_ends[near][:, :, 1 - along], axis=1).T
            box = table["box"][rows][:, 2 * (1 - along) :][:, :2]
            meets = (first < box[:, 1:]) & (last > box[:, :1])
            shared = (table["kind"][rows, side] == BORDER) & ~meets.any(axis=1)
            table["kind"][rows[shared], side] = SHARED
