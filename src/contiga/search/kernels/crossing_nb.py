"""Where a straight path crosses one leaf, cell by cell, with tolerances that are lengths.

The line p + x d, d of length one, is solved for, not the segment: seen along d only (s, t) are
unknown, and x follows from the point found. With a = S_s, b = S_t and c = (a × b)·d the rows
(b × d)/c and (d × a)/c turn a displacement of the line into one of (s, t). Every crossing in a
cell lies within |rows| · (departure from the tangent plane) of the linear one: a cell whose
rectangle misses that is dropped. Where the derivatives change so little over the cell that
|rows| · change < 1 there is at most one crossing, and Newton's method held in the cell finds it;
other cells are halved (interval Newton, Moore, Kearfott & Cloud 2009, ch. 8). None of this knows
how long the segment is; its ends only cut off what lies beyond them.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.bounds_nb import cell_box
from contiga.elements.kernels.element_nb import evaluate
from contiga.num.codes import ENTRIES
from contiga.num.jit import inlined, inner
from contiga.search.kernels.flat_cell_nb import touch

DROP, SOLVE, POINT, HALVE = 0, 1, 2, 3
CONTRACTS = 0.75
"""|rows| · change below which Newton's method, held in the cell, converges to the only root: its
steps shrink at least by λ²/(4 (1 − λ)) < 1, and squared from then on."""
STEPS = 60
"""Of Newton's method: held at a side with the root beyond it, it may only halve its steps."""
EASY = 64
"""Cells of a leaf after which its bounds are taken for too loose, and each cell gets its own."""
DEEP = 1.0 / 64.0
"""Cells of an element with a pole, smaller than this share of their leaf, get bounds of their own:
the leaf's do not shrink towards the pole."""
TINY = 1e-16
"""Half-size of a cell (local parameters) that cannot be halved any more."""
MAX_CELLS = 20000
"""Cells one path may open; then it is given up."""
DEPTH = 128
"""Cells of a leaf that can wait at once."""
NONE = (0.0, 0.0, 0.0, 0.0)
"""No room beyond any side."""


@inner(error_model="numpy")
def _beside_box(corner, p, d, near, far, pad):
    """Whether p + x d, near ≤ x ≤ far, misses a box (low, high) widened by `pad`."""
    for c in range(3):
        low = corner[0, c] - pad - p[c]
        high = corner[1, c] + pad - p[c]
        if d[c] == 0.0:
            if low > 0.0 or high < 0.0:
                return True
        else:
            a = low / d[c]
            b = high / d[c]
            near = max(near, min(a, b))
            far = min(far, max(a, b))
    return near > far


