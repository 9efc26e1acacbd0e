"""Points of splines: x = N q by rows of N, and by rows of Nᵀ forces that go back."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def map_rows(weights, given, out, start, stop):
    """Rows start … stop of a sparse matrix times `given` (m, 3), summed in their order."""
    for n in range(start, stop):
        x, y, z = 0.0, 0.0, 0.0
        for m in range(weights.starts[n], weights.starts[n + 1]):
            k, value = weights.columns[m], weights.values[m]
            x += value * given[k, 0]
            y += value * given[k, 1]
            z += value * given[k, 2]
        out[n, 0] = x
        out[n, 1] = y
        out[n, 2] = z
