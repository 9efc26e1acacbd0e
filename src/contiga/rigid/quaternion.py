"""Unit quaternions (w, x, y, z), which represent rotations and interpolate well.

Arrays have the quaternions in their last axis, (..., 4). q and −q are the same rotation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.arrays.ordered import length, product
from contiga.errors import InputError
from contiga.records import FloatArray

_SMALL_ANGLE = 1e-8
"""Angle between two quaternions below which sin θ / θ is 1 to rounding, and slerp is linear."""


def as_unit(quaternion: ArrayLike, *, tolerance: float | None = None) -> FloatArray:
    """Return quaternions (..., 4) divided by their length, a new array.

    Parameters
    ----------
    quaternion : (..., 4) w, x, y, z
    tolerance : largest deviation of the length from 1; None accepts any

    Raises
    ------
    InputError
        Not four finite numbers each, all zero, or of a length outside `tolerance`.
    """
    real(quaternion, "quaternion")
    try:
        q = np.asarray(quaternion, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("a quaternion must be four numbers", found=quaternion) from error
    if q.ndim == 0 or q.shape[-1] != 4 or not np.isfinite(q).all():
        raise InputError("a quaternion must be four finite numbers (w, x, y, z)", found=q.tolist())
    largest = np.abs(q).max(axis=-1, keepdims=True)
    if (largest == 0.0).any():
        raise InputError("a quaternion must not be all zero", found=q.tolist())
    scaled = q / largest
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    if tolerance is not None:
        deviation = np.abs(length * largest - 1.0)
        if (deviation > tolerance).any():
            worst = q[np.unravel_index(int(deviation.argmax()), deviation.shape)[:-1]]
            raise InputError(
                "a quaternion must have length 1",
                found=worst.tolist(),
                allowed=f"w² + x² + y² + z² = 1 to {tolerance:g}, in the order w, x, y, z",
            )
    return np.asarray(scaled / length)


def to_matrix(q: FloatArray) -> FloatArray:
    """Return the rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = q.tolist() if q.ndim == 1 else np.moveaxis(q, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    if q.ndim == 1:
        return np.array(rows)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(R: FloatArray) -> FloatArray:
    """Return the unit quaternion (4,), w ≥ 0, of one rotation matrix (3, 3).

    The division is by the largest component (Shepperd, J. Guidance and Control 1, 1978).
    """
    r = R.tolist()
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [trace, r[0][0], r[1][1], r[2][2]]
    largest = squares.index(max(squares))
    if largest == 0:
        axis = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
        q = np.array([1.0 + trace, *axis])
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = np.empty(4)
        q[0] = r[k][j] - r[j][k]
        q[1 + i] = 1.0 + r[i][i] - r[j][j] - r[k][k]
        q[1 + j] = r[j][i] + r[i][j]
        q[1 + k] = r[k][i] + r[i][k]
    q /= length(q)
    return -q if q[0] < 0.0 else q


def rotation_vector(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return the rotation from `p` to `q` (4,) as axis times angle (3,), by the smaller angle.

    It is in the axes that `p` and `q` rotate to, and zero for the same rotation. Divided by a time
    it is the spin of that rotation.
    """
    # Plain numbers are faster than arrays for one rotation.
    (a, b, c, d), (w, x, y, z) = p.tolist(), q.tolist()
    cosine = a * w + b * x + c * y + d * z
    if cosine < 0.0:
        cosine, w, x, y, z = -cosine, -w, -x, -y, -z
    # q times the inverse of p; its scalar part is not negative.
    axis = np.array(
        [
            a * x - w * b - (y * d - z * c),
            a * y - w * c - (z * b - x * d),
            a * z - w * d - (x * c - y * b),
        ]
    )
    sine = length(axis)
    return 2.0 * math.atan2(sine, cosine) / sine * axis if sine > 0.0 else axis


def slerp(p: FloatArray, q: FloatArray, s: float) -> FloatArray:
    """Return the rotation at the fraction `s` in [0, 1] from `p` to `q` (4,), by the smaller angle.

    Shoemake, Animating Rotation with Quaternion Curves, SIGGRAPH 1985; below `_SMALL_ANGLE` linear.
    If `p` and `q` are half a turn apart, both directions are equivalent, and q is used with its
    sign. The result is a unit quaternion (4,).
    """
    end = -q if float(product(p, q)) < 0.0 else q
    # From the chord, since the arc cosine loses half of its digits near 1.
    angle = 2.0 * np.arctan2(length(end - p), length(end + p))
    if angle < _SMALL_ANGLE:
        rotation = p + s * (end - p)
    else:
        rotation = (np.sin((1.0 - s) * angle) * p + np.sin(s * angle) * end) / np.sin(angle)
    return np.asarray(rotation / length(rotation))
