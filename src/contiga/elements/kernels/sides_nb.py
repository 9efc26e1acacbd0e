"""Points and normals along the sides of elements."""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

N_SAMPLES = 5
COLLAPSE_RATIO = 1e-14
"""Squared ratio of tangent to twist below which a side is a point, unless the element is expanded
about its pole and the tangent is exact."""


@kernel(linked=True)
def side_point(side, x):
    """Return the local (s, t) of the point x in [-1/2, 1/2] along a side.

    Sides 0 to 3 are s = -1/2, s = 1/2, t = -1/2 and t = 1/2.
    """
    if side == 0:
        return -0.5, x
    if side == 1:
        return 0.5, x
    if side == 2:
        return x, -0.5
    return x, 0.5


@inner()
def _unit_cross(h, a, b, sign):
    """Return the unit vector along sign · h[:, a] × h[:, b]; zero if the two are parallel.

    Parallel: the sine of their angle is at most 1e-14.
    """
    x = h[1, a] * h[2, b] - h[2, a] * h[1, b]
    y = h[2, a] * h[0, b] - h[0, a] * h[2, b]
    z = h[0, a] * h[1, b] - h[1, a] * h[0, b]
    length = math.sqrt(x * x + y * y + z * z)
    if length <= 1e-14 * math.sqrt(_square(h, a) * _square(h, b)) or length == 0.0:
        return 0.0, 0.0, 0.0
    return sign * x / length, sign * y / length, sign * z / length


@inner()
def _square(h, a):
    return h[0, a] ** 2 + h[1, a] ** 2 + h[2, a] ** 2


@inner(linked=False)
def normal_at(elements, e, s, t, h):
    """Return the unit normal at (s, t), and write the derivatives there to `h` (4, 6).

    At a side t = ±1/2 that is one point S_s vanishes and S_s ≈ (t ∓ 1/2) S_st: the limit of the
    normal from inside is along ∓ S_st × S_t. At a side s = ±1/2 S_t vanishes, and it is along
    ∓ S_s × S_st. Zero if that vanishes, too.
    """
    evaluate(elements, e, s, t, h)
    about = elements.table[e]["about"]
    m = _square(h, 4)
    if _square(h, 1) <= (0.0 if about[1] != 0.0 else COLLAPSE_RATIO * m):
        return _unit_cross(h, 4, 2, 1.0 if t < 0.0 else -1.0)
    if _square(h, 2) <= (0.0 if about[0] != 0.0 else COLLAPSE_RATIO * m):
        return _unit_cross(h, 1, 4, 1.0 if s < 0.0 else -1.0)
    return _unit_cross(h, 1, 2, 1.0)


@kernel()
def sample(elements):
    """Return points and unit normals (n, 4, 5, 3) at even places of the sides of every element.

    They are in body axes. A normal is zero where the surface has none.
    """
    n = elements.table.shape[0]
    points = np.empty((n, 4, N_SAMPLES, 3))
    normals = np.empty((n, 4, N_SAMPLES, 3))
    h = scratch(4, 6)
    for e in range(n):
        for side in range(4):
            for k in range(N_SAMPLES):
                s, t = side_point(side, k / (N_SAMPLES - 1) - 0.5)
                normal = normal_at(elements, e, s, t, h)
                for c in range(3):
                    normals[e, side, k, c] = normal[c]
                    points[e, side, k, c] = h[c, 0] + elements.table[e]["origin"][c]
    return points, normals
