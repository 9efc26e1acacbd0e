"""Crossings of swept points with a surface whose control points move in the same time.

The surface moves linearly from one shape to the other, S(s, t, τ) = S₀ + τ (S₁ − S₀), and the point
moves on a straight line. A cell is judged like one of a surface at rest (`crossing_nb`), in axes
that move with its middle: there the point moves straight relative to the mid-shape, and the cell
departs from that shape by no more than half of the variation of its displacement S₁ − S₀ over the
cell. Bounds of the displacement's derivatives bound this variation; it is added to the bounds of
the second derivatives, and a cell in which it is larger than these is halved in time. In a cell
with at most one crossing, Newton's method finds its (s, t, τ).

Boxes and plates are those of the last shape, widened by the displacement of its control points.
`surface` is a `MovingSurface`, `work` a `MovingWork`, and `shares` are the shares of the surface's
motion at the beginning and end of a segment.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import BUDGET, NO_HIT, NOT_FINITE
from contiga.arrays.kernels.query_nb import blank_hit, direction, slack_of
from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.vector_nb import column, cross, dot, minus
from contiga.elements.kernels.bounds_nb import cell_bounds
from contiga.elements.kernels.element_nb import evaluate
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner, kernel
from contiga.search.closest.kernels.edge_width_nb import OUTSIDE, edge_width
from contiga.search.hierarchy.kernels.plates_nb import is_passed
from contiga.search.sweep.kernels.crossing_nb import (
    DROP,
    HALVE,
    MAX_CELLS,
    MAX_PENDING,
    MAX_STEPS,
    MIN_SIZE,
    MISSED,
    NO_ROOM,
    NOT_CONVERGED,
    ON,
    POINT,
    SOLVE,
    held_cell,
    judge_cell,
    shrunk_cell,
)
from contiga.search.sweep.kernels.flat_cell_nb import meet_plane
from contiga.search.sweep.kernels.hit_nb import (
    X,
    keep_first,
    meets_box,
    next_leaves,
    reciprocal,
    write_last,
)
from contiga.search.sweep.sweep_records import LeafPath, MovingSegment, MovingWork, Queue


@inner()
def _shapes_at(surface, e, place, shares, work):
    """Evaluate element e at `place` (s, t) at the beginning, end and middle of a segment.

    Writes points and derivatives into work.begin, work.end and work.mid, relative to the origin of
    the element in the last shape.
    """
    now, before = surface.now.elements, surface.before
    begin, end, mid = work.begin, work.end, work.mid
    evaluate(now, e, place[0], place[1], begin)
    evaluate(before, e, place[0], place[1], end)
    for c in range(3):
        end[c, 0] += before.table[e]["origin"][c] - now.table[e]["origin"][c]
        for k in range(6):
            last, first = begin[c, k], end[c, k]
            begin[c, k] = (1.0 - shares[0]) * first + shares[0] * last
            end[c, k] = (1.0 - shares[1]) * first + shares[1] * last
            mid[c, k] = 0.5 * (begin[c, k] + end[c, k])


@inner()
def _bounds_over(surface, e, cell, shares, work):
    """Bound the derivatives over a cell in all shapes between `shares`; write them to work.bound.

    The bounds of the second derivatives include the variation of the displacement over the cell.
    Returns whether that variation exceeds the curvature: then the cell is better halved in time.
    """
    bound, change = work.bound, work.change
    box = (cell[0], cell[1], cell[2], cell[3])
    cell_bounds(surface.now.elements, e, box, bound)
    cell_bounds(surface.change, e, box, change)
    for c in range(9):
        bound[c] += change[c]
    hs, ht = 0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2])
    part = abs(shares[1] - shares[0])
    variation = part * (change[0] * hs + change[1] * ht)
    curvature = bound[2] * hs * hs + 2.0 * bound[3] * hs * ht + bound[4] * ht * ht
    bound[2] += part * change[0] / hs
    bound[4] += part * change[1] / ht
    return variation > curvature


@inner(error_model="numpy")
def _newton_crossing(surface, e, box, start, segment, work):
    """Find a crossing by Newton's method from `start` (s, t, τ), kept in `box` (s0, s1, t0, t1).

    Returns the state, s, t, τ, and the speed of the point along the normal, length per τ, negative
    where it enters. The state is ON if the method converged, MISSED if the box holds no root, or
    NOT_CONVERGED if the steps ran out or the point moves along the surface. work.mid holds the
    derivatives at the crossing.
    """
    p, q, slack, shares = segment.p, segment.q, segment.slack, segment.shares
    begin, end, mid = work.begin, work.end, work.mid
    s, t, tau = start
    speed = 0.0
    for _ in range(MAX_STEPS):
        _shapes_at(surface, e, (s, t), shares, work)
        for c in range(3):
            for k in range(6):
                mid[c, k] = (1.0 - tau) * begin[c, k] + tau * end[c, k]
        share = 1.0 - tau
        miss = (
            mid[0, 0] - share * p[0] - tau * q[0],
            mid[1, 0] - share * p[1] - tau * q[1],
            mid[2, 0] - share * p[2] - tau * q[2],
        )
        v = (
            end[0, 0] - begin[0, 0] - q[0] + p[0],
            end[1, 0] - begin[1, 0] - q[1] + p[1],
            end[2, 0] - begin[2, 0] - q[2] + p[2],
        )
        a, b = column(mid, 1), column(mid, 2)
        n = cross(a, b)
        c = dot(n, v)
        if c == 0.0:
            return NOT_CONVERGED, s, t, tau, speed
        speed = -c / math.sqrt(dot(n, n))
        ds = min(max(s - dot(miss, cross(b, v)) / c, box[0]), box[1]) - s
        dt = min(max(t - dot(miss, cross(v, a)) / c, box[2]), box[3]) - t
        new_tau = min(max(tau - dot(miss, n) / c, -1.0), 2.0)
        step = new_tau - tau
        s += ds
        t += dt
        tau = new_tau
        if math.sqrt(dot(miss, miss)) <= slack:
            return ON, s, t, tau, speed
        change = (
            a[0] * ds + b[0] * dt + v[0] * step,
            a[1] * ds + b[1] * dt + v[1] * step,
            a[2] * ds + b[2] * dt + v[2] * step,
        )
        if math.sqrt(dot(change, change)) <= 0.0625 * slack:
            return MISSED, s, t, tau, speed
    return NOT_CONVERGED, s, t, tau, speed


@inner(error_model="numpy")
def _unit_normal(surface, e, place, h, work):
    """Return the unit normal of element e at `place` (s, t) by the derivatives `h` (4, 6).

    Where they span no plane, it is the normal of the shape at the end of the motion
    (`surface.now`), and work.mid is overwritten.
    """
    n = cross(column(h, 1), column(h, 2))
    length = math.sqrt(dot(n, n))
    if length > 0.0:
        return n[0] / length, n[1] / length, n[2] / length
    return normal_at(surface.now.elements, e, place[0], place[1], work.mid)


@inner(error_model="numpy")
def _touch_plane(surface, e, cell, segment, path, length, work):
    """Intersect a path with the tangent plane of a cell, which rotates with the surface.

    `path` and its `length` are in the axes of the cell's middle, whose derivatives work.begin,
    work.end and work.mid hold. Returns the same as `flat_cell_nb.touch`.
    """
    if length == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    place = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3])
    r = minus(path.p, column(work.mid, 0))
    normal = _unit_normal(surface, e, place, work.begin, work)
    first = dot(minus(segment.p, column(work.begin, 0)), normal)
    normal = _unit_normal(surface, e, place, work.end, work)
    last = dot(minus(segment.q, column(work.end, 0)), normal)
    _shapes_at(surface, e, place, segment.shares, work)
    heights = first, (last - first) / length
    return meet_plane(cell, path, length, work.mid, r, heights)


@inner()
def _halve(stack, top, cell, h, halve_time):
    """Push the halves of a cell onto the stack; return its new top.

    Cut in time if `halve_time`, else along the longer side by the derivatives `h`.
    """
    hs, ht = 0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2])
    along_s = h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2
    along_t = h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2
    put(stack, top, cell)
    put(stack, top + 1, cell)
    axis = 2
    if halve_time:
        axis = 4
    elif ht < MIN_SIZE or (hs >= MIN_SIZE and along_s * hs * hs >= along_t * ht * ht):
        axis = 0
    stack[top, axis + 1] = stack[top + 1, axis] = 0.5 * (cell[axis] + cell[axis + 1])
    return top + 2


@inner()
def _between(p, q, share):
    """Return p + share (q − p)."""
    start_share = 1.0 - share
    return (
        start_share * p[0] + share * q[0],
        start_share * p[1] + share * q[1],
        start_share * p[2] + share * q[2],
    )


@inner(error_model="numpy")
def _face_edge_width(surface, e, place, d, slack, mid):
    """Return the width of an edge near a crossing in direction `d`; zero inside the face.

    OUTSIDE if the crossing is outside the face; `mid` holds the derivatives at the crossing.
    """
    line = LeafPath(column(mid, 0), d, slack, 0.0, NO_ROOM)
    tables = surface.now
    width, _, _ = edge_width(
        tables.elements, tables.trims, tables.piece_width, e, place, line, 3.0 * slack, mid
    )
    return width


@inner(linked=False, error_model="numpy")
def _cross_leaf(surface, leaf, segment, crossings, work):
    """Find all crossings of a leaf and keep the first entry and exit in `crossings` (`keep_first`).

    `segment` is relative to the origin of the leaf's element. Cells are boxes (s0, s1, t0, t1, τ0,
    τ1). They are counted in work.counts[0]; work.counts[1] becomes 1 if a cell is given up.
    """
    e, stack, mid, counts = leaf["element"], work.stack, work.mid, work.counts
    slack, spare = segment.slack, segment.spare
    box = leaf["box"]
    put(stack, 0, (box[0], box[1], box[2], box[3], 0.0, 1.0))
    top = 1
    while top > 0:
        top -= 1
        counts[0] += 1
        cell = (
            stack[top, 0],
            stack[top, 1],
            stack[top, 2],
            stack[top, 3],
            stack[top, 4],
            stack[top, 5],
        )
        rect = (cell[0], cell[1], cell[2], cell[3])
        place = (0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]))
        size = (0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2]))
        duration = cell[5] - cell[4]
        first, last = segment.shares
        part = MovingSegment(
            _between(segment.p, segment.q, cell[4]),
            _between(segment.p, segment.q, cell[5]),
            (first + cell[4] * (last - first), first + cell[5] * (last - first)),
            slack,
            spare,
        )
        halve_time = _bounds_over(surface, e, cell, part.shares, work)
        _shapes_at(surface, e, place, part.shares, work)
        # The path in axes that move with the middle of the cell.
        shift = minus(column(work.end, 0), column(work.begin, 0))
        p = (part.p[0] + 0.5 * shift[0], part.p[1] + 0.5 * shift[1], part.p[2] + 0.5 * shift[2])
        q = (part.q[0] - 0.5 * shift[0], part.q[1] - 0.5 * shift[1], part.q[2] - 0.5 * shift[2])
        length, d = direction(p, q)
        path, span = LeafPath(p, d, slack, 0.0, NO_ROOM), (-spare, length + spare)
        verdict, ds, dt = judge_cell(mid, work.bound, size, path, span, False)
        if verdict == DROP:
            continue
        if verdict == SOLVE:
            x = min(max(-dot(minus(p, column(mid, 0)), d), 0.0), length)
            start = (place[0] + ds, place[1] + dt, x / length)
            limits = held_cell(rect, size, path, NO_ROOM, mid)
            state, s, t, tau, speed = _newton_crossing(surface, e, limits, start, part, work)
            if state == ON:
                x = cell[4] + duration * tau  # share of the whole segment
                x_tol = duration * min(slack / abs(speed), spare / length)
                if -x_tol <= x <= 1.0 + x_tol:
                    width = _face_edge_width(surface, e, (s, t), d, slack, mid)
                    if width != OUTSIDE:
                        keep_first(crossings, e, (s, t), x, speed, x_tol, width)
            if state != NOT_CONVERGED:
                continue
            verdict = HALVE if max(size[0], size[1]) > MIN_SIZE else POINT
            _shapes_at(surface, e, place, part.shares, work)
        if verdict == POINT:
            x, ds, dt, slope = _touch_plane(surface, e, rect, part, path, length, work)
            if slope != 0.0:
                s, t = place[0] + ds, place[1] + dt
                _shapes_at(surface, e, (s, t), part.shares, work)
                width = _face_edge_width(surface, e, (s, t), d, slack, mid)
                if width != OUTSIDE:
                    x = cell[4] + duration * x / length
                    keep_first(crossings, e, (s, t), x, slope, duration * slack / length, width)
            continue
        if counts[0] > MAX_CELLS or top > MAX_PENDING - 3:
            counts[1] = 1
            continue
        rect = shrunk_cell(mid, work.bound, rect, path, span)
        if rect[0] >= rect[1] or rect[2] >= rect[3]:
            continue
        area = (rect[1] - rect[0]) * (rect[3] - rect[2])
        if area < 0.5 * (cell[1] - cell[0]) * (cell[3] - cell[2]):
            put(stack, top, (rect[0], rect[1], rect[2], rect[3], cell[4], cell[5]))
            top += 1
        else:
            top = _halve(stack, top, cell, mid, halve_time)


@inner(linked=False)
def _search(surface, segment, crossings, queue, work):
    """Write the first entry of a `MovingSegment` to crossings[0], its first exit to crossings[1].

    x, the share of the segment, is infinite for none. work.counts[1] is 1 afterwards if cells were
    given up, else 0.
    """
    tables = surface.now
    tree, leaves, elements = tables.tree, tables.leaves, tables.elements
    p, slack, spare = segment.p, segment.slack, segment.spare
    length, d = direction(p, segment.q)
    inverse = (reciprocal(d[0]), reciprocal(d[1]), reciprocal(d[2]))
    span, width = (-spare, length + spare), slack + surface.max_displacement
    crossings[0, X] = math.inf
    crossings[1, X] = math.inf
    work.counts[0] = 0
    work.counts[1] = 0
    queue.nodes[0] = 0
    queue.entry[0] = -spare
    top = 1 if meets_box(tree[0], p, inverse, span, width)[0] else 0
    while top > 0:
        node, top = next_leaves(tree, p, inverse, span, width, queue, top)
        if node < 0:
            break
        for i in range(tree[node]["first"], tree[node]["first"] + tree[node]["count"]):
            e = leaves[i]["element"]
            if e < 0 or is_passed(tables.plates[i], p, d, span, width):
                continue
            row = elements.table[e]
            origin = (row["origin"][0], row["origin"][1], row["origin"][2])
            local = MovingSegment(
                minus(p, origin),
                minus(segment.q, origin),
                segment.shares,
                slack + row["noise"] + surface.before.table[e]["noise"],
                spare,
            )
            _cross_leaf(surface, leaves[i], local, crossings, work)


@kernel(error_model="numpy")
def last_moving_crossings(surface, p0, p1, between, out, verdict, start, stop):
    """Write the crossing nearest the end of each segment p0[i] → p1[i] into row i of `out`.

    `p0` and `p1` are (n, 3); `between` (n, 2) are the shares of the surface's motion at the
    beginning and end of each segment. Points of `out` (a `Hit`) belong to the last shape. Statuses
    and `verdict` (n, 2) are those of `hit_nb.last_crossings`.
    """
    elements = surface.now.elements
    crossings = np.empty((2, 6))
    queue = Queue(np.empty(128, np.int64), np.empty(128))
    tables = np.empty((3, 4, 6))
    bounds = np.empty((2, 9))
    stack, counts = np.empty((MAX_PENDING, 6)), np.zeros(2, np.int64)
    work = MovingWork(tables[0], tables[1], tables[2], bounds[0], bounds[1], stack, counts)
    size = surface.now.scale[0]
    for i in range(start, stop):
        # The search goes backwards in time: what it finds as an entry is an exit.
        p = (p1[i, 0], p1[i, 1], p1[i, 2])
        q = (p0[i, 0], p0[i, 1], p0[i, 2])
        verdict[i] = 0.0
        if not math.isfinite(p[0] + p[1] + p[2] + q[0] + q[1] + q[2]):
            blank_hit(out, i, NOT_FINITE)
            continue
        blank_hit(out, i, NO_HIT)
        if surface.now.leaves.shape[0] == 0:
            continue
        slack = slack_of(p, q, size)
        shares = (between[i, 1], between[i, 0])
        segment = MovingSegment(p, q, shares, slack, math.sqrt(slack * size))
        _search(surface, segment, crossings, queue, work)
        write_last(elements, out, verdict, i, crossings, (1.0, slack), work.mid)
        if work.counts[1] != 0:
            out.status[i] = BUDGET
