"""The fold next to a foot: two faces that end at one edge, with cells of both and their bounds.

The edge may be one of a trimmed face, a natural side that the topology knows as a part of one, or a
crease between two elements that are linked along a side. In both cells it is one segment
(`edge_segment_nb`), and nothing else is trimmed away or ends there. A way of length r from the foot
stays in both: a part of it that runs in the other face between two places of the edge segment is
longer than the edge segment between them by no less than cos(1/2), for the edge segment turns by no
more than one radian.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import CREASE
from contiga.arrays.kernels.vector_nb import cross, dot
from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.search.certify.certify_records import EdgeFold, EdgeFrame, EdgeJoint, EdgeWork
from contiga.search.certify.kernels.bend_nb import (
    SPEED_S,
    SPEED_T,
    WIDTH_S,
    WIDTH_T,
    bend_bounds,
    principal,
)
from contiga.search.certify.kernels.cells_nb import CELL, SNAP, cell_about
from contiga.search.certify.kernels.edge_segment_nb import (
    anchor,
    place_on,
    segment_in,
    segment_work,
    side_segment,
    stretch_bend,
)
from contiga.search.certify.kernels.joined_nb import prove_work
from contiga.search.closest.kernels.around_nb import cross as beyond_side
from contiga.search.closest.kernels.global_among_nb import on_patch
from contiga.search.closest.kernels.global_nb import closest
from contiga.search.closest.kernels.pseudo_normal_nb import JOIN
from contiga.search.hierarchy.kernels.curve_nb import surface_foot
from contiga.search.hierarchy.kernels.face_nb import in_face

NONE, LINKED = -1, -2
"""Instead of an edge: there is none, or it is a crease between linked elements."""
BENT = 1.2
"""Ways along an edge segment are so many times as long as their chords at most: 1/cos(1/2) =
1.14."""
NOWHERE = (0.0, 0.0, 0.0)
NO_FRAME = EdgeFrame(NOWHERE, NOWHERE, NOWHERE, NOWHERE)
UNKNOWN = EdgeJoint(0.0, 0.0, 0.0)
NOTHING = EdgeFold(False, NO_FRAME, NO_FRAME, math.inf, 0.0, 0.0, 0, (-1, 0.0, 0.0), UNKNOWN)
ASIDE = 0.25
"""How far from the edge, in radii of the ball, its faces are told from what is beyond."""


@inner(error_model="numpy")
def edge_work():
    """Work of `over_edge`, nothing in it."""
    return EdgeWork(prove_work(), segment_work(), np.empty(4))


@inner(error_model="numpy")
def at_rim(tables, e, side):
    """Whether a side of an element is one of its patch's rectangle."""
    row = tables.elements.table[e]
    return row["box"][side] == tables.trims.domain[row["patch"]][side]


@inner(error_model="numpy")
def _segment_of(tables, e, cell, work):
    """(The edge of the edge segment in a cell of element e, or NONE or LINKED; its number of
    stretches;
    the side of the element that the cell touches)."""
    row = tables.elements.table[e]
    whole = tables.trims.trimmed[row["patch"]] == 0
    touched = -1
    for side in range(4):
        if cell[side] == (-0.5 if side & 1 == 0 else 0.5):
            inside = not at_rim(tables, e, side) and (not whole or row["kind"][side] != CREASE)
            if inside or (touched >= 0 and whole):
                return NONE, 0, -1
            touched = side
    if not whole:
        u0, v0 = parameters(tables.elements, e, cell[0], cell[2])
        u1, v1 = parameters(tables.elements, e, cell[1], cell[3])
        edge, n = segment_in(tables.trims, row["patch"], (u0, u1, v0, v1), work)
        return edge if edge >= 0 else NONE, n, touched
    if touched < 0:
        return NONE, 0, -1
    edge = tables.joints.sides[e, touched]
    if edge < 0:
        edge = LINKED if row["kind"][touched] == CREASE else NONE
    return edge, side_segment(touched, work), touched


@inner(error_model="numpy")
def is_in(tables, e, s, t):
    """Whether (s, t), inside element e or beyond a rim of its patch, belongs to its face."""
    if not (abs(s) <= 0.5 and abs(t) <= 0.5):
        return False
    return in_face(tables.elements, tables.trims, e, s, t)


