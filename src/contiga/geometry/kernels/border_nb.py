"""Triangles between polygons that may have holes: constrained Delaunay, then the outside dropped.

Vertices go in one by one (Lawson 1977), each from a neighbour of its own polygon; segments that are
missing are made by turning the sides that cross them (Sloan 1993). Segments that cross each other,
or run over a vertex, are told, not mended.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.geometry.kernels.triangulation_nb import (
    BORDER,
    FRAME,
    FREE,
    INSIDE,
    ON_VERTEX,
    TRIANGLES,
    VERTICES,
    corner_of,
    cross_sum,
    flip,
    opposite,
    split_side,
    split_triangle,
    turn,
    walk,
)
from contiga.jit import inner, kernel


@kernel()
def open_frame(t):
    """The square [−1, 2]² as two triangles."""
    for k, (x, y) in enumerate(((-1.0, -1.0), (2.0, -1.0), (2.0, 2.0), (-1.0, 2.0))):
        t.xy[k, 0], t.xy[k, 1] = x, y
    t.used[VERTICES], t.used[TRIANGLES] = FRAME, 2
    t.marks[:2] = FREE
    put(t.corners, 0, (0, 1, 2))
    put(t.corners, 1, (0, 2, 3))
    put(t.beside, 0, (BORDER, 1, BORDER))
    put(t.beside, 1, (BORDER, BORDER, 0))


@inner()
def settle(t, stack, top, metric):
    """Turn sides opposite the newest vertex, corner 0 of what is on the stack, until Delaunay."""
    while top > 0:
        top -= 1
        here = stack[top]
        other = t.beside[here, 0]
        if other == BORDER or t.marks[here, 0] != FREE:
            continue
        a, b, c = t.corners[here]
        d = t.corners[other, opposite(t, here, 0)]
        if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, here, 0):
            stack[top], stack[top + 1] = here, other
            top += 2


@kernel()
def insert_all(t, order, hint, metric, alias):
    """Insert the vertices `order`; `hint` is a vertex near each that is already there, or −1.

    `alias` gets, for each vertex, itself or the earlier vertex it coincides with.
    """
    stack = np.empty(t.corners.shape[0] + 8, np.int64)
    at = np.zeros(t.xy.shape[0], np.int64)
    form = (metric[0], metric[1], metric[2])
    for i in range(order.size):
        v = order[i]
        start = at[hint[i]] if hint[i] >= 0 else 0
        here, where = walk(t, start, v)
        if where == ON_VERTEX:
            for k in range(3):
                w = t.corners[here, k]
                if t.xy[w, 0] == t.xy[v, 0] and t.xy[w, 1] == t.xy[v, 1]:
                    alias[v] = w
            at[v] = here
            continue
        if where == INSIDE:
            top = split_triangle(t, here, v, stack)
        else:
            top = split_side(t, here, where, v, stack)
        at[v] = here
        settle(t, stack, top, form)
    return at


@inner()
def around(t, start, v, to):
    """Find the triangle with corner v whose opposite side the line from v to `to` crosses.

    Returns it and a code: the corner number of v, or −1 − k where side k already runs from v to
    `to`, or −9 where the way runs over another vertex.
    """
    here, _ = walk(t, start, v)
    first = here
    for _ in range(t.used[TRIANGLES] + 1):
        k = corner_of(t, here, v)
        b = t.corners[here, (k + 1) % 3]
        c = t.corners[here, (k + 2) % 3]
        if b == to:
            return here, -1 - (k + 2) % 3
        if c == to:
            return here, -1 - (k + 1) % 3
        right = turn(t.xy, v, b, to)
        left = turn(t.xy, v, c, to)
        if right > 0.0 and left < 0.0:
            return here, k
        if (right == 0.0 and is_towards(t.xy, v, b, to)) or (
            left == 0.0 and is_towards(t.xy, v, c, to)
        ):
            return here, -9
        here = t.beside[here, (k + 1) % 3]
        if here == first:
            break
    return first, -9


@inner()
def is_towards(xy, v, b, to):
    """Return whether b, on the line from v to `to`, is on the side of `to`."""
    along = (xy[b, 0] - xy[v, 0]) * (xy[to, 0] - xy[v, 0])
    return along + (xy[b, 1] - xy[v, 1]) * (xy[to, 1] - xy[v, 1]) > 0.0


@inner()
def crossed_sides(t, here, k, v, to, ends):
    """Ends of the sides that the way from v to `to` crosses; their number, or −1 − segment.

    −1 − segment where one of them is a segment, `FREE` (−1) as a segment where a vertex is met.
    """
    n = 0
    while True:
        b = t.corners[here, (k + 1) % 3]
        c = t.corners[here, (k + 2) % 3]
        if t.marks[here, k] != FREE:
            return -2 - t.marks[here, k]
        if n == ends.shape[0]:
            return -1
        ends[n, 0], ends[n, 1] = b, c
        n += 1
        j = opposite(t, here, k)
        here = t.beside[here, k]
        d = t.corners[here, j]
        if d == to:
            return n
        side = turn(t.xy, v, to, d)
        if side == 0.0:
            return -1
        # On from the side that parts the ends: d is left of the way, or right of it.
        k = (j + 1) % 3 if side > 0.0 else (j + 2) % 3


@inner()
def side_between(t, start, b, c):
    """Triangle and side from b to c, (−1, −1) if there is none."""
    here, _ = walk(t, start, b)
    first = here
    for _ in range(t.used[TRIANGLES] + 1):
        k = corner_of(t, here, b)
        if k < 0:
            return -1, -1
        if t.corners[here, (k + 1) % 3] == c:
            return here, (k + 2) % 3
        here = t.beside[here, (k + 1) % 3]
        if here in (first, BORDER):
            break
    return -1, -1


@inner()
def make_side(t, at, v, to, ends):
    """Turn sides until one runs from v to `to`: (triangle, side), or (−1, blocking segment).

    The blocking segment is −1 where it is a vertex that is in the way.
    """
    here, k = around(t, at[v], v, to)
    if k == -9:
        return -1, -1
    if k < 0:
        return here, -1 - k
    n = crossed_sides(t, here, k, v, to, ends)
    if n < 0:
        return -1, -2 - n
    head, count, rounds = 0, n, 0
    while count > 0:
        rounds += 1
        if rounds > 20 * n * n + 1000:
            return -1, -1
        b, c = ends[head, 0], ends[head, 1]
        head = (head + 1) % n
        count -= 1
        here, k = side_between(t, at[b], b, c)
        if here < 0:
            here, k = side_between(t, at[c], c, b)
        a = t.corners[here, k]
        d = t.corners[t.beside[here, k], opposite(t, here, k)]
        turned = flip(t, here, k)
        if turned:
            b, c = a, d
        if not turned or crosses(t.xy, v, to, a, d):
            tail = (head + count) % n
            ends[tail, 0], ends[tail, 1] = b, c
            count += 1
    here, k = around(t, at[v], v, to)
    if k < 0 and k != -9:
        return here, -1 - k
    return -1, -1


@inner()
def crosses(xy, v, to, a, d):
    """Return whether the side ad crosses the way from v to `to` inside both."""
    if a in (v, to) or d in (v, to):
        return False
    return turn(xy, v, to, a) * turn(xy, v, to, d) < 0.0


@kernel()
def make_segments(t, at, segments, alias, twice, bad):
    """Make every segment a side of triangles and mark it; `bad` gets those in each other's way.

    `twice` is turned for a segment each time that another runs along it.
    """
    ends = np.empty((4 * t.corners.shape[0] + 8, 2), np.int64)
    for s in range(segments.shape[0]):
        v, to = alias[segments[s, 0]], alias[segments[s, 1]]
        if v == to:
            bad[s] = True
            continue
        here, k = make_side(t, at, v, to, ends)
        if here < 0:
            bad[s] = True
            if k >= 0:
                bad[k] = True
            continue
        if t.marks[here, k] != FREE:
            twice[t.marks[here, k]] = not twice[t.marks[here, k]]
            continue
        t.marks[here, k] = s
        t.marks[t.beside[here, k], opposite(t, here, k)] = s


@kernel()
def flooded(t, twice, stack):
    """Return which triangles (m,) are inside.

    Each segment on the way in from the frame counts.
    """
    inside = np.full(t.used[TRIANGLES], -1, np.int8)
    for here in range(inside.size):
        # A triangle at the frame is outside.
        if min(t.corners[here, 0], t.corners[here, 1], t.corners[here, 2]) == 0:
            inside[here] = 0
            stack[0] = here
            break
    top = 1
    while top > 0:
        top -= 1
        here = stack[top]
        for k in range(3):
            other = t.beside[here, k]
            if other == BORDER or inside[other] >= 0:
                continue
            mark = t.marks[here, k]
            inside[other] = inside[here] if mark == FREE or twice[mark] else 1 - inside[here]
            stack[top] = other
            top += 1
    return inside


@kernel()
def carve(t, inside):
    """Remove the triangles that are not inside; sides that carry a segment become border."""
    new = np.full(inside.size, BORDER, np.int64)
    n = 0
    for here in range(inside.size):
        if inside[here] == 1:
            new[here] = n
            n += 1
    for here in range(inside.size):
        if inside[here] != 1:
            continue
        to = new[here]
        for k in range(3):
            other = t.beside[here, k]
            cut = other == BORDER or t.marks[here, k] != FREE
            t.corners[to, k] = t.corners[here, k]
            t.marks[to, k] = t.marks[here, k]
            t.beside[to, k] = BORDER if cut else new[other]
        t.state[to] = 0
    t.used[TRIANGLES] = n
