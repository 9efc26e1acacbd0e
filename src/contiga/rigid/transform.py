"""Affine maps as (4, 4) matrices, which move curves, surfaces, meshes and bodies."""

from __future__ import annotations

import math
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, real
from contiga.arrays.ordered import length, product
from contiga.errors import GeometryError, InputError
from contiga.records import FloatArray

Axis = str | ArrayLike


class HasMatrix(Protocol):
    """A rotation, or a rotation with a translation: scipy's `Rotation` and `RigidTransform`."""

    def as_matrix(self) -> Any:
        """Return the (3, 3) or (4, 4) matrix."""


PoseLike: TypeAlias = ArrayLike | HasMatrix | tuple[HasMatrix | ArrayLike, ArrayLike]
"""A (4, 4) matrix, a rotation, or a pair (R, t): R a rotation or (3, 3), t (3,), length."""

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_SINGULAR = 1e-14


def vector(values: ArrayLike, where: str) -> FloatArray:
    """Return `values` as three finite numbers (3,), a copy; raise `GeometryError` for others."""
    real(values, where)
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError("must be three numbers", where=where, found=values) from error
    if array.shape != (3,) or not np.isfinite(array).all():
        raise GeometryError("must be three finite numbers", where=where, found=values)
    return array


def as_matrix(X: PoseLike, where: str) -> Any:
    """Convert a rotation or a pair (R, t) to a (4, 4) matrix; return anything else unchanged.

    The caller checks whether the matrix is a rotation.

    Raises
    ------
    InputError
        R is not one (3, 3) matrix of numbers, or t is not three finite numbers.
    """
    is_pair = isinstance(X, tuple | list) and len(X) == 2
    if not (is_pair or hasattr(X, "as_matrix")):
        return X
    pair: tuple[Any, Any] = X if is_pair else (X, (0.0, 0.0, 0.0))  # type: ignore[assignment]
    R, t = pair
    rotation_matrix = as_numbers(
        R.as_matrix() if hasattr(R, "as_matrix") else R,
        where,
        "the rotation of a pose must be an array of numbers",
    )
    if rotation_matrix.shape == (4, 4) and not is_pair:  # scipy's RigidTransform, with translation
        return rotation_matrix
    if rotation_matrix.shape != (3, 3):
        is_several = rotation_matrix.ndim > 2
        raise InputError(
            "the rotation of a pose must be one (3, 3) matrix",
            where=where,
            found=rotation_matrix.shape,
            allowed="a scipy Rotation, a pair (R, t) with R (3, 3) or a Rotation, a (4, 4) matrix",
            remedy="Of several rotations take one, such as rotations[0]" if is_several else None,
        )
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation_matrix, vector(t, f"{where}, translation")
    return matrix


def cross_matrix(k: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) of the cross product k × ."""
    return np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])


def unit_axis(axis: Axis, where: str = "axis") -> FloatArray:
    """Return a unit vector (3,) from ``"x"``, ``"y"``, ``"z"`` or a vector.

    Raises `GeometryError` for another letter, the zero vector, or numbers that are not finite.
    """
    if isinstance(axis, str):
        if axis not in _AXES:
            raise GeometryError(
                "not an axis", where=where, found=axis, allowed="'x', 'y', 'z' or a vector"
            )
        return np.array(_AXES[axis])
    direction = vector(axis, where)
    largest = float(np.abs(direction).max())
    if largest == 0.0:
        raise GeometryError("an axis must not be the zero vector", where=where, found=axis)
    direction = direction / largest
    return np.asarray(direction / length(direction))


def translation(d: ArrayLike) -> FloatArray:
    """Return the matrix (4, 4) of a translation by `d` (3,)."""
    matrix = np.eye(4)
    matrix[:3, 3] = vector(d, "translation")
    return matrix


def rotation(axis: Axis, angle: float, origin: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return the matrix (4, 4) of a rotation by `angle` (radians, right-handed) about `axis`.

    The axis passes through `origin` (Rodrigues' formula). Quarter turns are exact: sine and cosine
    are 0 or ±1. Raises `GeometryError` for an angle that is not finite, and no axis.
    """
    if not math.isfinite(angle):
        raise GeometryError("the angle must be finite", where="angle", found=angle)
    k = unit_axis(axis)
    cosine, sine = cos_sin(angle)
    matrix = np.eye(4)
    matrix[:3, :3] = cosine * np.eye(3) + sine * cross_matrix(k) + (1.0 - cosine) * np.outer(k, k)
    centre = vector(origin, "origin")
    matrix[:3, 3] = centre - product(matrix[:3, :3], centre)
    return matrix


