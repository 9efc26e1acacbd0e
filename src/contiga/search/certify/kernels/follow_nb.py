"""Following the branch of a foot part by part, where its surroundings do not prove it at once.

Each part is walked to and proved (the theorem stands in `branch_nb`), by the bounds kept around
the foot or by those of a cell just large enough; what is not proved is halved. Where the smallest
part is not proved either, the branch has ended if the minimum is seen to vanish there.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import (
    AT_BORDER,
    BRANCH_EVENT,
    CREASE,
    FACE,
    HAS_ENDED,
    IN,
    OK,
    POLE,
    TO_FOLLOW,
)
from contiga.elements.kernels.element_nb import locate
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.certify.certify_records import Near
from contiga.search.certify.kernels.about_edge_nb import edge_work, may_join
from contiga.search.certify.kernels.bend_nb import principal
from contiga.search.certify.kernels.branch_nb import seen_from
from contiga.search.certify.kernels.cells_nb import is_untrimmed, whole_around
from contiga.search.certify.kernels.edge_nb import over_edge, rests_on_edge, runs_into_fold
from contiga.search.certify.kernels.joined_nb import least_bend, prove
from contiga.search.certify.kernels.vertex_nb import is_corner
from contiga.search.certify.kernels.within_face_nb import stays_in_face
from contiga.search.closest.kernels.around_nb import cross, inward_slope, stands, vertex_exit
from contiga.search.closest.kernels.foot_nb import continued_foot, turn_normal, write_foot
from contiga.search.closest.kernels.local_nb import expand
from contiga.search.closest.kernels.pseudo_normal_nb import pseudo_normal
from contiga.search.closest.kernels.walk_nb import walk
from contiga.search.hierarchy.kernels.face_nb import in_face

SHORT = 1e-12
HALVINGS = 10
"""Halvings of a motion that is not proved."""
EDGE_HALVINGS = 18
"""The same beside an edge, which a point may pass very close by."""
AHEAD = 24.0
"""How many parts a foot may be away from a fold beside which no more parts are proved."""
HELD = 0.5**4
"""A part this short that ends where the face does is not halved: the branch leads out there."""
EVENT_HALVINGS = 30
"""Halvings where the minimum is shallow: a branch is followed so far to its end."""
SHALLOW = 0.5
"""Least curvature of f at a foot (1 far from focal points) below which it may be about to end."""
VANISHED = 1e-3
"""Least curvature with which a minimum that cannot be followed any farther counts as gone."""
AWAY = 10.0
"""A foot that goes this many times as far as its least curvature explains has left its branch."""
MOST_PARTS = 1500
UNPROVED, PROVED, ENDED, FELL = 0, 1, 2, 3
NEAR_EDGE = 1e-6
"""Share of the body's size about a start on an edge that is looked at,"""
WIDTHS = 4.0
"""and so many times its width."""
SAME = 1e3
"""Feet this many tolerances apart at most are one."""


@inner(error_model="numpy")
def _between(path, share):
    a, b = path
    return (
        a[0] + share * (b[0] - a[0]),
        a[1] + share * (b[1] - a[1]),
        a[2] + share * (b[2] - a[2]),
    )


@inner(error_model="numpy")
def _has_ended(near, last, foot, path, h):
    """Whether the minimum `last` of path[0] is seen to vanish on the way to path[1].

    It has become flat, it is none for path[1], or the foot found there is farther off than the
    curvature of f explains.
    """
    elements, tolerance = near.elements, near.tolerance
    for side in range(4):
        if stands(side, last[1], last[2]) and elements.table[last[0]]["kind"][side] == CREASE:
            return False, math.inf  # f is bent there by more than curvature
    normal = normal_at(elements, last[0], last[1], last[2], h)
    origin = elements.table[last[0]]["origin"]
    at = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    a = h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2
    b = h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2
    if min(a, b) <= SHORT * max(a, b):
        return False, math.inf  # on a pole curvatures are not seen
    inner, outer, _ = principal(h)
    seen = seen_from(at, normal, path[0], path[1], tolerance)
    m, slip = seen.heights, seen.slip
    least = least_bend((inner, outer), m[0])
    if least > SHALLOW:
        return False, least
    if least < VANISHED or least_bend((inner, outer), m[1]) <= 0.0:
        return True, least
    normal_at(elements, foot[0], foot[1], foot[2], h)
    origin = elements.table[foot[0]]["origin"]
    square = 0.0
    for c in range(3):
        square += (h[c, 0] + origin[c] - at[c]) ** 2
    return math.sqrt(square) > AWAY * slip / least, least


