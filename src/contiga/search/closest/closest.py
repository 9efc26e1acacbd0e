"""Closest points of a body for some rows of many points."""

from __future__ import annotations

import numpy as np

from contiga.arrays.threads import run_ranges
from contiga.records import FloatArray, IntArray, Projection
from contiga.search.balls.radii import balls_if_they_pay
from contiga.search.closest.kernels import nearest_nb
from contiga.search.hierarchy.table_types import Tables

MIN_POINTS = 256
"""Number of rows below which a second thread does not pay."""


def closest_of_rows(
    tables: Tables,
    p_B: FloatArray,
    rows: IntArray,
    out: Projection,
    within: FloatArray | None = None,
) -> None:
    """Write the closest points of p_B[rows] to the same rows of `out`.

    `within` (len(rows),) are upper bounds of the distances, infinite where none is known. Touching
    balls prove most closest points once the balls are worth their computation; results have the
    same bits with balls and without.
    """
    if within is None:
        within = np.full(len(rows), np.inf)
    balls = balls_if_they_pay(tables, len(rows))
    query = p_B, rows, within, out
    if balls is None:
        run_ranges(nearest_nb.project_global, len(rows), MIN_POINTS, tables, *query)
    else:
        run_ranges(nearest_nb.project_proved, len(rows), MIN_POINTS, tables, balls, *query)
