"""Points of facets by their shape functions."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def points_of_facets(nodal, facets, shape, out, start, stop):
    """Write Σ_j shape[k, j] nodal[facets[f, j]] into row f n + k of `out`, of all n points k of the
    facets f = start … stop."""
    count = shape.shape[0]
    for f in range(start, stop):
        a, b, c = facets[f, 0], facets[f, 1], facets[f, 2]
        for k in range(count):
            for axis in range(3):
                value = shape[k, 0] * nodal[a, axis]
                value += shape[k, 1] * nodal[b, axis]
                value += shape[k, 2] * nodal[c, axis]
                out[f * count + k, axis] = value