@inner(error_model="numpy")
def _frame(tables, foot, tangent, aside, h):
    """Return the `EdgeFrame` at a place of an edge in a face, and whether the sense of b is sure.

    From there b, `aside` far, leads into the face, and −b out of it.
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
    before = is_in(tables, e, s + d_s, t + d_t)
    behind = is_in(tables, e, s - d_s, t - d_t)
    if behind:
        b = (-b[0], -b[1], -b[2])
    return EdgeFrame(point, tangent, b, normal), det > 0.0 and before != behind


@inner(error_model="numpy")
def cell_of(tables, foot, reach, bend, bending):
    """The cell about a foot that no way of length `reach` leaves but over a rim; its bounds into
    `bend`. (0, 0, 0, 0) where there is none."""
    e, s, t = foot
    normal_at(tables.elements, e, s, t, bending.derivatives)
    metric = principal(bending.derivatives).metric
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
def along(segment, n, foot, cell, bending):
    """The place y of an edge segment next to a foot, as (s, t), its slope there, and (longest way
    along it
    from y, largest curvature)."""
    _, s, t = foot
    h = bending.derivatives
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
    k, where = anchor(segment, n, at, (xx, xy, yy))
    x, y, dx, dy = place_on(segment, k, where)
    before = after = bent = 0.0
    for i in range(n):
        most, bent_here = stretch_bend(segment, i, bending)[3:]
        bent = max(bent, bent_here)
        before += most if i < k else (most * where if i == k else 0.0)
        after += most if i > k else (most * (1.0 - where) if i == k else 0.0)
    # Rounding of the edge segment may lie beyond a rim.
    y_s = min(max(middle_s + x * half_s, -0.5), 0.5)
    y_t = min(max(middle_t + y * half_t, -0.5), 0.5)
    return (y_s, y_t), (dx * half_s, dy * half_t), (max(before, after), bent)


@inner(error_model="numpy")
def tangent(elements, e, at, slope, h):
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
def _across(tables, foot, at, edge, side, point, work):
    """The face beyond an edge at the place `at` of the foot's element, and how it is joined there:
    (place (e, s, t) in it, −1 where none; (width, slip, turn))."""
    place = work.place
    elements = tables.elements
    e = foot[0]
    if edge == LINKED:
        e2, s, t, _ = beyond_side(elements, e, side, at[0], at[1])
        return (e2, s, t), (elements.table[e]["width"][side], 0.0, math.inf)
    joint = tables.joints.edges[edge]
    faces = joint["patch"]
    row = elements.table[e]
    other = faces[1] if faces[0] == row["patch"] else faces[0]
    if side >= 0 and row["kind"][side] <= CREASE and 0.5 - abs(at[side // 2]) <= SNAP:
        e2, s, t, _ = beyond_side(elements, e, side, at[0], at[1])
        if elements.table[e2]["patch"] == other:
            return (e2, s, t), (joint["width"], joint["slip"], joint["turn"])
    reach = max(joint["width"], JOIN * tables.scale[0])
    nowhere = (-1, 0.0, 0.0)
    known = (joint["width"], joint["slip"], joint["turn"])
    if other < 0 or not math.isfinite(
        closest(tables, point, on_patch(other), reach, place, work.cells.derivatives)
    ):
        return nowhere, known
    return surface_foot(tables, place, work.cells.derivatives), known


@inner(error_model="numpy")
def _goes_on(tables, there, reach, edge, work):
    """Whether about the place `there` of the second face the edge is its edge segment, and nothing
    else
    ends; bounds of the cell into the work tables."""
    cells, segment = work.cells, work.segment
    cell = cell_of(tables, there, reach, cells.beyond, cells.bending_beyond)
    if cell[1] == cell[0]:
        return False
    coefs, degree = segment.coefs.copy(), segment.degree.copy()
    same = _segment_of(tables, there[0], cell, segment)[0] == edge
    segment.coefs[:] = coefs
    segment.degree[:] = degree
    return same


@inner(linked=False, error_model="numpy")
def _fold_of(tables, foot, r, seen, work):
    """As `fold_about`, where there is an edge; `seen` is (cell, edge, number of its stretches, side
    of the element)."""
    cells, segment = work.cells, work.segment
    h = cells.derivatives
    cell, edge, n, side = seen
    e = foot[0]
    at, slope, (arc, bent) = along(segment, n, foot, cell, cells.bending)
    if not arc * bent <= 1.0:
        return NOTHING
    way = abs(at[0] - foot[1]) * cells.here[SPEED_S] + abs(at[1] - foot[2]) * cells.here[SPEED_T]
    forward = tangent(tables.elements, e, at, slope, h)
    first, good = _frame(tables, (e, at[0], at[1]), forward, ASIDE * r, h)
    if not good:
        return NOTHING
    there, (width, slip, turn) = _across(tables, foot, at, edge, side, first.point, work)
    if there[0] < 0:
        return NOTHING
    second, good = _frame(tables, there, forward, ASIDE * r, h)
    if not (good and _goes_on(tables, there, BENT * (way + r) + 2.0 * width, edge, work)):
        return NOTHING
    slip = max(slip, abs(dot(forward, second.normal)))
    joint = EdgeJoint(width, slip, turn)
    return EdgeFold(True, first, second, way, arc, bent, n, there, joint)


@inner(linked=False, error_model="numpy")
def fold_about(tables, foot, r, work):
    """The `EdgeFold` next to a foot, no farther than r, with the cells of both faces.

    The bounds of the cells are left in the work tables, and the edge segment as the first face has
    it.
    """
    cells, segment = work.cells, work.segment
    cell = cell_of(tables, foot, BENT * r, cells.here, cells.bending)
    if cell[1] == cell[0]:
        return NOTHING
    edge, n, side = _segment_of(tables, foot[0], cell, segment)
    if edge == NONE:
        return NOTHING
    return _fold_of(tables, foot, r, (cell, edge, n, side), work)


@inner(error_model="numpy")
def way_to(foot, last, there, way, cells):
    """Length of a way from a foot to the start `last` by the cells of the fold, at most; infinite
    where it is in neither."""
    if last[0] == foot[0]:
        d_s, d_t = abs(last[1] - foot[1]), abs(last[2] - foot[2])
        return d_s * cells.here[SPEED_S] + d_t * cells.here[SPEED_T]
    if last[0] == there[0]:
        d_s, d_t = abs(last[1] - there[1]), abs(last[2] - there[2])
        return way + d_s * cells.beyond[SPEED_S] + d_t * cells.beyond[SPEED_T]
    return math.inf


@inner(error_model="numpy")
def may_join(tables, e):
    """Whether an element may reach an edge."""
    if tables.trims.trimmed[tables.elements.table[e]["patch"]] != 0:
        return True
    row = tables.elements.table[e]
    for side in range(4):
        if tables.joints.sides[e, side] >= 0 or row["kind"][side] == CREASE:
            return True
    return False
