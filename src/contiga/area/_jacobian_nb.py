"""The Jacobian |S_u × S_v| at feet, and its integral over facets of them, whole or cut.

Feet are binned by element and taken sixteen at a time, as in tracking (`_lanes_nb` of the
search). One evaluation a node does for the six facets around it: a Gauss rule on every facet
takes ten times as long.

An image is what the facets need of a foot, in one line of memory: J, dJ/du, dJ/dv, u, v, x, y, z.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.area._facet_nb import hand_over, polygon_of
from contiga.num._fma_nb import fma
from contiga.search._element_nb import bicubic, evaluate, locate, quotient

LANES = 16
# Rows of the work array: s, t, then J, dJ/ds, dJ/dt.
ROWS = 5
# Numbers of an image.
IMAGE = 8
# The area by (u, v) over that of the plane triangle of the feet, squared: beyond these (a half and
# three halves) (u, v) is not trusted. It crosses a seam, say.
LEAST, MOST = 0.25, 2.25
THIRD = 1.0 / 3.0


@njit(inline="always")
def _cross(x, y, z, a, b):
    return (
        fma(y[a], z[b], -z[a] * y[b]),
        fma(z[a], x[b], -x[a] * z[b]),
        fma(x[a], y[b], -y[a] * x[b]),
    )


@njit(inline="always")
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(inline="always")
def _density(x, y, z):
    """Jacobian and its slopes, from the derivatives x, y, z of the surface's coordinates."""
    n_x, n_y, n_z = _cross(x, y, z, 1, 2)
    # Each slope is the sum of two cross products.
    s_x, s_y, s_z = _sum(_cross(x, y, z, 3, 2), _cross(x, y, z, 1, 4))
    t_x, t_y, t_z = _sum(_cross(x, y, z, 4, 2), _cross(x, y, z, 1, 5))
    square = fma(n_z, n_z, fma(n_y, n_y, n_x * n_x))
    size = math.sqrt(square)
    inverse = 1.0 / size if square > 0.0 else 0.0
    return (
        size,
        fma(n_z, s_z, fma(n_y, s_y, n_x * s_x)) * inverse,
        fma(n_z, t_z, fma(n_y, t_y, n_x * t_x)) * inverse,
    )


@njit(cache=True, error_model="numpy")
def _rational(lanes, k):
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        w = bicubic(k, 48, s, t)
        x = quotient(bicubic(k, 0, s, t), w)
        y = quotient(bicubic(k, 16, s, t), w)
        z = quotient(bicubic(k, 32, s, t), w)
        size, by_s, by_t = _density(x, y, z)
        lanes[2 * LANES + l] = size
        lanes[3 * LANES + l] = by_s
        lanes[4 * LANES + l] = by_t


@njit(cache=True, error_model="numpy")
def _polynomial(lanes, k):
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        size, by_s, by_t = _density(bicubic(k, 0, s, t), bicubic(k, 16, s, t), bicubic(k, 32, s, t))
        lanes[2 * LANES + l] = size
        lanes[3 * LANES + l] = by_s
        lanes[4 * LANES + l] = by_t


@njit(cache=True, nogil=True)
def blocks_in_order(tables, patch, uv, blocks):
    """Blocks (element, first, last + 1) of rows that follow one another in one element.

    Nodes of a mesh come so, and need not be sorted. Returns how many blocks there are, or −1
    where they are more than `blocks` has room for.
    """
    n = patch.shape[0]
    own = -1
    u0, u1, v0, v1 = 0.0, 0.0, 0.0, 0.0
    e = -1
    m = 0
    i = 0
    while i < n:
        if patch[i] < 0:
            i += 1
            continue
        u = uv[i, 0]
        v = uv[i, 1]
        if patch[i] != own or not (u0 <= u <= u1 and v0 <= v <= v1):
            own = patch[i]
            e = locate(tables.grid, own, u, v)[0]
            box = tables.elements.table[e]["box"]
            u0, u1, v0, v1 = box[0], box[1], box[2], box[3]
        j = i + 1
        last = min(n, i + LANES)
        while j < last and patch[j] == own and u0 <= uv[j, 0] <= u1 and v0 <= uv[j, 1] <= v1:
            j += 1
        if m == blocks.shape[0]:
            return -1
        blocks[m, 0] = e
        blocks[m, 1] = i
        blocks[m, 2] = j
        m += 1
        i = j
    return m


