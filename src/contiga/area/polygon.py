"""Area of a surface over a convex polygon in (u, v)."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import product
from contiga.errors import GeometryError
from contiga.geometry.quadrature import gauss
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

RTOL = 1e-12
# Rounding of the corners of triangles, as a share of the domain.
SLIVER_TOL = 1e-15
MAX_LEVELS = 12


def plane_area(polygon: FloatArray) -> float:
    """Return the area of a polygon (n, 2) in its own plane, positive if it is anticlockwise."""
    if len(polygon) < 3:
        return 0.0
    x, y = (polygon - polygon[0]).T
    return 0.5 * float(product(x, np.roll(y, -1)) - product(y, np.roll(x, -1)))


def area_over(surface: NurbsSurface, polygon: FloatArray, periods: tuple[float, float]) -> float:
    """Return the area ∫ |S_u × S_v| du dv over a convex polygon.

    The polygon is cut along the knots, where the integrand has kinks, and the pieces into
    triangles; each gets a Gauss rule, and is quartered until the four parts agree with the whole,
    `MAX_LEVELS` times at most. They agree within `RTOL` of the area over the root of the number of
    triangles, more for slivers. Without three corners the area is zero.

    Parameters
    ----------
    surface : the patch
    polygon : (n, 2) corners in (u, v), anticlockwise
    periods : length of the domain in u and v if the surface is closed in that direction, so that
        the polygon may reach beyond the domain; else 0

    Raises
    ------
    GeometryError
        The polygon leaves the domain in a direction without a period.
    """
    if len(polygon) < 3:
        return 0.0
    triangles = _triangulated(surface, polygon, periods)
    if len(triangles) == 0:
        return 0.0
    count = max(surface.degrees) + 5
    value = _integrals(surface, triangles, periods, count)
    scale = value.sum()
    # Feet on a line make slivers as wide as rounding: no rule agrees on their areas.
    (u0, u1), (v0, v1) = surface.domain
    span = float((np.ptp(polygon, axis=0) / (u1 - u0, v1 - v0)).sum())
    tol = max(RTOL * scale, SLIVER_TOL * span * surface.net_area())
    total = 0.0
    for _ in range(MAX_LEVELS):
        a, b, c = np.moveaxis(triangles, 1, 0)
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        parts = np.stack([np.stack(q, axis=1) for q in quarters], axis=1)
        fine = _integrals(surface, parts.reshape(-1, 3, 2), periods, count).reshape(-1, 4)
        agrees = np.abs(fine.sum(axis=1) - value) <= tol / np.sqrt(len(value))
        total += float(fine[agrees].sum())
        triangles, value = parts[~agrees].reshape(-1, 3, 2), fine[~agrees].ravel()
        if len(value) == 0:
            return total
    return total + float(value.sum())


def closing(surface: NurbsSurface) -> tuple[float, float]:
    """Return the lengths of the domain in u and in v, each 0 if the surface is not closed that way.

    A surface is closed in a direction if nine points of opposite sides coincide within 1e-9 of its
    largest extent.
    """
    (u0, u1), (v0, v1) = surface.domain
    s = np.linspace(0.0, 1.0, 9)
    u, v = u0 + (u1 - u0) * s, v0 + (v1 - v0) * s
    tol = 1e-9 * float(np.ptp(surface.bounds(), axis=0).max())

    def coincide(side: FloatArray, opposite: FloatArray) -> bool:
        return bool(np.abs(surface.evaluate(side) - surface.evaluate(opposite)).max() <= tol)

    in_u = coincide(np.column_stack([0 * v + u0, v]), np.column_stack([0 * v + u1, v]))
    in_v = coincide(np.column_stack([u, 0 * u + v0]), np.column_stack([u, 0 * u + v1]))
    return (u1 - u0) * in_u, (v1 - v0) * in_v


def _triangulated(
    surface: NurbsSurface, polygon: FloatArray, periods: tuple[float, float]
) -> FloatArray:
    """Return (m, 3, 2) triangles of the polygon that cross no knot line, nor a seam."""
    pieces = [polygon]
    for axis, period in enumerate(periods):
        low, high = polygon[:, axis].min(), polygon[:, axis].max()
        knots = np.unique(surface.knots[axis])
        if period > 0.0:
            knots = np.unique(np.concatenate([knots + k * period for k in (-1.0, 0.0, 1.0)]))
        for knot in knots[(knots > low) & (knots < high)]:
            pieces = [
                part
                for piece in pieces
                for part in (_clipped(piece, axis, knot, 1.0), _clipped(piece, axis, knot, -1.0))
                if len(part) > 2
            ]
    fans = [
        np.stack([np.broadcast_to(p[0], p[1:-1].shape), p[1:-1], p[2:]], axis=1) for p in pieces
    ]
    return np.concatenate(fans) if fans else np.zeros((0, 3, 2))


def _clipped(polygon: FloatArray, axis: int, knot: float, sign: float) -> FloatArray:
    """Return the corners (k, 2) of a convex polygon clipped to sign * x[axis] ≤ sign * knot."""
    d = sign * (polygon[:, axis] - knot)
    corners = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if d[i] <= 0.0:
            corners.append(polygon[i])
        if (d[i] < 0.0 < d[j]) or (d[j] < 0.0 < d[i]):
            point = polygon[i] + d[i] / (d[i] - d[j]) * (polygon[j] - polygon[i])
            point[axis] = knot
            corners.append(point)
    return np.array(corners).reshape(-1, 2)


def _integrals(
    surface: NurbsSurface, triangles: FloatArray, periods: tuple[float, float], count: int
) -> FloatArray:
    """Return ∫ |S_u × S_v| du dv (m,) over triangles (m, 3, 2) by a collapsed Gauss rule.

    The rule is that of the square, `count` points each way, collapsed to a triangle. Raises
    `GeometryError` for triangles that leave the domain by more than rounding.
    """
    x, w = gauss(count)
    s, t = np.meshgrid(x, x, indexing="ij")
    bary = np.stack([(1 - s), s * (1 - t), s * t], -1).reshape(-1, 3)
    weight = (np.outer(w, w) * s).ravel()
    edge1, edge2 = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    double_area = np.abs(edge1[:, 0] * edge2[:, 1] - edge1[:, 1] * edge2[:, 0])
    uv = np.einsum("gk,mkc->mgc", bary, triangles)
    # A triangle lies between two knots, so that its middle gives the period it is in.
    middle = triangles.mean(axis=1)
    for axis, period in enumerate(periods):
        low, high = surface.domain[axis]
        if period > 0.0:
            uv[:, :, axis] -= (np.floor((middle[:, axis] - low) / period) * period)[:, None]
        slack = 1e-9 * (high - low)
        if uv[:, :, axis].min() < low - slack or uv[:, :, axis].max() > high + slack:
            raise GeometryError("the polygon leaves the surface", where="polygon")
        np.clip(uv[:, :, axis], low, high, out=uv[:, :, axis])
    d = surface.derivatives(uv.reshape(-1, 2), 1)
    density = np.linalg.norm(np.cross(d[:, 1, 0], d[:, 0, 1]), axis=1).reshape(uv.shape[:2])
    return product(density, weight) * double_area
