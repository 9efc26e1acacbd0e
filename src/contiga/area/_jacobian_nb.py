"""The Jacobian |S_u × S_v| at feet, and its integral over whole facets of them.

Feet are binned by element and taken sixteen at a time, as in tracking (`_lanes_nb` of the
search). One evaluation a node does for the six facets around it: a Gauss rule on every facet
takes ten times as long.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.area._facet_nb import triangle
from contiga.search._element_nb import FAST, bicubic, evaluate, quotient

LANES = 16
# Rows of the work array: s, t, then J, dJ/ds, dJ/dt.
ROWS = 5
# Share by which the image in (u, v) may miss the plane triangle of its feet before it is not
# trusted: it crosses a seam, say.
ASTRAY = 0.5


@njit(inline="always")
def _density(x, y, z):
    """Jacobian and its slopes, from the derivatives x, y, z of the surface's coordinates."""
    n_x = y[1] * z[2] - z[1] * y[2]
    n_y = z[1] * x[2] - x[1] * z[2]
    n_z = x[1] * y[2] - y[1] * x[2]
    s_x = y[3] * z[2] - z[3] * y[2] + y[1] * z[4] - z[1] * y[4]
    s_y = z[3] * x[2] - x[3] * z[2] + z[1] * x[4] - x[1] * z[4]
    s_z = x[3] * y[2] - y[3] * x[2] + x[1] * y[4] - y[1] * x[4]
    t_x = y[4] * z[2] - z[4] * y[2] + y[1] * z[5] - z[1] * y[5]
    t_y = z[4] * x[2] - x[4] * z[2] + z[1] * x[5] - x[1] * z[5]
    t_z = x[4] * y[2] - y[4] * x[2] + x[1] * y[5] - y[1] * x[5]
    square = n_x * n_x + n_y * n_y + n_z * n_z
    size = math.sqrt(square)
    inverse = 1.0 / size if square > 0.0 else 0.0
    return (
        size,
        (n_x * s_x + n_y * s_y + n_z * s_z) * inverse,
        (n_x * t_x + n_y * t_y + n_z * t_z) * inverse,
    )


@njit(cache=True, fastmath=FAST, error_model="numpy")
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


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _polynomial(lanes, k):
    for l in range(LANES):
        s = lanes[l]
        t = lanes[LANES + l]
        size, by_s, by_t = _density(bicubic(k, 0, s, t), bicubic(k, 16, s, t), bicubic(k, 32, s, t))
        lanes[2 * LANES + l] = size
        lanes[3 * LANES + l] = by_s
        lanes[4 * LANES + l] = by_t


@njit(cache=True, nogil=True)
def jacobians(elements, uv, bins, density, start, stop):
    """|S_u × S_v|, d/du and d/dv of it at the feet of blocks start … stop, into density (n, 3)."""
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
            density[r, 0] = lanes[2 * LANES + l] * scale
            density[r, 1] = lanes[3 * LANES + l] * scale * to_s
            density[r, 2] = lanes[4 * LANES + l] * scale * to_t


@njit(cache=True, nogil=True)
def master_whole(corner, feet, density, share, start, stop):
    """Areas of the images of facets start … stop (corners among the feet), split to the corners.

    The Jacobian is integrated over the triangle in (u, v) from its values and slopes at the feet,
    exactly for polynomials of second degree, so that the error is of fourth order. Where the feet
    have no one image in (u, v), the plane triangle between them takes its place.
    """
    for f in range(start, stop):
        a = corner[f, 0]
        b = corner[f, 1]
        c = corner[f, 2]
        flat = triangle(feet.point[a], feet.point[b], feet.point[c])
        share[f, :] = flat / 3.0
        if feet.patch[a] != feet.patch[b] or feet.patch[a] != feet.patch[c]:
            continue
        ab_u = feet.uv[b, 0] - feet.uv[a, 0]
        ab_v = feet.uv[b, 1] - feet.uv[a, 1]
        ac_u = feet.uv[c, 0] - feet.uv[a, 0]
        ac_v = feet.uv[c, 1] - feet.uv[a, 1]
        cell = 0.5 * abs(ab_u * ac_v - ab_v * ac_u)
        total = density[a, 0] + density[b, 0] + density[c, 0]
        bend = (
            (density[b, 1] - density[a, 1]) * ab_u
            + (density[b, 2] - density[a, 2]) * ab_v
            + (density[c, 1] - density[a, 1]) * ac_u
            + (density[c, 2] - density[a, 2]) * ac_v
            + (density[c, 1] - density[b, 1]) * (ac_u - ab_u)
            + (density[c, 2] - density[b, 2]) * (ac_v - ab_v)
        )
        area = cell * (total / 3.0 - bend / 24.0)
        if not abs(area - flat) <= ASTRAY * flat or total == 0.0:
            continue
        for k in range(3):
            share[f, k] = area * (total + density[corner[f, k], 0]) / (4.0 * total)
