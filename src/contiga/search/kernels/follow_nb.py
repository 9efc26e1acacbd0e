"""Following the branch of a foot part by part, where its surroundings do not prove it at once.

Each part is walked to and proved (the theorem stands in `branch_nb`), by the bounds kept around
the foot or by those of a cell just large enough; what is not proved is halved. Where the smallest
part is not proved either, the branch has ended if the minimum is seen to vanish there.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import locate
from contiga.elements.kernels.sides_nb import normal_at
from contiga.num.codes import AT_BORDER, CREASE, FACE, IN, OK, POLE, VERTEX
from contiga.num.jit import inner, kernel
from contiga.search.kernels.around_nb import cross, inward_slope, stands, vertex_exit
from contiga.search.kernels.bend_nb import principal
from contiga.search.kernels.branch_nb import seen_from
from contiga.search.kernels.cells_nb import is_untrimmed, whole_around
from contiga.search.kernels.crease_nb import is_corner
from contiga.search.kernels.foot_nb import turn_normal, write_foot
from contiga.search.kernels.global_nb import in_face
from contiga.search.kernels.joined_nb import least_bend, prove, prove_work
from contiga.search.kernels.local_nb import expand
from contiga.search.kernels.pseudo_normal_nb import pseudo_normal
from contiga.search.kernels.walk_nb import walk

SHORT = 1e-12
HALVINGS = 10
"""Halvings of a motion that is not proved."""
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
UNPROVED, PROVED, ENDED = 0, 1, 2
EVENT = 2
"""Flag of rows whose branch ends."""
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
    elements, _, _, tolerance = near
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
    m, _, slip = seen_from(at, normal, path[0], path[1], tolerance)
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
    _, g_s, g_t, _, _, _, a, b = q
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
def follow(tables, last, path, step, work):
    """Follow the branch from the foot `last` of path[0] to path[1], part by part.

    The first part tried is the share `step` of the motion. Returns (UNPROVED, PROVED or ENDED, e,
    s, t): the foot at the end of what was proved.
    """
    elements = tables.elements
    tolerance = tables.scale[1]
    near = (elements, tables.rings, tables.trims.trimmed, tolerance)
    h = work[2]
    done = 0.0
    smallest = 0.5**HALVINGS
    for _ in range(MOST_PARTS):
        here = _between(path, done)
        there = _between(path, done + step)
        status, e, s, t, _ = walk(elements, last, there, tolerance, h)
        stays = status != AT_BORDER and (
            elements.table[e]["trim"] == IN or in_face(elements, tables.trims, e, s, t)
        )
        good = stays and status == OK
        good = good and prove(near, (e, s, t), last, (here, there), work)
        if good and is_untrimmed(tables, work[5]):
            last = (e, s, t)
            done += step
            if done >= 1.0:
                return PROVED, e, s, t
            step = min(2.0 * step, 1.0 - done)
            continue
        if not stays and step <= HELD:
            return UNPROVED, last[0], last[1], last[2]
        if step <= smallest:
            ended, least = _has_ended(near, last, (e, s, t), (here, there), h)
            if least > SHALLOW:
                break
            if step <= 0.5**EVENT_HALVINGS:
                return (ENDED if ended else UNPROVED), last[0], last[1], last[2]
        step *= 0.5
    there = _between(path, done + step)
    _, e, s, t, _ = walk(elements, last, there, tolerance, h)
    ended, _ = _has_ended(near, last, (e, s, t), (_between(path, done), there), h)
    return (ENDED if ended else UNPROVED), last[0], last[1], last[2]


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
    """Write row k for the foot of a point, on a face or a crease; `work` is (found, h)."""
    e, s, t = foot
    count = 0
    for side in range(4):
        if stands(side, s, t) and tables.elements.table[e]["kind"][side] == CREASE:
            count += 1
    feature = min(count, VERTEX)
    write_foot(tables, k, foot, OK, feature, point, out, work[1])
    if feature != FACE:
        total = np.empty(3)
        pseudo_normal(tables, foot, work[0], total, work[1])
        turn_normal(tables, k, total, point, out)


@kernel(error_model="numpy")
def follow_rows(tables, path, starts, rows, results, start, stop):
    """Follow the branches of rows[start:stop]; `path` is (points before, points now).

    A foot that is not the one on its branch is put right. Rows whose branch ends are flagged EVENT.
    """
    work = prove_work()
    found = np.empty(4)
    elements = tables.elements
    trimmed = tables.trims.trimmed
    near = (elements, tables.rings, trimmed, tables.scale[1])
    miss = SAME * tables.scale[1]
    before, points = path
    patch, uv = starts
    out, back = results
    for i in range(start, stop):
        k = rows[i]
        last = locate(tables.grid, patch[k], uv[k, 0], uv[k, 1])
        a = (before[k, 0], before[k, 1], before[k, 2])
        b = (points[k, 0], points[k, 1], points[k, 2])
        if _at_end(elements, last) or not _is_stationary(elements, last, a, miss, work[2]):
            continue
        if trimmed[patch[k]] != 0 and not whole_around(tables, last[0], last[1], last[2], 0.0, 0.0):
            continue
        step = 1.0
        if out.status[k] == OK:
            e, s, t = locate(tables.grid, out.patch[k], out.uv[k, 0], out.uv[k, 1])
            if prove(near, (e, s, t), last, (a, b), work) and is_untrimmed(tables, work[5]):
                out.certified[k] = 1
                continue
            step = 0.5
        outcome, e, s, t = follow(tables, last, (a, b), step, work)
        if outcome == ENDED:
            back[k] = EVENT
        elif outcome == PROVED:
            if not _is_there(tables, (e, s, t), k, out, work[2]):
                _put_right(tables, k, (e, s, t), b, out, (found, work[2]))
            out.certified[k] = 1
