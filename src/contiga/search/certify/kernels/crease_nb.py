"""The certificate of feet on and beside a crease.

A surface is bent into a crease where two faces meet under a turn α; e, b_i, N_i as in `fold_nb`.
A point moves straight from P(0) to P(1), w = P(τ) − x, f_τ(x) = |w|²/2. Let x_1 be a minimum of f_1
and B all x whose way to x_1 is r at most: no border in it, no vertex, and one crease at most. Ways
that are shortest on the surface go straight over a crease, as they would on the faces laid flat.
**Suppose that for all τ, with some μ > 0,**

1. **1 − κ m ≥ μ on the faces** in B, m = w·N, for all normal curvatures κ;
2. **1 − w·k ≥ μ on the crease** in B, k the vector of its curvature;
3. **w·(b_1 + b_2) ≤ 0 on the crease** in B: the point is on the outer side of the fold;
4. **2 t ≤ μ r**, where −t bounds the slopes of f_0 and f_1 at x_1, and x_0 ∈ B is stationary.

**Then one branch of minima joins x_0 to x_1.** For f_τ is convex with modulus μ along every
shortest way in B: f'' ≥ μ in the faces by 1 and where it runs along the crease by 2; where it
crosses the crease its slope jumps by −sin φ w·(b_1 + b_2) ≥ 0, φ the angle between them. The
slopes at x_1 being linear in τ, all are −t at least, so that f_τ rises on each shortest way from
x_1 where it is longer than t/μ ≤ r/2. So f_τ has its least value in B on the ball of half the
radius, and has no other minimum than there. A shortest way between two points of that stays in B.
So f_τ has but one minimum in B, strict, which moves without a jump; x_0 and x_1 are it at τ = 0
and 1.

Nothing of this asks on which face x_0 and x_1 are, or whether they are on the crease. Beside the
inner side of a fold there are two minima, and the foot does jump: nothing is proved there.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import CREASE
from contiga.arrays.kernels.vector_nb import dot, minus
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.search.certify.certify_records import Range, Reach
from contiga.search.certify.kernels.bend_nb import INNER, OUTER
from contiga.search.certify.kernels.branch_nb import WIDER, seen_from
from contiga.search.certify.kernels.cells_nb import CELL, cell_about, cells_about, touched
from contiga.search.certify.kernels.fold_nb import (
    largest_bend,
    side_bend,
    side_frame,
    speed_across,
    speed_along,
)
from contiga.search.closest.kernels.around_nb import stands

SAME = 1e3
"""A slope of this many tolerances is none."""


@inner(error_model="numpy")
def crease_beside(elements, foot, last):
    """The side of the foot's element that is the crease nearest to it; −1 where none is.

    The one beyond which the start `last` lies goes first.
    """
    e, s, t = foot
    best = 1.0
    nearest = -1
    for side in range(4):
        if elements.table[e]["kind"][side] != CREASE:
            continue
        x = s if side < 2 else t
        off = 0.5 - x if side & 1 else x + 0.5
        if last[0] != e and elements.table[e]["neighbour"][side] == last[0]:
            off -= 1.0
        if off < best:
            best = off
            nearest = side
    return nearest


@inner(error_model="numpy")
def fall_from(w, tangent, b_1, b_2):
    """How fast f falls at most on the ways from a point of a crease where its gradient is −w."""
    along = dot(w, tangent) ** 2
    in_first = max(dot(w, b_1), 0.0)
    in_second = max(dot(w, b_2), 0.0)
    return math.sqrt(along + max(in_first, in_second) ** 2)


@inner(error_model="numpy")
def _slip(near, foot, side, fold, path, h):
    """t of the theorem; infinite where the foot is none."""
    e, s, t = foot
    elements, tolerance = near.elements, near.tolerance
    first, second = fold
    if stands(side, s, t):
        faces = first.across, second.across
        end = fall_from(minus(path[1], first.point), first.tangent, *faces)
        if end > SAME * tolerance:
            return math.inf
        before = fall_from(minus(path[0], first.point), first.tangent, *faces)
        return max(before, end) + 4.0 * tolerance
    normal = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    return seen_from(at, normal, path[0], path[1], tolerance).slip


@inner(error_model="numpy")
def _least_guess(fold, w0, w1):
    """Least curvature of f at the crease."""
    bent = fold[0].bent
    most = max(dot(w0, bent), dot(w1, bent), 0.0)
    for frame in fold:
        bends = frame.principal
        m0 = dot(w0, frame.normal)
        m1 = dot(w1, frame.normal)
        most = max(most, bends.inner * max(m0, m1), -bends.outer * min(m0, m1))
    return 1.0 - most


@inner(error_model="numpy")
def least_in_face(bend, normal, w0, w1, wide):
    """Least curvature of f in a face with this normal where `w0` and `w1` are taken; `wide` is
    (|w| at most, longest way from there)."""
    m0 = dot(w0, normal)
    m1 = dot(w1, normal)
    change = largest_bend(bend) * wide[0] * wide[1]
    high = max(m0, m1, 0.0) + change
    low = min(m0, m1, 0.0) - change
    return 1.0 - max(bend[INNER] * high, -bend[OUTER] * low)


@inner(error_model="numpy")
def least_along(curve, ends, reach):
    """Least curvature of f along a `Curve`.

    `ends` is (w for P(0), w for P(1)) at the middle of it, `reach` its `Reach`.
    """
    c = curve.second
    size = math.sqrt(dot(c, c))
    most = max(dot(ends[0], c), dot(ends[1], c)) + reach.far * curve.change + reach.arc * size
    most += reach.along * (size + curve.change)
    return 1.0 - max(most, 0.0) / curve.slowest**2


@inner(error_model="numpy")
def most_jump(bends, b, ends, reach, bent):
    """Largest w·(b_1 + b_2) along the crease, `b` holds both; `ends` and `reach` as above, `bent`
    its curvature at most."""
    torsion = 0.5 * (bends[0][INNER] + bends[0][OUTER] + bends[1][INNER] + bends[1][OUTER])
    change = reach.arc * (2.0 * bent * reach.along + torsion * reach.far)
    jump0 = dot(ends[0], b[0]) + dot(ends[0], b[1])
    jump1 = dot(ends[1], b[0]) + dot(ends[1], b[1])
    return max(jump0, jump1) + change


@inner(error_model="numpy")
def reach_along(tangent, ends, arc, bent, given):
    """The `Reach` of a crease or an edge.

    `arc` is its length either way from where `tangent` and `ends` are taken, `bent` its largest
    curvature; places and tangents are given to within `given`, a length and radians.
    """
    w0, w1 = ends
    far = math.sqrt(max(dot(w0, w0), dot(w1, w1))) + given[0]
    along = max(abs(dot(w0, tangent)), abs(dot(w1, tangent))) + far * given[1]
    return Reach(arc, far + arc, along + (1.0 + (far + arc) * bent) * arc)


@inner(error_model="numpy")
def seen_along(bend, b, ends, reach, bent):
    """w·b of a face along an edge segment, a `Range` at either end of the motion."""
    torsion = 0.5 * (bend[INNER] + bend[OUTER])
    change = reach.arc * (bent * reach.along + torsion * reach.far)
    first = dot(ends[0], b)
    second = dot(ends[1], b)
    return Range(first - change, first + change), Range(second - change, second + change)


@inner(error_model="numpy")
def _is_convex(foot, sides, fold, ends, size, slip, work):
    """Whether the conditions hold by the bounds left in `work` of the cells on both sides."""
    _, s, t = foot
    side, there = sides
    r, far_s, far_t = size
    bends = (work.here, work.beyond)
    w0, w1 = ends
    arc = (far_t if side < 2 else far_s) * min(
        speed_along(bends[0], side), speed_along(bends[1], there)
    )
    off = (0.5 - abs(s if side < 2 else t)) * speed_across(bends[0], side)
    curve = side_bend(bends[0], work.bending, cell_about(s, t, far_s, far_t), side)
    first, second = fold
    reach = reach_along(first.tangent, ends, arc, curve.bent, (0.0, 0.0))
    wide = (reach.far + off + r, arc + off + r)
    least = min(
        least_in_face(bends[0], first.normal, w0, w1, wide),
        least_in_face(bends[1], second.normal, w0, w1, wide),
        least_along(curve, ends, reach),
    )
    if not (least > 0.0 and 2.0 * slip <= least * r):
        return False
    return most_jump(bends, (first.across, second.across), ends, reach, curve.bent) <= 0.0


@inner(linked=False, error_model="numpy")
def over_crease(near, foot, last, side, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1] by the crease that
    is a side of the foot's element.

    `near` and `work` are as for `prove`.
    """
    elements, tolerance = near.elements, near.tolerance
    e, s, t = foot
    h = work.derivatives
    x = t if side < 2 else s
    n = elements.table[e]["neighbour"][side]
    there = elements.table[e]["neighbour_side"][side]
    first = side_frame(elements, e, side, x, h)
    second = side_frame(elements, n, there, -x if elements.table[e]["flip"][side] == 1 else x, h)
    metric, other = first.principal.metric, second.principal.metric
    if not (metric[2] > 0.0 and other[2] > 0.0):
        return False
    ends = (minus(path[0], first.point), minus(path[1], first.point))
    least = _least_guess((first, second), ends[0], ends[1])
    slip = _slip(near, foot, side, (first, second), path, h)
    if not (least > 0.0 and slip < math.inf):
        return False
    way = _way_guess(elements, foot, last, metric, h)
    r = WIDER * max(1.1 * way + tolerance, 2.0 * slip / least)
    beside = min(metric[3 if side < 2 else 2], other[3 if there < 2 else 2])
    across = metric[2 if side < 2 else 3]
    size = (r, CELL * r / across, CELL * r / beside)
    if side >= 2:
        size = (r, CELL * r / beside, CELL * r / across)
    if touched(s, t, size[1], size[2]) != side:
        return False
    way = cells_about(elements, foot, last, size, side, work)
    if not 0.0 <= way <= r - tolerance:
        return False
    return _is_convex(foot, (side, there), (first, second), ends, size, slip, work)


@inner(error_model="numpy")
def _way_guess(elements, foot, last, metric, h):
    """About how long the way from foot to start is."""
    e, s, t = foot
    if last[0] == e:
        return abs(last[1] - s) * metric[0] + abs(last[2] - t) * metric[1]
    normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    normal_at(elements, last[0], last[1], last[2], h)
    origin = elements.table[last[0]]["origin"]
    d = (h[0, 0] + origin[0] - at[0], h[1, 0] + origin[1] - at[1], h[2, 0] + origin[2] - at[2])
    return 1.4 * math.sqrt(dot(d, d))
