"""The caps about the poles of a body: the cells in them, and the cells whose smooth block they are.

`ball_cap_bounds` states what is proved of a cap, and why.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import POLE, SMOOTH
from contiga.elements.element_arrays import Records
from contiga.records import FloatArray, IntArray
from contiga.search.balls.ball_cap_bounds import Cap, cap_over
from contiga.search.balls.kernels.ball_cell_nb import MAX_CHANGE
from contiga.search.hierarchy.table_types import Tables

MAX_RING = 64
"""Largest number of elements around a pole."""
MAX_HALVINGS = 6
"""Caps may also end where the first cell is halved up to this often."""
BLOCK_SHARE = 0.5
"""Share of the reach of a cap up to which it is the smooth block of cells."""


class Caps(NamedTuple):
    """The caps of a body."""

    cap_of_side: IntArray
    """(elements, 4) the cap about a side, −1 for none."""
    reach: FloatArray
    """(caps,) extent of the cap in its elements, as a share of them."""
    radii: FloatArray
    """(caps, 2) radii of inner and outer balls that contain no other point of the cap."""
    bend: FloatArray
    """(caps,) largest change of the slope of the surface over the tangent plane, per length."""

    def mark(self, cells: Records) -> None:
        """Set the cap of measured cells, in place, and tighten the bounds of their normals by it.

        A cell gets the cap of `_nearest` if that reaches over all of the cell, else −1. The cap's
        bound of slopes limits the angle of its normals to the middle's: `tilt` becomes the sine of
        that angle if it was larger. Cells whose derivatives bound nothing get the middle's normal
        at all corners, and a `wobble` by that angle; their tilt is 1 if the angle is too large,
        too.
        """
        cap, share = self._nearest(cells)
        cells["cap"] = np.where(share <= 1.0 + 1e-9, cap, -1)
        rows = np.flatnonzero(cells["cap"] >= 0)
        capped = cells[rows]
        distance = np.linalg.norm(capped["corner"] - capped["middle"][:, None], axis=2).max(axis=1)
        angle = self.bend[capped["cap"]] * (distance + capped["bulge"])
        angle[~capped["normal"].any(axis=1)] = math.inf
        is_poor = ~(capped["turn"] < MAX_CHANGE)
        is_bounded = angle < math.asin(MAX_CHANGE)
        tilt = capped["tilt"]
        tilt[is_poor] = 1.0
        tilt[is_bounded] = np.minimum(np.sin(angle[is_bounded]), tilt[is_bounded])
        is_level = is_bounded & is_poor
        capped["corner_normal"][is_level] = capped["normal"][is_level, None]
        capped["wobble"][is_level] = 2.0 * np.sin(0.5 * angle[is_level])
        cells[rows] = capped

    def take(self, cells: Records, blocks: Records, target: float) -> None:
        """Make caps the smooth blocks of the cells near a pole that gain by it.

        Sets `cap` and `radii` of their rows of `blocks`, one row for each cell. Only cells in the
        inner `BLOCK_SHARE` of a cap whose normals are bounded can have it. They do if the smaller
        radius of the cap is at least that of their block, or at least `target`.
        """
        cap, share = self._nearest(cells)
        rows = np.flatnonzero((share <= BLOCK_SHARE) & (cells["tilt"] < MAX_CHANGE))
        radii = self.radii[cap[rows]]
        min_radius = np.minimum(blocks["radii"][rows].min(axis=1), target)
        is_better = radii.min(axis=1) >= min_radius
        rows, radii = rows[is_better], radii[is_better]
        blocks["cap"][rows] = cap[rows]
        blocks["radii"][rows] = radii

    def _nearest(self, cells: Records) -> tuple[IntArray, FloatArray]:
        """Return the cap (n,) of each cell, and the share of its reach to which the cell extends.

        The cap with the smallest share counts. An element without caps has cap 0 and an infinite
        share.
        """
        cap = np.zeros(len(cells), np.int32)
        share = np.full(len(cells), math.inf)
        for side in range(4):
            side_cap = self.cap_of_side[cells["element"], side]
            rows = np.flatnonzero(side_cap >= 0)
            extent = _extent(cells["box"][rows], side) / self.reach[side_cap[rows]]
            is_nearer = extent < share[rows]
            rows = rows[is_nearer]
            cap[rows], share[rows] = side_cap[rows], extent[is_nearer]
        return cap, share


def find_caps(tables: Tables, cells: Records, tolerance: float) -> Caps:
    """Return the caps of a body whose grids have `cells`; points within `tolerance` are one.

    Poles whose elements do not close smoothly, or of which nothing is proved, have none.
    """
    table = tables.elements.table
    cap_of_side = np.full((len(table), 4), -1, np.int32)
    is_done = table["kind"] != POLE
    rows: list[Cap] = []
    for e, side in np.argwhere(~is_done).tolist():
        if is_done[e, side]:
            continue
        ring = _elements_around(table, e, side)
        for f, collapsed, _ in ring:
            is_done[f, collapsed] = True
        if not ring:
            continue
        # The distances from the pole at which cells end.
        extents = [_extent(cells["box"][cells["element"] == f], of_pole) for f, of_pole, _ in ring]
        edges = np.unique(np.round(np.concatenate(extents), 12))
        halves = edges[0] * 0.5 ** np.arange(MAX_HALVINGS, 0, -1)
        cap = cap_over(tables, ring, np.concatenate([halves, edges]), tolerance)
        if cap is not None:
            for f, collapsed, _ in ring:
                cap_of_side[f, collapsed] = len(rows)
            rows.append(cap)
    reach, bend = (np.array([getattr(row, name) for row in rows]) for name in ("reach", "bend"))
    return Caps(cap_of_side, reach, np.array([row.radii for row in rows]).reshape(-1, 2), bend)


def _elements_around(table: Records, e: int, side: int) -> list[tuple[int, int, bool]]:
    """Return the elements around a pole with their sides, and whether x runs backwards in each.

    They are traversed across the sides that start from the pole. Empty if they do not close over
    smooth sides within `MAX_RING` elements.
    """
    start = (e, side)
    ring = []
    exit_side = 3 if side < 2 else 1
    is_backwards = False
    for _ in range(MAX_RING):
        row = table[e]
        if row["kind"][side] != POLE or row["kind"][exit_side] != SMOOTH:
            return []
        ring.append((e, side, is_backwards))
        entry_side = int(row["neighbour_side"][exit_side])
        end = (side & 1) ^ int(row["flip"][exit_side])
        e = int(row["neighbour"][exit_side])
        side = (2 if entry_side < 2 else 0) + end
        is_backwards = bool(entry_side & 1)
        exit_side = entry_side ^ 1
        if (e, side) == start:
            return ring if not is_backwards else []
    return []


def _extent(box: FloatArray, side: int | IntArray) -> FloatArray:
    """Return the extent of boxes (n, 4) from a side of their element, as a share of it."""
    rows = np.arange(len(box))
    side = np.broadcast_to(side, len(box))
    return np.where(side & 1 == 0, box[rows, side | 1] + 0.5, 0.5 - box[rows, side & ~1])
