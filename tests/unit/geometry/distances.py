"""Distances to segments and triangles, written down."""

from __future__ import annotations

import numpy as np


def segment_distance(x, a, b):
    d = b - a
    square = np.maximum((d * d).sum(-1), 1e-300)
    t = np.clip(((x - a) * d).sum(-1) / square, 0.0, 1.0)
    return np.linalg.norm(x - a - t[..., None] * d, axis=-1)


def distance_to_triangle(x, a, b, c):
    """By plane and edges, unlike the package's own."""
    n = np.cross(b - a, c - a)
    size = np.linalg.norm(n, axis=-1, keepdims=True)
    n = n / np.maximum(size, 1e-300)
    height = ((x - a) * n).sum(-1)
    foot = x - height[..., None] * n
    inside = size[..., 0] > 0.0
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(q - p, foot - p) * n).sum(-1) >= 0.0
    edges = np.minimum(segment_distance(x, a, b), segment_distance(x, b, c))
    edges = np.minimum(edges, segment_distance(x, c, a))
    return np.where(inside, np.abs(height), edges)
