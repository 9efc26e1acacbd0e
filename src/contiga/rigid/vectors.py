"""Products of vectors, for the few of them that a step needs of each body."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def cross_matrix(k: FloatArray) -> FloatArray:
    """(3, 3) the matrix of k × ."""
    return np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """``np.cross`` of vectors (3,) or of rows (n, 3), the same bits.

    Of two vectors it takes a tenth of the time, of a few rows a quarter.

    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 2.0, 0.0])).tolist()
    [0.0, 0.0, 2.0]
    """
    if a.size == b.size == 3:
        (x, y, z), (u, v, w) = a.ravel().tolist(), b.ravel().tolist()
        product = np.array([y * w - z * v, z * u - x * w, x * v - y * u])
        return product.reshape(a.shape if a.ndim > b.ndim else b.shape)
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(a[..., i], b[..., j], out=out[..., k])
        out[..., k] -= a[..., j] * b[..., i]
    return out
