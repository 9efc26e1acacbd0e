"""Rigid motion of many points: the same bits whatever the number of threads or rows.

Points are read and written as numbers in a row, which compilers vectorise across the three axes.
"""

from __future__ import annotations

import math

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import kernel


@kernel()
def to_body(points, pose, out, start, stop):
    """Write Rᵀ (p − t) of rows start … stop − 1 of points (n, 3) into `out`; pose (4, 4)."""
    p, moved = points[start:stop].reshape(-1), out[start:stop].reshape(-1)
    x0, x1, x2, tx = pose[0]
    y0, y1, y2, ty = pose[1]
    z0, z1, z2, tz = pose[2]
    for k in range(p.shape[0] // 3):
        x, y, z = p[3 * k] - tx, p[3 * k + 1] - ty, p[3 * k + 2] - tz
        moved[3 * k] = x0 * x + y0 * y + z0 * z
        moved[3 * k + 1] = x1 * x + y1 * y + z1 * z
        moved[3 * k + 2] = x2 * x + y2 * y + z2 * z


@kernel()
def to_world(points, pose, shift, out, start, stop):
    """Write R p + shift t of rows start … stop − 1 of points (n, 3) into `out`; pose (4, 4)."""
    p, moved = points[start:stop].reshape(-1), out[start:stop].reshape(-1)
    x0, x1, x2, tx = pose[0]
    y0, y1, y2, ty = pose[1]
    z0, z1, z2, tz = pose[2]
    for k in range(p.shape[0] // 3):
        x, y, z = p[3 * k], p[3 * k + 1], p[3 * k + 2]
        moved[3 * k] = x0 * x + x1 * y + x2 * z + shift * tx
        moved[3 * k + 1] = y0 * x + y1 * y + y2 * z + shift * ty
        moved[3 * k + 2] = z0 * x + z1 * y + z2 * z + shift * tz


@kernel()
def is_rigid(pose, tolerance):
    """Return whether R Rᵀ = 1 to `tolerance`, det R ≥ 0, t is finite, the last row 0, 0, 0, 1.

    The tolerance holds for each entry; NaN fails.
    """
    determinant = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        determinant += pose[0, i] * (pose[1, j] * pose[2, k] - pose[1, k] * pose[2, j])
        if not (math.isfinite(pose[i, 3]) and pose[3, i] == 0.0):
            return False
        for row in range(i, 3):
            product = 0.0
            for c in range(3):
                product += pose[i, c] * pose[row, c]
            if not abs(product - (1.0 if i == row else 0.0)) <= tolerance:
                return False
    return determinant >= 0.0 and pose[3, 3] == 1.0


@kernel()
def add_wrench(wrench, point_B, pose, total):
    """Add a wrench (6,) about a point of a body to `total` (6,), in place.

    `total` is about the origin of the body's frame; both are in world axes. `point_B` (3,) is in
    the axes of the body, whose pose is (4, 4).
    """
    x, y, z = point_B[0], point_B[1], point_B[2]
    a = pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z
    b = pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z
    c = pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z
    total[0] += wrench[0]
    total[1] += wrench[1]
    total[2] += wrench[2]
    total[3] = total[3] + (b * wrench[2] - c * wrench[1]) + wrench[3]
    total[4] = total[4] + (c * wrench[0] - a * wrench[2]) + wrench[4]
    total[5] = total[5] + (a * wrench[1] - b * wrench[0]) + wrench[5]
