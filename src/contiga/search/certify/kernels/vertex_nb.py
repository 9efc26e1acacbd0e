"""The certificate of feet at a vertex, and of those on a crease up to one.

e, b_i, f_τ, w as in `crease_nb`; T are the tangents of all sides that meet at a vertex v, away from
it. A point moves straight from P(0) to P(1).

**A vertex that stays a foot** needs no bounds: if w·T < 0 for all T at τ = 0 and τ = 1, then for
all τ between and all T between two sides.

**On a crease** let C be the part of it between x_0 and x_1, minima of f_0 and f_1 on it. Suppose
that for τ = 0 and τ = 1

1. w·b_1 < 0 and w·b_2 < 0 along C;
2. 1 − w·k > 0 along C, k the vector of its curvature;
3. w·T < 0 where C ends at a vertex, for all T there but that of C.

**Then one branch of minima joins x_0 and x_1.** 1 and 3 hold for all τ between. f_0 and f_1 are
convex along C by 2, and rise from their minima; so no f_τ falls where C ends, if one were to go on
there, and each has one minimum on it, which moves without a jump. Inside of C f_τ rises from it
into both faces, by 1. At a vertex it rises along all T, that of C at least to second order, and so
on all ways between. It is a minimum on the surface, then, and x_0 and x_1 are it for τ = 0 and 1.

Unlike that of `crease_nb` this asks nothing of how the faces bend.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import CREASE
from contiga.arrays.kernels.vector_nb import dot, minus
from contiga.elements.kernels.sides_nb import side_point
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.kernels.bend_nb import bend_bounds
from contiga.search.certify.kernels.cells_nb import SNAP
from contiga.search.certify.kernels.crease_nb import SAME, least_along, reach_along, seen_along
from contiga.search.certify.kernels.fold_nb import side_bend, side_frame, speed_along
from contiga.search.closest.kernels.around_nb import MOST, around, inward_slope, stands
from contiga.search.closest.kernels.local_nb import expand

OPPOSED = 1e-9
"""Tangents of a corner with a cosine this near to −1 leave no angle between them."""
NARROW = 0.01
"""How far the cells beside a crease reach into its faces, as a share of its length in them."""


@inner(error_model="numpy")
def is_corner(foot):
    """Whether a foot stands at a corner of its element."""
    return abs(foot[1]) >= 0.5 and abs(foot[2]) >= 0.5


@inner()
def _side_along(side, s, t):
    """The side of an element along which the way in from another runs at its corner (s, t)."""
    return (2 if t < 0.0 else 3) if side < 2 else (0 if s < 0.0 else 1)


@inner(error_model="numpy")
def _rises(near, foot, path, free, h):
    """Whether f rises at the corner `foot` along all sides that meet there, for both points of a
    motion, but for the crease `free`: (element, side) on both sides of it, −1 for none."""
    elements, trimmed, tolerance = near.elements, near.trimmed, near.tolerance
    list_e = stack_int64(MOST)
    list_st = scratch(MOST, 2)
    miss = SAME * tolerance
    n = around(elements, foot, list_e, list_st)
    if n >= MOST:
        return False
    left_out = 0
    for k in range(n):
        e, s, t = list_e[k], list_st[k, 0], list_st[k, 1]
        if not is_corner((e, s, t)) or trimmed[elements.table[e]["patch"]] != 0:
            return False
        for point in path:
            q = expand(elements, e, s, t, point, h)
            for side in range(4):
                if stands(side, s, t):
                    if elements.table[e]["kind"][side] > CREASE:
                        return False
                    way = (e, _side_along(side, s, t))
                    if way == free[0] or way == free[1]:
                        left_out += 1
                    elif not inward_slope(q, side) > miss:
                        return False
        sign = -1.0 if (s > 0.0) != (t > 0.0) else 1.0
        cosine = sign * (h[0, 1] * h[0, 2] + h[1, 1] * h[1, 2] + h[2, 1] * h[2, 2])
        if not cosine > (OPPOSED - 1.0) * math.sqrt(q.square_s * q.square_t):
            return False
    # The motion has two points, the crease two faces.
    element, _ = free[0]
    return left_out == (0 if element < 0 else 4)


@inner(linked=False, error_model="numpy")
def stays_at_vertex(near, foot, path, h):
    """Whether the corner `foot` is a strict minimum for all points of a motion."""
    return _rises(near, foot, path, ((-1, -1), (-1, -1)), h)


@inner(error_model="numpy")
def _strip(side, low, high):
    """The cell along the part low … high of a side."""
    edge = -0.5 if side & 1 == 0 else 0.5
    deep = edge - math.copysign(NARROW * (high - low), edge)
    near, other = min(edge, deep), max(edge, deep)
    return (near, other, low, high) if side < 2 else (low, high, near, other)


@inner(error_model="numpy")
def _rises_into(bend, b, ends, reach, bent, miss):
    """Whether w·b < 0 along a crease for one of its faces."""
    first, second = seen_along(bend, b, ends, reach, bent)
    return max(first.largest, second.largest) < -miss


@inner(linked=False, error_model="numpy")
def along_crease(near, foot, last, side, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1], both of one
    element and on one side of it, a crease.

    `near` and `work` are as for `prove`.
    """
    elements, trimmed, tolerance = near.elements, near.trimmed, near.tolerance
    e, s, t = foot
    row = elements.table[e]
    h = work.derivatives
    x, start = (t, last[2]) if side < 2 else (s, last[1])
    n, there = row["neighbour"][side], row["neighbour_side"][side]
    # A hole may lie on the crease, or along one side of it.
    if trimmed[row["patch"]] != 0 or trimmed[elements.table[n]["patch"]] != 0:
        return False
    sign = -1.0 if row["flip"][side] == 1 else 1.0
    first = side_frame(elements, e, side, x, h)
    second = side_frame(elements, n, there, sign * x, h)
    metric = first.principal.metric
    if not (metric[2] > 0.0 and second.principal.metric[2] > 0.0):
        return False
    ends = (minus(path[0], first.point), minus(path[1], first.point))
    fall = dot(ends[1], first.tangent)
    if max(0.0 if x >= 0.5 else fall, 0.0 if x <= -0.5 else -fall) > SAME * tolerance:
        return False
    least = 1.0 - max(dot(ends[0], first.bent), dot(ends[1], first.bent), 0.0)
    if not least > 0.0:
        return False
    # Minima are given to within rounding, and so is where C ends.
    more = max(2.0 * SAME * tolerance / (least * metric[3 if side < 2 else 2]), SNAP)
    low, high = max(min(x, start) - more, -0.5), min(max(x, start) + more, 0.5)
    if not bend_bounds(elements, e, _strip(side, low, high), work.here, work.bending):
        return False
    curve = side_bend(work.here, work.bending, _strip(side, low, high), side)
    arc = (high - low) * speed_along(work.here, side)
    reach = reach_along(first.tangent, ends, arc, curve.bent, (0.0, 0.0))
    least = least_along(curve, ends, reach)
    if not least * more * 2.0 * curve.slowest > SAME * tolerance * (high - low):
        return False
    if not _rises_into(work.here, first.across, ends, reach, curve.bent, SAME * tolerance):
        return False
    low, high = (low, high) if sign > 0.0 else (-high, -low)
    if not bend_bounds(elements, n, _strip(there, low, high), work.beyond, work.bending):
        return False
    if not _rises_into(work.beyond, second.across, ends, reach, curve.bent, SAME * tolerance):
        return False
    for end in (-0.5, 0.5):
        if min(abs(x - end), abs(start - end)) <= more:
            at = side_point(side, end)
            if not _rises(near, (e, at[0], at[1]), path, ((e, side), (n, there)), h):
                return False
    return True


