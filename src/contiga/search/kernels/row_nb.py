"""Tracking one point by itself: what a thread of a GPU does.

The mathematics are those of the lanes and of the quick certificate, so the results are the same
numbers. A row that ends otherwise than in a proved foot within its patch is flagged and left as it
was: the careful walk, creases, edges and the search for closest points are the CPU's. `tables` is
whatever has `elements`, `grid`, `trims`, `rings` and `scale` as `Tables` does.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import locate
from contiga.num.codes import FACE, GENERAL, OK, OUT, RATIONAL_CUBIC
from contiga.num.jit import inlined, inner, kernel
from contiga.search.kernels.branch_nb import kept_ball, seen_from
from contiga.search.kernels.newton_nb import (
    ACTIVE,
    DONE,
    GIVEN_BACK,
    LEFT,
    ROUNDS,
    foot_record,
    local_place,
    newton_step,
    polynomial_at,
    rational_at,
)
from contiga.search.kernels.project_nb import may_go_on

HANDED_BACK = 1
"""Flag of rows that are left to the CPU."""


@inlined()
def _derivatives(k, rational, s, t):
    if rational:
        x, y, z = rational_at(k, s, t)
    else:
        x, y, z = polynomial_at(k, s, t)
    return x, y, z


@inner()
def _newton(own, place, best, p, tolerance):
    """Newton's method in the element `own` from place = (s, t), `p` relative to its origin.

    Returns (s, t), the square of the distance so far, the state, and (foot, normal, gap).
    """
    k = own["cubic"]
    rational = own["form"] == RATIONAL_CUBIC
    s, t = place
    state = ACTIVE
    for _ in range(ROUNDS):
        x, y, z = _derivatives(k, rational, s, t)
        s, t, best, state = newton_step((s, t), (best, state), p, x, y, z, tolerance)
        if state != ACTIVE:
            break
    x, y, z = _derivatives(k, rational, s, t)
    n_x, n_y, n_z, gap, state = foot_record(p, state, x, y, z, tolerance)
    return (s, t), best, state, ((x[0], y[0], z[0]), (n_x, n_y, n_z), gap)


@inner()
def _in_element(tables, e, foot, best, point):
    """As `_newton`, in element e from the parameters foot = (u, v), for a point of the body."""
    own = tables.elements.table[e]
    box = own["box"]
    origin = own["origin"]
    s = local_place(foot[0], box[0], 1.0 / (box[1] - box[0]))
    t = local_place(foot[1], box[2], 1.0 / (box[3] - box[2]))
    p = (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])
    if own["form"] == GENERAL or own["trim"] == OUT:
        return (s, t), best, GIVEN_BACK, (p, p, best)
    return _newton(own, (s, t), best, p, tables.scale[1] ** 2)


@inner()
def _foot(tables, patch, start, point):
    """Whether there is a foot in the element of start = (u, v) or the next; its (u, v) and record.

    Trims are left to the certificate: it clears all of a neighbourhood.
    """
    elements = tables.elements
    e = locate(tables.grid, patch, start[0], start[1])[0]
    place, best, state, record = _in_element(tables, e, start, math.inf, point)
    u, v = _parameters(elements.table[e]["box"], place)
    if state == LEFT and may_go_on(elements, e, place[0], place[1]):
        e = locate(tables.grid, patch, u, v)[0]
        place, best, state, record = _in_element(tables, e, (u, v), best, point)
        u, v = _parameters(elements.table[e]["box"], place)
    origin = elements.table[e]["origin"]
    (x, y, z), normal, gap = record
    return state == DONE, (u, v), ((x + origin[0], y + origin[1], z + origin[2]), normal, gap)


@inlined()
def _parameters(box, place):
    u = box[0] + (place[0] + 0.5) * (box[1] - box[0])
    v = box[2] + (place[1] + 0.5) * (box[3] - box[2])
    return u, v


@kernel()
def track_row(tables, path, results, k):
    """Track row k from its foot in `results` = (projection, flags), which the new one replaces.

    `path` is (points before, points now). The row is flagged HANDED_BACK and not written where no
    foot is found here, or its certificate takes more than the bounds kept around it.
    """
    before, points = path
    out, back = results
    back[k] = HANDED_BACK
    patch = out.patch[k]
    a = (before[k, 0], before[k, 1], before[k, 2])
    b = (points[k, 0], points[k, 1], points[k, 2])
    if patch < 0 or not math.isfinite(a[0] + a[1] + a[2] + b[0] + b[1] + b[2]):
        return
    start = (out.uv[k, 0], out.uv[k, 1])
    found, uv, (foot, normal, gap) = _foot(tables, patch, start, b)
    if not found:
        return
    seen = seen_from(foot, normal, a, b, tables.scale[1])
    taken = (tables.grid, tables.elements.table, tables.rings)
    if not kept_ball(tables, taken, (patch, patch), uv, start, seen) > 0.0:
        return
    back[k] = 0
    out.uv[k, 0] = uv[0]
    out.uv[k, 1] = uv[1]
    for c in range(3):
        out.point[k, c] = foot[c]
        out.normal[k, c] = normal[c]
    out.gap[k] = gap
    out.feature[k] = FACE
    out.status[k] = OK
    out.certified[k] = 1


@kernel()
def gather_row(tracked, rows, to, i):
    """Copy row rows[i] of `tracked` = (feet, points before) to row i of `to` = (patch, uv,
    points)."""
    feet, before = tracked
    patch, uv, points = to
    k = rows[i]
    patch[i] = feet.patch[k]
    for c in range(2):
        uv[i, c] = feet.uv[k, c]
    for c in range(3):
        points[i, c] = before[k, c]


@kernel()
def scatter_row(feet, rows, out, i):
    """Copy row i of the projection `feet` to row rows[i] of `out`."""
    k = rows[i]
    out.patch[k] = feet.patch[i]
    for c in range(2):
        out.uv[k, c] = feet.uv[i, c]
    for c in range(3):
        out.point[k, c] = feet.point[i, c]
        out.normal[k, c] = feet.normal[i, c]
    out.gap[k] = feet.gap[i]
    out.feature[k] = feet.feature[i]
    out.status[k] = feet.status[i]
    out.certified[k] = feet.certified[i]
