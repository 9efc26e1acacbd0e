"""First entry of moving points into a body."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.geometry.body import Body
from contiga.num.threads import run_ranges
from contiga.records import FloatArray, Hit, IntArray
from contiga.search import _hit_nb
from contiga.search.checks import checked_segments
from contiga.search.records import Tables
from contiga.search.tables import tables_of

# Segments below which a second thread does not pay.
SEGMENTS = 256


def empty_hit(n: int) -> Hit:
    """A record of n hits to be filled."""
    return Hit(
        np.empty(n), np.empty(n, np.int32), np.empty((n, 2)), np.empty((n, 3)), np.empty(n, np.int8)
    )


def first_hit(body: Body, p0: ArrayLike, p1: ArrayLike) -> Hit:
    """Where each segment p0 → p1 first enters `body` from its free side.

    Interval Newton on S(u, v) = p0 + τ (p1 − p0) over the hierarchy: the smallest τ in [0, 1]
    with (p1 − p0)·n < 0, both ends included.

    Parameters
    ----------
    p0, p1 : (n, 3) float64, length, body frame

    Returns
    -------
    Hit
        fraction τ, NaN with status NO_HIT where the path does not enter; AT_START where it
        starts on the surface.

    Raises
    ------
    InputError
        Arrays that are not (n, 3) or differ in n.
    """
    a_B, b_B = checked_segments(p0, p1)
    rows = np.arange(len(a_B), dtype=np.int32)
    return hits_of_rows(tables_of(body), a_B, b_B, rows)


def hits_of_rows(tables: Tables, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
    """First entries of the segments a_B[rows] → b_B[rows], one row an entry of `rows`."""
    out = empty_hit(len(rows))
    run_ranges(_hit_nb.first_hits, len(rows), SEGMENTS, tables, a_B, b_B, rows, out)
    return out
