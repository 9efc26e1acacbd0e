"""Rigid motion of many points: the same bits whatever the number of threads or rows.

Points are read and written as numbers in a row, as which compilers see three axes at once.
"""

from __future__ import annotations

import contiga.num.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.num.jit import kernel


@kernel()
def to_body(points, pose, out, start, stop):
    """Rᵀ (p − t) of points start … stop for a (4, 4) pose."""
    own, turned = points[start:stop].reshape(-1), out[start:stop].reshape(-1)
    x0, x1, x2, tx = pose[0]
    y0, y1, y2, ty = pose[1]
    z0, z1, z2, tz = pose[2]
    for k in range(own.shape[0] // 3):
        x, y, z = own[3 * k] - tx, own[3 * k + 1] - ty, own[3 * k + 2] - tz
        turned[3 * k] = x0 * x + y0 * y + z0 * z
        turned[3 * k + 1] = x1 * x + y1 * y + z1 * z
        turned[3 * k + 2] = x2 * x + y2 * y + z2 * z


@kernel()
def to_world(points, pose, shift, out, start, stop):
    """R p + t of points start … stop for a (4, 4) pose; R p where `shift` is 0."""
    own, turned = points[start:stop].reshape(-1), out[start:stop].reshape(-1)
    x0, x1, x2, tx = pose[0]
    y0, y1, y2, ty = pose[1]
    z0, z1, z2, tz = pose[2]
    for k in range(own.shape[0] // 3):
        x, y, z = own[3 * k], own[3 * k + 1], own[3 * k + 2]
        turned[3 * k] = x0 * x + x1 * y + x2 * z + shift * tx
        turned[3 * k + 1] = y0 * x + y1 * y + y2 * z + shift * ty
        turned[3 * k + 2] = z0 * x + z1 * y + z2 * z + shift * tz
