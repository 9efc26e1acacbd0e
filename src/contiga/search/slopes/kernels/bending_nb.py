"""The second fundamental form in an orthonormal frame of the tangent plane."""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.element_nb import evaluate
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner

PARALLEL_TOL = 1e-14
"""Squared sine of the angle between S_s and S_t below which they span no plane."""
SIDE_PLACES = (-0.5, -0.3, 0.1)
"""Places along a pole's side at which three curves start: no two are opposite if the side makes
half a turn or a full one."""
POLE_RATIO = 1e-8
"""|S_s| over |S_t| below which a place counts as the pole: nearer to it, the rounding of the
curvature exceeds its change from there to the pole."""
DETERMINANT_TOL = 1e-9
"""Determinant below which the three curves are too similar to determine the curvature."""


@inner()
def _scaled(v, factor):
    return v[0] * factor, v[1] * factor, v[2] * factor


@inner()
def _pole_bending(elements, e, side, normal, h):
    """Return `bending` at a side that is one point, by the curvatures of three curves out of it.

    The curve across the side at x leaves the pole along its derivative d, and its normal curvature
    is its second derivative along the normal over |d|². Zeros if a derivative vanishes; the first
    curvature in all directions if the three curves are too similar.
    """
    first = 1 if side < 2 else 2
    q = p = (0.0, 0.0, 0.0)
    # Curvatures k_i = b11 c² + 2 b12 c s + b22 s², with the angles to the first curve (c = 1).
    k0 = c1 = s1 = k1 = c2 = s2 = k2 = 0.0
    for i in range(3):
        s, t = side_point(side, SIDE_PLACES[i])
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
    if abs(determinant) < DETERMINANT_TOL:
        return q, p, k0, 0.0, k0
    r1, r2 = k1 - k0 * c1 * c1, k2 - k0 * c2 * c2
    b12 = (r1 * s2 * s2 - r2 * s1 * s1) / determinant
    b22 = 2.0 * (c1 * s1 * r2 - c2 * s2 * r1) / determinant
    return q, p, k0, b12, b22


@inner(linked=False)
def bending(elements, foot, normal, h):
    """Return two orthonormal tangents at `foot` = (element, s, t), and b11, b12, b22 there.

    The three numbers (one per length) are the second fundamental form towards `normal` in these
    tangents; zeros if the patch has no tangent plane there. Afterwards `h` holds the derivatives at
    the foot, except at a pole.
    """
    e, s, t = foot
    evaluate(elements, e, s, t, h)
    d_s, d_t = column(h, 1), column(h, 2)
    a, b = math.sqrt(dot(d_s, d_s)), math.sqrt(dot(d_t, d_t))
    side = -1
    if a <= POLE_RATIO * b:
        side = 3 if t > 0.0 else 2
    elif b <= POLE_RATIO * a:
        side = 1 if s > 0.0 else 0
    if side >= 0 and elements.table[e]["kind"][side] == POLE:
        return _pole_bending(elements, e, side, normal, h)
    if a == 0.0 or b == 0.0:
        return d_s, d_t, 0.0, 0.0, 0.0
    q, d = _scaled(d_s, 1.0 / a), _scaled(d_t, 1.0 / b)
    p = cross(normal, q)
    c, s = dot(d, q), dot(d, p)
    if s * s < PARALLEL_TOL:
        return q, p, 0.0, 0.0, 0.0
    l11 = dot(column(h, 3), normal) / (a * a)
    l12 = dot(column(h, 4), normal) / (a * b)
    l22 = dot(column(h, 5), normal) / (b * b)
    return q, p, l11, (l12 - c * l11) / s, (l22 - 2.0 * c * l12 + c * c * l11) / (s * s)