@njit(cache=True, nogil=True)
def jacobians(elements, uv, point, bins, images, start, stop):
    """Images of the feet of blocks start … stop, into images (n, 8)."""
    order, blocks = bins
    lanes = np.zeros(ROWS * LANES)
    k = np.empty(64)
    h = np.empty((4, 6))
    for b in range(start, stop):
        e = blocks[b, 0]
        rows = order[blocks[b, 1] : blocks[b, 2]]
        n = rows.shape[0]
        u0 = elements.table[e]["box"][0]
        v0 = elements.table[e]["box"][2]
        to_s = 1.0 / (elements.table[e]["box"][1] - u0)
        to_t = 1.0 / (elements.table[e]["box"][3] - v0)
        for l in range(LANES):
            r = rows[min(l, n - 1)]
            lanes[l] = min(max((uv[r, 0] - u0) * to_s - 0.5, -0.5), 0.5)
            lanes[LANES + l] = min(max((uv[r, 1] - v0) * to_t - 0.5, -0.5), 0.5)
        form = elements.table[e]["form"]
        if form == 0:
            for l in range(n):
                evaluate(elements, e, lanes[l], lanes[LANES + l], h)
                size, by_s, by_t = _density(h[0], h[1], h[2])
                lanes[2 * LANES + l] = size
                lanes[3 * LANES + l] = by_s
                lanes[4 * LANES + l] = by_t
        else:
            for i in range(64):
                k[i] = elements.table[e]["cubic"][i]
            if form == 2:
                _rational(lanes, k)
            else:
                _polynomial(lanes, k)
        scale = to_s * to_t
        for l in range(n):
            r = rows[l]
            images[r, 0] = lanes[2 * LANES + l] * scale
            images[r, 1] = lanes[3 * LANES + l] * scale * to_s
            images[r, 2] = lanes[4 * LANES + l] * scale * to_t
            images[r, 3] = uv[r, 0]
            images[r, 4] = uv[r, 1]
            images[r, 5] = point[r, 0]
            images[r, 6] = point[r, 1]
            images[r, 7] = point[r, 2]


@njit(inline="always")
def _area(t, a, b, c, one_patch):
    """Area of the image of a triangle of rows of `t`, and the sum of their Jacobians.

    The Jacobian is integrated over the triangle in (u, v) from its values and slopes at the
    corners, exactly for polynomials of second degree: an error of third order for one triangle, of
    fourth for a mesh. Where the corners have no one image in (u, v) the area is that of the plane
    triangle, the sum zero.
    """
    ab_u = t[b, 3] - t[a, 3]
    ab_v = t[b, 4] - t[a, 4]
    ac_u = t[c, 3] - t[a, 3]
    ac_v = t[c, 4] - t[a, 4]
    total = t[a, 0] + t[b, 0] + t[c, 0]
    bend = (
        (t[b, 1] - t[a, 1]) * ab_u
        + (t[b, 2] - t[a, 2]) * ab_v
        + (t[c, 1] - t[a, 1]) * ac_u
        + (t[c, 2] - t[a, 2]) * ac_v
        + (t[c, 1] - t[b, 1]) * (ac_u - ab_u)
        + (t[c, 2] - t[b, 2]) * (ac_v - ab_v)
    )
    area = 0.5 * abs(ab_u * ac_v - ab_v * ac_u) * THIRD * (total - 0.125 * bend)
    x1 = t[b, 5] - t[a, 5]
    y1 = t[b, 6] - t[a, 6]
    z1 = t[b, 7] - t[a, 7]
    x2 = t[c, 5] - t[a, 5]
    y2 = t[c, 6] - t[a, 6]
    z2 = t[c, 7] - t[a, 7]
    x = y1 * z2 - z1 * y2
    y = z1 * x2 - x1 * z2
    z = x1 * y2 - y1 * x2
    flat = 0.25 * (x * x + y * y + z * z)
    # Compared as squares: a root for every facet takes a tenth of all the time.
    if one_patch and total > 0.0 and area > 0.0 and LEAST * flat <= area * area <= MOST * flat:
        return area, total
    return math.sqrt(flat), 0.0


