"""Where segments enter a surface first, and where they last went in or out."""

from __future__ import annotations

from contiga.arrays.perturbed_paths import settled
from contiga.arrays.threads import run_ranges
from contiga.records import ByteArray, FloatArray, Hit, IntArray, empty_hit
from contiga.search.hierarchy.table_types import Tables
from contiga.search.sweep.kernels import hit_nb
from contiga.search.sweep.piece_lists import lists_of

# Segments below which a second thread does not pay.
SEGMENTS = 256


def hits_of_rows(tables: Tables, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
    """First entries of the segments a_B[rows] → b_B[rows], one row an entry of `rows`."""
    out = empty_hit(len(rows))
    lists = lists_of(tables, len(rows))
    run_ranges(hit_nb.first_hits, len(rows), SEGMENTS, tables, lists, a_B, b_B, rows, out)
    return out


def last_crossings(
    tables: Tables, a_B: FloatArray, b_B: FloatArray, rows: IntArray
) -> tuple[Hit, ByteArray]:
    """Of all places where a_B[rows] → b_B[rows] goes in or out, the one nearest to its end.

    Returns
    -------
    Hit
        One row an entry of `rows`; the fraction is measured from a_B. AT_START: within rounding
        of a_B.
    ByteArray
        1 where the path enters there, −1 where it leaves, 0 for none. See `settled` for paths
        through an edge.
    """
    lists = lists_of(tables, len(rows))

    def search(
        a: FloatArray, b: FloatArray, loose: tuple[float, float], out: Hit, verdict: FloatArray
    ) -> None:
        given = tables, lists, a, b, loose, out, verdict
        run_ranges(hit_nb.last_crossings, len(a), SEGMENTS, *given)

    return settled(search, a_B[rows], b_B[rows])
