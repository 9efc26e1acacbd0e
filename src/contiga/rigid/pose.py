"""Poses of rigid frames, as (4, 4) matrices with a rotation R and a position t.

``X_WB`` is the pose of the body B in the world W: ``p_W = R p_B + t``. Angles are in radians.
A pose may also be given as a ``scipy.spatial.transform.Rotation`` or a pair ``(R, t)``, which
`as_pose` converts.
"""

from __future__ import annotations

from functools import reduce
from itertools import chain
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, real
from contiga.arrays.ordered import product
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid import quaternion, transform
from contiga.rigid.transform import Axis, PoseLike, as_matrix

RIGID = 1e-9
"""Largest entry of R Rᵀ − 1 that a pose may have."""


def identity() -> FloatArray:
    """Return the identity pose (4, 4)."""
    return np.eye(4)


def translation(d: ArrayLike) -> FloatArray:
    """Return the pose (4, 4) of a translation by `d` (3,)."""
    return transform.translation(d)


def rotation(axis: Axis, angle: float, centre: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return the pose (4, 4) of a rotation by `angle`, rad, about `axis` through `centre`.

    The axis is "x", "y", "z" or a vector.
    """
    return transform.rotation(axis, angle, centre)


def from_quaternion(q: ArrayLike, position: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return the pose (4, 4) of the rotation `q` (w, x, y, z), of any length > 0, at `position`.

    Raises `InputError` for a `q` that is not four finite numbers, or all zero.
    """
    X = transform.translation(position)
    X[:3, :3] = quaternion.to_matrix(quaternion.as_unit(q))
    return X


def from_euler(
    angles: ArrayLike, order: str = "xyz", position: ArrayLike = (0.0, 0.0, 0.0)
) -> FloatArray:
    """Return the pose (4, 4) of rotations by `angles`, rad, about fixed axes, in the given `order`.

    Capitals rotate about the current axes of the frame (intrinsic), as in scipy's Rotation.

    Raises
    ------
    InputError
        `order` is not one to three of x, y, z in one case, or the angles do not match it.
    """
    values = np.atleast_1d(np.asarray(real(angles), dtype=np.float64))
    lower = order.lower()
    if not 1 <= len(order) <= 3 or set(lower) - set("xyz") or order not in (lower, order.upper()):
        raise InputError(
            "the order of Euler angles is not known",
            where="order",
            found=order,
            allowed='one to three letters, as "xyz" (fixed axes) or "ZYX" (the frame\'s own)',
        )
    if values.shape != (len(order),):
        raise InputError(
            "expected one angle for each axis",
            where="angles",
            found=values.shape,
            allowed=f"({len(order)},)",
        )
    rotations = [transform.rotation(a, float(v)) for a, v in zip(lower, values, strict=True)]
    X = compose(*(rotations if order.isupper() else reversed(rotations)))
    X[:3, 3] = transform.vector(position, "position")
    return X


def as_pose(X: PoseLike, where: str = "pose") -> FloatArray:
    """Check a rigid pose and return it as a (4, 4) matrix, a copy.

    Parameters
    ----------
    X : a (4, 4) matrix, a `scipy.spatial.transform.Rotation` about the origin, or a pair (R, t) of
        a Rotation or (3, 3) matrix and a position (3,), length
    where : name of the pose in messages

    Raises
    ------
    InputError
        None of these, not finite, or not rigid: R Rᵀ − 1 above 1e-9 in an entry, a reflection, a
        last row other than 0, 0, 0, 1.

    >>> from scipy.spatial.transform import Rotation
    >>> as_pose((Rotation.from_euler("z", 180, degrees=True), [0.0, 0.0, 5.0]))[:3, 3].tolist()
    [0.0, 0.0, 5.0]
    """
    matrix = real(as_matrix(X, where), where)
    try:
        pose = np.array(matrix, dtype=np.float64, order="C")  # contiguous, for kernels
    except (TypeError, ValueError) as error:
        raise InputError("a pose must be an array of numbers", where=where) from error
    rows = pose.tolist()
    if pose.shape != (4, 4) or not all(map(isfinite, chain.from_iterable(rows))):
        raise InputError(
            "a pose must be a finite (4, 4) matrix",
            where=where,
            found=pose.shape if pose.shape != (4, 4) else rows,
            allowed="a (4, 4) matrix, a scipy Rotation, or a pair (R, t)",
        )
    (a, b, c, _), (d, e, f, _), (g, h, i, _), last = rows
    determinant = a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)
    rigidity_error = max(  # of R Rᵀ − 1: plain numbers are faster than arrays for one matrix
        abs(a * a + b * b + c * c - 1.0),
        abs(d * d + e * e + f * f - 1.0),
        abs(g * g + h * h + i * i - 1.0),
        abs(a * d + b * e + c * f),
        abs(d * g + e * h + f * i),
        abs(g * a + h * b + i * c),
    )
    if last != [0.0, 0.0, 0.0, 1.0] or determinant < 0.0 or not rigidity_error <= RIGID:
        raise InputError(
            "a pose must be a rotation and a translation",
            where=where,
            found=rows,
            allowed=f"R Rᵀ = 1 to {RIGID:g}, det R = 1, last row 0, 0, 0, 1",
        )
    return pose