@inner(error_model="numpy")
def _judge(h, k, size, path, span, entries):
    """What to do with a cell of half-size `size` about the place whose derivatives are `h`.

    `path` is (p, d, slack, wide, room): `wide` is how far beside the cell, in space, a crossing
    still counts. `span` is the (near, far) of it that is asked for. Returns what to do, and the
    steps in (s, t) from the middle to where SOLVE is to start.
    """
    hs, ht = size
    p, d, slack, wide, _ = path
    near, far = span
    r0 = p[0] - h[0, 0]
    r1 = p[1] - h[1, 0]
    r2 = p[2] - h[2, 0]
    kx = k[0] * hs
    ky = k[1] * ht
    # The part of the path nearest to the cell's middle must come within its radius.
    x = min(max(-(r0 * d[0] + r1 * d[1] + r2 * d[2]), near), far)
    e0 = r0 + x * d[0]
    e1 = r1 + x * d[1]
    e2 = r2 + x * d[2]
    reach = (kx + ky) * (1.0 + 1e-9) + slack + wide
    if e0 * e0 + e1 * e1 + e2 * e2 > reach * reach:
        return DROP, 0.0, 0.0
    a0 = h[0, 1]
    a1 = h[1, 1]
    a2 = h[2, 1]
    b0 = h[0, 2]
    b1 = h[1, 2]
    b2 = h[2, 2]
    n0 = a1 * b2 - a2 * b1
    n1 = a2 * b0 - a0 * b2
    n2 = a0 * b1 - a1 * b0
    c = n0 * d[0] + n1 * d[1] + n2 * d[2]
    kxx = k[2] * hs * hs
    kxy = k[3] * hs * ht
    kyy = k[4] * ht * ht
    bend = 0.5 * (kxx + kyy) + kxy
    # Both ends on the same side of the slab that holds the cell.
    height = r0 * n0 + r1 * n1 + r2 * n2
    first = height + near * c
    last = height + far * c
    pad = (bend + slack + wide) * math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if min(first, last) > pad or max(first, last) < -pad:
        return DROP, 0.0, 0.0
    # Leaving wherever in the cell: n·d > 0 for all its normals.
    turn = (kxx + kxy) * ky + kx * (kxy + kyy)
    if entries and c * hs * ht > turn * (1.0 + 1e-6):
        return DROP, 0.0, 0.0
    q0 = b1 * d[2] - b2 * d[1]
    q1 = b2 * d[0] - b0 * d[2]
    q2 = b0 * d[1] - b1 * d[0]
    o0 = d[1] * a2 - d[2] * a1
    o1 = d[2] * a0 - d[0] * a2
    o2 = d[0] * a1 - d[1] * a0
    g_s = math.sqrt(q0 * q0 + q1 * q1 + q2 * q2)
    g_t = math.sqrt(o0 * o0 + o1 * o1 + o2 * o2)
    s = q0 * r0 + q1 * r1 + q2 * r2
    t = o0 * r0 + o1 * r1 + o2 * r2
    away = abs(c)
    off = bend + 2.0 * slack + wide
    if abs(s) - g_s * off > away * hs or abs(t) - g_t * off > away * ht:
        return DROP, 0.0, 0.0
    change = kxx + 2.0 * kxy + kyy
    if g_s * change < CONTRACTS * away * hs and g_t * change < CONTRACTS * away * ht:
        return SOLVE, min(max(s / c, -hs), hs), min(max(t / c, -ht), ht)
    if kx + ky < slack or bend < 0.25 * slack or (hs < TINY and ht < TINY):
        return POINT, 0.0, 0.0
    return HALVE, 0.0, 0.0


@inner(error_model="numpy")
def _solve(elements, e, box, start, path, h):
    """Newton's method for the line, held in `box` (s0, s1, t0, t1), from `start`.

    `path` begins with (p, d, slack). Returns 1 where it converged, 0 where the box holds no root,
    −1 where the steps ran out; s, t, x, and (S_s × S_t)·d over |S_s × S_t|.
    """
    p, d, slack = path[0], path[1], path[2]
    s, t = start
    x = slope = 0.0
    for _ in range(STEPS):
        evaluate(elements, e, s, t, h)
        r0 = p[0] - h[0, 0]
        r1 = p[1] - h[1, 0]
        r2 = p[2] - h[2, 0]
        a0 = h[0, 1]
        a1 = h[1, 1]
        a2 = h[2, 1]
        b0 = h[0, 2]
        b1 = h[1, 2]
        b2 = h[2, 2]
        n0 = a1 * b2 - a2 * b1
        n1 = a2 * b0 - a0 * b2
        n2 = a0 * b1 - a1 * b0
        c = n0 * d[0] + n1 * d[1] + n2 * d[2]
        if c == 0.0:
            return -1, s, t, x, slope
        slope = c / math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        x = -(r0 * d[0] + r1 * d[1] + r2 * d[2])
        e0 = r0 + x * d[0]
        e1 = r1 + x * d[1]
        e2 = r2 + x * d[2]
        miss = math.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
        # From the miss, not from the start: that far away the products cancel to noise.
        ds = (e0 * (b1 * d[2] - b2 * d[1]) + e1 * (b2 * d[0] - b0 * d[2])) / c
        ds += e2 * (b0 * d[1] - b1 * d[0]) / c
        dt = (e0 * (d[1] * a2 - d[2] * a1) + e1 * (d[2] * a0 - d[0] * a2)) / c
        dt += e2 * (d[0] * a1 - d[1] * a0) / c
        ds = min(max(s + ds, box[0]), box[1]) - s
        dt = min(max(t + dt, box[2]), box[3]) - t
        s += ds
        t += dt
        m0 = a0 * ds + b0 * dt
        m1 = a1 * ds + b1 * dt
        m2 = a2 * ds + b2 * dt
        x += m0 * d[0] + m1 * d[1] + m2 * d[2]
        if miss <= slack:
            return 1, s, t, x, slope
        if math.sqrt(m0 * m0 + m1 * m1 + m2 * m2) <= 0.0625 * slack:
            return 0, s, t, x, slope
    return -1, s, t, x, slope


