"""First entry of a swept point: the segment p0 → p1 against the triangles of a mesh.

Only crossings from the free side count ((p1 − p0)·n < 0). Edges belong to both triangles, so
that no path slips through between them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search.faceted._boxes_nb import NOBODY, WIDTH, put
from contiga.search.faceted._facet_nb import TRIANGLE

OK, NOT_FINITE, NO_HIT, AT_START = 0, 5, 6, 7
INCLUSIVE = 1e-9
"""Crossings this far outside a triangle (barycentric) still belong to it."""
ROUNDING = 1e-15
DEPTH = 256


@njit(cache=True)
def _box_entries(box, node, p, inverse, limits, out):
    """Fraction at which the path enters each box of a node; infinite where it does not."""
    first, last = limits
    for l in range(WIDTH):
        a = (box[node, l] - p[0]) * inverse[0]
        b = (box[node, 24 + l] - p[0]) * inverse[0]
        near = max(first, min(a, b))
        far = min(last, max(a, b))
        a = (box[node, 8 + l] - p[1]) * inverse[1]
        b = (box[node, 32 + l] - p[1]) * inverse[1]
        near = max(near, min(a, b))
        far = min(far, max(a, b))
        a = (box[node, 16 + l] - p[2]) * inverse[2]
        b = (box[node, 40 + l] - p[2]) * inverse[2]
        near = max(near, min(a, b))
        far = min(far, max(a, b))
        out[l] = near if near <= far + 1e-12 * abs(far) else math.inf


@njit(cache=True)
def _crossing(shape, s, p, d, reach):
    """Fraction at which the path comes through triangle s from its free side, or infinity."""
    nx, ny, nz = shape[s, 9], shape[s, 10], shape[s, 11]
    rate = d[0] * nx + d[1] * ny + d[2] * nz
    if rate >= 0.0:
        return math.inf, 0.0, 0.0
    vx = p[0] - shape[s, 0]
    vy = p[1] - shape[s, 1]
    vz = p[2] - shape[s, 2]
    tau = -(vx * nx + vy * ny + vz * nz) / rate
    vx += tau * d[0]
    vy += tau * d[1]
    vz += tau * d[2]
    u = vx * shape[s, 3] + vy * shape[s, 4] + vz * shape[s, 5]
    v = vx * shape[s, 6] + vy * shape[s, 7] + vz * shape[s, 8]
    steep = 0.0
    for c in range(3, 9):
        steep += abs(shape[s, c])
    slack = INCLUSIVE + ROUNDING * reach * steep
    if u < -slack or v < -slack or u + v > 1.0 + slack:
        return math.inf, 0.0, 0.0
    return tau, u, v


@njit(cache=True)
def first_entry(tree, scale, p, q, work):
    """Smallest fraction of p → q at which the path enters: fraction (or infinity), slot, u, v."""
    shape, link, box, child = tree
    nodes, entry, lane = work
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    length = math.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
    best = math.inf
    slot = -1
    u = 0.0
    v = 0.0
    if length == 0.0:
        return best, slot, u, v
    slack = scale[1] / length
    reach = scale[0] + abs(p[0]) + abs(p[1]) + abs(p[2])
    # A path along an axis has no finite inverse there: a huge one gives the same boxes.
    inverse = (
        1.0 / d[0] if abs(d[0]) > 1e-290 else 1e290,
        1.0 / d[1] if abs(d[1]) > 1e-290 else 1e290,
        1.0 / d[2] if abs(d[2]) > 1e-290 else 1e290,
    )
    nodes[0] = 0
    entry[0] = -slack
    top = 1
    while top > 0:
        top -= 1
        if entry[top] > best + slack:
            continue
        node = nodes[top]
        limits = (-slack, min(1.0, best) + slack)
        _box_entries(box, node, p, inverse, limits, lane)
        if child[node, 0] < 0:
            for l in range(WIDTH):
                if lane[l] > best + slack or child[node, l] == NOBODY:
                    continue
                s = -1 - child[node, l]
                tau, a, b = _crossing(shape, s, p, d, reach)
                if tau < -slack or tau > 1.0 + slack:
                    continue
                if tau < best or (tau == best and link[s, TRIANGLE] < link[slot, TRIANGLE]):
                    best = tau
                    slot = s
                    u = a
                    v = b
            continue
        base = top
        for l in range(WIDTH):
            if lane[l] < math.inf and child[node, l] != NOBODY:
                top = put(nodes, entry, base, top, child[node, l], lane[l])
    return best, slot, u, v


@njit(cache=True, nogil=True)
def first_hits(facets, p0, p1, rows, out, start, stop):
    """First entry of each segment p0[rows[i]] → p1[rows[i]] into row i of `out`."""
    work = (np.empty(DEPTH, np.int64), np.empty(DEPTH), np.empty(WIDTH))
    shape = facets.shape
    tree = (shape, facets.link, facets.box, facets.child)
    for i in range(start, stop):
        k = rows[i]
        p = (p0[k, 0], p0[k, 1], p0[k, 2])
        q = (p1[k, 0], p1[k, 1], p1[k, 2])
        out.patch[i] = -1
        out.fraction[i] = math.nan
        for c in range(2):
            out.uv[i, c] = math.nan
        for c in range(3):
            out.point[i, c] = math.nan
        if not math.isfinite(p[0] + p[1] + p[2] + q[0] + q[1] + q[2]):
            out.status[i] = NOT_FINITE
            continue
        tau, s, u, v = first_entry(tree, facets.scale, p, q, work)
        if s < 0:
            out.status[i] = NO_HIT
            continue
        u = min(max(u, 0.0), 1.0)
        v = min(max(v, 0.0), 1.0 - u)
        out.fraction[i] = min(max(tau, 0.0), 1.0)
        out.patch[i] = facets.link[s, TRIANGLE]
        out.uv[i, 0] = u
        out.uv[i, 1] = v
        for c in range(3):
            b = u * (shape[s, 12 + c] - shape[s, c])
            out.point[i, c] = shape[s, c] + b + v * (shape[s, 15 + c] - shape[s, c])
        out.status[i] = AT_START if tau <= 0.0 else OK
