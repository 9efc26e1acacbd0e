"""Unit quaternions (w, x, y, z): turns that can be mixed without losing their length.

Arrays have the quaternions in their last axis, (..., 4). q and −q are the same turn.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.arrays.ordered import length, product
from contiga.errors import InputError
from contiga.records import FloatArray

# Below this angle between two quaternions sin θ / θ is 1 to rounding, and slerp is a straight line.
_SMALL = 1e-8


def as_unit(quaternion: ArrayLike, *, tolerance: float | None = None) -> FloatArray:
    """Quaternions (..., 4) divided by their length.

    Parameters
    ----------
    quaternion : (..., 4) w, x, y, z
    tolerance : largest accepted relative distance of the length from 1; None accepts any

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
    """Unit quaternion (4,), w ≥ 0, of one rotation matrix (3, 3).

    Shepperd's choice of the largest component to divide by (J. Guidance and Control 1, 1978).
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
    """The turn from `p` to `q` (4,) as axis times angle (3,), the way `slerp` goes.

    In the axes that `p` and `q` turn into: the spin of an even turn is this over its time.
    """
    # In plain numbers, as all of one turn here: these are too few for arrays to pay.
    (a, b, c, d), (w, x, y, z) = p.tolist(), q.tolist()
    cosine = a * w + b * x + c * y + d * z
    if cosine < 0.0:
        cosine, w, x, y, z = -cosine, -w, -x, -y, -z
    # The second times the inverse of the first; its scalar part is not negative.
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
