"""Derivatives of the depth and the normal at feet, with respect to their points.

With the foot q of a point p and the unit normal n along which the gap g is measured, p = q + g n:
the depth −g falls along n. On a face dn = H dp with H = −B (1 − g B)⁻¹ of the second fundamental
form B (do Carmo, Differential Geometry of Curves and Surfaces, 3-2). On a curve C the foot moves by
dq = C' (C'·dp)/(|C'|² − (p − C)·C''), at a vertex it does not move, and the normal points from the
foot to the point: g dn is the part of dp − dq across it. A foot held on a border may keep the
normal n(C) of its face, along which the point does not lie.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE
from contiga.arrays.kernels.foot_slopes_nb import (
    PERPENDICULAR_TOL,
    is_along,
    write_kink_slopes,
    write_slopes,
)
from contiga.arrays.kernels.vector_nb import column, dot, minus
from contiga.elements.kernels.element_nb import evaluate, locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.around_nb import stands
from contiga.search.hierarchy.kernels.curve_nb import curve_point, piece_parameters
from contiga.search.slopes.kernels.bending_nb import bending

SAME_UV_TOL = 1e-7
"""Largest distance of equal places (u, v), as a share of the patch."""
N_STARTS = 8
"""Number of intervals between the starts of Newton's method on a trimming piece."""
N_STEPS = 12
"""Number of Newton steps from each start."""
MIN_LENGTH = 10.0
"""Least length of a vector that has a direction, in tolerances of a foot."""


@inner()
def _uv_distance2(trims, piece, t, place, c):
    """Squared distance in (u, v), in shares of the patch, of a piece at t from `place`, with its
    first and second derivative by t."""
    domain = trims.domain[trims.piece_patch[piece]]
    piece_parameters(trims, piece, t, c)
    square = slope = curvature = 0.0
    for k in range(2):
        scale = 1.0 / (domain[2 * k + 1] - domain[2 * k])
        r, d1, d2 = (c[0, k] - place[k]) * scale, c[1, k] * scale, c[2, k] * scale
        square += r * r
        slope += 2.0 * r * d1
        curvature += 2.0 * (d1 * d1 + r * d2)
    return square, slope, curvature


@inner()
def _box_contains(trims, piece, place):
    """Return whether the box of a piece's control points contains a place, within rounding."""
    domain = trims.domain[trims.piece_patch[piece]]
    for k in range(2):
        margin = SAME_UV_TOL * (domain[2 * k + 1] - domain[2 * k])
        low, high = math.inf, -math.inf
        for i in range(trims.piece_degree[piece] + 1):
            x = trims.piece_coefs[piece, i, k] / trims.piece_coefs[piece, i, 2]
            low, high = min(low, x), max(high, x)
        if not low - margin <= place[k] <= high + margin:
            return False
    return True


@inner()
def _closest_parameter(trims, piece, place, c):
    """Return the parameter t of a piece nearest to `place` (u, v), and its squared distance."""
    best, best_t = math.inf, 0.0
    for i in range(N_STARTS + 1):
        t = i / N_STARTS
        for _ in range(N_STEPS):
            square, slope, curvature = _uv_distance2(trims, piece, t, place, c)
            if square < best:
                best, best_t = square, t
            step = slope / curvature if curvature > 0.0 else 0.0
            t = min(max(t - step, 0.0), 1.0)
            if step == 0.0:
                break
    return best_t, best


@inner()
def _cosine_to_curve(d, r):
    """Return |cos| of the angle between a curve's derivative d and the vector r to a point; 1 if d
    vanishes."""
    square = dot(d, d)
    return abs(dot(d, r)) / math.sqrt(square * dot(r, r)) if square > 0.0 else 1.0


