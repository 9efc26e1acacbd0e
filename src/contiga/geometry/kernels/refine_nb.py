"""Insert vertices in the triangles of a face until none misses the surface by too much.

A front advances from the border: a triangle that is too large, next to one that is not, gets the
vertex that makes a well-sized triangle on their common side (Rebay, Efficient unstructured mesh
generation by means of Delaunay triangulation and Bowyer-Watson algorithm, 1993), all measured in
the metric of `shape_nb`. Border sides are never touched.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.geometry.kernels.chord_nb import triangle_distance
from contiga.geometry.kernels.shape_nb import E, F, G, evaluate, expected_miss, shape_at, square
from contiga.geometry.kernels.triangulation_nb import (
    BORDER,
    INSIDE,
    N_FRAME,
    ON_VERTEX,
    OUTSIDE,
    TRIANGLES,
    VERTICES,
    cross_sum,
    flip,
    on_grid,
    opposite,
    orient,
    split_side,
    split_triangle,
    walk,
)
from contiga.jit import inner, kernel
from contiga.pointer_records import pass_by_pointer

NEW, GOOD, CHECKED, GIVEN_UP = 0, 1, 2, 3
"""States of a triangle."""
SAG_SHARE = 0.985
"""Share of the sag that is used, so that points between the samples keep it."""
CIRCUMRADIUS = 0.95
"""Wanted circumradius of a triangle, in the metric."""
MIN_SPACING = 0.7
"""Smallest distance of a new vertex from others, in the metric."""
MIN_AREA2 = 1e-26
"""Triangles with less than half of this area in the unit square are not split any further."""
MIN_DISTANCE_SHARE = 0.5
"""Smallest distance of a new vertex from others and from the border, as a share of the sag: nearer
ones do not help. A finite surface holds finitely many vertices so far apart: refinement ends."""


@pass_by_pointer
class Front(NamedTuple):
    """Points and forms of the vertices, and the queue of triangles to check."""

    points: np.ndarray
    """(n, 3) places on the surface."""
    forms: np.ndarray
    """(n, 7), see `shape_nb`."""
    queue: np.ndarray
    """(m,) triangles, a ring."""
    queued: np.ndarray
    """(m,) bool."""
    ring: np.ndarray
    """(2,) start and length of the queue."""
    stack: np.ndarray
    """(m + 8,) triangles changed by a new vertex."""
    heads: np.ndarray
    """(2^k,) newest vertex whose cube in space has that hash, −1 for none."""
    older: np.ndarray
    """(n,) vertex before each with the same hash."""


@inner()
def push(front, triangle):
    """Append a triangle to the queue unless it is there."""
    if not front.queued[triangle]:
        front.queued[triangle] = True
        size = front.queue.size
        front.queue[(front.ring[0] + front.ring[1]) % size] = triangle
        front.ring[1] += 1


@inner()
def pop(front):
    """Remove and return the triangle that waits longest in the queue."""
    triangle = front.queue[front.ring[0]]
    front.ring[0] = (front.ring[0] + 1) % front.queue.size
    front.ring[1] -= 1
    front.queued[triangle] = False
    return triangle


@inner()
def is_good(t, front, triangle):
    """Return whether a triangle needs no more vertices: its state is not NEW.

    A NEW one becomes GOOD if its expected miss, by the forms at its corners, is within the sag.
    """
    if t.state[triangle] == NEW:
        corners, neighbours = t.corners[triangle], t.neighbours[triangle]
        if expected_miss(t.xy, corners, neighbours, front.forms) <= SAG_SHARE:
            t.state[triangle] = GOOD
    return t.state[triangle] != NEW


@inner()
def mean_metric(front, vertices, n):
    """Return the mean metric (E, F, G) of the first n of `vertices`."""
    e = f = g = 0.0
    for k in range(n):
        v = vertices[k]
        e += front.forms[v, E]
        f += front.forms[v, F]
        g += front.forms[v, G]
    return (e / n, f / n, g / n)


@inner()
def legalize_in_metric(t, front, top):
    """Turn sides opposite the newest vertex until Delaunay in the metric; queue changed triangles.

    The vertex is corner 0 of the first `top` triangles on `front.stack`. Every turn adds a side at
    that vertex, which is not turned again: this ends in any metric.
    """
    stack = front.stack
    while top > 0:
        top -= 1
        triangle = stack[top]
        push(front, triangle)
        neighbour = t.neighbours[triangle, 0]
        if neighbour == BORDER:
            continue
        a, b, c = t.corners[triangle]
        d = t.corners[neighbour, opposite(t, triangle, 0)]
        metric = mean_metric(front, (a, b, c, d), 4)
        if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, triangle, 0):
            stack[top], stack[top + 1] = triangle, neighbour
            top += 2


@inner()
def hash_of_cube(front, i, j, k):
    """Return the row in `front.heads` of the cube (i, j, k) of space; cubes may share one."""
    return (i * 73856093 ^ j * 19349663 ^ k * 83492791) & (front.heads.size - 1)


@inner()
def add_to_hash(front, side, v):
    """Add a vertex to the hash table of `has_vertex_within`, which has cubes of this `side`."""
    p = front.points[v]
    x = np.int64(math.floor(p[0] / side))
    y = np.int64(math.floor(p[1] / side))
    z = np.int64(math.floor(p[2] / side))
    at = hash_of_cube(front, x, y, z)
    front.older[v] = front.heads[at]
    front.heads[at] = v


@kernel()
def hash_vertices(t, front, side):
    """Fill the hash table of `has_vertex_within` with all vertices, by cubes of this side."""
    front.heads[:] = -1
    for v in range(N_FRAME, t.used[VERTICES]):
        add_to_hash(front, side, v)


@inner()
def has_vertex_within(front, side, p):
    """Return whether a vertex in the hash table is nearer to p than `side`.

    The cubes of the table must have this side.
    """
    x = np.int64(math.floor(p[0] / side))
    y = np.int64(math.floor(p[1] / side))
    z = np.int64(math.floor(p[2] / side))
    for n in range(27):
        v = front.heads[hash_of_cube(front, x + n // 9 - 1, y + n // 3 % 3 - 1, z + n % 3 - 1)]
        while v >= 0:
            q = front.points[v]
            if (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2 < side * side:
                return True
            v = front.older[v]
    return False


@inner(error_model="numpy")
def foot_on_side(t, metric, a, b, v):
    """Return (x, y) of the point of side ab nearest to v, in the metric."""
    dx, dy = t.xy[b, 0] - t.xy[a, 0], t.xy[b, 1] - t.xy[a, 1]
    px, py = t.xy[v, 0] - t.xy[a, 0], t.xy[v, 1] - t.xy[a, 1]
    dot_product = metric[0] * dx * px + metric[1] * (dx * py + dy * px) + metric[2] * dy * py
    share = dot_product / square(metric[0], metric[1], metric[2], dx, dy)
    if not share > 0.0:
        share = 0.0
    share = min(share, 1.0)
    return t.xy[a, 0] + share * dx, t.xy[a, 1] + share * dy


@inner()
def is_redundant(t, face, front, triangle, v):
    """Return whether v is too near to another vertex, or to the border, to reduce the miss.

    Too near is below `MIN_DISTANCE_SHARE` of the sag in space, from vertices in the hash table or
    from the border sides of `triangle`.
    """
    limit = MIN_DISTANCE_SHARE * face.sag
    p = front.points[v]
    if has_vertex_within(front, limit, p):
        return True
    c = t.corners[triangle]
    for k in range(3):
        if t.neighbours[triangle, k] == BORDER:
            metric = mean_metric(front, (c[0], c[1], c[2], -1), 3)
            x, y = foot_on_side(t, metric, c[(k + 1) % 3], c[(k + 2) % 3], v)
            # The border side may be far off the surface: its image on the surface is compared.
            evaluate(face, x, y, 0)
            foot = face.D[0, 0]
            if triangle_distance(p, foot, foot, foot) < limit:
                return True
    return False


@kernel()
def insert_vertex(t, face, front, start, x, y, spacing):
    """Insert a vertex at (x, y) if it is inside and none is nearer than `spacing`; True if done.

    `spacing`, in the metric, is compared at the corners of the triangle there. A vertex on the
    border, on another one or redundant is refused; with a negative spacing a redundant one is not.
    Sides are then turned until Delaunay in the metric, and changed triangles queued.
    """
    if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
        return False
    v = t.used[VERTICES]
    t.xy[v, 0], t.xy[v, 1] = on_grid(x), on_grid(y)
    triangle, position = walk(t, start, v)
    if position in (OUTSIDE, ON_VERTEX):
        return False
    if position != INSIDE and t.neighbours[triangle, position] == BORDER:
        return False
    if spacing > 0.0:
        c = t.corners[triangle]
        e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
        for k in range(3):
            dx = t.xy[t.corners[triangle, k], 0] - t.xy[v, 0]
            dy = t.xy[t.corners[triangle, k], 1] - t.xy[v, 1]
            if e * dx * dx + 2.0 * f * dx * dy + g * dy * dy < spacing * spacing:
                return False
    shape_at(face, t.xy[v, 0], t.xy[v, 1], front.points[v], front.forms[v])
    if spacing >= 0.0:
        if is_redundant(t, face, front, triangle, v):
            return False
        add_to_hash(front, MIN_DISTANCE_SHARE * face.sag, v)
    t.used[VERTICES] += 1
    if position == INSIDE:
        top = split_triangle(t, triangle, v, front.stack)
    else:
        top = split_side(t, triangle, position, v, front.stack)
    legalize_in_metric(t, front, top)
    return True


@inner(error_model="numpy")
def front_vertex(t, front, triangle, k):
    """Return the third corner of a well-sized triangle on side k: whether it exists, x and y.

    It is on the side of the triangle's own third corner, and none if the circumcentre is beyond
    side k. The circumradius is `CIRCUMRADIUS`, or half the side if that is longer, with the limit
    of Rebay (1993).
    """
    c = t.corners[triangle]
    e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
    # In coordinates p = r11 x + r12 y, q = r22 y the metric is Euclidean.
    r11 = math.sqrt(e)
    r12 = f / r11
    r22 = math.sqrt(max(g - r12 * r12, 1e-30 * g))
    a, b, d = c[k], c[(k + 1) % 3], c[(k + 2) % 3]
    bx, by = r11 * t.xy[b, 0] + r12 * t.xy[b, 1], r22 * t.xy[b, 1]
    cx, cy = r11 * t.xy[d, 0] + r12 * t.xy[d, 1], r22 * t.xy[d, 1]
    ax, ay = r11 * t.xy[a, 0] + r12 * t.xy[a, 1], r22 * t.xy[a, 1]
    mx, my = 0.5 * (bx + cx), 0.5 * (by + cy)
    length = math.sqrt((cx - bx) ** 2 + (cy - by) ** 2)
    nx, ny = -(cy - by) / length, (cx - bx) / length
    half = 0.5 * length
    height = (ax - mx) * nx + (ay - my) * ny
    # Distances from the middle of the side: of the circumcentre, and of the new vertex.
    centre = ((ax - mx) ** 2 + (ay - my) ** 2 - half * half) / (2.0 * height)
    if not centre > 0.0:
        return False, 0.0, 0.0
    radius = min(max(CIRCUMRADIUS, half), (half * half + centre * centre) / (2.0 * centre))
    distance = radius + math.sqrt(max(radius * radius - half * half, 0.0))
    q = my + distance * ny
    y = q / r22
    x = (mx + distance * nx - r12 * y) / r11
    return True, x, y


@inner()
def longest_inner(t, front, triangle):
    """Return the number of the longest side in the metric that is not on the border, −1 if none."""
    c = t.corners[triangle]
    e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
    best = -1
    longest = 0.0
    for k in range(3):
        if t.neighbours[triangle, k] == BORDER:
            continue
        p, q = c[(k + 1) % 3], c[(k + 2) % 3]
        x, y = t.xy[q, 0] - t.xy[p, 0], t.xy[q, 1] - t.xy[p, 1]
        square_length = e * x * x + 2.0 * f * x * y + g * y * y
        if square_length > longest:
            best, longest = k, square_length
    return best


@inner()
def halve(t, face, front, triangle):
    """Split a triangle at the middle of its longest inner side, else at its centroid.

    If neither vertex can go in, or its area is below `MIN_AREA2`, its state becomes GIVEN_UP.
    """
    c = t.corners[triangle]
    if orient(t.xy, c[0], c[1], c[2]) > MIN_AREA2:
        k = longest_inner(t, front, triangle)
        if k >= 0:
            p, q = c[(k + 1) % 3], c[(k + 2) % 3]
            x, y = 0.5 * (t.xy[p, 0] + t.xy[q, 0]), 0.5 * (t.xy[p, 1] + t.xy[q, 1])
            if insert_vertex(t, face, front, triangle, x, y, 0.0):
                return
        x = (t.xy[c[0], 0] + t.xy[c[1], 0] + t.xy[c[2], 0]) / 3.0
        y = (t.xy[c[0], 1] + t.xy[c[1], 1] + t.xy[c[2], 1]) / 3.0
        if insert_vertex(t, face, front, triangle, x, y, 0.0):
            return
    t.state[triangle] = GIVEN_UP


@inner()
def is_full(t, spare):
    """Return whether the memory has no room for a vertex beyond `spare` others."""
    return t.used[VERTICES] + spare >= t.xy.shape[0]


@inner()
def advance(t, face, front):
    """Advance the front until the queue is empty; False if the memory is full.

    A good triangle queues its new neighbours. One that is not good, next to a good one or the
    border, gets a `front_vertex` there, or is halved; others wait for a good neighbour.
    """
    while front.ring[1] > 0:
        if is_full(t, 2):
            return False
        triangle = pop(front)
        if is_good(t, front, triangle):
            for k in range(3):
                neighbour = t.neighbours[triangle, k]
                if neighbour != BORDER and t.state[neighbour] == NEW:
                    push(front, neighbour)
            continue
        best = -1
        for k in range(3):
            neighbour = t.neighbours[triangle, k]
            if neighbour == BORDER or is_good(t, front, neighbour):
                has_place, x, y = front_vertex(t, front, triangle, k)
                if has_place and insert_vertex(t, face, front, triangle, x, y, MIN_SPACING):
                    best = 3
                    break
                best = k
        if best >= 0 and best < 3:
            halve(t, face, front, triangle)
    return True


@inner()
def queue_new(t, front):
    """Queue all triangles of the state NEW."""
    for triangle in range(t.used[TRIANGLES]):
        if t.state[triangle] == NEW:
            push(front, triangle)


@kernel()
def relax(t, front, rounds):
    """Turn sides until Delaunay in the metric, in at most so many `rounds` over all triangles."""
    for _ in range(rounds):
        turned = 0
        for triangle in range(t.used[TRIANGLES]):
            for k in range(3):
                neighbour = t.neighbours[triangle, k]
                if neighbour == BORDER or neighbour < triangle:
                    continue
                a = t.corners[triangle, k]
                b, c = t.corners[triangle, (k + 1) % 3], t.corners[triangle, (k + 2) % 3]
                d = t.corners[neighbour, opposite(t, triangle, k)]
                metric = mean_metric(front, (a, b, c, d), 4)
                if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, triangle, k):
                    turned += 1
        if turned == 0:
            return