@njit(cache=True, nogil=True)
def master_whole(corner, patch, images, share, start, stop):
    """Areas of the images of facets start … stop (corners among the feet), split to the corners."""
    for f in range(start, stop):
        a = corner[f, 0]
        b = corner[f, 1]
        c = corner[f, 2]
        one_patch = patch[a] == patch[b] and patch[a] == patch[c]
        area, total = _area(images, a, b, c, one_patch)
        if total > 0.0:
            scale = 0.25 * area / total
            share[f, 0] = scale * (total + images[a, 0])
            share[f, 1] = scale * (total + images[b, 0])
            share[f, 2] = scale * (total + images[c, 0])
        else:
            share[f, 0] = THIRD * area
            share[f, 1] = THIRD * area
            share[f, 2] = THIRD * area


@njit(cache=True, nogil=True)
def master_pieces(corner, patch, images, sides, fraction, share, start, stop):
    """As `master_whole`, for the parts of facets that are cut at the edge of contact.

    `sides` is (n_c, row of each border edge among the images or −1 (m, 3)); the corners below n_c
    are in contact.
    """
    n_c, row = sides
    polygon = np.empty((4, 3))
    edge = np.empty(4, np.int64)
    inside = np.empty(3, np.bool_)
    vertex = np.empty((4, IMAGE))
    own = np.empty(4, np.int64)
    for f in range(start, stop):
        for k in range(3):
            share[f, k] = 0.0
            inside[k] = corner[f, k] < n_c
        n = polygon_of(inside, fraction, f, polygon, edge)
        for i in range(n):
            r = corner[f, -1 - edge[i]] if edge[i] < 0 else row[f, edge[i]]
            if r >= 0:
                own[i] = patch[r]
                for c in range(IMAGE):
                    vertex[i, c] = images[r, c]
            else:
                a = corner[f, edge[i]]
                b = corner[f, (edge[i] + 1) % 3]
                own[i] = patch[a] if patch[a] == patch[b] else -1
                _between(images, a, b, polygon[i, (edge[i] + 1) % 3], vertex, i)
        for j in range(1, n - 1):
            one_patch = own[0] >= 0 and own[0] == own[j] and own[0] == own[j + 1]
            area, total = _area(vertex, 0, j, j + 1, one_patch)
            for g in range(3):
                i = 0 if g == 0 else j + g - 1
                part = THIRD * area
                if total > 0.0:
                    part = 0.25 * area * (1.0 + vertex[i, 0] / total)
                for k in range(3):
                    share[f, k] += part * polygon[i, k]
        hand_over(share[f], inside)


@njit(cache=True)
def _between(images, a, b, t, vertex, i):
    """Image of a cut, the share `t` of the way from a to b: the Jacobian by Hermite's cubic."""
    s = 1.0 - t
    for c in range(1, IMAGE):
        vertex[i, c] = s * images[a, c] + t * images[b, c]
    du = images[b, 3] - images[a, 3]
    dv = images[b, 4] - images[a, 4]
    by_a = images[a, 1] * du + images[a, 2] * dv
    by_b = images[b, 1] * du + images[b, 2] * dv
    value = s * s * ((1.0 + 2.0 * t) * images[a, 0] + t * by_a)
    value += t * t * ((1.0 + 2.0 * s) * images[b, 0] - s * by_b)
    vertex[i, 0] = max(value, 0.0)
