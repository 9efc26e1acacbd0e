"""Write rows of tables by loops: numba's ``rows[k] = values`` compiles, in each process, 4 s of
code for an error about lengths that does not occur in kernels."""

from __future__ import annotations

import numpy as np

from contiga.jit import inner


@inner()
def put(rows, k, values):
    """Write a tuple of n numbers into row k of a table (m, n)."""
    for c in range(len(values)):
        rows[k, c] = values[c]


@inner(linked=False)
def double_rows(rows):
    """Return a copy of a table (m, n) with room for twice the rows."""
    new = np.empty((2 * rows.shape[0], rows.shape[1]))
    for k in range(rows.shape[0]):
        for c in range(rows.shape[1]):
            new[k, c] = rows[k, c]
    return new
