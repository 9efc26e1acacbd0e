"""The certificate of feet on and beside the edges of trimmed faces.

The theorem of `_crease_nb` asks nothing of how the faces are parametrised. Here they are two faces
A and B that end at a common edge: A, where the foot x_1 is, in a cell about that; B in a cell about
the place y of the edge next to it. In both cells the edge is one strand (`_strand_nb`), and nothing
else is trimmed away or ends. A way of length r from x_1 stays in both: a part of it that runs in
the other face between two places of the strand is longer than the strand between them by no less
than cos(1/2), for the strand turns by no more than one radian.

**Of what surface this is claimed.** Faces of a file meet within a tolerance. The claim is about
every surface of two faces that are joined exactly, whose points are no farther from those of the
file than the width δ of the edge, and whose tangents and normals along it differ from those of the
file by no more than its slip σ (or, where faces are joined smoothly, its turn) as it was measured
when the body was built (`trimmed_edges`). Where a way crosses the strand at an angle φ, the slope
of f may then fall, by no more than

    δ + sin φ max(0, w·(b_1 + b_2) + 2 |w| σ),    or    δ + sin φ |w| α

where the faces turn by α at most, outer side or inner. The angles under which a shortest way can
cross again and again add up to less than 1 + 2 k r, for between two crossings the strand turns by
their sum. So on all shortest ways the slope of f falls by D in all at most, and grows by μ a
length otherwise. Then the minima of f_τ in the ball lie within D/μ of each other: **the branch is
known to D/μ**, and that must be no more than `SHARP` allows. All else is as there, with t + D in
place of t.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.num.jit import inner
from contiga.search._bend_nb import SPEED_S, SPEED_T, WIDTH_S, WIDTH_T, bend_bounds, principal
from contiga.search._branch_nb import WIDER, seen_from
from contiga.search._cells_nb import CELL, cell_about
from contiga.search._crease_nb import (
    SAME,
    fall_from,
    least_along,
    least_in_face,
    most_jump,
)
from contiga.search._curve_nb import surface_foot
from contiga.search._element_nb import parameters
from contiga.search._fold_nb import cross, dot, minus
from contiga.search._global_nb import closest, in_face
from contiga.search._joined_nb import least_bend, prove_work
from contiga.search._kink_nb import JOIN
from contiga.search._sides_nb import normal_at
from contiga.search._strand_nb import (
    anchor,
    place_on,
    side_strand,
    strand_in,
    strand_work,
    stretch_bend,
)

SHARP = 1e-7
"""A branch is known if it is to this share of the body's size, or to a few widths of the edge."""
FEW = 4.0
BENT = 1.2
"""Ways along a strand are so many times as long as their chords at most: 1/cos(1/2) = 1.14."""
TRIES = 3
GROWTH = 8.0
ASIDE = 0.25
"""How far from the edge, in radii of the ball, its faces are told from what is beyond."""
LEAST = 0.1
"""Least curvature of f that a ball is laid out for."""


@inner(error_model="numpy")
def edge_work():
    """Work tables of `over_edge`: those of `prove`, of a strand, and of `closest`."""
    return prove_work(), strand_work(), np.empty(4)


@inner(error_model="numpy")
def _at_rim(tables, e, side):
    """Whether a side of an element is one of its patch's rectangle."""
    row = tables.elements.table[e]
    return row["box"][side] == tables.trims.domain[row["patch"]][side]


@inner(error_model="numpy")
def _strand_of(tables, e, cell, work):
    """The edge of the strand in a cell of element e, and its number of stretches; (−1, 0) none."""
    row = tables.elements.table[e]
    whole = tables.trims.trimmed[row["patch"]] == 0
    touched = -1
    for side in range(4):
        if cell[side] == (-0.5 if side & 1 == 0 else 0.5):
            if not _at_rim(tables, e, side) or (touched >= 0 and whole):
                return -1, 0
            touched = side
    if not whole:
        u0, v0 = parameters(tables.elements, e, cell[0], cell[2])
        u1, v1 = parameters(tables.elements, e, cell[1], cell[3])
        return strand_in(tables.trims, row["patch"], (u0, u1, v0, v1), work)
    if touched < 0:
        return -1, 0
    return tables.joints.sides[e, touched], side_strand(touched, work)