def compose(*poses: FloatArray) -> FloatArray:
    """Return the matrix product: ``compose(X_AB, X_BC)`` is X_AC. The last pose applies first."""
    return reduce(product, poses, np.eye(4))


def invert(X_AB: FloatArray) -> FloatArray:
    """Return X_BA, the pose of A in B."""
    X_BA = np.eye(4)
    X_BA[:3, :3] = X_AB[:3, :3].T
    X_BA[:3, 3] = -product(X_AB[:3, :3].T, X_AB[:3, 3])
    return X_BA


def relative(X_WA: FloatArray, X_WB: FloatArray) -> FloatArray:
    """Return X_AB, the pose of B in A."""
    (a, b, c, _), (x, y, z, last) = X_WA.tolist(), X_WB.tolist()
    x[3], y[3], z[3] = x[3] - a[3], y[3] - b[3], z[3] - c[3]
    columns = list(zip(x, y, z, strict=True))
    rows = [[a[i] * u + b[i] * v + c[i] * w for u, v, w in columns] for i in range(3)]
    return np.array([*rows, last])


def apply(X_AB: FloatArray, points_B: ArrayLike) -> FloatArray:
    """Return points (n, 3) of the frame B in the frame A."""
    return transform.apply(X_AB, as_points(points_B))


def apply_vectors(X_AB: FloatArray, vectors_B: ArrayLike) -> FloatArray:
    """Return directions (n, 3) of the frame B in the frame A: rotated, not translated."""
    return np.asarray(product(as_points(vectors_B, "vectors"), X_AB[:3, :3].T))


def to_quaternion(X: FloatArray) -> FloatArray:
    """Return the rotation of a pose as a unit quaternion (w, x, y, z) with w ≥ 0."""
    return quaternion.from_matrix(X[:3, :3])


def interpolate(X0: FloatArray, X1: FloatArray, s: float) -> FloatArray:
    """Return the pose at the fraction `s` in [0, 1] between `X0` and `X1`, a new array.

    The position is linear, the frame rotates about one axis by the smaller angle (slerp). At s = 0
    and s = 1 the ends are copied bit by bit.
    """
    if s in (0.0, 1.0):
        return (X1 if s else X0).copy()
    X = np.eye(4)
    q = quaternion.slerp(to_quaternion(X0), to_quaternion(X1), s)
    X[:3, :3] = quaternion.to_matrix(q)
    X[:3, 3] = (1.0 - s) * X0[:3, 3] + s * X1[:3, 3]
    return X
