"""Point clouds: samples of a surface and random points.

>>> from contiga.geometry import shapes
>>> sample(shapes.plane(width=2.0, length=2.0), 3, 3)[:2].tolist()
[[-1.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import GeometryError, InputError
from contiga.geometry.slopes import first_derivative_bounds
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray
from contiga.rigid import transform

__all__ = ["random_in_box", "random_on", "sample"]

MAX_CLOUD_POINTS = 50_000_000
"""Largest number of points of a cloud; a larger one is treated as a typing error."""
_BATCH = 1024
# Parts of an element in each direction with bounds of their own: then few points are rejected.
_PARTS = 4


def sample(surface: NurbsSurface, nu: int, nv: int) -> FloatArray:
    """Return points (nu · nv, 3) at a tensor grid of parameters, ends included (section 5.1.3).

    They are in the order of u, then v. Raises the errors of `check_grid`. A seam or a pole of the
    surface is sampled as often as the grid meets it.
    """
    check_grid(nu, nv)
    (u0, u1), (v0, v1) = surface.domain
    u, v = np.linspace(u0, u1, nu), np.linspace(v0, v1, nv)
    return surface.evaluate(np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2))


def check_grid(nu: int, nv: int) -> None:
    """Raise an error for numbers of points along u and v that are no grid.

    Raises
    ------
    InputError
        A number is not whole or below 2, or both make more than `MAX_CLOUD_POINTS` points.
    """
    larger, name = max((_count(nu, "nu", 2), "nu"), (_count(nv, "nv", 2), "nv"))
    if int(nu) * int(nv) > MAX_CLOUD_POINTS:
        raise InputError(
            f"makes {float(nu) * float(nv):.3g} points",
            where=name,
            found=larger,
            allowed=f"at most {MAX_CLOUD_POINTS} points",
        )


def random_on(surface: NurbsSurface, n: int, *, seed: int = 0) -> FloatArray:
    """Return `n` random points (n, 3), uniform in the area of `surface`; the same for one seed.

    By rejection: a cell is drawn with a probability proportional to a rigorous bound on its area,
    and a point in it is accepted with the probability of its area element `|S_u × S_v|` over that
    bound. Nothing is approximated.

    Raises
    ------
    InputError
        The number is not whole, negative or above `MAX_CLOUD_POINTS`.
    GeometryError
        The surface has no area.
    """
    count = _count(n, "n", 0)
    if not surface.area(1e-3) > 0.0:
        raise GeometryError("the surface has no area to draw points from")
    rng = np.random.default_rng(seed)
    (bound_u, bound_v), u, v = first_derivative_bounds(surface, _PARTS)
    largest = bound_u * bound_v
    shares = largest / largest.sum()
    batches: list[FloatArray] = []
    missing = count
    while missing > 0:
        size = max(_BATCH, 2 * missing)
        cell = rng.choice(shares.size, size=size, p=shares.ravel())
        i, j = np.unravel_index(cell, shares.shape)
        uv = np.empty((size, 2))
        uv[:, 0] = u[i] + (u[i + 1] - u[i]) * rng.random(size)
        uv[:, 1] = v[j] + (v[j + 1] - v[j]) * rng.random(size)
        first = surface.derivatives(uv, 1)
        jacobian = np.linalg.norm(np.cross(first[:, 1, 0], first[:, 0, 1]), axis=1)
        area = jacobian * np.diff(u)[i] * np.diff(v)[j]
        accepted = uv[rng.random(size) * largest[i, j] < area][:missing]
        batches.append(surface.evaluate(accepted))
        missing -= len(accepted)
    return np.concatenate([np.zeros((0, 3)), *batches])


def random_in_box(lo: ArrayLike, hi: ArrayLike, n: int, *, seed: int = 0) -> FloatArray:
    """Return `n` random points (n, 3), uniform in the box from `lo` to `hi`; the same for one seed.

    Raises
    ------
    InputError
        The number is not whole, negative or above `MAX_CLOUD_POINTS`.
    GeometryError
        A corner is not three finite numbers, or `lo` is above `hi`.
    """
    low, high = transform.vector(lo, "lo"), transform.vector(hi, "hi")
    if (low > high).any():
        raise GeometryError(
            "the lower corner of a box must not be above the upper one",
            found=(low.tolist(), high.tolist()),
        )
    rng = np.random.default_rng(seed)
    return np.asarray(low + (high - low) * rng.random((_count(n, "n", 0), 3)))


def _count(value: int, name: str, minimum: int) -> int:
    """Return a number of points; InputError unless from `minimum` to `MAX_CLOUD_POINTS`."""
    good = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not good or not minimum <= value <= MAX_CLOUD_POINTS:
        raise InputError(
            "must be a whole number within limits",
            where=name,
            found=value,
            allowed=f"{minimum} or more, at most {MAX_CLOUD_POINTS}",
        )
    return int(value)
