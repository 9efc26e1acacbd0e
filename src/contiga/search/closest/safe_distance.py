"""How far free points can go before they can touch (distance changes by at most the way gone)."""

from __future__ import annotations

from contiga.arrays.threads import run_ranges
from contiga.records import FloatArray, IntArray
from contiga.search.closest.kernels import safe_distance_nb
from contiga.search.hierarchy.table_types import Tables

# Points below which a second thread does not pay.
POINTS = 1024


def box_distance(
    tables: Tables, p_B: FloatArray, rows: IntArray, safe_distance: FloatArray
) -> None:
    """Lower bounds of the distance of p_B[rows] to the body into reach[rows]; zero when near."""
    run_ranges(
        safe_distance_nb.box_distance, len(rows), POINTS, tables.tree, p_B, rows, safe_distance
    )
