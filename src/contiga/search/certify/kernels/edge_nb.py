"""The certificate of feet on and beside the edges of trimmed faces.

The theorem of `crease_nb` asks nothing of how the faces are parametrised. Here they are two faces
A and B that end at a common edge: A, where the foot x_1 is, in a cell about that; B in a cell about
the place y of the edge next to it (`about_edge_nb`).

**Of what surface this is claimed.** Faces of a file meet within a tolerance. The claim is about
every surface of two faces that are joined exactly, whose points are no farther from those of the
file than the width δ of the edge, and whose tangents and normals along it differ from those of the
file by no more than its slip σ (or, where faces are joined smoothly, its turn) as it was measured
when the body was built (`trimmed_edges`). Where a way crosses the edge segment at an angle φ, the
slope of f may then fall by δ, if w·(b_1 + b_2) + 2 |w| σ ≤ 0 there; else by δ + sin φ |w| α, where
the faces turn by α at most, outer side or inner. That is used for joints meant to be smooth only,
with α ≤ `FOLD`: beside a real fold two minima that were as good as one may part later, and which of
them is followed would not be known. Beside a smooth joint they stay within |w| α/μ. The angles
under which a shortest way can cross again and again add up to less than 1 + 2 k r, for between two
crossings the edge segment turns by their sum. So on all shortest ways the slope of f falls by D in
all at most, and grows by μ a length otherwise. Then the minima of f_τ in the ball lie within D/μ of
each other: **the branch is known to D/μ**, and that must be no more than `SHARP` allows. All else
is as there, with t + D in place of t.

**A branch that ends at a fold.** On the inner side of a fold a minimum x_0 of f_0 in A may run
into the edge. Let B be the ball of radius r about x_0, f_τ convex with modulus μ > 0 along the
shortest ways of A in it (1 and 2 above, for A alone), v the way from x_0 to the edge, and t the
length of P(1) − P(0). Suppose

1. 2 t/μ + v ≤ r;
2. w·b_2 > 0 on the edge in B for all τ: f falls from there into the other face;
3. w·b_1 < 0 on the edge in B for τ = 1: there f falls on the way to it.

Then the branch of minima through x_0 ends on the way. While it lasts it is in A, off the edge by 2,
and no farther than t/μ from x_0, for the slopes of f_τ at x_0 are −t at least. But there is no
minimum z for τ = 1: f would rise all along the shortest way from it to the edge, no longer than
t/μ + v, which meets that at a right angle, and falls there by 3. The tolerances are taken from
all sides of 2 and 3, and where f falls in 2 by less than `FOLD` |w| a joint counts as smooth: a
foot that goes over it does not jump.
"""

from __future__ import annotations

import math

from contiga.arrays.kernels.vector_nb import dot, minus
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.search.certify.certify_records import Curve
from contiga.search.certify.kernels.about_edge_nb import BENT, fold_about, way_to
from contiga.search.certify.kernels.bend_nb import principal
from contiga.search.certify.kernels.branch_nb import WIDER, seen_from
from contiga.search.certify.kernels.crease_nb import (
    SAME,
    fall_from,
    least_along,
    least_in_face,
    most_jump,
    reach_along,
    seen_along,
)
from contiga.search.certify.kernels.edge_segment_nb import stretch_bend
from contiga.search.certify.kernels.joined_nb import least_bend

SHARP = 1e-6
"""A branch is known if it is to this share of the body's size, or to a few widths of the edge."""
FEW = 4.0
TRIES = 3
LEAST = 0.1
"""Least curvature of f that a ball is laid out for."""
AHEAD = 3.5
"""The ball about a minimum that may run into a fold is at least so many times as large as
its way."""
FOLD = 1e-3
"""Sine of the angle under which f falls into the other face of a fold that is none: joints that are
meant to be smooth."""


@inner(error_model="numpy")
def _give(joint):
    """By how much tangents and normals of an `EdgeJoint` are uncertain, radians."""
    return min(joint.slip, joint.turn)


@inner(linked=False, error_model="numpy")
def _slip_at(tables, foot, fold, ends, path, h):
    """t of the theorem; infinite where the foot is none. `fold` is an `EdgeFold`."""
    first, across, joint = fold.first, fold.second.across, fold.joint
    tolerance = tables.scale[1]
    if fold.way > SAME * tolerance:
        e, s, t = foot
        normal = normal_at(tables.elements, e, s, t, h)
        origin = tables.elements.table[e]["origin"]
        at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
        w = minus(path[1], at)
        m = dot(w, normal)
        off = (w[0] - m * normal[0], w[1] - m * normal[1], w[2] - m * normal[2])
        if math.sqrt(dot(off, off)) > SAME * tolerance:
            return math.inf
        return seen_from(at, normal, path[0], path[1], tolerance).slip
    far = math.sqrt(dot(ends[1], ends[1]))
    end = fall_from(ends[1], first.tangent, first.across, across)
    if end > SAME * tolerance + joint.width + far * _give(joint):
        return math.inf
    return max(fall_from(ends[0], first.tangent, first.across, across), end) + 4.0 * tolerance


@inner(error_model="numpy")
def _reach_of(fold, ends):
    """As `reach_along`, of the edge segment of a fold."""
    given = (fold.joint.width, _give(fold.joint))
    return reach_along(fold.first.tangent, ends, fold.arc, fold.bent, given)


