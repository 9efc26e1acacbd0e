"""The tables that the search on a body reads: elements, neighbours, hierarchy.

The tables of a body are kept as long as the body lives. Tables for certificates of tracked feet are
built when the first certificate is needed (`contiga.search.certify.neighbourhoods`).
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import BORDER, SHARED
from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.once import once
from contiga.elements.extraction import elements_of
from contiga.elements.neighbours import join
from contiga.errors import GeometryError
from contiga.geometry.body_key import key_of
from contiga.geometry.faces import Faces
from contiga.geometry.slits import stitches
from contiga.search.certify import neighbourhoods
from contiga.search.closest.widths import SIDE_TOL, edge_widths, joints_of_faces
from contiga.search.hierarchy.build import build_hierarchy, empty_seeds, items_of
from contiga.search.hierarchy.table_types import Tables

RELATIVE_TOLERANCE = 1e-12
"""Tangential miss accepted at a foot, relative to the body's size."""
MIN_SIZE, MAX_SIZE = 1e-60, 1e60
"""Sizes of bodies whose lengths to the fourth power neither overflow nor underflow."""

_DISK = DiskCache("tables", __file__)


@once
def tables_of(body: Faces) -> Tables:
    """Return the search tables of `body` without neighbourhoods, built at the first call.

    They are cached with the body and on the disk.

    Raises
    ------
    GeometryError
        A body that is a point, or too large or small (`check_size`).
    """
    check_size(body)
    tables = _DISK.get_or_build(key_of(body), lambda: _build(body))
    return tables._replace(trims=body.trim_tables)


def check_size(body: Faces) -> None:
    """Refuse a body that is a point, or so large or small that products of lengths are lost.

    Raises
    ------
    GeometryError
        Such a size.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        size = body.size
    check_extent(size, body.name)


def check_extent(size: float, name: str) -> None:
    """Raise the GeometryError of `check_size` for a body `name` whose `size` is out of range."""
    if not MIN_SIZE <= size <= MAX_SIZE:
        raise GeometryError(
            "the body's size cannot be computed with",
            where=name,
            found=size,
            allowed=f"{MIN_SIZE:g} to {MAX_SIZE:g}",
        )


def _build(body: Faces) -> Tables:
    """Build the tables of a body, with empty seeds and neighbourhoods.

    Sides of elements are joined, marked as SHARED where another face continues a trimmed patch, and
    given their widths.
    """
    trims = body.trim_tables
    elements, grid = elements_of(body, trims)
    grid = join(elements, grid, body)
    is_joint = joints_of_faces(body)
    edge_pieces = np.flatnonzero(trims.piece_edge >= 0)
    is_open = stitches(body)[1].astype(np.float64)
    is_open[edge_pieces] = ~is_joint[trims.piece_edge[edge_pieces]]
    # Sides of trimmed patches are SHARED where no open trimming piece ends the surface: there
    # another face continues it, across the edge of the trimming piece along that side.
    table = elements.table
    ends = trims.piece_ends.reshape(-1, 2, 2)
    for k in np.unique(table["patch"][trims.trimmed[table["patch"]] != 0]):
        rows = np.flatnonzero(table["patch"] == k)
        low, high = trims.domain[k].reshape(2, 2).T
        open_ends = ends[np.flatnonzero((trims.piece_patch == k) & (is_open != 0.0))]
        for side in range(4):
            direction, end = side // 2, (low, high)[side % 2][side // 2]
            distance = np.abs(open_ends[:, :, direction] - end).max(axis=1)
            is_alongside = distance <= SIDE_TOL * (high - low)[direction]
            first, last = np.sort(open_ends[is_alongside][:, :, 1 - direction], axis=1).T
            box = table["box"][rows][:, 2 * (1 - direction) :][:, :2]
            has_end = (first < box[:, 1:]) & (last > box[:, :1])
            is_shared = (table["kind"][rows, side] == BORDER) & ~has_end.any(axis=1)
            table["kind"][rows[is_shared], side] = SHARED
    piece_width = edge_widths(body, elements, trims)
    hierarchy = build_hierarchy(elements, grid, trims)
    scale = np.array([body.size, RELATIVE_TOLERANCE * body.size])
    items = items_of(hierarchy, elements, trims, scale[1])
    return Tables(
        elements,
        grid,
        hierarchy.leaves,
        hierarchy.plates,
        hierarchy.tree,
        items,
        empty_seeds(hierarchy.tree),
        trims,
        is_open,
        piece_width,
        scale,
        neighbourhoods.none(),
    )