@inner()
def _curve_at(tables, foot, feature, r, h):
    """Return the first and second derivative of the curve on which a foot lies; zeros at a vertex.

    Of the sides of elements and the trimming pieces through the foot, it is the one most nearly
    perpendicular to the vector r to the point.
    """
    e, s, t = foot
    elements, trims = tables.elements, tables.trims
    best = PERPENDICULAR_TOL
    first = second = (0.0, 0.0, 0.0)
    patch = elements.table[e]["patch"]
    if feature != EDGE:
        return first, second
    evaluate(elements, e, s, t, h)
    for side in range(4):
        if not stands(side, s, t):
            continue
        d = column(h, 2 if side < 2 else 1)
        miss = _cosine_to_curve(d, r)
        if miss < best:
            best, first, second = miss, d, column(h, 5 if side < 2 else 3)
    if trims.trimmed[patch] == 0:
        return first, second
    box = elements.table[e]["box"]
    place = (box[0] + (s + 0.5) * (box[1] - box[0]), box[2] + (t + 0.5) * (box[3] - box[2]))
    c = scratch(3, 3)
    for piece in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        if not _box_contains(trims, piece, place):
            continue
        t_piece, square = _closest_parameter(trims, piece, place, c)
        if square > SAME_UV_TOL * SAME_UV_TOL:
            continue
        curve_point(elements, tables.grid, trims, piece, t_piece, h, c)
        d = (c[1, 0], c[1, 1], c[1, 2])
        miss = _cosine_to_curve(d, r)
        if miss < best:
            best, first, second = miss, d, (c[2, 0], c[2, 1], c[2, 2])
    return first, second


@inner()
def _face_slopes(elements, k, foot, normal, gap, out, h):
    """Write the slopes of a foot inside a face: H of the second fundamental form."""
    q, p, b11, b12, b22 = bending(elements, foot, normal, h)
    determinant = b11 * b22 - b12 * b12
    focal = 1.0 - gap * (b11 + b22) + gap * gap * determinant
    scale = -1.0 / focal if focal != 0.0 else 0.0
    h11, h12 = scale * (b11 - gap * determinant), scale * b12
    h22 = scale * (b22 - gap * determinant)
    a = (h11 * q[0] + h12 * p[0], h11 * q[1] + h12 * p[1], h11 * q[2] + h12 * p[2])
    b = (h12 * q[0] + h22 * p[0], h12 * q[1] + h22 * p[1], h12 * q[2] + h22 * p[2])
    write_slopes(k, (-normal[0], -normal[1], -normal[2]), a, q, b, p, out)


@inner()
def _border_slopes(elements, k, foot, r, foot_move, normal, out, h):
    """Write the slopes of a foot on a border with the normal of its face, which turns with it."""
    d, foot_rate = foot_move
    q, p, b11, b12, b22 = bending(elements, foot, normal, h)
    x, y = dot(q, d), dot(p, d)
    a, b = -(b11 * x + b12 * y), -(b12 * x + b22 * y)
    normal_rate = (a * q[0] + b * p[0], a * q[1] + b * p[1], a * q[2] + b * p[2])
    tangential_rate = dot(normal_rate, r)
    depth = (
        -normal[0] - tangential_rate * foot_rate[0],
        -normal[1] - tangential_rate * foot_rate[1],
        -normal[2] - tangential_rate * foot_rate[2],
    )
    write_slopes(k, depth, normal_rate, foot_rate, (0.0, 0.0, 0.0), foot_rate, out)


@kernel(error_model="numpy")
def slopes(tables, points, feet, out, start, stop):
    """Fill rows start … stop of `out`, `FootSlopes`, at `feet`, a `Projection`, of points (k, 3).

    The gaps are the true distances from the surface.
    """
    elements, min_length = tables.elements, MIN_LENGTH * tables.scale[1]
    h = scratch(4, 6)
    none = (0.0, 0.0, 0.0)
    for k in range(start, stop):
        foot = locate(tables.grid, feet.patch[k], feet.uv[k, 0], feet.uv[k, 1])
        normal = (feet.normal[k, 0], feet.normal[k, 1], feet.normal[k, 2])
        if feet.feature[k] == FACE:
            _face_slopes(elements, k, foot, normal, feet.gap[k], out, h)
            continue
        foot_point = (feet.point[k, 0], feet.point[k, 1], feet.point[k, 2])
        r = minus((points[k, 0], points[k, 1], points[k, 2]), foot_point)
        d, curvature = _curve_at(tables, foot, feet.feature[k], r, h)
        denominator = dot(d, d) - dot(r, curvature)
        scale = 1.0 / denominator if denominator > 0.0 else 0.0
        foot_move = (d, (d[0] * scale, d[1] * scale, d[2] * scale))
        if not is_along(r, normal, min_length):
            _border_slopes(elements, k, foot, r, foot_move, normal, out, h)
        elif dot(r, r) > min_length * min_length:
            write_kink_slopes(k, foot_move[0], foot_move[1], normal, feet.gap[k], out)
        else:
            write_slopes(k, (-normal[0], -normal[1], -normal[2]), none, none, none, none, out)
