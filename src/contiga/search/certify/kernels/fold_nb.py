"""A crease and its two faces beside a foot: frames, and how far they turn along it.

Along a crease with unit tangent e, face i has the unit vector b_i, perpendicular to e and pointing
into it, and the normal N_i. Per length of the crease they turn by

    b_i' = −g_i e + t_i N_i,    |N_i'| ≤ κ_i,

g_i the geodesic curvature, no more than the curvature k of the crease as a curve in space, t_i the
geodesic torsion, no more than half the difference of the principal curvatures.
"""

from __future__ import annotations

import math

from contiga.arrays.kernels.vector_nb import cross, dot
from contiga.elements.kernels.sides_nb import normal_at, side_point
from contiga.jit import inner
from contiga.search.certify.certify_records import Curve, SideFrame
from contiga.search.certify.kernels.bend_nb import (
    INNER,
    OUTER,
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    principal,
)
from contiga.search.certify.kernels.rest_nb import D01, D02, D10, D20


@inner(error_model="numpy")
def side_frame(elements, e, side, x, h):
    """The `SideFrame` at the point x of a side."""
    s, t = side_point(side, x)
    normal = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    point = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    along, across = (2, 1) if side < 2 else (1, 2)
    sign = 1.0 if side & 1 == 0 else -1.0
    d = (h[0, along], h[1, along], h[2, along])
    length = 1.0 / math.sqrt(dot(d, d))
    tangent = (d[0] * length, d[1] * length, d[2] * length)
    b = cross(normal, tangent)
    if sign * (h[0, across] * b[0] + h[1, across] * b[1] + h[2, across] * b[2]) < 0.0:
        b = (-b[0], -b[1], -b[2])
    twice = along + along + 1  # 3 or 5
    c = (h[0, twice], h[1, twice], h[2, twice])
    part = dot(c, tangent)
    bent = (
        (c[0] - part * tangent[0]) * length * length,
        (c[1] - part * tangent[1]) * length * length,
        (c[2] - part * tangent[2]) * length * length,
    )
    return SideFrame(point, tangent, b, normal, bent, principal(h))


@inner(error_model="numpy")
def side_bend(bend, work, cell, side):
    """The `Curve` that a side of a cell is.

    `bend` and `work` are what `bend_bounds` has left of the cell. In parameters that run over
    [-1, 1] from the middle, C' = a + y c + R1 and C'' = c + R2 along the side, with rests no
    larger than kept in `work`; its curvature as a curve in space is |C' × C''|/|C'|³.
    """
    h, rest = work.derivatives, work.rest
    along, twice, r1, r2 = (2, 5, D01, D02) if side < 2 else (1, 3, D10, D20)
    half = 0.5 * (cell[3] - cell[2] if side < 2 else cell[1] - cell[0])
    least = bend[WIDTH_T if side < 2 else WIDTH_S] * half
    sign = 1.0 if side & 1 == 1 else -1.0
    a = (h[0, along] + sign * h[0, 4], h[1, along] + sign * h[1, 4], h[2, along] + sign * h[2, 4])
    c = (h[0, twice], h[1, twice], h[2, twice])
    x = cross(a, c)
    size_c = math.sqrt(dot(c, c))
    rest1, rest2 = rest[0, r1], rest[0, r2]
    most = math.sqrt(dot(x, x)) + (math.sqrt(dot(a, a)) + size_c + rest1) * rest2 + rest1 * size_c
    return Curve(c, rest2, least, most / least**3)


@inner(error_model="numpy")
def speed_along(bend, side):
    """Largest speed along a side."""
    return bend[SPEED_T if side < 2 else SPEED_S]


@inner(error_model="numpy")
def speed_across(bend, side):
    """Largest speed across a side."""
    return bend[SPEED_S if side < 2 else SPEED_T]


@inner(error_model="numpy")
def largest_bend(bend):
    """Largest normal curvature, either way."""
    return max(bend[INNER], bend[OUTER])