@inner(error_model="numpy")
def _is_in(tables, e, s, t):
    """Whether (s, t), inside element e or beyond a rim of its patch, belongs to its face."""
    if not (abs(s) <= 0.5 and abs(t) <= 0.5):
        return False
    return in_face(tables.elements, tables.trims, e, s, t)


@inner(error_model="numpy")
def _frame(tables, foot, tangent, aside, h):
    """At a place of an edge in a face: (point, tangent, b, normal), and whether b is told.

    b leads `aside` far to places inside the face, −b to none.
    """
    e, s, t = foot
    normal = normal_at(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    point = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    b = cross(normal, tangent)
    size = math.sqrt(dot(b, b))
    b = (b[0] / size, b[1] / size, b[2] / size)
    x = (h[0, 1], h[1, 1], h[2, 1])
    y = (h[0, 2], h[1, 2], h[2, 2])
    xx, xy, yy = dot(x, x), dot(x, y), dot(y, y)
    det = xx * yy - xy * xy
    d_s = aside * (dot(b, x) * yy - dot(b, y) * xy) / det
    d_t = aside * (dot(b, y) * xx - dot(b, x) * xy) / det
    ahead = _is_in(tables, e, s + d_s, t + d_t)
    behind = _is_in(tables, e, s - d_s, t - d_t)
    if behind:
        b = (-b[0], -b[1], -b[2])
    return (point, tangent, b, normal), det > 0.0 and ahead != behind


@inner(error_model="numpy")
def _cell_of(tables, foot, reach, bend, bending):
    """The cell about a foot that no way of length `reach` leaves but over a rim; its bounds into
    `bend`. (0, 0, 0, 0) where there is none."""
    e, s, t = foot
    normal_at(tables.elements, e, s, t, bending[0])
    metric = principal(bending[0])[2]
    nothing = (0.0, 0.0, 0.0, 0.0)
    if not metric[2] > 0.0:
        return nothing
    far_s = CELL * reach / metric[2]
    far_t = CELL * reach / metric[3]
    if not (far_s < 1.0 and far_t < 1.0):
        return nothing
    cell = cell_about(s, t, far_s, far_t)
    if not bend_bounds(tables.elements, e, cell, bend, bending):
        return nothing
    if not (reach < far_s * bend[WIDTH_S] and reach < far_t * bend[WIDTH_T]):
        return nothing
    return cell


@inner(error_model="numpy")
def _along(strand, n, foot, cell, bending):
    """The place y of a strand next to a foot, as (s, t), its slope there, and bounds of it: (longest
    way along it from y, largest curvature)."""
    _, s, t = foot
    h = bending[0]
    half_s = 0.5 * (cell[1] - cell[0])
    half_t = 0.5 * (cell[3] - cell[2])
    middle_s = 0.5 * (cell[0] + cell[1])
    middle_t = 0.5 * (cell[2] + cell[3])
    xx = xy = yy = 0.0
    for c in range(3):
        xx += h[c, 1] * h[c, 1]
        xy += h[c, 1] * h[c, 2]
        yy += h[c, 2] * h[c, 2]
    at = ((s - middle_s) / half_s, (t - middle_t) / half_t)
    k, where = anchor(strand, n, at, (xx, xy, yy))
    x, y, dx, dy = place_on(strand, k, where)
    before = after = bent = 0.0
    for i in range(n):
        _, _, least, most, own = stretch_bend(strand, i, h, bending[1])
        bent = max(bent, own)
        before += most if i < k else (most * where if i == k else 0.0)
        after += most if i > k else (most * (1.0 - where) if i == k else 0.0)
    # Rounding of the strand may lie beyond a rim.
    y_s = min(max(middle_s + x * half_s, -0.5), 0.5)
    y_t = min(max(middle_t + y * half_t, -0.5), 0.5)
    return (y_s, y_t), (dx * half_s, dy * half_t), (max(before, after), bent)


@inner(error_model="numpy")
def _tangent(elements, e, at, slope, h):
    """Unit tangent in space of a curve that leaves (s, t) = at along `slope`."""
    normal_at(elements, e, at[0], at[1], h)
    d = (
        h[0, 1] * slope[0] + h[0, 2] * slope[1],
        h[1, 1] * slope[0] + h[1, 2] * slope[1],
        h[2, 1] * slope[0] + h[2, 2] * slope[1],
    )
    size = math.sqrt(dot(d, d))
    return (d[0] / size, d[1] / size, d[2] / size)


@inner(error_model="numpy")
def _fold_about(tables, foot, r, work):
    """The fold next to a foot, no farther than r, with the cells of both faces.

    Returns (edge, −1 where nothing is known; its first and second frame; the way from the foot to
    it; (way along it, its curvature, number of stretches); the place in the second face). The
    bounds of the cells are left in the work tables, and the strand as the first face has it.
    """
    bends, strand, found = work
    e = foot[0]
    elements = tables.elements
    h = bends[2]
    nowhere = (0.0, 0.0, 0.0)
    no_frame = (nowhere, nowhere, nowhere, nowhere)
    nothing = (-1, no_frame, no_frame, math.inf, (0.0, 0.0, 0), (-1, 0.0, 0.0))
    cell = _cell_of(tables, foot, BENT * r, bends[0], bends[3])
    if cell[1] == cell[0]:
        return nothing
    edge, n = _strand_of(tables, e, cell, strand)
    if edge < 0:
        return nothing
    joint = tables.joints.edges[edge]
    patch = elements.table[e]["patch"]
    other = joint["patch"][1] if joint["patch"][0] == patch else joint["patch"][0]
    if other < 0:
        return nothing
    at, slope, bounds = _along(strand, n, foot, cell, bends[3])
    if not bounds[0] * bounds[1] <= 1.0:
        return nothing
    way = abs(at[0] - foot[1]) * bends[0][SPEED_S] + abs(at[1] - foot[2]) * bends[0][SPEED_T]
    tangent = _tangent(elements, e, at, slope, h)
    first, good = _frame(tables, (e, at[0], at[1]), tangent, ASIDE * r, h)
    reach = max(joint["width"], JOIN * tables.scale[0])
    if not good or not math.isfinite(closest(tables, first[0], other, reach, found, h)):
        return nothing
    there = surface_foot(tables, found, h)
    second, good = _frame(tables, there, tangent, ASIDE * r, h)
    longest = BENT * (way + r) + 2.0 * joint["width"]
    beyond = _cell_of(tables, there, longest, bends[1], bends[4])
    if not good or beyond[1] == beyond[0]:
        return nothing
    own = strand[0].copy(), strand[1].copy()
    same = _strand_of(tables, there[0], beyond, strand)[0] == edge
    strand[0][:] = own[0]
    strand[1][:] = own[1]
    if not same:
        return nothing
    return edge, first, second, way, (bounds[0], bounds[1], n), there


@inner(error_model="numpy")
def _way_to(foot, last, there, way, bends):
    """Length of a way from a foot to the start `last` by the cells of the fold, at most; infinite
    where it is in neither."""
    if last[0] == foot[0]:
        d_s, d_t = abs(last[1] - foot[1]), abs(last[2] - foot[2])
        return d_s * bends[0][SPEED_S] + d_t * bends[0][SPEED_T]
    if last[0] == there[0]:
        d_s, d_t = abs(last[1] - there[1]), abs(last[2] - there[2])
        return way + d_s * bends[1][SPEED_S] + d_t * bends[1][SPEED_T]
    return math.inf


@inner(error_model="numpy")
def _give(joint):
    """By how much tangents and normals of an edge are uncertain, radians."""
    return min(joint["slip"], joint["turn"])


@inner(error_model="numpy")
def _slip_at(tables, foot, fold, ends, path, h):
    """t of the theorem; infinite where the foot is none. `fold` is of `_fold_about`."""
    edge, first, second, way = fold[0], fold[1], fold[2], fold[3]
    tolerance = tables.scale[1]
    if way > SAME * tolerance:
        e, s, t = foot
        normal = normal_at(tables.elements, e, s, t, h)
        origin = tables.elements.table[e]["origin"]
        at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
        return seen_from(at, normal, path[0], path[1], tolerance)[2]
    joint = tables.joints.edges[edge]
    far = math.sqrt(dot(ends[1], ends[1]))
    end = fall_from(ends[1], first, second)
    if end > SAME * tolerance + joint["width"] + far * _give(joint):
        return math.inf
    return max(fall_from(ends[0], first, second), end) + 4.0 * tolerance


@inner(error_model="numpy")
def _least_and_drop(tables, fold, ends, r, work):
    """μ and D of the theorem."""
    bends, strand, _ = work
    edge, first, second, way, (arc, bent, n), _ = fold
    joint = tables.joints.edges[edge]
    w0, w1 = ends
    far = math.sqrt(max(dot(w0, w0), dot(w1, w1))) + joint["width"]
    along = max(abs(dot(w0, first[1])), abs(dot(w1, first[1]))) + far * _give(joint)
    reach = (arc, far + arc, along + (1.0 + (far + arc) * bent) * arc)
    wide = (far + way + r, way + r)
    least = min(
        least_in_face(bends[0], first, w0, w1, wide), least_in_face(bends[1], second, w0, w1, wide)
    )
    for k in range(n):
        c, rest, slowest, _, own = stretch_bend(strand, k, bends[3][0], bends[3][1])
        least = min(least, least_along((c, rest, slowest, own), ends, reach))
    jump = most_jump((bends[0], bends[1]), (first, second), ends, reach, bent)
    jump = max(jump + 2.0 * reach[1] * joint["slip"], 0.0)
    jump = min(jump, reach[1] * joint["turn"])
    return least, joint["width"] + (1.0 + 2.0 * bent * r) * jump


@inner(error_model="numpy")
def over_edge(tables, foot, last, path, work):
    """Whether one branch joins the feet `last` of path[0] and `foot` of path[1] by an edge.

    `work` is of `edge_work`.
    """
    bends = work[0]
    h = bends[2]
    e, s, t = foot
    normal = normal_at(tables.elements, e, s, t, h)
    origin = tables.elements.table[e]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    inner, outer, _ = principal(h)
    m, _, slip = seen_from(at, normal, path[0], path[1], tables.scale[1])
    least = min(least_bend((inner, outer), m[0]), least_bend((inner, outer), m[1]))
    normal_at(tables.elements, last[0], last[1], last[2], h)
    origin = tables.elements.table[last[0]]["origin"]
    d = (h[0, 0] + origin[0] - at[0], h[1, 0] + origin[1] - at[1], h[2, 0] + origin[2] - at[2])
    off = math.sqrt(dot(d, d))
    need = max(2.0 * off, 2.0 * slip / max(least, LEAST)) + SAME * tables.scale[1]
    for _ in range(TRIES):
        r = WIDER * need
        fold = _fold_about(tables, foot, r, work)
        if fold[0] < 0:
            return False
        width = tables.joints.edges[fold[0]]["width"]
        ends = (minus(path[0], fold[1][0]), minus(path[1], fold[1][0]))
        slip = _slip_at(tables, foot, fold, ends, path, h)
        least, drop = _least_and_drop(tables, fold, ends, r, work)
        if not (least > 0.0 and slip < math.inf):
            return False
        if not drop <= least * max(SHARP * tables.scale[0], FEW * width):
            return False
        way = BENT * _way_to(foot, last, fold[5], fold[3], bends) + width + tables.scale[1]
        need = max(way, 2.0 * (slip + drop) / least)
        if need <= r:
            return True
        if not need <= GROWTH * r:
            return False
    return False


@inner(error_model="numpy")
def rests_on_edge(tables, foot, point, r, work):
    """Whether a start on or beside an edge is the foot of its point at all.

    `r` is how much of the edge about it is looked at.
    """
    fold = _fold_about(tables, foot, r, work)
    if fold[0] < 0:
        return False
    w = minus(point, fold[1][0])
    return _slip_at(tables, foot, fold, (w, w), (point, point), work[0][2]) < math.inf


@inner(error_model="numpy")
def may_join(tables, e):
    """Whether an element may reach an edge of a trimmed face."""
    if tables.trims.trimmed[tables.elements.table[e]["patch"]] != 0:
        return True
    for side in range(4):
        if tables.joints.sides[e, side] >= 0:
            return True
    return False
