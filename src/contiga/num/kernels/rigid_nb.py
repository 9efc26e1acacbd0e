"""Rigid motion of many points: the same bits whatever the number of threads or rows."""

from __future__ import annotations

import contiga.num.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.num.jit import kernel


@kernel()
def to_body(points, pose, out, start, stop):
    """Rᵀ (p − t) of points start … stop for a (4, 4) pose."""
    for k in range(start, stop):
        x = points[k, 0] - pose[0, 3]
        y = points[k, 1] - pose[1, 3]
        z = points[k, 2] - pose[2, 3]
        for c in range(3):
            out[k, c] = pose[0, c] * x + pose[1, c] * y + pose[2, c] * z


@kernel()
def to_world(points, pose, shift, out, start, stop):
    """R p + t of points start … stop for a (4, 4) pose; R p where `shift` is 0."""
    for k in range(start, stop):
        for c in range(3):
            out[k, c] = (
                pose[c, 0] * points[k, 0]
                + pose[c, 1] * points[k, 1]
                + pose[c, 2] * points[k, 2]
                + shift * pose[c, 3]
            )
