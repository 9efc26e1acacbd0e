"""The caps about the poles of a body: which cells lie in them, and which take them for their block.

What is proved of a cap, and why, says `ball_cap_bounds`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import POLE, SMOOTH
from contiga.elements.element_arrays import Records
from contiga.records import FloatArray, IntArray
from contiga.search.balls.ball_cap_bounds import Cap, cap_over
from contiga.search.balls.kernels.ball_cell_nb import WORST
from contiga.search.hierarchy.table_types import Tables

# Elements round a pole at most.
MAX_RING = 64
# Caps may also end where the first cell is halved this often.
HALVINGS = 6
# Share of its reach up to which cells take a cap for their smooth block.
INNER = 0.5


class Caps(NamedTuple):
    """The caps of a body."""

    of: IntArray
    """(elements, 4) the cap about a side, −1 where there is none."""
    reach: FloatArray
    """(caps,) how far they go into their elements, 1: all through."""
    near: FloatArray
    """(caps, 2) radii of inner and outer balls that hold no more of the cap."""
    bend: FloatArray
    """(caps,) how much the slope of the surface over the tangent plane changes per length."""

    def mark(self, cells: Records) -> None:
        """Set of which cap measured cells are part, and how their normals differ, as it tells.

        Slopes that differ by x belong to normals at an angle of x at most.
        """
        cap, share = self._where(cells)
        cells["cap"] = np.where(share <= 1.0 + 1e-9, cap, -1)
        rows = np.flatnonzero(cells["cap"] >= 0)
        capped = cells[rows]
        apart = np.linalg.norm(capped["corner"] - capped["middle"][:, None], axis=2).max(axis=1)
        angle = self.bend[capped["cap"]] * (apart + capped["bulge"])
        angle[~capped["normal"].any(axis=1)] = math.inf
        poor = ~(capped["turn"] < WORST)
        bounded = angle < math.asin(WORST)
        capped["tilt"][poor] = 1.0
        capped["tilt"][bounded] = np.minimum(np.sin(angle[bounded]), capped["tilt"][bounded])
        level = bounded & poor
        capped["corner_normal"][level] = capped["normal"][level, None]
        capped["wobble"][level] = 2.0 * np.sin(0.5 * angle[level])
        cells[rows] = capped

    def take(self, cells: Records, homes: Records, enough: float) -> None:
        """Make caps the smooth blocks, rows of `homes`, of cells within that have no better ones.

        Balls as large as `enough` are.
        """
        cap, share = self._where(cells)
        rows = np.flatnonzero((share <= INNER) & (cells["tilt"] < WORST))
        near = self.near[cap[rows]]
        least = np.minimum(homes["near"][rows].min(axis=1), enough)
        better = near.min(axis=1) >= least
        rows, near = rows[better], near[better]
        homes["cap"][rows] = cap[rows]
        homes["near"][rows] = near

    def _where(self, cells: Records) -> tuple[IntArray, FloatArray]:
        """The nearest cap of each cell, and how far the cell goes from the pole, in its reach."""
        cap = np.zeros(len(cells), np.int32)
        share = np.full(len(cells), math.inf)
        for side in range(4):
            cap_here = self.of[cells["element"], side]
            rows = np.flatnonzero(cap_here >= 0)
            away = _away(cells["box"][rows], side) / self.reach[cap_here[rows]]
            nearer = away < share[rows]
            cap[rows[nearer]], share[rows[nearer]] = cap_here[rows[nearer]], away[nearer]
        return cap, share


def find_caps(tables: Tables, cells: Records, tolerance: float) -> Caps:
    """The caps of a body whose grids have `cells`; what is nearer than `tolerance` is one point."""
    table = tables.elements.table
    of = np.full((len(table), 4), -1, np.int32)
    seen = table["kind"] != POLE
    rows: list[Cap] = []
    for e, side in np.argwhere(~seen).tolist():
        if seen[e, side]:
            continue
        ring = _ring(table, e, side)
        for f, collapsed, _ in ring:
            seen[f, collapsed] = True
        if not ring:
            continue
        # How far from the pole cells may end.
        parts = [_away(cells["box"][cells["element"] == f], of_pole) for f, of_pole, _ in ring]
        edges = np.unique(np.round(np.concatenate(parts), 12))
        halves = edges[0] * 0.5 ** np.arange(HALVINGS, 0, -1)
        cap = cap_over(tables, ring, np.concatenate([halves, edges]), tolerance)
        if cap is not None:
            for f, collapsed, _ in ring:
                of[f, collapsed] = len(rows)
            rows.append(cap)
    reach, bend = (np.array([getattr(row, name) for row in rows]) for name in ("reach", "bend"))
    return Caps(of, reach, np.array([row.near for row in rows]).reshape(-1, 2), bend)


def _ring(table: Records, e: int, side: int) -> list[tuple[int, int, bool]]:
    """Elements round a pole with their sides, and whether x runs back; none if they do not close.

    They are gone through by the sides that start from the pole.
    """
    start = (e, side)
    ring = []
    leave = 3 if side < 2 else 1
    back = False
    for _ in range(MAX_RING):
        row = table[e]
        if row["kind"][side] != POLE or row["kind"][leave] != SMOOTH:
            return []
        ring.append((e, side, back))
        enter = int(row["neighbour_side"][leave])
        end = (side & 1) ^ int(row["flip"][leave])
        e = int(row["neighbour"][leave])
        side = (2 if enter < 2 else 0) + end
        back = bool(enter & 1)
        leave = enter ^ 1
        if (e, side) == start:
            return ring if not back else []
    return []


def _away(box: FloatArray, side: int | IntArray) -> FloatArray:
    """Return how far boxes (n, 4) go from a side of their element, as a share of it."""
    rows = np.arange(len(box))
    side = np.broadcast_to(side, len(box))
    return np.where(side & 1 == 0, box[rows, side | 1] + 0.5, 0.5 - box[rows, side & ~1])