@inner(error_model="numpy")
def _is_stationary(elements, foot, point, miss, h):
    """Whether a start is the foot of its point at all: f falls nowhere from there by `miss`."""
    e, s, t = foot
    q = expand(elements, e, s, t, point, h)
    g_s, g_t, a, b = q.f_s, q.f_t, q.square_s, q.square_t
    # At a pole one tangent vanishes, and its slope is rounding.
    if abs(s) < 0.5 and not abs(g_s) <= miss * math.sqrt(max(a, SHORT * b)):
        return False
    if abs(t) < 0.5 and not abs(g_t) <= miss * math.sqrt(max(b, SHORT * a)):
        return False
    for side in range(4):
        if not stands(side, s, t) or elements.table[e]["kind"][side] == POLE:
            continue
        if inward_slope(q, side) < -miss:
            return False
        e2, s2, t2, other = cross(elements, e, side, s, t)
        if inward_slope(expand(elements, e2, s2, t2, point, h), other) < -miss:
            return False
    return not is_corner(foot) or vertex_exit(elements, foot, point, miss, h)[0] < 0


@inner(error_model="numpy")
def _go_on(tables, last, path, work):
    """The foot of path[1] continued from `last`, and whether that is proved: (proved, whether it
    stays on the body, e, s, t, whether it is on a face or a crease)."""
    cells = work.cells
    elements = tables.elements
    tolerance = tables.scale[1]
    near = Near(elements, tables.neighbourhoods, tables.trims.trimmed, tolerance)
    status, e, s, t, feature = walk(elements, last, path[1], tolerance, cells.derivatives)
    stays = status != AT_BORDER and (
        elements.table[e]["trim"] == IN or in_face(elements, tables.trims, e, s, t)
    )
    good = stays and status == OK and prove(near, (e, s, t), last, path, cells)
    if good and is_untrimmed(tables, cells.boxes):
        return True, True, e, s, t, feature
    inside = stays and status == OK and feature == FACE
    if inside and stays_in_face(tables, (e, s, t), last, path, work):
        return True, True, e, s, t, feature
    if not (may_join(tables, e) or may_join(tables, last[0])):
        return False, stays, e, s, t, feature
    if not inside:
        h = cells.derivatives
        status, e, s, t, feature = continued_foot(tables, last, path[1], work.place, h)
        stays = status == OK
    good = stays and over_edge(tables, (e, s, t), last, path, work)
    return good, stays, e, s, t, feature


@inner(linked=False, error_model="numpy")
def follow(tables, last, path, step, work):
    """Follow the branch from the foot `last` of path[0] to path[1], part by part.

    The first part tried is the share `step` of the motion; `work` is of `edge_work`. Returns
    (UNPROVED, PROVED, ENDED or FELL, e, s, t, feature): the foot at the end of what was proved.
    """
    near = Near(tables.elements, tables.neighbourhoods, tables.trims.trimmed, tables.scale[1])
    h = work.cells.derivatives
    done = 0.0
    kind = FACE
    smallest = 0.5**HALVINGS
    at_edge = 0.5**EDGE_HALVINGS
    at_limit = False
    for _ in range(MOST_PARTS):
        here = _between(path, done)
        there = _between(path, done + step)
        good, stays, e, s, t, feature = _go_on(tables, last, (here, there), work)
        if good:
            last = (e, s, t)
            kind = feature
            done += step
            if done >= 1.0:
                return PROVED, e, s, t, feature
            # Beside an edge, where one was too long just now, the next is too, more often than not.
            step = min(step if at_limit else 2.0 * step, 1.0 - done)
            at_limit = False
            continue
        beside = may_join(tables, last[0])
        if beside:
            beyond = _between(path, min(done + AHEAD * step, 1.0))
            if runs_into_fold(tables, last, (here, beyond), work):
                return FELL, last[0], last[1], last[2], kind
        if not stays and step <= HELD:
            return UNPROVED, last[0], last[1], last[2], kind
        if step <= (at_edge if beside else smallest):
            ended, least = _has_ended(near, last, (e, s, t), (here, there), h)
            if least > SHALLOW:
                break
            if step <= 0.5**EVENT_HALVINGS:
                return (ENDED if ended else UNPROVED), last[0], last[1], last[2], kind
        step *= 0.5
        at_limit = beside
    there = _between(path, done + step)
    _, e, s, t, _ = walk(tables.elements, last, there, tables.scale[1], h)
    ended, _ = _has_ended(near, last, (e, s, t), (_between(path, done), there), h)
    return (ENDED if ended else UNPROVED), last[0], last[1], last[2], kind