@inner(error_model="numpy")
def _least_of(fold, bend, frame, ends, r):
    """Least curvature of f in a face of a fold, ball of radius r."""
    reach, way = _reach_of(fold, ends), fold.way + r
    wide = (reach.far - reach.arc + way, way)
    return least_in_face(bend, frame.normal, ends[0], ends[1], wide)


@inner(error_model="numpy")
def _least_on_segment(fold, ends, work):
    """Least curvature of f along the edge segment of a fold."""
    cells, segment = work.cells, work.segment
    least = 1.0
    for k in range(fold.stretches):
        c, rest, slowest, _, bent = stretch_bend(segment, k, cells.bending)
        curve = Curve(c, rest, slowest, bent)
        least = min(least, least_along(curve, ends, _reach_of(fold, ends)))
    return least


@inner(linked=False, error_model="numpy")
def _least_and_drop(fold, ends, r, work):
    """μ and D of the theorem."""
    cells = work.cells
    first, second, bent, joint = fold.first, fold.second, fold.bent, fold.joint
    reach = _reach_of(fold, ends)
    least = min(
        _least_of(fold, cells.here, first, ends, r),
        _least_of(fold, cells.beyond, second, ends, r),
        _least_on_segment(fold, ends, work),
    )
    faces = (first.across, second.across)
    jump = most_jump((cells.here, cells.beyond), faces, ends, reach, bent)
    if jump + 2.0 * reach.far * joint.slip <= 0.0:
        return least, joint.width
    if joint.turn > FOLD:
        return least, math.inf
    return least, joint.width + (1.0 + 2.0 * bent * r) * reach.far * joint.turn


@inner(linked=False, error_model="numpy")
def over_edge(tables, foot, last, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1] by an edge.

    `work` is of `edge_work`.
    """
    cells = work.cells
    h = cells.derivatives
    e, s, t = foot
    normal = normal_at(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, _ = principal(h)
    seen = seen_from(at, normal, path[0], path[1], tables.scale[1])
    m, slip = seen.heights, seen.slip
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    normal_at(tables.elements, last[0], last[1], last[2], h)
    origin = tables.elements.table[last[0]]["origin"]
    d = (h[0, 0] + origin[0] - at[0], h[1, 0] + origin[1] - at[1], h[2, 0] + origin[2] - at[2])
    off = math.sqrt(dot(d, d))
    need = max(2.0 * off, 2.0 * slip / max(least, LEAST)) + SAME * tables.scale[1]
    for _ in range(TRIES):
        r = WIDER * need
        fold = fold_about(tables, foot, r, work)
        if not fold.is_known:
            return False
        width, origin_of_w = fold.joint.width, fold.first.point
        ends = (minus(path[0], origin_of_w), minus(path[1], origin_of_w))
        slip = _slip_at(tables, foot, fold, ends, path, h)
        least, drop = _least_and_drop(fold, ends, r, work)
        if not (least > 0.0 and slip < math.inf):
            return False
        if not drop <= least * max(SHARP * tables.scale[0], FEW * width):
            return False
        way = BENT * way_to(foot, last, fold.there, fold.way, cells) + width + tables.scale[1]
        need = max(way, 2.0 * (slip + drop) / least)
        if need <= r:
            return True
        if not need < math.inf:
            return False
    return False


@inner(linked=False, error_model="numpy")
def rests_on_edge(tables, foot, point, r, work):
    """Whether a start on or beside an edge is the foot of its point at all.

    `r` is how much of the edge about it is looked at.
    """
    fold = fold_about(tables, foot, r, work)
    if not (fold.is_known and fold.way <= SAME * tables.scale[1]):
        return False
    w = minus(point, fold.first.point)
    return _slip_at(tables, foot, fold, (w, w), (point, point), work.cells.derivatives) < math.inf


@inner(linked=False, error_model="numpy")
def runs_into_fold(tables, last, path, work):
    """Whether the branch of the minimum `last` of path[0] is proved to end at a fold on the way to
    path[1]: the second theorem."""
    h = work.cells.derivatives
    e, s, t = last
    normal = normal_at(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, _ = principal(h)
    m = seen_from(at, normal, path[0], path[1], tables.scale[1]).heights
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    d = minus(path[1], path[0])
    slip = math.sqrt(dot(d, d)) + SAME * tables.scale[1]
    need = AHEAD * slip / max(least, LEAST)
    for _ in range(TRIES):
        r = WIDER * need
        fold = fold_about(tables, last, r, work)
        if not fold.is_known:
            return False
        first, second, bent, joint = fold.first, fold.second, fold.bent, fold.joint
        ends = (minus(path[0], first.point), minus(path[1], first.point))
        reach = _reach_of(fold, ends)
        least = _least_of(fold, work.cells.here, first, ends, r)
        least = min(least, _least_on_segment(fold, ends, work))
        slack = joint.width + reach.far * joint.slip
        before, after = seen_along(work.cells.beyond, second.across, ends, reach, bent)
        falls = min(before.least, after.least) - slack
        _, at_last = seen_along(work.cells.here, first.across, ends, reach, bent)
        past = at_last.largest + slack
        if not (least > 0.0 and falls > FOLD * reach.far):
            return False
        need = 2.0 * slip / least + BENT * fold.way
        if need <= r:
            return past < 0.0
    return False
