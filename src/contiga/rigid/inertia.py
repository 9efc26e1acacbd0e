"""Inertia tensors: from the moments of a volume, their checks, and the inertia of several parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.arrays.ordered import length, principal_axes
from contiga.errors import InputError
from contiga.records import FloatArray, MassProperties

ROUNDING = 1e-6
"""Relative tolerance of symmetry and of the triangle rule, for the digits that a user types."""


def principal_moments(inertia: ArrayLike) -> FloatArray:
    """Return (3,) principal moments, rising, of a symmetric tensor (3, 3); symmetry is not checked.

    >>> principal_moments([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.5]]).round(12).tolist()
    [1.0, 2.5, 3.0]
    """
    tensor = np.asarray(real(inertia), dtype=np.float64)
    # Singular values have no sign: the shift makes all eigenvalues positive.
    shift = length(tensor)
    return np.asarray(principal_axes(tensor + shift * np.eye(3))[0][::-1] - shift)


def check_inertia(inertia: ArrayLike, where: str) -> FloatArray:
    """Return `inertia` as a symmetric (3, 3) array, a copy, if a solid can have it.

    Off-diagonal entries are those of the tensor, I_xy = −∫ x y dm; the mean of I_xy and I_yx is
    returned.

    Raises
    ------
    InputError
        Not (3, 3), not finite, or asymmetric by more than 1e-6 of the largest entry; a principal
        moment below 1e-12 of the largest, or one that exceeds the sum of the other two (the
        triangle rule) by more than 1e-6 of it.

    >>> check_inertia([[2, 0, 0], [0, 2, 0], [0, 0, 3]], "inertia").tolist()
    [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]
    """
    real(inertia, where)
    try:
        tensor = np.array(inertia, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "an inertia must be numbers", where=where, found=inertia, allowed="shape (3, 3)"
        ) from error
    if tensor.shape != (3, 3) or not np.isfinite(tensor).all():
        found = tensor.shape if tensor.shape != (3, 3) else tensor.tolist()
        raise InputError("an inertia must be finite, (3, 3)", where=where, found=found)
    if np.abs(tensor - tensor.T).max() > ROUNDING * np.abs(tensor).max():
        raise InputError("an inertia must be symmetric", where=where, found=tensor.tolist())
    tensor = np.asarray(0.5 * (tensor + tensor.T))
    low, middle, high = (float(moment) for moment in principal_moments(tensor))
    moments = tuple(float(f"{moment:.6g}") for moment in (low, middle, high))
    if not low > ROUNDING**2 * high:
        raise InputError(
            "the inertia must be positive about every axis",
            where=where,
            found=f"principal moments {moments}",
            allowed="three > 0",
            remedy="Entries off the diagonal are those of the tensor: Ixy is -∫ x y dm",
        )
    if high - middle - low > ROUNDING * high:
        raise InputError(
            "no body has this inertia: a principal moment is larger than the sum of the others",
            where=where,
            found=f"principal moments {moments}",
            allowed=f"the largest at most {low + middle:.6g}",
            remedy="Entries off the diagonal are those of the tensor: Ixy is -∫ x y dm",
        )
    return tensor


def combined(parts: Sequence[MassProperties]) -> MassProperties:
    """Return the mass properties of several rigid parts together, all in the same axes.

    Each inertia, and that of the sum, is about the centre of mass it stands with.

    >>> part = MassProperties(1.0, np.array([1.0, 0.0, 0.0]), np.eye(3))
    >>> total = combined([part, part._replace(centre=-part.centre)])
    >>> total.mass, total.centre.tolist(), total.inertia.diagonal().tolist()
    (2.0, [0.0, 0.0, 0.0], [2.0, 4.0, 4.0])
    """
    mass = sum(part.mass for part in parts)
    centre = np.sum([part.mass * part.centre for part in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.centre - centre
        steiner = (arm * arm).sum() * np.eye(3) - np.multiply.outer(arm, arm)
        inertia += part.inertia + part.mass * steiner
    return MassProperties(mass, centre, inertia)


def of_points(points: FloatArray, mass: FloatArray) -> MassProperties:
    """Return the mass properties of masses (n,) at points (n, 3) as one rigid body.

    The inertia is about the common centre; it is singular for points on a line.

    >>> pair = of_points(np.array([[1.0, 0, 0], [3.0, 0, 0]]), np.array([1.0, 1.0]))
    >>> pair.mass, pair.centre.tolist(), pair.inertia.diagonal().tolist()
    (2.0, [2.0, 0.0, 0.0], [0.0, 2.0, 2.0])
    """
    total = float(mass.sum())
    centre = (mass[:, None] * points).sum(axis=0) / total
    arms = points - centre
    second = np.einsum("n,ni,nj->ij", mass, arms, arms)
    return MassProperties(total, centre, np.trace(second) * np.eye(3) - second)


def of_volume(
    moments: FloatArray, origin: FloatArray, density: float, where: str
) -> MassProperties:
    """Return mass, centre and inertia of a solid from its moments (10,) about `origin`.

    The order is that of `geometry.trim_area.body_moments`: volume, ∫ x, y, z dV, then ∫ of xx, yy,
    zz, xy, yz, xz. The centre of mass is a position in the same axes as `origin`; the inertia is
    about it.

    Raises
    ------
    InputError
        The volume is not positive: normals point inward, or nothing is enclosed.
    """
    volume = float(moments[0])
    if not volume > 0.0:
        raise InputError(
            "encloses no volume: its normals point inward",
            where=where,
            found=volume,
            allowed="a volume > 0",
            remedy="Turn it by flipped(), in a case by flip = true",
        )
    arm = moments[1:4] / volume
    xx, yy, zz, xy, yz, xz = moments[4:]
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # Parallel axis theorem, from the origin to the centre.
    second -= volume * np.multiply.outer(arm, arm)
    inertia = density * (np.trace(second) * np.eye(3) - second)
    return MassProperties(density * volume, origin + arm, inertia)
