"""Closest points of a body, of some rows of many points."""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.records import FloatArray, IntArray, Projection
from contiga.search.balls.radii import known_balls
from contiga.search.closest.kernels import nearest_nb
from contiga.search.hierarchy.table_types import Tables

# Rows below which a second thread does not pay.
POINTS = 256


def closest_of_rows(
    tables: Tables,
    p_B: FloatArray,
    rows: IntArray,
    out: Projection,
    within: FloatArray | None = None,
) -> None:
    """Closest points of p_B[rows] into the same rows of `out`.

    `within` (len(rows),) are distances to feet that are known, infinite where none is.
    """
    if within is None:
        within = np.full(len(rows), np.inf)
    balls = known_balls(tables, len(rows))
    known = p_B, rows, within, out
    if balls is None:
        run_ranges(nearest_nb.project_global, len(rows), POINTS, tables, *known)
    else:
        run_ranges(nearest_nb.project_proved, len(rows), POINTS, tables, balls, *known)
