"""Compute the velocities of points against a body: one pass over them."""

from __future__ import annotations

import math

from contiga.jit import inner, kernel


@inner()
def is_finite_row(rows, k):
    """Return whether row k of (n, 3) has three finite numbers."""
    return math.isfinite(rows[k, 0]) and math.isfinite(rows[k, 1]) and math.isfinite(rows[k, 2])


@kernel()
def first_without_velocity(velocity, points):
    """Return the first of the n points whose velocity (n, 3) is not finite; −1 if none.

    Points that are not finite need no velocity.
    """
    for k in range(velocity.shape[0]):
        if not is_finite_row(velocity, k) and is_finite_row(points, k):
            return k
    return -1


@kernel()
def relative(velocity, points, pose, twist, out, start, stop):
    """Write Rᵀ (v − v_B − ω × (p − t)) of points start … stop, body axes, to rows of `out`.

    `velocity` v and `points` p (m, 3) are in world axes; `pose` (4, 4) and `twist` (2, 3), its
    (v_B, ω), are those of the body.
    """
    bx, by, bz = twist[0, 0], twist[0, 1], twist[0, 2]
    wx, wy, wz = twist[1, 0], twist[1, 1], twist[1, 2]
    for k in range(start, stop):
        rx, ry, rz = points[k, 0] - pose[0, 3], points[k, 1] - pose[1, 3], points[k, 2] - pose[2, 3]
        x = velocity[k, 0] - (bx + (wy * rz - wz * ry))
        y = velocity[k, 1] - (by + (wz * rx - wx * rz))
        z = velocity[k, 2] - (bz + (wx * ry - wy * rx))
        for c in range(3):
            out[k, c] = pose[0, c] * x + pose[1, c] * y + pose[2, c] * z