@inner(error_model="numpy")
def _at_end(elements, foot):
    """Whether a foot stands where its surface ends, or goes on in elements not linked with it."""
    e, s, t = foot
    kind = elements.table[e]["kind"]
    for side in range(4):
        if stands(side, s, t) and kind[side] > CREASE and kind[side] != POLE:
            return True
    return False


@inner(error_model="numpy")
def _is_there(tables, foot, k, out, h):
    """Whether row k holds the foot already."""
    if out.status[k] != OK:
        return False
    e, s, t = foot
    normal_at(tables.elements, e, s, t, h)
    square = 0.0
    for c in range(3):
        square += (h[c, 0] + tables.elements.table[e]["origin"][c] - out.point[k, c]) ** 2
    return square <= (SAME * tables.scale[1]) ** 2


@inner(error_model="numpy")
def _put_right(tables, k, foot, point, out, work):
    """Write row k for the foot (e, s, t, feature) of a point."""
    e, s, t, feature = foot
    h = work.cells.derivatives
    write_foot(tables, k, (e, s, t), OK, feature, point, out, h)
    if feature != FACE:
        total = scratch(3)
        pseudo_normal(tables, (e, s, t), work.place, total, h)
        turn_normal(tables, k, total, point, out)


@inner(error_model="numpy")
def _is_start(tables, last, point, work):
    """Whether `last` is a foot of its point that can be followed."""
    e, s, t = last
    trimmed = tables.trims.trimmed[tables.elements.table[e]["patch"]] != 0
    if _at_end(tables.elements, last) or (trimmed and not whole_around(tables, e, s, t, 0.0, 0.0)):
        reach = max(
            NEAR_EDGE * tables.scale[0], WIDTHS * tables.elements.table[e]["edge_tolerance"]
        )
        return may_join(tables, e) and rests_on_edge(tables, last, point, reach, work)
    h = work.cells.derivatives
    return _is_stationary(tables.elements, last, point, SAME * tables.scale[1], h)


@kernel(error_model="numpy")
def follow_rows(tables, points, left, m, out):
    """Follow the branches of the rows flagged TO_FOLLOW; arguments as of `certify_rows`.

    A foot that is not the one on its branch is put right. Rows whose branch ends are flagged
    HAS_ENDED, or, where it ran into a fold and the foot fell on to the other face, are a
    BRANCH_EVENT at once. Returns how many are flagged.
    """
    work = edge_work()
    cells = work.cells
    elements = tables.elements
    near = Near(elements, tables.neighbourhoods, tables.trims.trimmed, tables.scale[1])
    rows, flags, before, patch, uv = left.rows, left.flags, left.before, left.patch, left.uv
    ended = 0
    for j in range(m):
        if flags[j] != TO_FOLLOW:
            continue
        k = rows[j]
        last = locate(tables.grid, patch[j], uv[j, 0], uv[j, 1])
        a = (before[j, 0], before[j, 1], before[j, 2])
        b = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_start(tables, last, a, work):
            continue
        step = 1.0
        if out.status[k] == OK:
            foot = locate(tables.grid, out.patch[k], out.uv[k, 0], out.uv[k, 1])
            good = prove(near, foot, last, (a, b), cells) and is_untrimmed(tables, cells.boxes)
            if not good and out.feature[k] == FACE:
                good = stays_in_face(tables, foot, last, (a, b), work)
            if not good and may_join(tables, foot[0]):
                good = over_edge(tables, foot, last, (a, b), work)
            if good:
                out.certified[k] = 1
                continue
            step = 0.5
        outcome, e, s, t, feature = follow(tables, last, (a, b), step, work)
        if outcome == ENDED:
            flags[j] = HAS_ENDED
            ended += 1
        elif outcome == FELL and out.status[k] == OK:
            out.status[k] = BRANCH_EVENT
        elif outcome == PROVED:
            if not _is_there(tables, (e, s, t), k, out, cells.derivatives):
                _put_right(tables, k, (e, s, t, feature), b, out, work)
            out.certified[k] = 1
    return ended
