"""Facets that touch in part: their cut at the edge of contact, and the area of what is left."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._element_nb import evaluate, locate

OK = 0
# Cut of an edge whose outer end lies inside without being in contact: each end keeps its half.
HALF = 0.5
# Share by which the chord between two feet may miss the tangents' before (u, v) is not trusted.
STRAY = 0.5


@njit(cache=True, nogil=True)
def cuts(corner, feet, n_c, fraction):
    """Where contact ends on the edges of the facets, by the signed gap at their ends.

    `corner` is (m, 3) indices of the corners, those below n_c in contact. `fraction` (m, 3) is
    filled for edge k (corner k to k + 1) with the way from its end in contact. Returns the edges
    (facet*3 + k) on which the foot leaves the surface, whose cut must be searched for.
    """
    border = np.empty(3 * corner.shape[0], np.int64)
    n = 0
    for f in range(corner.shape[0]):
        for k in range(3):
            a = corner[f, k]
            b = corner[f, (k + 1) % 3]
            fraction[f, k] = 1.0
            if (a < n_c) == (b < n_c):
                continue
            if b < n_c:
                a, b = b, a
            if feet.status[b] != OK:
                border[n] = 3 * f + k
                n += 1
            elif feet.gap[b] > 0.0:
                depth = max(-feet.gap[a], 0.0)
                fraction[f, k] = depth / (depth + feet.gap[b])
            else:
                fraction[f, k] = HALF
    return border[:n].copy()


@njit(cache=True)
def _polygon(inside, fraction, f, polygon, edge):
    """Corners of the part in contact: barycentric coordinates, and the edge each is cut from."""
    n = 0
    for k in range(3):
        if inside[k]:
            polygon[n, :] = 0.0
            polygon[n, k] = 1.0
            edge[n] = -1 - k
            n += 1
        l = (k + 1) % 3
        if inside[k] != inside[l]:
            t = fraction[f, k] if inside[k] else 1.0 - fraction[f, k]
            polygon[n, :] = 0.0
            polygon[n, k] = 1.0 - t
            polygon[n, l] = t
            edge[n] = k
            n += 1
    return n


@njit(cache=True)
def _hand_over(share, inside):
    """Give the shares of corners that are not in contact to those that are."""
    kept = 0.0
    lost = 0.0
    count = 0
    for k in range(3):
        if inside[k]:
            kept += share[k]
            count += 1
        else:
            lost += share[k]
            share[k] = 0.0
    for k in range(3):
        if inside[k]:
            share[k] += lost * (share[k] / kept if kept > 0.0 else 1.0 / count)


@njit(cache=True, nogil=True)
def slave_pieces(nodes, points, corner, n_c, fraction, share, start, stop):
    """Area in contact of facets start … stop (corners `nodes`), split to the corners, into `share`.

    Each corner is given the integral of its linear shape function.
    """
    polygon = np.empty((4, 3))
    edge = np.empty(4, np.int64)
    inside = np.empty(3, np.bool_)
    for f in range(start, stop):
        area = triangle(points[nodes[f, 0]], points[nodes[f, 1]], points[nodes[f, 2]])
        for k in range(3):
            inside[k] = corner[f, k] < n_c
            share[f, k] = 0.0
        n = _polygon(inside, fraction, f, polygon, edge)
        for j in range(1, n - 1):
            part = area * abs(_determinant(polygon[0], polygon[j], polygon[j + 1]))
            for k in range(3):
                share[f, k] += part * (polygon[0, k] + polygon[j, k] + polygon[j + 1, k]) / 3.0
        _hand_over(share[f], inside)


@njit(cache=True)
def triangle(a, b, c):
    """Area of a triangle in space."""
    x1, y1, z1 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x2, y2, z2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x = y1 * z2 - z1 * y2
    y = z1 * x2 - x1 * z2
    z = x1 * y2 - y1 * x2
    return 0.5 * math.sqrt(x * x + y * y + z * z)


@njit(cache=True)
def _determinant(a, b, c):
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


@njit(cache=True, nogil=True)
def master_pieces(tables, corner, feet, sides, fraction, share, start, stop):
    """As `slave_pieces`, for the images of the parts on the master.

    `sides` is (n_c, row of each border edge or −1 (m, 3), feet of the border edges). The Jacobian
    is integrated over the image in (u, v); where that has no one image (a seam, two patches, a
    pole), the plane triangle of the feet takes its place.
    """
    n_c, row, ends = sides
    polygon = np.empty((4, 3))
    edge = np.empty(4, np.int64)
    inside = np.empty(3, np.bool_)
    uv = np.empty((4, 2))
    foot = np.empty((4, 3))
    patch = np.empty(4, np.int64)
    h = np.empty((4, 6))
    for f in range(start, stop):
        share[f, :] = 0.0
        for k in range(3):
            inside[k] = corner[f, k] < n_c
        n = _polygon(inside, fraction, f, polygon, edge)
        for i in range(n):
            if edge[i] < 0:
                _copy_foot(feet, corner[f, -1 - edge[i]], uv[i], foot[i], patch, i)
            elif row[f, edge[i]] >= 0:
                _copy_foot(ends, row[f, edge[i]], uv[i], foot[i], patch, i)
            else:
                _between(feet, corner[f], edge[i], polygon[i], (uv[i], foot[i]), patch, i)
        for j in range(1, n - 1):
            _image(tables, (0, j, j + 1), (polygon, uv, foot, patch), share[f], h)
        _hand_over(share[f], inside)


@njit(cache=True)
def _copy_foot(feet, k, uv, foot, patch, i):
    patch[i] = feet.patch[k]
    for c in range(2):
        uv[c] = feet.uv[k, c]
    for c in range(3):
        foot[c] = feet.point[k, c]


@njit(cache=True)
def _between(feet, corner, k, weight, out, patch, i):
    """Foot of a cut, between those of the ends of its edge."""
    uv, foot = out
    a = corner[k]
    b = corner[(k + 1) % 3]
    s = weight[k]
    t = weight[(k + 1) % 3]
    patch[i] = feet.patch[a] if feet.patch[a] == feet.patch[b] else -1
    for c in range(2):
        uv[c] = s * feet.uv[a, c] + t * feet.uv[b, c]
    for c in range(3):
        foot[c] = s * feet.point[a, c] + t * feet.point[b, c]


@njit(cache=True)
def _image(tables, part, vertices, share, h):
    """Add the area of one triangle on the master to the shares of the facet's corners."""
    polygon, uv, foot, patch = vertices
    i, j, k = part
    flat = triangle(foot[i], foot[j], foot[k])
    du, dv = uv[j, 0] - uv[i, 0], uv[j, 1] - uv[i, 1]
    eu, ev = uv[k, 0] - uv[i, 0], uv[k, 1] - uv[i, 1]
    cell = 0.5 * abs(du * ev - dv * eu)
    whole = patch[i] >= 0 and patch[i] == patch[j] and patch[i] == patch[k] and cell > 0.0
    weights = np.empty(3)
    for g in range(3):
        if not whole:
            break
        a = 2.0 / 3.0 if g == 0 else 1.0 / 6.0
        b = 2.0 / 3.0 if g == 1 else 1.0 / 6.0
        c = 1.0 - a - b
        e, s, t = locate(
            tables.grid,
            patch[i],
            a * uv[i, 0] + b * uv[j, 0] + c * uv[k, 0],
            a * uv[i, 1] + b * uv[j, 1] + c * uv[k, 1],
        )
        evaluate(tables.elements, e, s, t, h)
        box = tables.elements.table[e]["box"]
        width = box[1] - box[0]
        height = box[3] - box[2]
        if g == 0 and (
            _strays(h, du / width, dv / height, foot[i], foot[j])
            or _strays(h, eu / width, ev / height, foot[i], foot[k])
        ):
            whole = False
        x = h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2]
        y = h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2]
        z = h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2]
        weights[g] = cell / 3.0 * math.sqrt(x * x + y * y + z * z) / (width * height)
    if not whole:
        weights[:] = flat / 3.0
    for g in range(3):
        a = 2.0 / 3.0 if g == 0 else 1.0 / 6.0
        b = 2.0 / 3.0 if g == 1 else 1.0 / 6.0
        for l in range(3):
            share[l] += weights[g] * (
                a * polygon[i, l] + b * polygon[j, l] + (1.0 - a - b) * polygon[k, l]
            )


@njit(cache=True)
def _strays(h, ds, dt, a, b):
    """Whether the step (ds, dt) along the tangents does not lead from foot a to foot b."""
    miss = 0.0
    way = 0.0
    for c in range(3):
        chord = b[c] - a[c]
        miss += (h[c, 1] * ds + h[c, 2] * dt - chord) ** 2
        way += chord * chord
    return miss > STRAY * STRAY * way


@njit(cache=True, nogil=True)
def slave_whole(rows, points, corner, share, start, stop):
    """Areas of facets start … stop that touch as a whole, split to the corners."""
    for f in range(start, stop):
        share[f, :] = (
            triangle(
                points[rows[corner[f, 0]]], points[rows[corner[f, 1]]], points[rows[corner[f, 2]]]
            )
            / 3.0
        )


@njit(cache=True, nogil=True)
def gather(corner, share, area):
    """Add the shares of facets' corners to the nodal areas (n_c,), in order."""
    for f in range(corner.shape[0]):
        for k in range(3):
            if corner[f, k] < area.shape[0]:
                area[corner[f, k]] += share[f, k]
