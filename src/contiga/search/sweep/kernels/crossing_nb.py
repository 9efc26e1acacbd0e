"""Crossings of a straight path with one leaf, cell by cell, with tolerances that are lengths.

The equations are those of the line p + x d, d of length one, not of the segment: seen along d only
(s, t) are unknown, and x follows from them. With a = S_s, b = S_t and c = (a × b)·d the rows (b ×
d)/c and (d × a)/c convert a displacement of the line to one of (s, t). Every crossing in a cell is
within |rows| · (departure from the tangent plane) of the linear one: a cell whose rectangle misses
that is dropped. Where the derivatives change so little over the cell that |rows| · change < 1 there
is at most one crossing, and Newton's method held in the cell finds it; other cells are halved
(interval Newton, Moore, Kearfott & Cloud 2009, ch. 8). None of this depends on the length of the
segment; its ends only cut off what lies beyond them.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EITHER, ENTRIES
from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.vector_nb import column, cross, dot, minus
from contiga.elements.kernels.bounds_nb import cell_box
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.search.sweep.kernels.flat_cell_nb import over_plane, touch
from contiga.search.sweep.sweep_records import LeafPath

DROP, SOLVE, POINT, HALVE = 0, 1, 2, 3
NOT_CONVERGED, MISSED, ON = -1, 0, 1
MAX_CONTRACTION = 0.75
"""|rows| · change below which Newton's method, held in the cell, converges to the only root: its
steps shrink at least by λ²/(4 (1 − λ)) < 1, and squared from then on."""
MAX_STEPS = 60
"""Largest number of Newton's steps: held at a side with the root beyond it, they may only halve."""
MAX_LOOSE_CELLS = 64
"""Number of cells of a leaf from which on each gets bounds of its own: those of the leaf are too
loose."""
POLE_SHARE = 1.0 / 64.0
"""Share of their leaf below which cells of an element with a pole get bounds of their own: the
leaf's do not shrink towards the pole."""
MIN_SIZE = 1e-16
"""Half-size of a cell (local parameters) below which it is not halved."""
MAX_CELLS = 20000
"""Largest number of cells of a path; with more the search is given up."""
MAX_PENDING = 128
"""Largest number of pending cells of a leaf."""
NO_ROOM = (0.0, 0.0, 0.0, 0.0)
"""Room beyond the sides of an element without a widened edge."""


@inner(error_model="numpy")
def _misses_box(corner, p, d, x_min, x_max, pad):
    """Return whether p + x d, x_min ≤ x ≤ x_max, misses a box (low, high) widened by `pad`."""
    for c in range(3):
        low = corner[0, c] - pad - p[c]
        high = corner[1, c] + pad - p[c]
        if d[c] == 0.0:
            if low > 0.0 or high < 0.0:
                return True
        else:
            a = low / d[c]
            b = high / d[c]
            x_min = max(x_min, min(a, b))
            x_max = min(x_max, max(a, b))
    return x_min > x_max


@inner(error_model="numpy")
def judge_cell(h, k, size, path, span, entries):
    """Decide whether to DROP a cell, to SOLVE its crossing, to treat it as a POINT, or to HALVE it.

    Returns that verdict, and the steps in s and t from the cell's middle to the start of SOLVE,
    else zeros. The cell has the half-size `size` about the place with derivatives `h`, and bounds
    k[9]. `path` is a `LeafPath`, `span` is (x_min, x_max), the range that is searched; `entries`
    tells whether only entries count.
    """
    hs, ht = size
    p, d, slack, wide = path.p, path.d, path.slack, path.wide
    r = minus(p, column(h, 0))
    kx = k[0] * hs
    ky = k[1] * ht
    # The path is too far from the cell's middle.
    radius = (kx + ky) * (1.0 + 1e-9) + slack + wide
    x = min(max(-dot(r, d), span[0]), span[1])
    e = (r[0] + x * d[0], r[1] + x * d[1], r[2] + x * d[2])
    if dot(e, e) > radius * radius:
        return DROP, 0.0, 0.0
    a = column(h, 1)
    b = column(h, 2)
    n = cross(a, b)
    c = dot(n, d)
    kxx = k[2] * hs * hs
    kxy = k[3] * hs * ht
    kyy = k[4] * ht * ht
    bend = 0.5 * (kxx + kyy) + kxy
    # Both ends of the path are on one side of the slab that contains the cell.
    height = dot(r, n)
    first = height + span[0] * c
    last = height + span[1] * c
    pad = (bend + slack + wide) * math.sqrt(dot(n, n))
    if min(first, last) > pad or max(first, last) < -pad:
        return DROP, 0.0, 0.0
    # Wherever the path crosses the cell it leaves the body: n·d > 0 for all normals.
    turn = (kxx + kxy) * ky + kx * (kxy + kyy)
    if entries and c * hs * ht > turn * (1.0 + 1e-6):
        return DROP, 0.0, 0.0
    q = cross(b, d)
    o = cross(d, a)
    g_s = math.sqrt(dot(q, q))
    g_t = math.sqrt(dot(o, o))
    s = dot(q, r)
    t = dot(o, r)
    abs_c = abs(c)
    departure = bend + 2.0 * slack + wide
    if abs(s) - g_s * departure > abs_c * hs or abs(t) - g_t * departure > abs_c * ht:
        return DROP, 0.0, 0.0
    change = kxx + 2.0 * kxy + kyy
    if g_s * change < MAX_CONTRACTION * abs_c * hs and g_t * change < MAX_CONTRACTION * abs_c * ht:
        return SOLVE, min(max(s / c, -hs), hs), min(max(t / c, -ht), ht)
    if kx + ky < slack or bend < 0.25 * slack or (hs < MIN_SIZE and ht < MIN_SIZE):
        return POINT, 0.0, 0.0
    return HALVE, 0.0, 0.0


