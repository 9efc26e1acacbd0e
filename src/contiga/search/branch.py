"""The certificate of tracked feet: tables built once a body, and the rows it is asked for.

What is proved, and why, stands in `branch_nb`.
"""

from __future__ import annotations

import numpy as np

from contiga.elements.element_arrays import Elements, Records
from contiga.num.threads import run_ranges
from contiga.records import FloatArray, IntArray, Projection
from contiga.search.kernels import branch_nb, follow_nb, ring_nb
from contiga.search.table_types import RING, Tables

# Elements and rows below which a second thread does not pay.
ELEMENTS = 64
ROWS = 4096
FOLLOWED = 64
# How often a part is quartered for its bounds, and elements up to which that is worth its time.
QUARTERED = ((3, 100), (2, 400), (1, 4000))


def build_rings(elements: Elements) -> Records:
    """(elements, 16) bounds around the parts of all elements."""
    n = len(elements.table)
    parts = ring_nb.PARTS**2
    raw = np.empty((n, parts, 6))
    rings = np.zeros((n, parts), RING)
    depth = next((d for d, most in QUARTERED if n <= most), 0)
    run_ranges(ring_nb.bends_of_parts, n, ELEMENTS, elements, depth, raw)
    run_ranges(ring_nb.join_parts, n, ELEMENTS, elements, raw, rings)
    return rings


def certify(
    tables: Tables,
    path: tuple[FloatArray, FloatArray],
    starts: tuple[IntArray, FloatArray],
    out: Projection,
) -> IntArray:
    """Certify the feet `out` continued from starts = (patch, uv) along path = (before, now).

    Feet that had jumped to another branch are put right. Returned are the rows whose branch ends
    on the way.
    """
    before, now = path
    flags = np.zeros(len(now), np.uint8)
    results = (out, flags)
    run_ranges(branch_nb.certify_rows, len(now), ROWS, tables, now, before, starts, results)
    rows = np.flatnonzero(flags).astype(np.int32)
    run_ranges(follow_nb.follow_rows, len(rows), FOLLOWED, tables, path, starts, rows, results)
    return np.flatnonzero(flags == follow_nb.EVENT).astype(np.int32)
