"""Derivatives of the depth and the normal at feet, with respect to their points.

With the foot q of a point p, the unit normal n along which the gap g is measured, p = q + g n: the
depth −g falls along n. On a face dn = H dp with H = −B (1 − g B)⁻¹ of the second fundamental form B
(do Carmo, Differential Geometry of Curves and Surfaces, 3-2). On a curve C the foot moves by
dq = C' (C'·dp)/(|C'|² − (p − C)·C''), at a vertex by nothing, and the normal is the way from the
foot to the point: g dn is the part of dp − dq across it. A foot that is held on a border may keep
the normal n(C) of its face, to which the point is not square.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE
from contiga.arrays.kernels.foot_slopes_nb import (
    SQUARE,
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

SAME_PLACE = 1e-7
"""Places (u, v) this near, as a share of the patch, are one."""
STARTS = 8
STEPS = 12
"""Newton's steps on a trimming piece, from each of as many starts."""
SMALL = 10.0
"""Tolerances of a foot below which a way has no direction."""


@inner()
def _miss(trims, piece, t, place, c):
    """Squared distance in (u, v), as a share of the patch, of a piece at t from `place`, and its
    first and second derivative over t."""
    domain = trims.domain[trims.piece_patch[piece]]
    piece_parameters(trims, piece, t, c)
    square = slope = bend = 0.0
    for k in range(2):
        wide = 1.0 / (domain[2 * k + 1] - domain[2 * k])
        r, d1, d2 = (c[0, k] - place[k]) * wide, c[1, k] * wide, c[2, k] * wide
        square += r * r
        slope += 2.0 * r * d1
        bend += 2.0 * (d1 * d1 + r * d2)
    return square, slope, bend


@inner()
def _is_near(trims, piece, place):
    """Return whether the box of a piece's control points holds a place, but for a little."""
    domain = trims.domain[trims.piece_patch[piece]]
    for k in range(2):
        little = SAME_PLACE * (domain[2 * k + 1] - domain[2 * k])
        low, high = math.inf, -math.inf
        for i in range(trims.piece_degree[piece] + 1):
            x = trims.piece_coefs[piece, i, k] / trims.piece_coefs[piece, i, 2]
            low, high = min(low, x), max(high, x)
        if not low - little <= place[k] <= high + little:
            return False
    return True


@inner()
def _place_on(trims, piece, place, c):
    """Parameter t of a trimming piece at `place` (u, v), and how far it misses it, squared."""
    best, best_t = math.inf, 0.0
    for i in range(STARTS + 1):
        t = i / STARTS
        for _ in range(STEPS):
            square, slope, bend = _miss(trims, piece, t, place, c)
            if square < best:
                best, best_t = square, t
            step = slope / bend if bend > 0.0 else 0.0
            t = min(max(t - step, 0.0), 1.0)
            if step == 0.0:
                break
    return best_t, best


@inner()
def _misses(d, r):
    """Cosine of the angle between a curve's derivative d and the way r to a point; one where there
    is no curve."""
    square = dot(d, d)
    return abs(dot(d, r)) / math.sqrt(square * dot(r, r)) if square > 0.0 else 1.0


@inner()
def _curve_at(tables, foot, feature, r, h):
    """First and second derivative of the curve that a foot is the closest point of: zeros at a
    vertex.

    Sides of elements and trimming pieces pass through the foot; the one that the way r to the point
    is square to is the curve.
    """
    e, s, t = foot
    elements, trims = tables.elements, tables.trims
    best = SQUARE
    first = second = (0.0, 0.0, 0.0)
    patch = elements.table[e]["patch"]
    if feature != EDGE:
        return first, second
    evaluate(elements, e, s, t, h)
    for side in range(4):
        if not stands(side, s, t):
            continue
        d = column(h, 2 if side < 2 else 1)
        miss = _misses(d, r)
        if miss < best:
            best, first, second = miss, d, column(h, 5 if side < 2 else 3)
    if trims.trimmed[patch] == 0:
        return first, second
    box = elements.table[e]["box"]
    place = (box[0] + (s + 0.5) * (box[1] - box[0]), box[2] + (t + 0.5) * (box[3] - box[2]))
    c = scratch(3, 3)
    for piece in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        if not _is_near(trims, piece, place):
            continue
        at, square = _place_on(trims, piece, place, c)
        if square > SAME_PLACE * SAME_PLACE:
            continue
        curve_point(elements, tables.grid, trims, piece, at, h, c)
        d = (c[1, 0], c[1, 1], c[1, 2])
        miss = _misses(d, r)
        if miss < best:
            best, first, second = miss, d, (c[2, 0], c[2, 1], c[2, 2])
    return first, second


@inner()
def _on_face(elements, k, foot, normal, gap, out, h):
    """A foot inside a face: H of the second fundamental form."""
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
def _on_held_border(elements, k, foot, r, moves, normal, out, h):
    """A foot on a border that keeps the normal of its face: it turns as the foot goes along."""
    d, over = moves
    q, p, b11, b12, b22 = bending(elements, foot, normal, h)
    x, y = dot(q, d), dot(p, d)
    a, b = -(b11 * x + b12 * y), -(b12 * x + b22 * y)
    turned = (a * q[0] + b * p[0], a * q[1] + b * p[1], a * q[2] + b * p[2])
    lost = dot(turned, r)
    depth = (
        -normal[0] - lost * over[0],
        -normal[1] - lost * over[1],
        -normal[2] - lost * over[2],
    )
    write_slopes(k, depth, turned, over, (0.0, 0.0, 0.0), over, out)


@kernel(error_model="numpy")
def slopes(tables, points, feet, out, start, stop):
    """Fill rows start … stop of `out`, `FootSlopes`; `feet` is a `Projection` of as many points
    (k, 3), with their true distances from the surface as gaps."""
    elements, small = tables.elements, SMALL * tables.scale[1]
    h = scratch(4, 6)
    none = (0.0, 0.0, 0.0)
    for k in range(start, stop):
        foot = locate(tables.grid, feet.patch[k], feet.uv[k, 0], feet.uv[k, 1])
        normal = (feet.normal[k, 0], feet.normal[k, 1], feet.normal[k, 2])
        if feet.feature[k] == FACE:
            _on_face(elements, k, foot, normal, feet.gap[k], out, h)
            continue
        at = (feet.point[k, 0], feet.point[k, 1], feet.point[k, 2])
        r = minus((points[k, 0], points[k, 1], points[k, 2]), at)
        d, bend = _curve_at(tables, foot, feet.feature[k], r, h)
        over = dot(d, d) - dot(r, bend)
        share = 1.0 / over if over > 0.0 else 0.0
        moves = (d, (d[0] * share, d[1] * share, d[2] * share))
        if not is_along(r, normal, small):
            _on_held_border(elements, k, foot, r, moves, normal, out, h)
        elif dot(r, r) > small * small:
            write_kink_slopes(k, moves[0], moves[1], normal, feet.gap[k], out)
        else:
            write_slopes(k, (-normal[0], -normal[1], -normal[2]), none, none, none, none, out)
