"""The certificate of feet that stay on their face, beside edges which f falls away from.

A face A ends at edges, creases or borders. A point moves straight from P(0) to P(1), w = P(τ) − x;
x_0 and x_1 are stationary points of f_0 and f_1 inside of A; N is the normal of A, T the tangent of
its edges and b what leads from them into A, square to both. Let B be all x of A whose way to x_1 in
A is no longer than r, and t, μ as in `branch_nb`. **If μ > 0 and μ r > t in B, x_0 ∈ B, and
w·b > 0 on all that A ends at in B, for τ = 0 and τ = 1, one branch joins x_0 and x_1.**

w·b > 0 holds for all τ between, being linear in τ. A shortest way of A from x_1 runs inside of A as
a geodesic, or along an edge where that bends away from A, and goes over from one to the other, or
round a corner of the edge, without a turn or with one away from A. Along an edge f'' is
1 − κ m + |k| w·b, k the part of its curvature in the surface; at a corner the slope of f jumps by
w·b' ≥ 0, b' between the b of both sides. So f bends by μ at least on the whole of it, and as in
`branch_nb` no f_τ has a stationary point near the rim of B; nor has it one on the edges, for it
falls from there into A. The branches of its minima in B, which are nondegenerate, run over all τ,
then; at τ = 1 there is one of them, x_1, and so there is one at τ = 0, x_0.

Nothing is asked of the face beyond the edge, nor how many edges there are. That is what feet of
points inside of a solid need beside its sharp edges, where there is a minimum on either face.

**How far the face sees the point**: along an edge w·b changes with its length by −k_g w·T + τ_g m,
k_g its curvature in the surface and τ_g its torsion there, half the difference of the largest
curvatures at most. The edge is known to within its width δ; w·b > 2 δ keeps the branch farther from
it than that.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE, SMOOTH
from contiga.arrays.kernels.vector_nb import cross, dot, minus
from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.search.certify.kernels.about_edge_nb import along, at_rim, cell_of, is_in, tangent
from contiga.search.certify.kernels.bend_nb import INNER, OUTER, SPEED_S, SPEED_T, principal
from contiga.search.certify.kernels.branch_nb import WIDER, holds, seen_from
from contiga.search.certify.kernels.crease_nb import SAME, reach_along, seen_along
from contiga.search.certify.kernels.edge_segment_nb import (
    AT_END,
    place_on,
    side_segment,
    stretch,
    through,
    with_hair,
)
from contiga.search.certify.kernels.joined_nb import least_bend

BESIDE = 1e-3
"""How far beside an edge, in halves of the cell, it is asked where the face is."""


@inner(error_model="numpy")
def _parts(segment, axis, start, end):
    """Whether the square of the direction `axis` parts the first stretch of an edge segment from
    the
    straight way from `start` to `end`: its control points are told to be beyond it."""
    coefs, degree = segment.coefs, segment.degree
    low, high = math.inf, -math.inf
    for i in range(degree[0] + 1):
        off = (axis[0] * coefs[0, i, 1] - axis[1] * coefs[0, i, 0]) / coefs[0, i, 2]
        low, high = min(low, off), max(high, off)
    first = axis[0] * start[1] - axis[1] * start[0]
    second = axis[0] * end[1] - axis[1] * end[0]
    return max(first, second) < low or min(first, second) > high


@inner(error_model="numpy")
def _is_between(segment, start, end):
    """Whether the straight way from `start` to `end`, places (x, y) of the cell, may meet the first
    stretch of a segment."""
    coefs, degree = segment.coefs, segment.degree
    n = degree[0]
    chord = (
        coefs[0, n, 0] / coefs[0, n, 2] - coefs[0, 0, 0] / coefs[0, 0, 2],
        coefs[0, n, 1] / coefs[0, n, 2] - coefs[0, 0, 1] / coefs[0, 0, 2],
    )
    way = (end[0] - start[0], end[1] - start[1])
    across = (-way[1], way[0])
    return not (
        _parts(segment, chord, start, end)
        or _parts(segment, way, start, end)
        or _parts(segment, across, start, end)
    )


@inner(error_model="numpy")
def _side_of(tables, e, cell, segment):
    """On which side of the first stretch of an edge segment the face is: 1 left, −1 right, 0 not
    known."""
    x, y, dx, dy = place_on(segment, 0, 0.5)
    size = math.hypot(dx, dy)
    if not size > 0.0:
        return 0
    s, half_s = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[1] - cell[0])
    t, half_t = 0.5 * (cell[2] + cell[3]), 0.5 * (cell[3] - cell[2])
    dx, dy = BESIDE * dx / size, BESIDE * dy / size
    left = is_in(tables, e, s + half_s * (x - dy), t + half_t * (y + dx))
    right = is_in(tables, e, s + half_s * (x + dy), t + half_t * (y - dx))
    return 0 if left == right else (1 if left else -1)


@inner(linked=False, error_model="numpy")
def _sees(tables, foot, cell, path, work):
    """Whether w·b > 0 holds along the first stretch of the edge segment in a cell of the foot."""
    cells, segment = work.cells, work.segment
    h = cells.derivatives
    e = foot[0]
    which = _side_of(tables, e, cell, segment)
    if which == 0:
        return False
    at, slope, (arc, bent) = along(segment, 1, foot, cell, cells.bending)
    if not arc * bent < math.inf:
        return False
    forward = tangent(tables.elements, e, at, slope, h)
    normal = normal_at(tables.elements, e, at[0], at[1], h)
    origin = tables.elements.table[e]["origin"]
    point = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    b = cross(normal, forward)
    left = 0.0
    for c in range(3):
        left += b[c] * (slope[0] * h[c, 2] - slope[1] * h[c, 1])
    if (left > 0.0) != (which > 0):
        b = (-b[0], -b[1], -b[2])
    ends = (minus(path[0], point), minus(path[1], point))
    reach = reach_along(forward, ends, arc, bent, (0.0, 0.0))
    first, second = seen_along(cells.here, b, ends, reach, bent)
    slack = 2.0 * tables.elements.table[e]["edge_tolerance"] + SAME * tables.scale[1]
    return min(first.least, second.least) > slack


@inner(error_model="numpy")
def _sides_see(tables, foot, cell, path, work):
    """Whether w·b > 0 holds along all sides of its element that a cell of the foot reaches.

    Those at the rim of a trimmed patch are left to its trimming pieces.
    """
    e = foot[0]
    row = tables.elements.table[e]
    trimmed = tables.trims.trimmed[row["patch"]] != 0
    for side in range(4):
        if cell[side] != (-0.5 if side & 1 == 0 else 0.5) or (trimmed and at_rim(tables, e, side)):
            continue
        if row["kind"][side] == SMOOTH or row["kind"][side] == POLE:
            return False
        side_segment(side, work.segment)
        if not _sees(tables, foot, cell, path, work):
            return False
    return True


@inner(error_model="numpy")
def _pieces_see(tables, foot, last, cell, path, work):
    """Whether w·b > 0 holds along all trimming pieces in a cell of the foot, and none of them is
    between it and the start `last`."""
    e = foot[0]
    trims = tables.trims
    segment = work.segment
    patch = tables.elements.table[e]["patch"]
    u0, v0 = parameters(tables.elements, e, cell[0], cell[2])
    u1, v1 = parameters(tables.elements, e, cell[1], cell[3])
    uv_box = (u0, u1, v0, v1)
    wide = with_hair(trims, patch, uv_box)
    s, half_s = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[1] - cell[0])
    t, half_t = 0.5 * (cell[2] + cell[3]), 0.5 * (cell[3] - cell[2])
    here = ((foot[1] - s) / half_s, (foot[2] - t) / half_t)
    there = ((last[1] - s) / half_s, (last[2] - t) / half_t)
    for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        first, end = through(trims, k, wide)
        if first > end + AT_END:
            continue
        if not first < end:
            return False
        segment.degree[0] = stretch(trims, k, (first, end), uv_box, segment.coefs[0])
        if _is_between(segment, here, there) or not _sees(tables, foot, cell, path, work):
            return False
    return True


@inner(error_model="numpy")
def _may_end(tables, e):
    """Whether the face of an element may end in it or at its sides."""
    row = tables.elements.table[e]
    if tables.trims.trimmed[row["patch"]] != 0:
        return True
    ends = False
    for side in range(4):
        ends = ends or (row["kind"][side] != SMOOTH and row["kind"][side] != POLE)
    return ends


@inner(error_model="numpy")
def _is_foot(at, normal, point, tolerance):
    """Whether a place on a face is a foot of a point, by its normal."""
    w = minus(point, at)
    m = dot(w, normal)
    off = (w[0] - m * normal[0], w[1] - m * normal[1], w[2] - m * normal[2])
    return math.sqrt(dot(off, off)) <= SAME * tolerance


@inner(linked=False, error_model="numpy")
def stays_in_face(tables, foot, last, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1], (e, s, t) each, in
    the face that both are in.

    `work` is of `edge_work`.
    """
    e, s, t = foot
    if last[0] != e or not _may_end(tables, e):
        return False
    cells = work.cells
    bend, h = cells.here, cells.derivatives
    normal = normal_at(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, metric = principal(h)
    seen = seen_from(at, normal, path[0], path[1], tables.scale[1])
    m = seen.heights
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    if not (metric[2] > 0.0 and least > 0.0 and _is_foot(at, normal, path[1], tables.scale[1])):
        return False
    way = abs(last[1] - s) * metric[0] + abs(last[2] - t) * metric[1]
    r = WIDER * max(1.1 * way + tables.scale[1], seen.slip / least)
    cell = cell_of(tables, foot, r, bend, cells.bending)
    if cell[1] == cell[0]:
        return False
    way = abs(last[1] - s) * bend[SPEED_S] + abs(last[2] - t) * bend[SPEED_T]
    if not (way <= r - tables.scale[1] and holds((bend[INNER], bend[OUTER]), seen, r)):
        return False
    if not _sides_see(tables, foot, cell, path, work):
        return False
    if tables.trims.trimmed[tables.elements.table[e]["patch"]] == 0:
        return True
    return _pieces_see(tables, foot, last, cell, path, work)
