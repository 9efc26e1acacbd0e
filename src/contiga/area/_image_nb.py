"""The image of facets on the master, whole or cut, measured in space from feet and normals.

The image of a facet's edge is the curve from foot to foot that leaves either in its tangent plane:
a parabola in the plane of the chord and the normals (Nagata 2005, Computer Aided Geometric Design
22, Eq. 6, with the root of its determinant for arcs). Three such sides span the quadratic triangle
that is measured, with an error of fourth order. Nothing is asked of the parameters, which are no
map of the surface at a pole, across a seam or a border of patches.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.area._facet_nb import hand_over, polygon_of

THIRD = 1.0 / 3.0
# Gauss points of the triangle (barycentric), each with a third of its area.
NEAR, FAR = 2.0 / 3.0, 1.0 / 6.0
# The square of the sum of two normals below which the image is torn: they are a right angle apart.
TORN = 2.0
NO_SAG = ((0.0, 0.0, 0.0), False)


@njit(inline="always")
def _sag(point, normal, a, b):
    """From the middle of the chord of the feet a and b to that of its image; whether it is one.

    Along m = n_a + n_b by q m/(2|m| (2 + |m|)), q = (n_b − n_a)·(p_b − p_a): exact for an arc.
    """
    m_x = normal[a, 0] + normal[b, 0]
    m_y = normal[a, 1] + normal[b, 1]
    m_z = normal[a, 2] + normal[b, 2]
    square = m_x * m_x + m_y * m_y + m_z * m_z
    if not square > TORN:
        return NO_SAG
    q = (
        (normal[b, 0] - normal[a, 0]) * (point[b, 0] - point[a, 0])
        + (normal[b, 1] - normal[a, 1]) * (point[b, 1] - point[a, 1])
        + (normal[b, 2] - normal[a, 2]) * (point[b, 2] - point[a, 2])
    )
    scale = 0.5 * q / (2.0 * math.sqrt(square) + square)
    return (scale * m_x, scale * m_y, scale * m_z), True


@njit(inline="always")
def _density(ab, ac, sags, x, y):
    """Area element, in units of the triangle's own, at the barycentric (1 − x − y, x, y).

    `ab` and `ac` are two sides, `sags` those of the sides ab, bc and ca.
    """
    z = 1.0 - x - y
    d, e, f = sags
    u_x = ab[0] + 4.0 * ((z - x) * d[0] + y * (e[0] - f[0]))
    u_y = ab[1] + 4.0 * ((z - x) * d[1] + y * (e[1] - f[1]))
    u_z = ab[2] + 4.0 * ((z - x) * d[2] + y * (e[2] - f[2]))
    v_x = ac[0] + 4.0 * (x * (e[0] - d[0]) + (z - y) * f[0])
    v_y = ac[1] + 4.0 * (x * (e[1] - d[1]) + (z - y) * f[1])
    v_z = ac[2] + 4.0 * (x * (e[2] - d[2]) + (z - y) * f[2])
    n_x = u_y * v_z - u_z * v_y
    n_y = u_z * v_x - u_x * v_z
    n_z = u_x * v_y - u_y * v_x
    return 0.5 * math.sqrt(n_x * n_x + n_y * n_y + n_z * n_z)


@njit(inline="always")
def _side(point, a, b):
    return point[b, 0] - point[a, 0], point[b, 1] - point[a, 1], point[b, 2] - point[a, 2]


@njit(inline="always")
def _shares(point, normal, a, b, c):
    """Integrals of the linear shape functions of a, b and c over the image of their triangle.

    Where normals are more than a right angle apart the image is torn, over a thin edge say, and
    that of the plane triangle is taken.
    """
    ab = _side(point, a, b)
    ac = _side(point, a, c)
    d, one_d = _sag(point, normal, a, b)
    e, one_e = _sag(point, normal, b, c)
    f, one_f = _sag(point, normal, c, a)
    if not (one_d and one_e and one_f):
        d = e = f = NO_SAG[0]
    sags = (d, e, f)
    one = _density(ab, ac, sags, FAR, FAR)
    two = _density(ab, ac, sags, NEAR, FAR)
    three = _density(ab, ac, sags, FAR, NEAR)
    all_three = FAR * (one + two + three)
    # NEAR and FAR at the point of each; NEAR is FAR and a half.
    return (
        THIRD * (all_three + 0.5 * one),
        THIRD * (all_three + 0.5 * two),
        THIRD * (all_three + 0.5 * three),
    )


@njit(cache=True, nogil=True)
def image_whole(corner, point, normal, share, start, stop):
    """Areas of the images of facets start … stop (corners among the feet), split to the corners."""
    for f in range(start, stop):
        a, b, c = _shares(point, normal, corner[f, 0], corner[f, 1], corner[f, 2])
        share[f, 0] = a
        share[f, 1] = b
        share[f, 2] = c


@njit(cache=True, nogil=True)
def image_pieces(corner, feet, sides, fraction, share, start, stop):
    """As `image_whole`, for the parts of facets that are cut at the edge of contact.

    `feet` is (points, normals), `sides` (n_c, row of each border edge among the feet or −1
    (m, 3)); the corners below n_c are in contact.
    """
    point, normal = feet
    n_c, row = sides
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
            r = corner[f, -1 - edge[i]] if edge[i] < 0 else row[f, edge[i]]
            if r >= 0:
                for c in range(3):
                    p[i, c] = point[r, c]
                    n[i, c] = normal[r, c]
            else:
                b = (edge[i] + 1) % 3
                ends = (corner[f, edge[i]], corner[f, b])
                _between(point, normal, ends, polygon[i, b], p[i], n[i])
        for j in range(1, count - 1):
            parts = _shares(p, n, 0, j, j + 1)
            for k in range(3):
                share[f, k] += (
                    parts[0] * polygon[0, k]
                    + parts[1] * polygon[j, k]
                    + parts[2] * polygon[j + 1, k]
                )
        hand_over(share[f], inside)


@njit(cache=True)
def _between(point, normal, ends, t, p, n):
    """Foot and normal of a cut, the share `t` of the way along an edge.

    The foot lies above the chord as high as the image does, but along the normal there. Where the
    image is torn the normal is zero, and tears what lies beside it.
    """
    a, b = ends
    s = 1.0 - t
    sag, one = _sag(point, normal, a, b)
    square = 0.0
    high = 0.0
    for c in range(3):
        p[c] = s * point[a, c] + t * point[b, c]
        n[c] = s * normal[a, c] + t * normal[b, c] if one else 0.0
        square += n[c] * n[c]
        high += sag[c] * n[c]
    if one:
        size = math.sqrt(square)
        for c in range(3):
            n[c] /= size
            p[c] += 4.0 * s * t * (high / size) * n[c]
