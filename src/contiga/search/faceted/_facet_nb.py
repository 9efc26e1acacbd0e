"""One point and one triangle: the closest point, and what the surface is like there."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

OK, BORDER_STATUS, MAX_ITERATIONS, NOT_FINITE = 0, 1, 3, 5
FACE, EDGE, VERTEX = 0, 1, 2
BORDER = -1
INSIDE = 1e-12
"""Barycentric coordinates this far below zero are inside: rounding of points over an edge."""


@njit(cache=True)
def _on_edge(corner, s, k, x, y, z):
    """Squared distance to edge k of triangle s, and the share of the edge where it is."""
    a = 3 * k
    b = 3 * ((k + 1) % 3)
    ex = corner[s, b] - corner[s, a]
    ey = corner[s, b + 1] - corner[s, a + 1]
    ez = corner[s, b + 2] - corner[s, a + 2]
    vx = x - corner[s, a]
    vy = y - corner[s, a + 1]
    vz = z - corner[s, a + 2]
    t = (vx * ex + vy * ey + vz * ez) / (ex * ex + ey * ey + ez * ez)
    if t >= 1.0:
        t = 1.0
        vx = x - corner[s, b]
        vy = y - corner[s, b + 1]
        vz = z - corner[s, b + 2]
    elif t <= 0.0:
        t = 0.0
    else:
        vx -= t * ex
        vy -= t * ey
        vz -= t * ez
    return vx * vx + vy * vy + vz * vz, t


@njit(cache=True)
def closest_on(facets, s, x, y, z):
    """Closest point of triangle s: squared distance, place, and two numbers.

    Place 0: inside, with the barycentric coordinates. 1, 2, 3: on edge 0, 1, 2, with the share
    of the edge. 4, 5, 6: corner 0, 1, 2. Only the edges whose coordinate is negative can hold
    the closest point of a point beside the triangle.
    """
    plane = facets.plane
    vx = x - plane[s, 0]
    vy = y - plane[s, 1]
    vz = z - plane[s, 2]
    u = vx * plane[s, 3] + vy * plane[s, 4] + vz * plane[s, 5]
    v = vx * plane[s, 6] + vy * plane[s, 7] + vz * plane[s, 8]
    if u >= -INSIDE and v >= -INSIDE and u + v <= 1.0 + INSIDE:
        gap = vx * plane[s, 9] + vy * plane[s, 10] + vz * plane[s, 11]
        return gap * gap, 0, u, v
    best = math.inf
    edge = 0
    share = 0.0
    if v < 0.0:
        best, share = _on_edge(facets.corner, s, 0, x, y, z)
    if u + v > 1.0:
        square, t = _on_edge(facets.corner, s, 1, x, y, z)
        if square < best:
            best = square
            edge = 1
            share = t
    if u < 0.0:
        square, t = _on_edge(facets.corner, s, 2, x, y, z)
        if square < best:
            best = square
            edge = 2
            share = t
    if share == 0.0:
        return best, 4 + edge, 0.0, 0.0
    if share == 1.0:
        return best, 4 + (edge + 1) % 3, 0.0, 0.0
    return best, 1 + edge, share, 0.0


@njit(cache=True)
def barycentric(place, a, b):
    """(u, v) of a place as `closest_on` gives it: foot = (1 − u − v) A + u B + v C."""
    if place == 0:
        u = min(max(a, 0.0), 1.0)
        return u, min(max(b, 0.0), 1.0 - u)
    if place == 1:
        return a, 0.0
    if place == 2:
        return 1.0 - a, a
    if place == 3:
        return 0.0, 1.0 - a
    if place == 5:
        return 1.0, 0.0
    if place == 6:
        return 0.0, 1.0
    return 0.0, 0.0


@njit(cache=True)
def blank(out, k, status):
    """Row k of `out` for a point without a foot."""
    out.patch[k] = -1
    out.feature[k] = -1
    out.status[k] = status
    out.gap[k] = math.nan
    for c in range(3):
        out.point[k, c] = math.nan
        out.normal[k, c] = math.nan
    out.uv[k, 0] = math.nan
    out.uv[k, 1] = math.nan


@njit(cache=True)
def write_foot(facets, k, foot, point, options, out):
    """Row k of the projection for a foot (slot, place, a, b) of `point`.

    `options` is (tracked, smooth): a tracked foot on a border keeps the triangle's own normal;
    smooth normals are those of the vertices, interpolated.
    """
    s, place, a, b = foot
    x, y, z = point
    plane = facets.plane
    nx, ny, nz = plane[s, 9], plane[s, 10], plane[s, 11]
    u, v = barycentric(place, a, b)
    out.patch[k] = facets.triangle[s]
    out.uv[k, 0] = u
    out.uv[k, 1] = v
    if place == 0:
        gap = (x - plane[s, 0]) * nx + (y - plane[s, 1]) * ny + (z - plane[s, 2]) * nz
        out.point[k, 0] = x - gap * nx
        out.point[k, 1] = y - gap * ny
        out.point[k, 2] = z - gap * nz
        out.normal[k, 0] = nx
        out.normal[k, 1] = ny
        out.normal[k, 2] = nz
        out.gap[k] = gap
        out.feature[k] = FACE
        out.status[k] = OK
    else:
        _write_kink(facets, k, foot, point, options[0], out)
    if options[1]:
        _smooth_normal(facets, s, u, v, k, out)


@njit(cache=True)
def _write_kink(facets, k, foot, point, tracked, out):
    """Foot, normal, gap, feature and status on an edge or a corner."""
    s, place, a, _ = foot
    corner = facets.corner
    r = np.empty(3)
    square = 0.0
    i = 3 * (place - 1) if place < 4 else 3 * (place - 4)
    j = (i + 3) % 9
    for c in range(3):
        p = corner[s, i + c]
        if place < 4:
            p += a * (corner[s, j + c] - p)
        out.point[k, c] = p
        r[c] = point[c] - p
        square += r[c] * r[c]
    out.feature[k] = EDGE if place < 4 else VERTEX
    n = facets.plane[s, 9:12]
    own = r[0] * n[0] + r[1] * n[1] + r[2] * n[2]
    at_end = _is_border(facets, s, place)
    beside = at_end and square - own * own > (4.0 * facets.scale[1]) ** 2
    out.status[k] = BORDER_STATUS if beside else OK
    if at_end and (tracked or not beside):
        out.gap[k] = own
        for c in range(3):
            out.normal[k, c] = n[c]
        return
    toward = np.zeros(3)
    _pseudo_normal(facets, s, place, out.point[k], toward)
    length = math.sqrt(toward[0] ** 2 + toward[1] ** 2 + toward[2] ** 2)
    if length == 0.0:
        toward[:] = n
        length = 1.0
    side = r[0] * toward[0] + r[1] * toward[1] + r[2] * toward[2]
    distance = math.sqrt(square)
    if distance <= 4.0 * facets.scale[1]:
        out.gap[k] = side / length
        for c in range(3):
            out.normal[k, c] = toward[c] / length
        return
    sign = 1.0 if side >= 0.0 else -1.0
    out.gap[k] = sign * distance
    for c in range(3):
        out.normal[k, c] = sign * r[c] / distance


@njit(cache=True)
def _is_border(facets, s, place):
    if place < 4:
        return facets.neighbour[s, place - 1] == BORDER
    return facets.at_border[facets.vertex[s, place - 4]] != 0


@njit(cache=True)
def _pseudo_normal(facets, s, place, foot, total):
    """Sum of the normals at an edge or a corner, weighted by angle: it tells the side of a point
    (Baerentzen & Aanaes 2005, doi 10.1109/TVCG.2005.49)."""
    plane = facets.plane
    if place >= 4:
        v = facets.vertex[s, place - 4]
        total[:] = facets.vertex_normal[v]
        return
    other = facets.neighbour[s, place - 1]
    total[:] = plane[s, 9:12]
    if other >= 0:
        total += plane[other, 9:12]
    elif other < BORDER:
        f = -2 - other
        near = (4.0 * facets.scale[1]) ** 2
        for i in range(facets.fan_first[f], facets.fan_first[f + 1]):
            t = facets.fan[i]
            if t != s and closest_on(facets, t, foot[0], foot[1], foot[2])[0] <= near:
                total += plane[t, 9:12]


@njit(cache=True)
def _smooth_normal(facets, s, u, v, k, out):
    """The normals of the corners, interpolated; the gap stays the signed distance."""
    square = 0.0
    for c in range(3):
        value = (
            (1.0 - u - v) * facets.vertex_normal[facets.vertex[s, 0], c]
            + u * facets.vertex_normal[facets.vertex[s, 1], c]
            + v * facets.vertex_normal[facets.vertex[s, 2], c]
        )
        out.normal[k, c] = value
        square += value * value
    length = math.sqrt(square)
    for c in range(3):
        out.normal[k, c] = out.normal[k, c] / length if length > 0.0 else facets.plane[s, 9 + c]
