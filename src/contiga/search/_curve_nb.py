"""Trimming pieces in space: the surface along a p-curve, and its closest point."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._element_nb import bernstein_basis, evaluate, locate

MAX_ITERATIONS = 30
STARTS = 4


@njit(cache=True)
def piece_parameters(trims, piece, t, c):
    """(u, v) and two derivatives of a piece at t in [0, 1], into c[:3, :2]."""
    n = trims.piece_degree[piece]
    basis = np.zeros((3, 16))
    bernstein_basis(n, t, basis)
    for k in range(3):
        for m in range(3):
            total = 0.0
            for i in range(n + 1):
                total += basis[k, i] * trims.piece_coefs[piece, i, m]
            c[k, m] = total
    w = 1.0 / c[0, 2]
    for m in range(2):
        x = c[0, m] * w
        x1 = (c[1, m] - c[1, 2] * x) * w
        c[2, m] = (c[2, m] - 2.0 * c[1, 2] * x1 - c[2, 2] * x) * w
        c[1, m] = x1
        c[0, m] = x


@njit(cache=True)
def curve_point(elements, grid, trims, piece, t, h, d):
    """Point and two derivatives of the trimming curve in space into d[3, 3].

    The point is relative to the origin of the element it lies in. Returns that element and the
    local (s, t) there; `h` holds the element's derivatives.
    """
    c = np.empty((3, 3))
    piece_parameters(trims, piece, t, c)
    e, s, r = locate(grid, trims.piece_patch[piece], c[0, 0], c[0, 1])
    evaluate(elements, e, s, r, h)
    scale_u = 1.0 / (elements.table[e]["box"][1] - elements.table[e]["box"][0])
    scale_v = 1.0 / (elements.table[e]["box"][3] - elements.table[e]["box"][2])
    a1 = c[1, 0] * scale_u
    b1 = c[1, 1] * scale_v
    a2 = c[2, 0] * scale_u
    b2 = c[2, 1] * scale_v
    for k in range(3):
        d[0, k] = h[k, 0]
        d[1, k] = h[k, 1] * a1 + h[k, 2] * b1
        d[2, k] = (
            h[k, 3] * a1 * a1
            + 2.0 * h[k, 4] * a1 * b1
            + h[k, 5] * b1 * b1
            + h[k, 1] * a2
            + h[k, 2] * b2
        )
    return e, s, r


@njit(cache=True)
def closest_on_stretch(elements, grid, trims, piece, limits, point, h):
    """Closest point of the stretch `limits` (t0, t1) of a piece: t and the distance.

    Safeguarded Newton on C'·(C − P) = 0 from the best of a few samples.
    """
    t0, t1 = limits
    d = np.empty((3, 3))
    best_t = t0
    best = math.inf
    for k in range(STARTS + 1):
        t = t0 + (t1 - t0) * k / STARTS
        f = _squared(elements, grid, trims, piece, t, point, h, d)
        if f < best:
            best = f
            best_t = t
    t = best_t
    step = (t1 - t0) / STARTS
    for _ in range(MAX_ITERATIONS):
        e = curve_point(elements, grid, trims, piece, t, h, d)[0]
        slope = 0.0
        curvature = 0.0
        speed = 0.0
        for k in range(3):
            r = d[0, k] + elements.table[e]["origin"][k] - point[k]
            slope += d[1, k] * r
            curvature += d[2, k] * r
            speed += d[1, k] * d[1, k]
        curvature += speed
        if curvature <= 0.1 * speed:
            curvature = speed
        if curvature <= 0.0:
            break
        move = min(max(-slope / curvature, -step), step)
        new = min(max(t + move, t0), t1)
        if new == t:
            break
        f = _squared(elements, grid, trims, piece, new, point, h, d)
        if f <= best:
            best = f
            best_t = new
            settled = abs(new - t) < 1e-15
            t = new
            if settled:
                break
        else:
            step = 0.5 * abs(new - t)
            if step < 1e-15:
                break
    return best_t, math.sqrt(best)


@njit(cache=True)
def _squared(elements, grid, trims, piece, t, point, h, d):
    e = curve_point(elements, grid, trims, piece, t, h, d)[0]
    total = 0.0
    for k in range(3):
        total += (d[0, k] + elements.table[e]["origin"][k] - point[k]) ** 2
    return total
