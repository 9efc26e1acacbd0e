"""Ellipsoids as NURBS surfaces, and the feet of points on them by one equation."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.records import FloatArray


def ellipsoid(axes: tuple[float, float, float]) -> cg.NurbsSurface:
    """About the origin, its poles on z."""
    ball = cg.shapes.sphere(radius=1.0)
    return cg.NurbsSurface(ball.degrees, ball.knots, ball.control_points * axes, ball.weights)


def feet(points: FloatArray, axes: tuple[float, float, float]) -> tuple[FloatArray, FloatArray]:
    """Feet and outward normals of points near the z axis, not deeper than the focal surface.

    Foot i is a²p/(a² + t), t the largest root of Σ (a p/(a² + t))² = 1 (Eberly, Distance from a
    point to an ellipsoid), from the left by Newton's method, for Σ is convex there.
    """
    square = np.array(axes) ** 2
    t = axes[2] * np.abs(points[:, 2]) - square[2]
    for _ in range(60):
        share = square / (square + t[:, None])
        value = ((share * points) ** 2 / square).sum(axis=1) - 1.0
        slope = -2.0 * (share**3 * (points / square) ** 2).sum(axis=1)
        t = t - value / slope
    normal = points / (square + t[:, None])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return square * points / (square + t[:, None]), normal
