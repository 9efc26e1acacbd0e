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
def _closest_parameter(trims, piece, place, c):
    """Return the parameter t of a piece nearest to `place` (u, v), and the squared distance.

    The distance is in shares of the patch, and the smallest on Newton's way from `N_STARTS` + 1
    starts. It is infinite if the place is outside the box of the piece's control points by more
    than `SAME_UV_TOL`. `c` (3, 3) is work.
    """
    best, best_t = math.inf, 0.0
    domain = trims.domain[trims.piece_patch[piece]]
    for k in range(2):
        margin = SAME_UV_TOL * (domain[2 * k + 1] - domain[2 * k])
        low, high = math.inf, -math.inf
        for i in range(trims.piece_degree[piece] + 1):
            x = trims.piece_coefs[piece, i, k] / trims.piece_coefs[piece, i, 2]
            low, high = min(low, x), max(high, x)
        if not low - margin <= place[k] <= high + margin:
            return best_t, best
    for i in range(N_STARTS + 1):
        t = i / N_STARTS
        for _ in range(N_STEPS):
            piece_parameters(trims, piece, t, c)
            square = slope = curvature = 0.0
            for k in range(2):
                scale = 1.0 / (domain[2 * k + 1] - domain[2 * k])
                r, d1, d2 = (c[0, k] - place[k]) * scale, c[1, k] * scale, c[2, k] * scale
                square += r * r
                slope += 2.0 * r * d1
                curvature += 2.0 * (d1 * d1 + r * d2)
            if square < best:
                best, best_t = square, t
            step = slope / curvature if curvature > 0.0 else 0.0
            t = min(max(t - step, 0.0), 1.0)
            if step == 0.0:
                break
    return best_t, best


@inner()
def _cosine_to_curve(d, r):
    """Return |cos| of the angle between a curve's derivative d and the vector r to a point.

    1 if d vanishes.
    """
    square = dot(d, d)
    return abs(dot(d, r)) / math.sqrt(square * dot(r, r)) if square > 0.0 else 1.0


@inner()
def _curve_at(tables, foot, feature, r, h):
    """Return both derivatives (3,) of the curve on which a foot lies, by its parameter; or zeros.

    The curve is the side of the element, or the trimming piece through the foot, that is most
    nearly perpendicular to the vector r to the point, within `PERPENDICULAR_TOL`. They are zeros if
    there is no such curve, and at a vertex.
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
        t_piece, square = _closest_parameter(trims, piece, place, c)
        if square > SAME_UV_TOL * SAME_UV_TOL:
            continue
        curve_point(elements, tables.grid, trims, piece, t_piece, h, c)
        d = (c[1, 0], c[1, 1], c[1, 2])
        miss = _cosine_to_curve(d, r)
        if miss < best:
            best, first, second = miss, d, (c[2, 0], c[2, 1], c[2, 2])
    return first, second


@kernel(error_model="numpy")
def slopes(tables, points, feet, out, start, stop):
    """Write rows start … stop − 1 of `out` (`FootSlopes`) at `feet`, a `Projection` of `points`.

    The gaps must be the true distances from the surface. The normal counts as fixed at a focal
    point of a face, and at a foot on an edge or vertex that the point almost touches.
    """
    elements, min_length = tables.elements, MIN_LENGTH * tables.scale[1]
    h = scratch(4, 6)
    none = (0.0, 0.0, 0.0)
    for k in range(start, stop):
        foot = locate(tables.grid, feet.patch[k], feet.uv[k, 0], feet.uv[k, 1])
        normal = (feet.normal[k, 0], feet.normal[k, 1], feet.normal[k, 2])
        toward_surface = (-normal[0], -normal[1], -normal[2])
        if feet.feature[k] == FACE:
            # H of the second fundamental form.
            q, p, b11, b12, b22 = bending(elements, foot, normal, h)
            gap, determinant = feet.gap[k], b11 * b22 - b12 * b12
            focal = 1.0 - gap * (b11 + b22) + gap * gap * determinant
            scale = -1.0 / focal if focal != 0.0 else 0.0
            h11, h12 = scale * (b11 - gap * determinant), scale * b12
            h22 = scale * (b22 - gap * determinant)
            a = (h11 * q[0] + h12 * p[0], h11 * q[1] + h12 * p[1], h11 * q[2] + h12 * p[2])
            b = (h12 * q[0] + h22 * p[0], h12 * q[1] + h22 * p[1], h12 * q[2] + h22 * p[2])
            write_slopes(k, toward_surface, a, q, b, p, out)
            continue
        foot_point = (feet.point[k, 0], feet.point[k, 1], feet.point[k, 2])
        r = minus((points[k, 0], points[k, 1], points[k, 2]), foot_point)
        d, curvature = _curve_at(tables, foot, feet.feature[k], r, h)
        denominator = dot(d, d) - dot(r, curvature)
        scale = 1.0 / denominator if denominator > 0.0 else 0.0
        foot_rate = (d[0] * scale, d[1] * scale, d[2] * scale)
        if not is_along(r, normal, min_length):
            # A foot on a border keeps the normal of its face, which turns with the foot.
            q, p, b11, b12, b22 = bending(elements, foot, normal, h)
            x, y = dot(q, d), dot(p, d)
            turn_q, turn_p = -(b11 * x + b12 * y), -(b12 * x + b22 * y)
            normal_rate = (
                turn_q * q[0] + turn_p * p[0],
                turn_q * q[1] + turn_p * p[1],
                turn_q * q[2] + turn_p * p[2],
            )
            along_turn = dot(normal_rate, r)
            depth = (
                -normal[0] - along_turn * foot_rate[0],
                -normal[1] - along_turn * foot_rate[1],
                -normal[2] - along_turn * foot_rate[2],
            )
            write_slopes(k, depth, normal_rate, foot_rate, none, foot_rate, out)
        elif dot(r, r) > min_length * min_length:
            write_kink_slopes(k, d, foot_rate, normal, feet.gap[k], out)
        else:
            write_slopes(k, toward_surface, none, none, none, none, out)
