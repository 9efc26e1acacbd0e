"""Points and normals along the sides of elements."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._element_nb import evaluate

SAMPLES = 5
INSET = 1e-7
"""How far inside the element a normal is taken where the side itself has none (a pole)."""


@njit(cache=True)
def side_point(side, x):
    """Local (s, t) of the point x in [-1/2, 1/2] along a side."""
    if side == 0:
        return -0.5, x
    if side == 1:
        return 0.5, x
    if side == 2:
        return x, -0.5
    return x, 0.5


@njit(cache=True)
def unit_normal(h):
    """Unit S_s × S_t of a table of derivatives; zero where the two are parallel."""
    x = h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2]
    y = h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2]
    z = h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2]
    length = math.sqrt(x * x + y * y + z * z)
    scale_s = math.sqrt(h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2)
    scale_t = math.sqrt(h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2)
    if length <= 1e-14 * scale_s * scale_t or length == 0.0:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@njit(cache=True)
def normal_at(elements, e, s, t, h):
    """Unit normal at (s, t), through the limit from inside where a side is collapsed.

    `h` holds the derivatives at (s, t) afterwards in any case.
    """
    evaluate(elements, e, s, t, h)
    x, y, z = unit_normal(h)
    if x == 0.0 and y == 0.0 and z == 0.0:
        evaluate(elements, e, s * (1.0 - 2.0 * INSET), t * (1.0 - 2.0 * INSET), h)
        x, y, z = unit_normal(h)
        evaluate(elements, e, s, t, h)
    return x, y, z


@njit(cache=True)
def sample(elements):
    """Points (n, 4, 5, 3) and unit normals along the four sides of every element."""
    n = elements.table.shape[0]
    points = np.empty((n, 4, SAMPLES, 3))
    normals = np.empty((n, 4, SAMPLES, 3))
    h = np.empty((4, 6))
    for e in range(n):
        for side in range(4):
            for k in range(SAMPLES):
                s, t = side_point(side, k / (SAMPLES - 1) - 0.5)
                x, y, z = normal_at(elements, e, s, t, h)
                normals[e, side, k] = (x, y, z)
                for c in range(3):
                    points[e, side, k, c] = h[c, 0] + elements.table[e]["origin"][c]
    return points, normals
