"""The second fundamental form in an orthonormal frame of the tangent plane."""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.element_nb import evaluate
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner

PARALLEL = 1e-14
"""Sine between S_s and S_t, squared, below which they span no plane."""
WAYS = (-0.5, -0.3, 0.1)
"""Where along the side the ways begin: no two are opposite in a side of half or a full turn."""
AT_POLE = 1e-8
"""|S_s| over |S_t| below which a place counts as the pole: nearer, rounding takes more from the
curvature than its change on the way there."""
ONE_WAY = 1e-9
"""Determinant below which three ways from a pole are too much alike to tell a curvature by."""


@inner()
def _scaled(v, factor):
    return v[0] * factor, v[1] * factor, v[2] * factor


@inner()
def _at_pole(elements, e, side, normal, h):
    """Do as `bending` where a whole side is one point: from the curvature of three ways out of it.

    The curve across the side at x leaves the pole along its derivative d, and bends towards the
    normal by its second derivative over |d|².
    """
    first = 1 if side < 2 else 2
    q = p = (0.0, 0.0, 0.0)
    # Curvatures k_i = b11 c² + 2 b12 c s + b22 s² of the angles to the first way, c = 1 there.
    k0 = c1 = s1 = k1 = c2 = s2 = k2 = 0.0
    for i in range(3):
        s, t = side_point(side, WAYS[i])
        evaluate(elements, e, s, t, h)
        d = column(h, first)
        square = dot(d, d)
        if square == 0.0:
            return q, p, 0.0, 0.0, 0.0
        k = dot(column(h, 3 if side < 2 else 5), normal) / square
        d = _scaled(d, 1.0 / math.sqrt(square))
        if i == 0:
            q, p, k0 = d, cross(normal, d), k
        elif i == 1:
            c1, s1, k1 = dot(d, q), dot(d, p), k
        else:
            c2, s2, k2 = dot(d, q), dot(d, p), k
    determinant = 2.0 * s1 * s2 * (c1 * s2 - c2 * s1)
    if abs(determinant) < ONE_WAY:
        return q, p, k0, 0.0, k0
    r1, r2 = k1 - k0 * c1 * c1, k2 - k0 * c2 * c2
    b12 = (r1 * s2 * s2 - r2 * s1 * s1) / determinant
    b22 = 2.0 * (c1 * s1 * r2 - c2 * s2 * r1) / determinant
    return q, p, k0, b12, b22


@inner(linked=False)
def bending(elements, foot, normal, h):
    """Two orthonormal vectors of the tangent plane at `foot` = (element, s, t), and the second
    fundamental form there towards `normal`: b11, b12, b22.

    `h` holds the derivatives at the foot afterwards, but for a pole. Zeros where the patch has no
    tangent plane there.
    """
    e, s, t = foot
    evaluate(elements, e, s, t, h)
    one, other = column(h, 1), column(h, 2)
    a, b = math.sqrt(dot(one, one)), math.sqrt(dot(other, other))
    side = -1
    if a <= AT_POLE * b:
        side = 3 if t > 0.0 else 2
    elif b <= AT_POLE * a:
        side = 1 if s > 0.0 else 0
    if side >= 0 and elements.table[e]["kind"][side] == POLE:
        return _at_pole(elements, e, side, normal, h)
    if a == 0.0 or b == 0.0:
        return one, other, 0.0, 0.0, 0.0
    q, d = _scaled(one, 1.0 / a), _scaled(other, 1.0 / b)
    p = cross(normal, q)
    c, s = dot(d, q), dot(d, p)
    if s * s < PARALLEL:
        return q, p, 0.0, 0.0, 0.0
    l11 = dot(column(h, 3), normal) / (a * a)
    l12 = dot(column(h, 4), normal) / (a * b)
    l22 = dot(column(h, 5), normal) / (b * b)
    return q, p, l11, (l12 - c * l11) / s, (l22 - 2.0 * c * l12 + c * c * l11) / (s * s)
