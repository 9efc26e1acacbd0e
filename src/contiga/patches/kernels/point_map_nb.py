"""Points of splines x = N q by rows of N, and forces Nᵀ f by rows of Nᵀ."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def map_rows(matrix, vectors, out, start, stop):
    """Write rows start … stop − 1 of a sparse matrix times `vectors` (m, 3) to `out` (n, 3).

    Each sum adds the entries of its row in their order.
    """
    for n in range(start, stop):
        x, y, z = 0.0, 0.0, 0.0
        for m in range(matrix.starts[n], matrix.starts[n + 1]):
            k, value = matrix.columns[m], matrix.values[m]
            x += value * vectors[k, 0]
            y += value * vectors[k, 1]
            z += value * vectors[k, 2]
        out[n, 0] = x
        out[n, 1] = y
        out[n, 2] = z
