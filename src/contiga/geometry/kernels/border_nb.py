"""Triangulate between polygons that may have holes: constrained Delaunay, the outside removed.

Vertices go in one by one (Lawson 1977), each from a neighbour of its own polygon; missing segments
are recovered by turning the sides that cross them (Sloan 1993). Segments that cross each other, or
run over a vertex, are flagged, not repaired.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.geometry.kernels.triangulation_nb import (
    BORDER,
    FREE,
    INSIDE,
    N_FRAME,
    ON_VERTEX,
    TRIANGLES,
    VERTICES,
    corner_of,
    cross_sum,
    flip,
    opposite,
    orient,
    split_side,
    split_triangle,
    walk,
)
from contiga.jit import inner, kernel


@kernel()
def open_frame(t):
    """Start a triangulation anew, as the square [−1, 2]² of two triangles."""
    for k, (x, y) in enumerate(((-1.0, -1.0), (2.0, -1.0), (2.0, 2.0), (-1.0, 2.0))):
        t.xy[k, 0], t.xy[k, 1] = x, y
    t.used[VERTICES], t.used[TRIANGLES] = N_FRAME, 2
    t.marks[:2] = FREE
    put(t.corners, 0, (0, 1, 2))
    put(t.corners, 1, (0, 2, 3))
    put(t.neighbours, 0, (BORDER, 1, BORDER))
    put(t.neighbours, 1, (BORDER, BORDER, 0))


@inner()
def legalize(t, stack, top, metric):
    """Turn sides opposite the newest vertex until Delaunay in the metric; segments are not turned.

    The vertex is corner 0 of the triangles on the `stack`, whose number is `top`.
    """
    while top > 0:
        top -= 1
        triangle = stack[top]
        neighbour = t.neighbours[triangle, 0]
        if neighbour == BORDER or t.marks[triangle, 0] != FREE:
            continue
        a, b, c = t.corners[triangle]
        d = t.corners[neighbour, opposite(t, triangle, 0)]
        if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, triangle, 0):
            stack[top], stack[top + 1] = triangle, neighbour
            top += 2


@kernel()
def insert_vertices(t, order, hint, metric, alias):
    """Insert the vertices `order`; `hint` is a vertex near each that is already there, or −1.

    A vertex at the place of an earlier one is not inserted: alias[v] becomes the earlier one.
    Returns, by number of vertex, a triangle near it from which later searches may start; 0 for
    vertices that are not in `order`.
    """
    stack = np.empty(t.corners.shape[0] + 8, np.int64)
    at = np.zeros(t.xy.shape[0], np.int64)
    form = (metric[0], metric[1], metric[2])
    for i in range(order.size):
        v = order[i]
        start = at[hint[i]] if hint[i] >= 0 else 0
        triangle, position = walk(t, start, v)
        if position == ON_VERTEX:
            for k in range(3):
                w = t.corners[triangle, k]
                if t.xy[w, 0] == t.xy[v, 0] and t.xy[w, 1] == t.xy[v, 1]:
                    alias[v] = w
            at[v] = triangle
            continue
        if position == INSIDE:
            top = split_triangle(t, triangle, v, stack)
        else:
            top = split_side(t, triangle, position, v, stack)
        at[v] = triangle
        legalize(t, stack, top, form)
    return at


@inner()
def find_crossed_side(t, start, v, target):
    """Return the triangle with corner v whose opposite side the line from v to `target` crosses.

    It comes with a code: the corner number of v, or −1 − k where side k already runs from v to
    `target`, or −9 if the line runs over another vertex or no such side is found.
    """
    triangle, _ = walk(t, start, v)
    first = triangle
    for _ in range(t.used[TRIANGLES] + 1):
        k = corner_of(t, triangle, v)
        b = t.corners[triangle, (k + 1) % 3]
        c = t.corners[triangle, (k + 2) % 3]
        if b == target:
            return triangle, -1 - (k + 2) % 3
        if c == target:
            return triangle, -1 - (k + 1) % 3
        right = orient(t.xy, v, b, target)
        left = orient(t.xy, v, c, target)
        if right > 0.0 and left < 0.0:
            return triangle, k
        if (right == 0.0 and is_ahead(t.xy, v, b, target)) or (
            left == 0.0 and is_ahead(t.xy, v, c, target)
        ):
            return triangle, -9
        triangle = t.neighbours[triangle, (k + 1) % 3]
        if triangle == first:
            break
    return first, -9


@inner()
def is_ahead(xy, v, b, target):
    """Return whether b, on the line from v to `target`, is on the side of `target`."""
    dot_product = (xy[b, 0] - xy[v, 0]) * (xy[target, 0] - xy[v, 0])
    return dot_product + (xy[b, 1] - xy[v, 1]) * (xy[target, 1] - xy[v, 1]) > 0.0


@inner()
def crossed_sides(t, triangle, k, v, target, ends):
    """Write the `ends` of the sides that the line from v to `target` crosses; return their number.

    The line leaves `triangle` by side k. The number is −2 − segment if one of the sides is a
    segment, −1 if the line meets a vertex or `ends` is full.
    """
    n = 0
    while True:
        b = t.corners[triangle, (k + 1) % 3]
        c = t.corners[triangle, (k + 2) % 3]
        if t.marks[triangle, k] != FREE:
            return -2 - t.marks[triangle, k]
        if n == ends.shape[0]:
            return -1
        ends[n, 0], ends[n, 1] = b, c
        n += 1
        j = opposite(t, triangle, k)
        triangle = t.neighbours[triangle, k]
        d = t.corners[triangle, j]
        if d == target:
            return n
        side = orient(t.xy, v, target, d)
        if side == 0.0:
            return -1
        # The line leaves by the side between its left and its right: d is left of it, or right.
        k = (j + 1) % 3 if side > 0.0 else (j + 2) % 3


@inner()
def find_side(t, start, b, c):
    """Return the triangle and its side that runs from b to c; (−1, −1) if there is none.

    The search goes round b, from a triangle `start`.
    """
    triangle, _ = walk(t, start, b)
    first = triangle
    for _ in range(t.used[TRIANGLES] + 1):
        k = corner_of(t, triangle, b)
        if k < 0:
            return -1, -1
        if t.corners[triangle, (k + 1) % 3] == c:
            return triangle, (k + 2) % 3
        triangle = t.neighbours[triangle, (k + 1) % 3]
        if triangle in (first, BORDER):
            break
    return -1, -1


@inner()
def recover_segment(t, at, v, target, ends):
    """Flip edges until one joins v to `target`; return (triangle, side) or (−1, blocking segment).

    The blocking segment is −1 if a vertex blocks, or too many turns are needed. `ends` is work
    memory.
    """
    triangle, k = find_crossed_side(t, at[v], v, target)
    if k == -9:
        return -1, -1
    if k < 0:
        return triangle, -1 - k
    n = crossed_sides(t, triangle, k, v, target, ends)
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
        triangle, k = find_side(t, at[b], b, c)
        if triangle < 0:
            triangle, k = find_side(t, at[c], c, b)
        a = t.corners[triangle, k]
        d = t.corners[t.neighbours[triangle, k], opposite(t, triangle, k)]
        turned = flip(t, triangle, k)
        if turned:
            b, c = a, d
        if not turned or crosses(t.xy, v, target, a, d):
            tail = (head + count) % n
            ends[tail, 0], ends[tail, 1] = b, c
            count += 1
    triangle, k = find_crossed_side(t, at[v], v, target)
    if k < 0 and k != -9:
        return triangle, -1 - k
    return -1, -1


@inner()
def crosses(xy, v, target, a, d):
    """Return whether the side ad crosses the line through v and `target`, neither being an end."""
    if a in (v, target) or d in (v, target):
        return False
    return orient(xy, v, target, a) * orient(xy, v, target, d) < 0.0


@kernel()
def recover_segments(t, at, segments, alias, is_double, is_bad):
    """Make every segment a side of triangles and mark it; set `is_bad` where that fails.

    A segment is bad if both ends are one, if a vertex or another segment blocks it, or if it blocks
    another. `is_double` is negated at a segment each time that another runs along it.
    """
    ends = np.empty((4 * t.corners.shape[0] + 8, 2), np.int64)
    for s in range(segments.shape[0]):
        v, target = alias[segments[s, 0]], alias[segments[s, 1]]
        if v == target:
            is_bad[s] = True
            continue
        triangle, k = recover_segment(t, at, v, target, ends)
        if triangle < 0:
            is_bad[s] = True
            if k >= 0:
                is_bad[k] = True
            continue
        if t.marks[triangle, k] != FREE:
            is_double[t.marks[triangle, k]] = not is_double[t.marks[triangle, k]]
            continue
        t.marks[triangle, k] = s
        t.marks[t.neighbours[triangle, k], opposite(t, triangle, k)] = s


@kernel()
def find_inside(t, is_double, stack):
    """Return (m,) 1 for triangles inside, behind an odd number of segments from the frame, else 0.

    Double segments do not count; `stack` is work memory.
    """
    inside = np.full(t.used[TRIANGLES], -1, np.int8)
    for triangle in range(inside.size):
        # A triangle at the frame is outside.
        if min(t.corners[triangle, 0], t.corners[triangle, 1], t.corners[triangle, 2]) == 0:
            inside[triangle] = 0
            stack[0] = triangle
            break
    top = 1
    while top > 0:
        top -= 1
        triangle = stack[top]
        for k in range(3):
            neighbour = t.neighbours[triangle, k]
            if neighbour == BORDER or inside[neighbour] >= 0:
                continue
            mark = t.marks[triangle, k]
            inside[neighbour] = (
                inside[triangle] if mark == FREE or is_double[mark] else 1 - inside[triangle]
            )
            stack[top] = neighbour
            top += 1
    return inside


@kernel()
def remove_outside(t, inside):
    """Remove the triangles that are not inside, and number the others anew, in order.

    Sides that carry a segment become border, on both sides.
    """
    new = np.full(inside.size, BORDER, np.int64)
    n = 0
    for triangle in range(inside.size):
        if inside[triangle] == 1:
            new[triangle] = n
            n += 1
    for triangle in range(inside.size):
        if inside[triangle] != 1:
            continue
        target = new[triangle]
        for k in range(3):
            neighbour = t.neighbours[triangle, k]
            cut = neighbour == BORDER or t.marks[triangle, k] != FREE
            t.corners[target, k] = t.corners[triangle, k]
            t.marks[target, k] = t.marks[triangle, k]
            t.neighbours[target, k] = BORDER if cut else new[neighbour]
        t.state[target] = 0
    t.used[TRIANGLES] = n