@inner(error_model="numpy")
def _shrunk(h, k, cell, path, span):
    """The part of a cell in which the path itself, not the line, can cross it.

    To first order (s, t) of a point of the path follow from the dual vectors of the tangent plane,
    whatever the angle: what is shorter than the cell leaves little of it. Empty: low ≥ high.
    """
    p, d, slack, wide, _ = path
    hs = 0.5 * (cell[1] - cell[0])
    ht = 0.5 * (cell[3] - cell[2])
    a = (h[0, 1], h[1, 1], h[2, 1])
    b = (h[0, 2], h[1, 2], h[2, 2])
    r = (p[0] - h[0, 0], p[1] - h[1, 0], p[2] - h[2, 0])
    aa = ab = bb = ra = rb = da = db = 0.0
    for c in range(3):
        aa += a[c] * a[c]
        ab += a[c] * b[c]
        bb += b[c] * b[c]
        ra += r[c] * a[c]
        rb += r[c] * b[c]
        da += d[c] * a[c]
        db += d[c] * b[c]
    det = aa * bb - ab * ab
    if not det > 1e-12 * aa * bb:
        return cell
    off = 0.5 * (k[2] * hs * hs + k[4] * ht * ht) + k[3] * hs * ht + 2.0 * slack + wide
    s = (bb * ra - ab * rb) / det
    t = (aa * rb - ab * ra) / det
    ds = (bb * da - ab * db) / det
    dt = (aa * db - ab * da) / det
    pad_s = off * math.sqrt(bb / det) + 4.0 * TINY
    pad_t = off * math.sqrt(aa / det) + 4.0 * TINY
    sc = 0.5 * (cell[0] + cell[1])
    tc = 0.5 * (cell[2] + cell[3])
    return (
        max(cell[0], sc + s + min(span[0] * ds, span[1] * ds) - pad_s),
        min(cell[1], sc + s + max(span[0] * ds, span[1] * ds) + pad_s),
        max(cell[2], tc + t + min(span[0] * dt, span[1] * dt) - pad_t),
        min(cell[3], tc + t + max(span[0] * dt, span[1] * dt) + pad_t),
    )


@inner()
def _halve(stack, top, cell, across):
    """Put the halves of a cell on the stack, cut across s (True) or t."""
    s0, s1, t0, t1 = cell
    for c in range(2):
        stack[top + c] = (s0, s1, t0, t1)
    if across:
        stack[top, 1] = stack[top + 1, 0] = 0.5 * (s0 + s1)
    else:
        stack[top, 3] = stack[top + 1, 2] = 0.5 * (t0 + t1)


@inner()
def _wider_across(h, k, size, own):
    """Whether a cell is to be cut across s: where the surface is longer."""
    hs, ht = size
    if hs < TINY or ht < TINY:
        return ht < TINY
    if own:
        return k[0] * hs >= k[1] * ht
    extent_s = h[0, 1] ** 2 + h[1, 1] ** 2 + h[2, 1] ** 2
    extent_t = h[0, 2] ** 2 + h[1, 2] ** 2 + h[2, 2] ** 2
    return extent_s * hs * hs >= extent_t * ht * ht


@inner(error_model="numpy")
def _held(cell, size, path, room, h):
    """The rectangle in which the crossing of a cell is looked for: the cell and its tolerance.

    A displacement of the line by `slack`, and beyond the sides of the element by their `room`, is
    turned into one of (s, t) by the derivatives `h` in the cell's middle.
    """
    d, slack = path[1], path[2]
    a0 = h[0, 1]
    a1 = h[1, 1]
    a2 = h[2, 1]
    b0 = h[0, 2]
    b1 = h[1, 2]
    b2 = h[2, 2]
    q0 = b1 * d[2] - b2 * d[1]
    q1 = b2 * d[0] - b0 * d[2]
    q2 = b0 * d[1] - b1 * d[0]
    o0 = d[1] * a2 - d[2] * a1
    o1 = d[2] * a0 - d[0] * a2
    o2 = d[0] * a1 - d[1] * a0
    c = abs(a0 * q0 + a1 * q1 + a2 * q2)
    per_s = math.sqrt(q0 * q0 + q1 * q1 + q2 * q2) / c
    per_t = math.sqrt(o0 * o0 + o1 * o1 + o2 * o2) / c
    s = min(2.0 * slack * per_s, size[0])
    t = min(2.0 * slack * per_t, size[1])
    return (
        cell[0] - s - (min(room[0] * per_s, 0.5) if cell[0] <= -0.5 else 0.0),
        cell[1] + s + (min(room[1] * per_s, 0.5) if cell[1] >= 0.5 else 0.0),
        cell[2] - t - (min(room[2] * per_t, 0.5) if cell[2] <= -0.5 else 0.0),
        cell[3] + t + (min(room[3] * per_t, 0.5) if cell[3] >= 0.5 else 0.0),
    )


