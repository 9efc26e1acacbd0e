"""Rows of `FootSlopes`: the derivatives of a foot on a kink, and how all are written."""

from __future__ import annotations

from contiga.arrays.kernels.vector_nb import dot
from contiga.jit import inner

SQUARE = 1e-6
"""Cosine below which the way to a point is square to a curve, or along a normal."""


@inner()
def is_along(r, normal, small):
    """Return whether the way r to a point is along a normal.

    One shorter than `small` has no direction.
    """
    square, along = dot(r, r), dot(r, normal)
    return square - along * along <= max(small * small, SQUARE * SQUARE * square)


@inner()
def write_slopes(k, depth, a, x, b, y, out):
    """Row k of `out`: the gradient of the depth, and a xᵀ + b yᵀ for the normal."""
    for i in range(3):
        out.depth[k, i] = depth[i]
        for j in range(3):
            out.normal[k, i, j] = a[i] * x[j] + b[i] * y[j]


@inner()
def write_kink_slopes(k, d, over, normal, gap, out):
    """Row k of `out` for a foot off a face, whose normal is the way from it to its point.

    The foot moves by d (over · dp): along a curve of derivative d, and not where both are zero.
    """
    away, along = 1.0 / gap, dot(normal, d)
    for i in range(3):
        out.depth[k, i] = -normal[i]
        for j in range(3):
            part = (1.0 if i == j else 0.0) - normal[i] * normal[j]
            out.normal[k, i, j] = away * (part - (d[i] - along * normal[i]) * over[j])
