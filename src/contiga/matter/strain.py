"""Green's strain of elements, E = ½ (FᵀF − 1), in the axes in which they stand unstrained.

Of any linear element F = Σ x_a ⊗ G_a with the gradients G_a of its corners' shape functions, and
P = Σ X_a ⊗ G_a at rest projects to the plane of a membrane or the line of a bar, so that
E = ½ (FᵀF − PᵀP) is what these know of it. It is finite where they are pressed flat or go slack,
which a logarithmic strain is not.
"""

from __future__ import annotations

import numpy as np

from contiga.matter.stress import COMPONENTS
from contiga.records import FloatArray

_HALVINGS = 30
"""Steps of Newton's method: beside a double root each halves what is missing."""


def membrane_gradients(corners: FloatArray) -> FloatArray:
    """Return gradients (e, 3, 3) of the corners of triangles (e, 3, 3) at rest, in their planes."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(one, other)
    normal /= np.sum(normal * normal, axis=1, keepdims=True)
    second, third = np.cross(other, normal), np.cross(normal, one)
    return np.stack([-second - third, second, third], axis=1)


def bar_gradients(corners: FloatArray) -> FloatArray:
    """Return gradients (e, 2, 3) of the ends of bars (e, 2, 3) at rest, along them."""
    way = corners[:, 1] - corners[:, 0]
    second = way / np.sum(way * way, axis=1, keepdims=True)
    return np.stack([-second, second], axis=1)


def metric(corners: FloatArray, gradients: FloatArray) -> FloatArray:
    """Return FᵀF (e, 3, 3) of elements with corners (e, k, 3) and gradients (e, k, 3) at rest."""
    slopes = np.einsum("eai,eaj->eij", corners, gradients)
    return np.einsum("eki,ekj->eij", slopes, slopes)


def green(corners: FloatArray, gradients: FloatArray, still: FloatArray) -> FloatArray:
    """Return Green's strains (e, 6) xx, yy, zz, xy, yz, xz, the last three tensor components.

    Parameters
    ----------
    corners : (e, k, 3) now
    gradients : (e, k, 3) of the corners' shape functions at rest
    still : (e, 3, 3) `metric` of the corners at rest

    Examples
    --------
    >>> ends = np.array([[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    >>> along = bar_gradients(ends)
    >>> green(1.2 * ends, along, metric(ends, along)).round(6).tolist()
    [[0.0, 0.22, 0.0, 0.0, 0.0, 0.0]]
    """
    whole = 0.5 * (metric(corners, gradients) - still)
    return np.stack([whole[:, i, j] for i, j in COMPONENTS], axis=1)


def largest_principal(tensors: FloatArray) -> FloatArray:
    """Return the largest principal value (n,) of tensors (n, 6).

    With the mean m, the deviator D and p² = tr D²/6 it is m + p t with the largest root t of
    t³ − 3 t = det(D/p), which is 2 cos θ of Smith (Commun. ACM 4, 1961). Newton's method comes to
    it from above by plain arithmetic: the same bits on every processor, unlike cosines or LAPACK.

    Examples
    --------
    >>> largest_principal(np.array([[1.0, 1.0, -3.0, 0.5, 0.0, 0.0]])).round(6).tolist()
    [1.5]
    """
    x, y, z, xy, yz, xz = tensors.T
    mean = (x + y + z) / 3.0
    x, y, z = x - mean, y - mean, z - mean
    size = np.sqrt((x * x + y * y + z * z + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0)
    whole = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz)
    with np.errstate(divide="ignore", invalid="ignore"):
        side = np.where(size > 0.0, whole / (size * size * size), 0.0)
    root = np.full(len(mean), 2.0)
    for _ in range(_HALVINGS):
        slope = 3.0 * (root * root - 1.0)
        miss = root * (root * root - 3.0) - side
        root = np.where((slope > 0.0) & (miss > 0.0), root - miss / np.maximum(slope, 1e-300), root)
    return np.asarray(mean + size * root)