@inner(error_model="numpy")
def _solve(elements, e, box, start, path, h):
    """Find a crossing of the line by Newton's method from `start` (s, t), kept in `box`.

    `box` is (s0, s1, t0, t1). Returns the state, s, t, x, and the slope n·d with the unit normal n.
    The state is ON if the method converged, MISSED if the box holds no root, NOT_CONVERGED if the
    steps ran out or the line is tangential.
    """
    p, d, slack = path.p, path.d, path.slack
    s, t = start
    x = slope = 0.0
    for _ in range(MAX_STEPS):
        evaluate(elements, e, s, t, h)
        r = minus(p, column(h, 0))
        a = column(h, 1)
        b = column(h, 2)
        n = cross(a, b)
        c = dot(n, d)
        if c == 0.0:
            return NOT_CONVERGED, s, t, x, slope
        slope = c / math.sqrt(dot(n, n))
        x = -dot(r, d)
        # Products with the miss, because those with the vector to a distant start cancel to noise.
        miss = (r[0] + x * d[0], r[1] + x * d[1], r[2] + x * d[2])
        q = cross(b, d)
        o = cross(d, a)
        ds = (miss[0] * q[0] + miss[1] * q[1]) / c + miss[2] * q[2] / c
        dt = (miss[0] * o[0] + miss[1] * o[1]) / c + miss[2] * o[2] / c
        ds = min(max(s + ds, box[0]), box[1]) - s
        dt = min(max(t + dt, box[2]), box[3]) - t
        s += ds
        t += dt
        m = (a[0] * ds + b[0] * dt, a[1] * ds + b[1] * dt, a[2] * ds + b[2] * dt)
        x += dot(m, d)
        if math.sqrt(dot(miss, miss)) <= slack:
            return ON, s, t, x, slope
        if math.sqrt(dot(m, m)) <= 0.0625 * slack:
            return MISSED, s, t, x, slope
    return NOT_CONVERGED, s, t, x, slope


@inner(error_model="numpy")
def shrunk_cell(h, k, cell, path, span):
    """Return the part (s0, s1, t0, t1) of a cell that the path, not just its line, may cross.

    Low ≥ high if it may cross no part; the cell itself if it has no tangent plane. To first order
    the dual vectors of the tangent plane give (s, t) of a point of the path, at any angle: a path
    shorter than the cell can cross only a small part of it.
    """
    p, d, slack, wide = path.p, path.d, path.slack, path.wide
    hs = 0.5 * (cell[1] - cell[0])
    ht = 0.5 * (cell[3] - cell[2])
    has_plane, line, per = over_plane(h, minus(p, column(h, 0)), d)
    if not has_plane:
        return cell
    departure = 0.5 * (k[2] * hs * hs + k[4] * ht * ht) + k[3] * hs * ht + 2.0 * slack + wide
    s, t, ds, dt = line
    pad_s = departure * per[0] + 4.0 * MIN_SIZE
    pad_t = departure * per[1] + 4.0 * MIN_SIZE
    sc = 0.5 * (cell[0] + cell[1])
    tc = 0.5 * (cell[2] + cell[3])
    return (
        max(cell[0], sc + s + min(span[0] * ds, span[1] * ds) - pad_s),
        min(cell[1], sc + s + max(span[0] * ds, span[1] * ds) + pad_s),
        max(cell[2], tc + t + min(span[0] * dt, span[1] * dt) - pad_t),
        min(cell[3], tc + t + max(span[0] * dt, span[1] * dt) + pad_t),
    )


@inner(error_model="numpy")
def held_cell(cell, size, path, room, h):
    """Return the rectangle (s0, s1, t0, t1) in which the crossing of a cell is searched.

    It is the cell and its tolerance: the derivatives `h` in the middle of the cell turn a
    displacement of the line by `slack`, and beyond the sides of the element by their `room`, into
    one of (s, t), by half an element at most.
    """
    d, slack = path.d, path.slack
    a = column(h, 1)
    q = cross(column(h, 2), d)
    o = cross(d, a)
    c = abs(dot(a, q))
    per_s = math.sqrt(dot(q, q)) / c
    per_t = math.sqrt(dot(o, o)) / c
    s = min(2.0 * slack * per_s, size[0])
    t = min(2.0 * slack * per_t, size[1])
    return (
        cell[0] - s - (min(room[0] * per_s, 0.5) if cell[0] <= -0.5 else 0.0),
        cell[1] + s + (min(room[1] * per_s, 0.5) if cell[1] >= 0.5 else 0.0),
        cell[2] - t - (min(room[2] * per_t, 0.5) if cell[2] <= -0.5 else 0.0),
        cell[3] + t + (min(room[3] * per_t, 0.5) if cell[3] >= 0.5 else 0.0),
    )


