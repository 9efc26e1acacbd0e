"""Unit quaternions (w, x, y, z): turns that can be mixed without losing their length.

Arrays have the quaternions in their last axis, (..., 4). q and −q are the same turn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.ordered import length, product
from contiga.errors import InputError
from contiga.records import FloatArray

# Below this angle between two quaternions sin θ / θ is 1 to rounding, and slerp is a straight line.
_SMALL = 1e-8


def as_unit(quaternion: ArrayLike, *, tolerance: float | None = None) -> FloatArray:
    """Quaternions (..., 4) divided by their length.

    Parameters
    ----------
    tolerance : largest accepted relative distance of the length from 1; None accepts any

    Raises
    ------
    InputError
        Not four finite numbers each, all zero, or of a length outside `tolerance`.
    """
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
        miss = np.abs(length * largest - 1.0)
        if (miss > tolerance).any():
            bad = q[np.unravel_index(int(miss.argmax()), miss.shape)[:-1]]
            raise InputError(
                "a quaternion must have length 1",
                found=bad.tolist(),
                allowed=f"w² + x² + y² + z² = 1 to {tolerance:g}, in the order w, x, y, z",
            )
    return np.asarray(scaled / length)


def to_matrix(q: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(R: FloatArray) -> FloatArray:
    """Unit quaternion (4,), w ≥ 0, of one rotation matrix (3, 3).

    Shepperd's choice of the largest component to divide by (J. Guidance and Control 1, 1978).
    """
    trace = float(np.trace(R))
    squares = np.array([trace, R[0, 0], R[1, 1], R[2, 2]])
    largest = int(squares.argmax())
    q = np.empty(4)
    if largest == 0:
        q[0] = 1.0 + trace
        q[1:] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q[0] = R[k, j] - R[j, k]
        q[1 + i] = 1.0 + R[i, i] - R[j, j] - R[k, k]
        q[1 + j] = R[j, i] + R[i, j]
        q[1 + k] = R[k, i] + R[i, k]
    q /= length(q)
    return -q if q[0] < 0.0 else q


def rotation_vector(p: FloatArray, q: FloatArray) -> FloatArray:
    """The turn from `p` to `q` (4,) as axis times angle (3,), the way `slerp` goes.

    In the axes that `p` and `q` turn into: the spin of an even turn is this over its time.
    """
    end = -q if float(product(p, q)) < 0.0 else q
    # end · p⁻¹, whose scalar part is not negative.
    axis = p[0] * end[1:] - end[0] * p[1:] - np.cross(end[1:], p[1:])
    sine = length(axis)
    if sine == 0.0:
        return np.zeros(3)
    return np.asarray(2.0 * np.arctan2(sine, float(product(p, end))) / sine * axis)


def slerp(p: FloatArray, q: FloatArray, s: float) -> FloatArray:
    """The turn a part `s` in [0, 1] of the shorter way from `p` to `q`, both (4,).

    Shoemake, Animating Rotation with Quaternion Curves, SIGGRAPH 1985. Where `p` and `q` are
    half a turn apart both ways are as long and the one through `q` as given is taken.
    """
    end = -q if float(product(p, q)) < 0.0 else q
    # From the chord, since the arc cosine loses half its digits near 1.
    angle = 2.0 * np.arctan2(length(end - p), length(end + p))
    if angle < _SMALL:
        mixed = p + s * (end - p)
    else:
        mixed = (np.sin((1.0 - s) * angle) * p + np.sin(s * angle) * end) / np.sin(angle)
    return np.asarray(mixed / length(mixed))
