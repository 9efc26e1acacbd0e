"""Area of the image of facets on the master, whole or cut, from feet and normals in space.

The image of a facet's edge is the curve from foot to foot that is tangent to the surface at both:
a parabola in the plane of the chord and the normals (Nagata 2005, Computer Aided Geometric Design
22, Eq. 6, with the root of its determinant for arcs). Three such sides span a quadratic triangle,
whose area has an error of fourth order. The parameters (u, v) play no part: they are no chart of
the surface at a pole, across a seam or a border of patches.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.area.kernels.facet_area_nb import hand_over, polygon_of
from contiga.arrays.kernels.fma_nb import fma
from contiga.jit import inlined, inner, kernel

N_LANES = 16
THIRD = 1.0 / 3.0
# Gauss points of the triangle (barycentric), each with a third of its area.
NEAR, FAR = 2.0 / 3.0, 1.0 / 6.0
# Square of the sum of two normals below which the image is torn: they are a right angle apart.
MIN_SUM2 = 2.0
# Prevents a division by zero for opposite normals, whose result is discarded.
TINY = 1e-30


@inlined()
def _dot(a, b):
    return fma(a[2], b[2], fma(a[1], b[1], a[0] * b[0]))


@inlined()
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined()
def _difference(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined()
def _plus(a, t, b):
    """Return a + t b of two vectors."""
    return fma(t, b[0], a[0]), fma(t, b[1], a[1]), fma(t, b[2], a[2])


@inlined()
def _sag(side, m, change):
    """Return the factor of m that leads from the middle of a chord to that of its image.

    With m = n_a + n_b and q = (n_b − n_a)·(p_b − p_a) it is q/(2|m| (2 + |m|)): exact for an arc.
    """
    square = _dot(m, m) + TINY
    return 0.5 * _dot(change, side) / fma(2.0, math.sqrt(square), square)


@inlined()
def _density(ab, ac, sags, x, y):
    """Return ½ |∂X/∂x × ∂X/∂y| of the quadratic triangle X at barycentric (1 − x − y, x, y).

    Its mean over the triangle is the area of the image; without sags it is the area of the flat
    triangle everywhere. `ab` and `ac` are two sides, `sags` the sags of the sides ab, bc and ca.
    """
    z = 1.0 - x - y
    d, e, f = sags
    u = _plus(_plus(ab, 4.0 * (z - x), d), 4.0 * y, _difference(e, f))
    v = _plus(_plus(ac, 4.0 * (z - y), f), 4.0 * x, _difference(e, d))
    n_x = fma(u[1], v[2], -u[2] * v[1])
    n_y = fma(u[2], v[0], -u[0] * v[2])
    n_z = fma(u[0], v[1], -u[1] * v[0])
    return 0.5 * math.sqrt(_dot((n_x, n_y, n_z), (n_x, n_y, n_z)))


@inlined()
def _shares(points, normals):
    """Return the integrals of three feet's linear shape functions over their triangle's image.

    If normals are more than a right angle apart, as over a thin edge, the image is torn, and the
    plane triangle replaces it. There are no branches, so that a loop of these is vectorised.
    """
    a, b, c = points
    n_a, n_b, n_c = normals
    ab = _difference(b, a)
    bc = _difference(c, b)
    ca = _difference(a, c)
    m_d = _sum(n_a, n_b)
    m_e = _sum(n_b, n_c)
    m_f = _sum(n_c, n_a)
    smooth = (_dot(m_d, m_d) > MIN_SUM2) & (_dot(m_e, m_e) > MIN_SUM2) & (_dot(m_f, m_f) > MIN_SUM2)
    d = _sag(ab, m_d, _difference(n_b, n_a))
    e = _sag(bc, m_e, _difference(n_c, n_b))
    f = _sag(ca, m_f, _difference(n_a, n_c))
    d = d if smooth else 0.0
    e = e if smooth else 0.0
    f = f if smooth else 0.0
    zero = (0.0, 0.0, 0.0)
    sags = (_plus(zero, d, m_d), _plus(zero, e, m_e), _plus(zero, f, m_f))
    ac = _difference(c, a)
    at_a = _density(ab, ac, sags, FAR, FAR)
    at_b = _density(ab, ac, sags, NEAR, FAR)
    at_c = _density(ab, ac, sags, FAR, NEAR)
    all_three = FAR * (at_a + at_b + at_c)
    # The shape function is NEAR at its own Gauss point and FAR at the others: FAR and a half.
    return (
        THIRD * fma(0.5, at_a, all_three),
        THIRD * fma(0.5, at_b, all_three),
        THIRD * fma(0.5, at_c, all_three),
    )


@inlined()
def _row(rows, i):
    return rows[i, 0], rows[i, 1], rows[i, 2]


@inlined()
def _lane(lanes, k, l):
    return lanes[k, l], lanes[k + 1, l], lanes[k + 2, l]


@inner(error_model="numpy")
def _block_shares(lanes):
    """Write the shares of the facets of all lanes into the first three rows of `lanes`.

    Rows 0 to 8 hold the feet of the three corners, rows 9 to 17 the normals.
    """
    for l in range(N_LANES):
        points = (_lane(lanes, 0, l), _lane(lanes, 3, l), _lane(lanes, 6, l))
        normals = (_lane(lanes, 9, l), _lane(lanes, 12, l), _lane(lanes, 15, l))
        a, b, c = _shares(points, normals)
        lanes[0, l] = a
        lanes[1, l] = b
        lanes[2, l] = c


@kernel()
def image_whole(corner, point, normal, share, start, stop):
    """Write the areas of the images of facets start … stop into `share` (m, 3), split to corners.

    `corner` (m, 3) are rows of the feet, `point` and `normal`. Blocks of sixteen, with the lanes'
    data next to each other, take 0.5 of the time of single facets.
    """
    lanes = np.zeros((18, N_LANES))
    for first in range(start, stop, N_LANES):
        n = min(N_LANES, stop - first)
        for l in range(n):
            for k in range(3):
                r = corner[first + l, k]
                for c in range(3):
                    lanes[3 * k + c, l] = point[r, c]
                    lanes[9 + 3 * k + c, l] = normal[r, c]
        _block_shares(lanes)
        for l in range(n):
            for k in range(3):
                share[first + l, k] = lanes[k, l]


@kernel()
def image_pieces(corner, feet, n_c, border, fraction, share, start, stop):
    """Write the areas in contact of the images of facets start … stop that are cut into `share`.

    They are split to the corners (m, 3); those out of contact hand theirs over. `fraction` is as in
    `facet_area_nb.cuts`. `feet` is a `Projection`: first the feet of the corners, of which the ones
    below n_c are in contact, then the feet on edges where they leave the surface; `border` (m, 3)
    is the row of each such edge among them, or −1.
    """
    point, normal = feet.point, feet.normal
    polygon = np.empty((4, 3))
    edge = np.empty(4, np.int64)
    inside = np.empty(3, np.bool_)
    p = np.empty((4, 3))
    n = np.empty((4, 3))
    for f in range(start, stop):
        for k in range(3):
            share[f, k] = 0.0
            inside[k] = corner[f, k] < n_c
        count = polygon_of(inside, fraction, f, polygon, edge)
        for i in range(count):
            r = corner[f, -1 - edge[i]] if edge[i] < 0 else border[f, edge[i]]
            if r >= 0:
                for c in range(3):
                    p[i, c] = point[r, c]
                    n[i, c] = normal[r, c]
            else:
                b = (edge[i] + 1) % 3
                ends = (corner[f, edge[i]], corner[f, b])
                _cut_foot(feet, ends, polygon[i, b], p[i], n[i])
        for j in range(1, count - 1):
            parts = _shares(
                (_row(p, 0), _row(p, j), _row(p, j + 1)), (_row(n, 0), _row(n, j), _row(n, j + 1))
            )
            for k in range(3):
                share[f, k] += (
                    parts[0] * polygon[0, k]
                    + parts[1] * polygon[j, k]
                    + parts[2] * polygon[j + 1, k]
                )
        hand_over(share[f], inside)


@inner()
def _cut_foot(feet, ends, t, p, n):
    """Write foot `p` (3,) and normal `n` (3,) of a cut, at the fraction `t` of an edge.

    `ends` are the rows of the feet of its ends.
    The foot lies above the chord as high as the image does, but along the normal there. Where the
    image is torn the normal is zero, so that the adjacent triangles are torn, too.
    """
    point, normal = feet.point, feet.normal
    a, b = ends
    s = 1.0 - t
    m = _sum(_row(normal, a), _row(normal, b))
    smooth = _dot(m, m) > MIN_SUM2
    side = _difference(_row(point, b), _row(point, a))
    height = 0.0
    if smooth:
        height = 4.0 * s * t * _sag(side, m, _difference(_row(normal, b), _row(normal, a)))
    square = 0.0
    m_n = 0.0
    for c in range(3):
        p[c] = s * point[a, c] + t * point[b, c]
        n[c] = s * normal[a, c] + t * normal[b, c] if smooth else 0.0
        square += n[c] * n[c]
        m_n += m[c] * n[c]
    if smooth:
        for c in range(3):
            p[c] += height * m_n / square * n[c]
            n[c] /= math.sqrt(square)