@inner()
def next_crossing(elements, leaf, pole, path, ends, work, top):
    """Find the next crossing of one leaf, trimmed or not, among the `top` cells on the stack.

    It is the first crossing found, not the one with the least x; it has x < max_x, and enters if
    only entries count. `path` is a `LeafPath`, `ends` are `Ends`, `work` is `CellWork`, in which
    cells are counted, and counts[1] becomes 1 if one is given up. Returns x (infinite for none), s,
    t, the slope (n·d, or −1 or 1 by `touch`), and the number of cells still on the stack.
    """
    stack, h, k, corner, count = work.stack, work.h, work.k, work.corner, work.counts
    length, spare, max_x, sense = ends.length, ends.spare, ends.max_x, ends.sense
    e = leaf["element"]
    p, d, slack = path.p, path.d, path.slack
    pole_area = POLE_SHARE * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
    span = (-spare, min(max_x, length + spare))
    max_loose = count[0] + MAX_LOOSE_CELLS
    crossing_x, s, t, slope = math.inf, 0.0, 0.0, 0.0
    while top > 0 and crossing_x == math.inf:
        top -= 1
        count[0] += 1
        cell = (stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3])
        place = (0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]))
        size = (0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2]))
        # For a cell the path has the largest width beyond the sides that the cell touches.
        room = path.room
        wide = room[0] if cell[0] <= -0.5 else 0.0
        wide = max(wide, room[1] if cell[1] >= 0.5 else 0.0)
        wide = max(wide, room[2] if cell[2] <= -0.5 else 0.0)
        wide = max(wide, room[3] if cell[3] >= 0.5 else 0.0)
        cell_path = LeafPath(path.p, path.d, path.slack, wide, room)
        is_tight = count[0] > max_loose or (pole and 4.0 * size[0] * size[1] < pole_area)
        if is_tight:
            cell_box(elements, e, cell, k, corner)
            if _misses_box(corner, p, d, span[0], span[1], slack + cell_path.wide):
                continue
        else:
            for c in range(9):
                k[c] = leaf["bound"][c]
        evaluate(elements, e, place[0], place[1], h)
        verdict, ds, dt = judge_cell(h, k, size, cell_path, span, sense == ENTRIES)
        if verdict == SOLVE:
            start = (place[0] + ds, place[1] + dt)
            box = held_cell(cell, size, path, NO_ROOM, h)
            wide_box = held_cell(cell, size, path, path.room, h)
            state, s, t, x, slope = _solve(elements, e, box, start, path, h)
            if state == MISSED and wide_box != box:
                state, s, t, x, slope = _solve(elements, e, wide_box, start, path, h)
                state = max(state, MISSED)
            # Near a wide edge the caller finds the position of the crossing along the path.
            if state == ON:
                tol = spare if path.wide > 0.0 else min(slack / abs(slope), spare)
                if -tol <= x <= length + tol and x < max_x and (sense == EITHER or slope < 0.0):
                    crossing_x = x
            if state == NOT_CONVERGED:
                verdict = HALVE if max(size[0], size[1]) > MIN_SIZE else POINT
                evaluate(elements, e, place[0], place[1], h)
        if verdict == POINT:
            x, ds, dt, slope = touch(elements, e, cell, path, length, h)
            s, t = place[0] + ds, place[1] + dt
            if slope != 0.0 and x < max_x and (sense == EITHER or slope < 0.0):
                crossing_x = x
        if verdict == HALVE:
            if count[0] > MAX_CELLS or top > MAX_PENDING - 3:
                count[1] = 1
                continue
            part = shrunk_cell(h, k, cell, cell_path, span)
            if part[0] >= part[1] or part[2] >= part[3]:
                continue
            part_area = (part[1] - part[0]) * (part[3] - part[2])
            if part_area < 0.5 * (cell[1] - cell[0]) * (cell[3] - cell[2]):
                put(stack, top, part)
                top += 1
                continue
            # Halves, cut across s where the surface is longer along it.
            hs, ht = size
            if hs < MIN_SIZE or ht < MIN_SIZE:
                across_s = ht < MIN_SIZE
            elif is_tight:
                across_s = k[0] * hs >= k[1] * ht
            else:
                along_s = h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2
                along_t = h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2
                across_s = along_s * hs * hs >= along_t * ht * ht
            for c in range(2):
                put(stack, top + c, cell)
            if across_s:
                stack[top, 1] = stack[top + 1, 0] = place[0]
            else:
                stack[top, 3] = stack[top + 1, 2] = place[1]
            top += 2
    return crossing_x, s, t, slope, top
