"""Write rows of `FootSlopes`, in general and for a foot on a kink."""

from __future__ import annotations

from contiga.arrays.kernels.vector_nb import dot
from contiga.jit import inner

PERPENDICULAR_TOL = 1e-6
"""Cosine below which two directions count as perpendicular."""


@inner()
def is_along(r, normal, small):
    """Return whether the vector r is parallel to a unit normal.

    Its part perpendicular to the normal is at most `PERPENDICULAR_TOL` of r, or `small`.
    """
    square, normal_part = dot(r, r), dot(r, normal)
    return square - normal_part * normal_part <= max(
        small * small, PERPENDICULAR_TOL * PERPENDICULAR_TOL * square
    )


@inner()
def write_slopes(k, depth, a, x, b, y, out):
    """Write row k of `out` (`FootSlopes`): `depth` as ∂depth/∂p, and a xᵀ + b yᵀ as ∂normal/∂p."""
    for i in range(3):
        out.depth[k, i] = depth[i]
        for j in range(3):
            out.normal[k, i, j] = a[i] * x[j] + b[i] * y[j]


@inner()
def write_kink_slopes(k, d, rate, normal, gap, out):
    """Write row k of `out` (`FootSlopes`) for a foot on an edge or a vertex.

    The normal is (p − foot)/gap, so that ∂depth/∂p = −normal. The foot moves by d (rate · dp),
    along a curve of derivative d; it stays if both are zero. The signed `gap` must not be zero.
    """
    inverse_gap, normal_part = 1.0 / gap, dot(normal, d)
    for i in range(3):
        out.depth[k, i] = -normal[i]
        for j in range(3):
            projector = (1.0 if i == j else 0.0) - normal[i] * normal[j]
            out.normal[k, i, j] = inverse_gap * (
                projector - (d[i] - normal_part * normal[i]) * rate[j]
            )
