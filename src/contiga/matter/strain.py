"""Green's strain of elements, E = ½ (FᵀF − 1), in the axes of the undeformed elements.

For a linear element F = Σ x_a ⊗ G_a with the gradients G_a of its corners' shape functions. At rest
P = Σ X_a ⊗ G_a is the projection to the plane of a membrane or the line of a bar, whose strain is
E = ½ (FᵀF − PᵀP). It is finite for elements that are pressed flat or go slack, unlike a
logarithmic strain.
"""

from __future__ import annotations

import numpy as np

from contiga.matter.stress import COMPONENTS
from contiga.records import FloatArray

_N_NEWTON = 30
"""Number of Newton steps: close to a double root each one halves the error."""


def membrane_gradients(corners: FloatArray) -> FloatArray:
    """Return gradients (e, 3, 3) of the corners of triangles (e, 3, 3) at rest, in their planes.

    They are in the axes of space; elements must have an area.
    """
    edge_1, edge_2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(edge_1, edge_2)
    normal /= np.sum(normal * normal, axis=1, keepdims=True)
    second, third = np.cross(edge_2, normal), np.cross(normal, edge_1)
    return np.stack([-second - third, second, third], axis=1)


def bar_gradients(corners: FloatArray) -> FloatArray:
    """Return gradients (e, 2, 3) of the two end shape functions along bars (e, 2, 3) at rest."""
    axis = corners[:, 1] - corners[:, 0]
    second = axis / np.sum(axis * axis, axis=1, keepdims=True)
    return np.stack([-second, second], axis=1)


def metric(corners: FloatArray, gradients: FloatArray) -> FloatArray:
    """Return FᵀF (e, 3, 3) of elements with corners (e, k, 3) and gradients (e, k, 3) at rest."""
    slopes = np.einsum("eai,eaj->eij", corners, gradients)
    return np.einsum("eki,ekj->eij", slopes, slopes)


def green(corners: FloatArray, gradients: FloatArray, rest_metric: FloatArray) -> FloatArray:
    """Return Green's strains (e, 6) xx, yy, zz, xy, yz, xz, the last three tensor components.

    Parameters
    ----------
    corners : (e, k, 3) of the deformed elements
    gradients : (e, k, 3) of the corners' shape functions at rest
    rest_metric : (e, 3, 3) `metric` of the corners at rest

    Examples
    --------
    >>> ends = np.array([[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    >>> gradients = bar_gradients(ends)
    >>> green(1.2 * ends, gradients, metric(ends, gradients)).round(6).tolist()
    [[0.0, 0.22, 0.0, 0.0, 0.0, 0.0]]
    """
    strain = 0.5 * (metric(corners, gradients) - rest_metric)
    return np.stack([strain[:, i, j] for i, j in COMPONENTS], axis=1)


def largest_principal(tensors: FloatArray) -> FloatArray:
    """Return the largest principal value (n,) of tensors (n, 6).

    With the mean m, the deviator D and p² = tr D²/6 it is m + p t with the largest root t of
    t³ − 3 t = det(D/p), which is 2 cos θ of Smith (Commun. ACM 4, 1961). Newton's method converges
    to t from above by plain arithmetic: the same bits on every processor, unlike cosines or LAPACK.

    Examples
    --------
    >>> largest_principal(np.array([[1.0, 1.0, -3.0, 0.5, 0.0, 0.0]])).round(6).tolist()
    [1.5]
    """
    x, y, z, xy, yz, xz = tensors.T
    mean = (x + y + z) / 3.0
    x, y, z = x - mean, y - mean, z - mean
    size = np.sqrt((x * x + y * y + z * z + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0)
    determinant = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = np.where(size > 0.0, determinant / (size * size * size), 0.0)
    t = np.full(len(mean), 2.0)
    for _ in range(_N_NEWTON):
        slope = 3.0 * (t * t - 1.0)
        residual = t * (t * t - 3.0) - right
        is_above = (slope > 0.0) & (residual > 0.0)
        t = np.where(is_above, t - residual / np.maximum(slope, 1e-300), t)
    return np.asarray(mean + size * t)