def cos_sin(angle: float) -> tuple[float, float]:
    """Return cosine and sine; 0 and ±1 for an angle within 4e-16, relative, of quarter turns."""
    quarters = angle / (0.5 * math.pi)
    nearest = round(quarters)
    if abs(quarters - nearest) <= 4e-16 * max(1.0, abs(quarters)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(angle), math.sin(angle)


def scaling(s: float | ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return the matrix (4, 4) of a scaling about `origin` by `s`, one number or one for each axis.

    Raises `GeometryError` for factors that are not positive and finite.
    """
    factors = np.asarray(real(s), dtype=np.float64)
    if factors.shape not in ((), (3,)) or not (np.isfinite(factors).all() and (factors > 0).all()):
        raise GeometryError(
            "scale factors must be positive",
            where="scale",
            found=s,
            allowed="one number > 0, or three",
            remedy="For a mirror image use transformed with a reflecting matrix",
        )
    centre = vector(origin, "origin")
    matrix = np.eye(4)
    matrix[:3, :3] = np.diag(np.broadcast_to(factors, (3,)))
    matrix[:3, 3] = centre - product(matrix[:3, :3], centre)
    return matrix


def frame(axis: Axis, centre: ArrayLike) -> FloatArray:
    """Return the pose (4, 4) whose z axis is `axis` and whose origin is `centre`.

    Poses along the coordinate axes are cyclic permutations, and so exact. Other axes are reached by
    the smallest rotation from z, the opposite of z by a half turn about x.
    """
    k = unit_axis(axis)
    matrix = np.eye(4)
    sine = math.hypot(k[0], k[1])
    if k[2] == -1.0:
        matrix[:3, :3] = np.diag([1.0, -1.0, -1.0])
    elif k[0] == 1.0:
        matrix[:3, :3] = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    elif k[1] == 1.0:
        matrix[:3, :3] = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    elif sine > 0.0:
        rotation_axis = np.array([-k[1] / sine, k[0] / sine, 0.0])
        matrix[:3, :3] = rotation(rotation_axis, math.atan2(sine, k[2]))[:3, :3]
    matrix[:3, 3] = vector(centre, "centre")
    return matrix


def affine(matrix: PoseLike) -> FloatArray:
    """Check a regular affine map and return it as a matrix (4, 4), a copy.

    Raises
    ------
    GeometryError
        Not (4, 4), not finite, a last row other than (0, 0, 0, 1), or singular.
    InputError
        A rotation or a pair (R, t) that is not one: see `as_matrix`.
    """
    array = np.array(real(as_matrix(matrix, "transform"), "transform"), dtype=np.float64)
    if array.shape != (4, 4) or not np.isfinite(array).all():
        raise GeometryError(
            "a transform must be a finite (4, 4) matrix", where="transform", found=array.shape
        )
    if not np.array_equal(array[3], [0.0, 0.0, 0.0, 1.0]):
        raise GeometryError(
            "the last row of a transform must be (0, 0, 0, 1)",
            where="transform",
            found=array[3].tolist(),
        )
    sizes = np.linalg.svd(array[:3, :3], compute_uv=False)
    if sizes[-1] <= _SINGULAR * sizes[0]:
        raise GeometryError(
            "a transform must not flatten space: its matrix is singular", where="transform"
        )
    return array


def apply(matrix: FloatArray, points: FloatArray) -> FloatArray:
    """Return `points` (..., 3) moved by the affine `matrix`."""
    return np.asarray(product(points, matrix[:3, :3].T) + matrix[:3, 3])


def reflects(matrix: FloatArray) -> bool:
    """Return whether the map is a reflection, with a negative determinant."""
    return bool(np.linalg.det(matrix[:3, :3]) < 0.0)
