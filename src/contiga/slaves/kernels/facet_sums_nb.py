"""Sums from some points on facets to their corners, and interpolation back."""

from __future__ import annotations

from contiga.jit import kernel


@kernel()
def to_corners(rows, first, values, facets, shape, out):
    """Add shape[k, j] times the `values` (r, c) of points `rows` (r,) to row facets[f, j] of `out`.

    Row `first` + f n + k is point k of n on facet f, with corners j; `out` is (nodes, c). Sums are
    in the order of `rows`.
    """
    count, corners = shape.shape
    for i in range(rows.shape[0]):
        f, k = divmod(rows[i] - first, count)
        for j in range(corners):
            node, weight = facets[f, j], shape[k, j]
            for c in range(values.shape[1]):
                out[node, c] += weight * values[i, c]


@kernel()
def from_corners(rows, first, nodal, facets, shape, out):
    """Write Σ_j shape[k, j] nodal[facets[f, j]] of the points `rows` (r,) to `out` (r, 3).

    Row `first` + f n + k is point k of n on facet f; `nodal` is (nodes, 3).
    """
    count, corners = shape.shape
    for i in range(rows.shape[0]):
        f, k = divmod(rows[i] - first, count)
        for axis in range(3):
            value = shape[k, 0] * nodal[facets[f, 0], axis]
            for j in range(1, corners):
                value += shape[k, j] * nodal[facets[f, j], axis]
            out[i, axis] = value
