"""First entries and last crossings of moving points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.perturbed_paths import Paths, robust_last_crossings
from contiga.arrays.query_checks import checked_segments
from contiga.arrays.threads import run_ranges
from contiga.records import ByteArray, FloatArray, Hit, IntArray, empty_hit
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.facets import Facets
from contiga.triangles.kernels import entry_nb
from contiga.triangles.triangle_arrays import TriangleArrays

MIN_SEGMENTS = 512
"""Number of segments below which a second thread does not pay."""


def first_hit(mesh: TriangleArrays, p0: ArrayLike, p1: ArrayLike) -> Hit:
    """Return where each segment p0 → p1 first enters `mesh` from its free side.

    It enters at the smallest fraction τ in [0, 1] at which it crosses a triangle against its
    normal, both ends and all edges included; of triangles at the same fraction the first counts.

    Parameters
    ----------
    mesh : the triangles
    p0, p1 : (n, 3) float64, length, the mesh's frame

    Returns
    -------
    Hit
        fraction τ, NaN with status NO_HIT where the path does not enter; AT_START where it
        enters at its start; NOT_FINITE for ends that are not finite.

    Raises
    ------
    InputError
        Arrays that are not (n, 3) or differ in n.
    MeshError
        The mesh has no triangle with an area.
    """
    a_M, b_M = checked_segments(p0, p1)
    rows = np.arange(len(a_M), dtype=np.int32)
    return hits_of_rows(tables_of(mesh).facets, a_M, b_M, rows)


def hits_of_rows(facets: Facets, a_M: FloatArray, b_M: FloatArray, rows: IntArray) -> Hit:
    """Return the first entries of segments a_M[rows] → b_M[rows], in the order of `rows`.

    See `first_hit`; `Hit` has one row for each of `rows`.
    """
    out = empty_hit(len(rows))
    run_ranges(entry_nb.first_hits, len(rows), MIN_SEGMENTS, facets, a_M, b_M, rows, out)
    return out


def last_crossings(
    facets: Facets, a_M: FloatArray, b_M: FloatArray, rows: IntArray
) -> tuple[Hit, ByteArray]:
    """Return the crossing nearest to the end of each segment a_M[rows] → b_M[rows].

    Segments that meet an edge are searched again on perturbed paths: see `robust_last_crossings`.

    Returns
    -------
    Hit
        One row an entry of `rows`; the fraction is measured from a_M.
    ByteArray
        1 where the path enters there, −1 where it leaves, 0 for none.
    """

    def search(paths: Paths, out: Hit, verdict: FloatArray) -> None:
        query = facets, paths.start, paths.end, out, verdict
        run_ranges(entry_nb.last_crossings, len(verdict), MIN_SEGMENTS, *query)

    return robust_last_crossings(search, a_M[rows], b_M[rows])