@inner(error_model="numpy")
def common_crease(elements, foot, last):
    """The crease of their element on which two feet stand, −1 where there is none."""
    crease = -1
    for side in range(4):
        both = stands(side, foot[1], foot[2]) and stands(side, last[1], last[2])
        if both and elements.table[foot[0]]["kind"][side] == CREASE:
            crease = side
    return crease


@inner(error_model="numpy")
def _lowest_crease(elements, foot, point, h):
    """The crease from a vertex along which f rises least, or falls: (e, s, t, side), e −1 where f
    rises less along a side that is none."""
    list_e = stack_int64(MOST)
    list_st = scratch(MOST, 2)
    least = math.inf
    lowest = (-1, 0.0, 0.0, -1)
    for k in range(around(elements, foot, list_e, list_st)):
        e, s, t = list_e[k], list_st[k, 0], list_st[k, 1]
        q = expand(elements, e, s, t, point, h)
        for side in range(4):
            if stands(side, s, t) and inward_slope(q, side) < least:
                least = inward_slope(q, side)
                way = _side_along(side, s, t)
                lowest = (e if elements.table[e]["kind"][way] == CREASE else -1, s, t, way)
    return lowest


@inner(linked=False, error_model="numpy")
def leaves_vertex(near, foot, path, work):
    """Whether a foot at a corner stays there, or goes so little along a crease that it is the same
    to within rounding; `near` and `work` are as for `prove`."""
    e, s, t, side = _lowest_crease(near.elements, foot, path[1], work.derivatives)
    return e >= 0 and along_crease(near, (e, s, t), (e, s, t), side, path, work)
