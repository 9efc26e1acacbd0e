"""Area, volume and moments of a body with its trims: Green's theorem over exact p-curves.

The area of a trimmed patch is ``∮ F dv`` along its loops, ``F(u, v) = ∫ |S_u × S_v| du`` up to the
curve. Both integrals are cut at the borders of elements and at turning points, between which the
integrand is smooth, so Gauss rules converge at their full order; parts are halved until two
results agree. The divergence theorem makes a volume integral one over the faces:
``∫ f dV = ∮ f S · n dA / (k + 3)`` for f homogeneous of degree k.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from contiga.arrays.threads import map_threads
from contiga.geometry.bezier import extract
from contiga.geometry.faces_like import FacesLike
from contiga.geometry.kernel_records import AREA, FLUX, GaussRule
from contiga.geometry.kernels.trim_area_nb import add_loop, add_rectangle
from contiga.geometry.quadrature import gauss, surface_area
from contiga.geometry.trim import loop_pieces
from contiga.records import FloatArray

T = TypeVar("T")

MOMENTS = 10
"""Number of moments of degree 0, 1 and 2: 1, x, y, z, xx, yy, zz, xy, yz, xz."""
_DEGREE = np.repeat([0.0, 1.0, 2.0], [1, 3, 6])
MAX_PARTS = 64
"""Largest number of parts in each direction of an element."""
_EXTRA_POINTS, _SECOND_EXTRA = 4, 3
"""Points of the first rule beyond the degree, and of the second rule beyond the first."""


def body_area(body: FacesLike, rtol: float = 1e-9) -> float:
    """Return the area of `body`, trims obeyed, to about the relative tolerance `rtol`; length²."""
    return float(patch_areas(body, rtol).sum())


def body_volume(body: FacesLike, rtol: float = 1e-9) -> float:
    """Return the volume inside `body`, length³: ⅓ ∮ S · n dA, positive if normals point outward.

    S is taken from the middle of the bounds, which does not change a closed body's volume. An open
    body is not refused: its result is the volume of the cones from there over its faces.
    """
    return float(patch_volumes(body, body.bounds().mean(axis=0), rtol).sum())


def body_moments(body: FacesLike, origin: FloatArray, rtol: float = 1e-9) -> FloatArray:
    """Return moments (10,) about `origin` of the volume that `body` encloses.

    ∫ f dV of f = 1, x, y, z, xx, yy, zz, xy, yz, xz, positive if normals point outward; to about
    `rtol` in the scale of the body.
    """
    total = np.zeros(MOMENTS)
    for flux in _fluxes(body, origin, MOMENTS, rtol):
        total += flux
    return total / (_DEGREE + 3.0)


def patch_areas(body: FacesLike, rtol: float = 1e-9) -> FloatArray:
    """Return (m,) area of every patch of `body`, trims obeyed, to about `rtol` of each, length²."""

    def area(k: int) -> float:
        patch = body.patches[k]
        if body.trims[k] is None:
            return surface_area(patch, max(rtol, 1e-13))
        return float(_integral(body, k, patch.bounds().mean(axis=0), AREA, (np.zeros(1), rtol))[0])

    return np.array(_of_patches(body, area))


def patch_volumes(body: FacesLike, origin: FloatArray, rtol: float = 1e-9) -> FloatArray:
    """Return (m,) signed volume, length³, of the cone from `origin` over every patch, trims obeyed.

    Negative if the normals point to the origin.
    """
    return np.array(_fluxes(body, origin, 1, rtol))[:, 0] / 3.0


def _fluxes(body: FacesLike, origin: FloatArray, count: int, rtol: float) -> list[FloatArray]:
    """Return by patch the first `count` integrals ∮ f (S · n) dA, with S from `origin`.

    They are of the f of `body_moments`, in its order.
    """
    reach = np.abs(body.bounds() - origin).max()

    def flux(k: int) -> FloatArray:
        low, high = body.patches[k].bounds()
        floor = rtol * float(np.linalg.norm(high - low)) ** 3 * reach ** _DEGREE[:count]
        return _integral(body, k, origin, FLUX, (floor, rtol))

    return _of_patches(body, flux)


def _of_patches(body: FacesLike, value: Callable[[int], T]) -> list[T]:
    """Return `value` of every patch number, computed on several threads."""
    _ = body.trim_tables  # built once, before the threads use them
    return map_threads(value, range(len(body.patches)))


def _integral(
    body: FacesLike, k: int, origin: FloatArray, kind: int, stop: tuple[FloatArray, float]
) -> FloatArray:
    """Return integrals of a kind, AREA or FLUX, over patch `k`; halve parts until two rules agree.

    `stop` holds the largest absolute difference of the rules, by integral, and the relative one, of
    which ten times counts; the larger decides. With `MAX_PARTS` parts the finer rule's result is
    returned in any case.
    """
    floor, rtol = stop
    patch = body.patches[k]
    grid = extract(patch.translated(-origin))
    groups = loop_pieces(body.trim_tables, k) if body.trims[k] is not None else None

    def value(points: int, parts: int) -> FloatArray:
        rule = GaussRule(*gauss(points), parts, kind)
        out = np.zeros(len(floor))
        if groups is None:
            add_rectangle(grid, rule, out)
        for group in groups or ():
            add_loop(body.trim_tables, group, grid, rule, out)
        return out

    points = max(patch.degrees) + _EXTRA_POINTS
    parts = 1
    while True:
        # Two rules on the same parts cost half as much as one rule on halved parts.
        coarse, fine = value(points, parts), value(points + _SECOND_EXTRA, parts)
        close = np.maximum(10.0 * rtol * np.abs(fine), floor)
        if np.all(np.abs(fine - coarse) <= close) or parts >= MAX_PARTS:
            return fine
        parts *= 2