@inner()
def _over(cell, path):
    """The path as one cell sees it: as wide as the widest room beyond sides that it touches."""
    p, d, slack, _, room = path
    wide = room[0] if cell[0] <= -0.5 else 0.0
    wide = max(wide, room[1] if cell[1] >= 0.5 else 0.0)
    wide = max(wide, room[2] if cell[2] <= -0.5 else 0.0)
    wide = max(wide, room[3] if cell[3] >= 0.5 else 0.0)
    return p, d, slack, wide, room


@inlined()
def next_crossing(elements, leaf, pole, path, ends, work, top):
    """Next crossing of one leaf, trimmed or not, among the `top` cells on the stack.

    `path` is (p, d, slack, wide, room) about the element's origin, `ends` (length, spare, far,
    sense): the length of the segment, how far beyond its ends a crossing at a small angle may lie,
    where it need not be looked for any more, and ENTRIES or EITHER. Returns x (infinite where
    there is none), s, t, the slope n·d, and how many cells are left. `work` is (stack, h, k,
    corner, count); count holds the cells opened and whether the path was given up.
    """
    stack, h, k, corner, count = work
    length, spare, far, sense = ends
    e = leaf["element"]
    p, d, slack, _, room = path
    whole = DEEP * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
    span = (-spare, min(far, length + spare))
    easy = count[0] + EASY
    found, s, t, slope = math.inf, 0.0, 0.0, 0.0
    while top > 0 and found == math.inf:
        top -= 1
        count[0] += 1
        cell = (stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3])
        place = (0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]))
        size = (0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2]))
        seen = _over(cell, path)
        own = count[0] > easy or (pole and 4.0 * size[0] * size[1] < whole)
        if own:
            cell_box(elements, e, cell, k, corner)
            if _beside_box(corner, p, d, span[0], span[1], slack + seen[3]):
                continue
        else:
            for c in range(9):
                k[c] = leaf["bound"][c]
        evaluate(elements, e, place[0], place[1], h)
        verdict, ds, dt = _judge(h, k, size, seen, span, sense == ENTRIES)
        if verdict == SOLVE:
            box = _held(cell, size, path, NONE, h)
            reach = _held(cell, size, path, room, h)
            start = (place[0] + ds, place[1] + dt)
            state, s, t, x, slope = _solve(elements, e, box, start, path, h)
            if state == 0 and reach != box:  # not in the cell, perhaps beside it
                state, s, t, x, slope = _solve(elements, e, reach, start, path, h)
                state = max(state, 0)
            if state > 0:
                # Beside a wide edge the caller finds where along the path the crossing is.
                over = spare if path[3] > 0.0 else min(slack / abs(slope), spare)
                if -over <= x <= length + over and x < far and (sense or slope < 0.0):
                    found = x
            if state < 0:
                verdict = HALVE if max(size[0], size[1]) > TINY else POINT
                evaluate(elements, e, place[0], place[1], h)
        if verdict == POINT:
            x, ds, dt, slope = touch(elements, e, cell, path, length, h)
            s, t = place[0] + ds, place[1] + dt
            if slope != 0.0 and x < far and (sense or slope < 0.0):
                found = x
        if verdict == HALVE:
            if count[0] > MAX_CELLS or top > DEPTH - 3:
                count[1] = 1
                continue
            part = _shrunk(h, k, cell, seen, span)
            if part[0] >= part[1] or part[2] >= part[3]:
                continue
            left = (part[1] - part[0]) * (part[3] - part[2])
            if left < 2.0 * size[0] * size[1]:
                stack[top] = part
                top += 1
                continue
            _halve(stack, top, cell, _wider_across(h, k, size, own))
            top += 2
    return found, s, t, slope, top
