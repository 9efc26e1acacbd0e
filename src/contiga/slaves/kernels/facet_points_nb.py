"""Points of facets by their shape functions."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def points_of_facets(nodal, facets, shape, out, start, stop):
    """Write Σ_j shape[k, j] nodal[facets[f, j]] into row f n + k of `out`, of all n points k of the
    facets f = start … stop, of three or four corners j."""
    count, corners = shape.shape
    for f in range(start, stop):
        for k in range(count):
            for axis in range(3):
                value = shape[k, 0] * nodal[facets[f, 0], axis]
                for j in range(1, corners):
                    value += shape[k, j] * nodal[facets[f, j], axis]
                out[f * count + k, axis] = value
