"""Leaves over the elements: their parts in boxes, with bounds of the derivatives."""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import OUT
from contiga.arrays.kernels.rows_nb import double_rows
from contiga.elements.kernels.bounds_nb import subdivide
from contiga.jit import kernel


@kernel()
def surface_leaves(elements, flatness, depth):
    """Return rows (n, 20) of all surface leaves: element, box (4), bound (9), low and high (3).

    Elements are halved until their parts are flat (`subdivide`), at most `depth` times; elements
    that are trimmed away have no rows.
    """
    max_leaves = 1 << depth
    rows = np.empty((max_leaves + elements.table.shape[0], 20))
    n = 0
    for e in range(elements.table.shape[0]):
        if elements.table[e]["trim"] != OUT:
            if n + max_leaves > rows.shape[0]:
                rows = double_rows(rows)
            n += subdivide(elements, e, flatness, depth, rows[n:])
    return rows[:n]
