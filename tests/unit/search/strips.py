"""Strips of surface that bend as badly as bounds allow.

They turn by constant rates for a while, then by others: what is worst within bounds is of this
kind. Frames are kept as (…, 3) arrays; a step of the way turns them about one axis.
"""

from __future__ import annotations

import numpy as np


def turned(v, axis):
    """Vectors turned about `axis`, by its length."""
    angle = np.linalg.norm(axis, axis=-1, keepdims=True)
    n = axis / np.where(angle > 0.0, angle, 1.0)
    along = n * (n * v).sum(-1, keepdims=True)
    return along + np.cos(angle) * (v - along) + np.sin(angle) * np.cross(n, v)


def pieces(rng, n, steps, most=3):
    """Which of `most` pieces each of the steps of n ways is in; some ways have one piece only."""
    ends = np.sort(rng.uniform(0.0, 1.0, (n, most - 1)), axis=1)
    ends[rng.random(n) < 0.4] = 2.0
    return (np.linspace(0.0, 1.0, steps)[None, :, None] > ends[:, None]).sum(-1)


def geodesics(rng, n, inner, outer, length, steps=48):
    """Geodesics of surfaces whose normal curvatures lie between −outer and inner.

    From the origin, in the frame (T, b, N) = (x, y, z): points, T and N (n, steps + 1, 3).
    """
    part = pieces(rng, n, steps)
    angle = rng.uniform(0.0, np.pi, (n, 3))
    angle[rng.random((n, 3)) < 0.5] = 0.0
    ends = np.stack([inner, -outer], axis=-1)
    first, second = (np.take_along_axis(ends, rng.integers(0, 2, (n, 3)), 1) for _ in "ab")
    bend = first * np.cos(angle) ** 2 + second * np.sin(angle) ** 2
    twist = (second - first) * np.sin(angle) * np.cos(angle)
    frame = np.tile(np.eye(3), (n, 1, 1))
    h = length / steps
    x = np.zeros((n, steps + 1, 3))
    tangent, normal = np.empty_like(x), np.empty_like(x)
    rows = np.arange(n)
    for k in range(steps + 1):
        tangent[:, k], normal[:, k] = frame[:, 0], frame[:, 2]
        if k == steps:
            break
        i = part[:, k]
        axis = twist[rows, i, None] * frame[:, 0] - bend[rows, i, None] * frame[:, 1]
        middle = turned(frame, 0.5 * h[:, None, None] * axis[:, None])
        x[:, k + 1] = x[:, k] + h[:, None] * middle[:, 0]
        frame = turned(frame, h[:, None, None] * axis[:, None])
    return x, tangent, normal
