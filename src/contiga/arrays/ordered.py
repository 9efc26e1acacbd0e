"""Linear algebra with the same order of sums on every machine.

``@``, `np.dot`, `np.linalg.norm` of a vector and all of `np.linalg` call the BLAS, which chooses
its kernels, and so the order and the rounding of sums, by the processor. These functions give the
same bits everywhere.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from contiga.records import FloatArray

MAX_SWEEPS = 30
MAX_PLAIN_ENTRIES = 8
"""Largest number of entries that are added as plain floats, in order: a tenth of the time, the same
bits."""
MIN_SQUARE, MAX_SQUARE = 1e-280, 1e300
"""Range of squared lengths without underflow or overflow."""


def product(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Return ``a @ b`` of vectors and matrices; `a` may have leading axes.

    >>> product([[1.0, 2.0], [0.0, 1.0]], [3.0, 4.0]).tolist()
    [11.0, 4.0]
    """
    left, right = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    subscripts = "...j,j->..." if right.ndim == 1 else "...j,jk->...k"
    return np.asarray(np.einsum(subscripts, left, right, optimize=False))


def row_products(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar products (n,) of rows (n, 3) of `a` and `b`, one of which may be (3,).

    It is ``(a * b).sum(axis=-1)`` in a fourth of the time.

    >>> row_products(np.array([[1.0, 2.0, 3.0]]), np.array([4.0, 5.0, 6.0])).tolist()
    [32.0]
    """
    total = a[..., 0] * b[..., 0]
    total += a[..., 1] * b[..., 1]
    total += a[..., 2] * b[..., 2]
    return np.asarray(total)


def row_lengths(a: FloatArray) -> FloatArray:
    """Return (n,) lengths of the rows of (n, 3).

    >>> row_lengths(np.array([[2.0, 3.0, 6.0]])).tolist()
    [7.0]
    """
    return np.asarray(np.sqrt(row_products(a, a)))


def length(vector: ArrayLike) -> float:
    """Return the root of the sum of the squares of all entries, without overflow or underflow.

    It is zero without entries, and infinite or NaN if an entry is.

    >>> length([3.0, 4.0])
    5.0
    """
    values = np.asarray(vector, dtype=np.float64)
    if values.size <= MAX_PLAIN_ENTRIES:
        square = 0.0
        for x in values.ravel().tolist():
            square += x * x
        if MIN_SQUARE < square < MAX_SQUARE:
            return math.sqrt(square)
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    power = math.frexp(largest)[1]
    scaled = np.ldexp(values, -power)
    return float(np.ldexp(math.sqrt(float(np.sum(scaled * scaled))), power))


def solve(matrix: ArrayLike, right: ArrayLike) -> FloatArray:
    """Return the solution of a regular system (n, n) for one right side (n,) or several (n, m).

    By Gaussian elimination with partial pivoting; a pivot of zero gives infinite or NaN entries.

    >>> solve([[0.0, 2.0], [1.0, 1.0]], [4.0, 5.0]).tolist()
    [3.0, 2.0]
    """
    a, b = np.array(matrix, dtype=np.float64), np.array(right, dtype=np.float64)
    n = len(a)
    for k in range(n):
        pivot = k + int(np.argmax(np.abs(a[k:, k])))
        a[[k, pivot]], b[[k, pivot]] = a[[pivot, k]], b[[pivot, k]]
        below = k + 1 + np.flatnonzero(a[k + 1 :, k])
        factor = a[below, k] / a[k, k]
        a[below, k:] -= np.multiply.outer(factor, a[k, k:])
        b[below] -= np.multiply.outer(factor, b[k])
    for k in range(n - 1, -1, -1):
        b[k] = (b[k] - product(b[k + 1 :].T, a[k, k + 1 :])) / a[k, k]
    return b


def principal_axes(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the singular values (3,), falling, of vectors (n, 3), and the axes as rows (3, 3).

    The axes are the right singular vectors; the sense of each is arbitrary, so that they may be
    left-handed. By one-sided Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.6.3).
    """
    columns, axes = np.array(vectors, dtype=np.float64).T.copy(), np.eye(3)
    for _ in range(MAX_SWEEPS):
        has_rotated = False
        for i, j in ((0, 1), (0, 2), (1, 2)):
            a, b = float(np.sum(columns[i] ** 2)), float(np.sum(columns[j] ** 2))
            c = float(np.sum(columns[i] * columns[j]))
            if abs(c) <= 1e-15 * math.sqrt(a * b):
                continue
            has_rotated = True
            z = (b - a) / (2.0 * c)
            t = math.copysign(1.0, z) / (abs(z) + math.sqrt(1.0 + z * z))
            cosine = 1.0 / math.sqrt(1.0 + t * t)
            rotation = cosine * np.array([[1.0, -t], [t, 1.0]])
            for rows in (columns, axes):
                rows[[i, j]] = product(rotation, rows[[i, j]])
        if not has_rotated:
            break
    sizes = np.array([length(column) for column in columns])
    order = np.argsort(-sizes, kind="stable")
    return sizes[order], axes[order]
