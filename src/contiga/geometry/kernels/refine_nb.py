"""Vertices put into the triangles of a face until none misses the surface by too much.

A front goes in from the border: a triangle that is too large, beside one that is not, gets the
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
    FRAME,
    INSIDE,
    ON_VERTEX,
    OUTSIDE,
    TRIANGLES,
    VERTICES,
    cross_sum,
    flip,
    opposite,
    snapped,
    split_side,
    split_triangle,
    turn,
    walk,
)
from contiga.jit import inner, kernel
from contiga.pointer_records import pass_by_pointer

NEW, GOOD, CHECKED, GIVEN_UP = 0, 1, 2, 3
"""States of a triangle."""
ALLOWED = 0.985
"""Share of the wanted distance that is used, so that places between the sampled ones keep it."""
RADIUS = 0.95
"""Wanted circle around a triangle, in the metric."""
CLOSEST = 0.7
"""A new vertex keeps this distance from others, in the metric."""
SMALLEST = 1e-26
"""Triangles with less than this area in the unit square are not cut any further."""
USELESS = 0.5
"""Nor does a vertex help that is nearer, as a share of the distance, to another or to the border.
A finite surface holds finitely many that are not, so refinement ends."""


@pass_by_pointer
class Front(NamedTuple):
    """The known state of the vertices, and the triangles to be looked at."""

    points: np.ndarray
    """(n, 3) places on the surface."""
    forms: np.ndarray
    """(n, 7), see `shape_nb`."""
    queue: np.ndarray
    """(m,) triangles, a ring."""
    queued: np.ndarray
    """(m,) bool."""
    ring: np.ndarray
    """(2,) start and length of the ring."""
    stack: np.ndarray
    """(m + 8,) triangles that a new vertex touched."""
    heads: np.ndarray
    """(2^k,) newest vertex whose cube in space has that hash, −1 for none."""
    older: np.ndarray
    """(n,) vertex before each with the same hash."""


@inner()
def push(front, triangle):
    """Put a triangle in the queue unless it is there."""
    if not front.queued[triangle]:
        front.queued[triangle] = True
        size = front.queue.size
        front.queue[(front.ring[0] + front.ring[1]) % size] = triangle
        front.ring[1] += 1


@inner()
def pop(front):
    """The triangle that waits longest."""
    triangle = front.queue[front.ring[0]]
    front.ring[0] = (front.ring[0] + 1) % front.queue.size
    front.ring[1] -= 1
    front.queued[triangle] = False
    return triangle


@inner()
def is_good(t, front, triangle):
    """Return whether a triangle needs no more vertices, as far as its corners tell."""
    if t.state[triangle] == NEW:
        corners, beside = t.corners[triangle], t.beside[triangle]
        if expected_miss(t.xy, corners, beside, front.forms) <= ALLOWED:
            t.state[triangle] = GOOD
    return t.state[triangle] != NEW


@inner()
def mean_metric(front, vertices, n):
    """Return (E, F, G) of the mean metric of the first n of four vertices."""
    e = f = g = 0.0
    for k in range(n):
        v = vertices[k]
        e += front.forms[v, E]
        f += front.forms[v, F]
        g += front.forms[v, G]
    return (e / n, f / n, g / n)


@inner()
def settle_in(t, front, top):
    """Turn sides around the newest vertex until Delaunay in the metric; queue all touched.

    Every turn gives that vertex one more side, which is not turned again: this ends in any metric.
    """
    stack = front.stack
    while top > 0:
        top -= 1
        here = stack[top]
        push(front, here)
        other = t.beside[here, 0]
        if other == BORDER:
            continue
        a, b, c = t.corners[here]
        d = t.corners[other, opposite(t, here, 0)]
        metric = mean_metric(front, (a, b, c, d), 4)
        if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, here, 0):
            stack[top], stack[top + 1] = here, other
            top += 2


@inner()
def bucket(front, i, j, k):
    """Hash of a cube of space."""
    return (i * 73856093 ^ j * 19349663 ^ k * 83492791) & (front.heads.size - 1)


@inner()
def enter(front, side, v):
    """Put a vertex where `is_near` finds it."""
    p = front.points[v]
    x = np.int64(math.floor(p[0] / side))
    y = np.int64(math.floor(p[1] / side))
    z = np.int64(math.floor(p[2] / side))
    at = bucket(front, x, y, z)
    front.older[v] = front.heads[at]
    front.heads[at] = v


@kernel()
def enter_all(t, front, side):
    """Put all vertices where `is_near` finds them, cubes having this side."""
    front.heads[:] = -1
    for v in range(FRAME, t.used[VERTICES]):
        enter(front, side, v)


@inner()
def is_near(front, side, p):
    """Return whether a vertex is nearer to p than `side`."""
    x = np.int64(math.floor(p[0] / side))
    y = np.int64(math.floor(p[1] / side))
    z = np.int64(math.floor(p[2] / side))
    for n in range(27):
        v = front.heads[bucket(front, x + n // 9 - 1, y + n // 3 % 3 - 1, z + n % 3 - 1)]
        while v >= 0:
            q = front.points[v]
            if (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 + (p[2] - q[2]) ** 2 < side * side:
                return True
            v = front.older[v]
    return False


@inner(error_model="numpy")
def foot_on_side(t, metric, a, b, v):
    """Return (x, y) of the place nearest to v, in the metric, on the side from a to b."""
    dx, dy = t.xy[b, 0] - t.xy[a, 0], t.xy[b, 1] - t.xy[a, 1]
    px, py = t.xy[v, 0] - t.xy[a, 0], t.xy[v, 1] - t.xy[a, 1]
    along = metric[0] * dx * px + metric[1] * (dx * py + dy * px) + metric[2] * dy * py
    share = along / square(metric[0], metric[1], metric[2], dx, dy)
    if not share > 0.0:
        share = 0.0
    share = min(share, 1.0)
    return t.xy[a, 0] + share * dx, t.xy[a, 1] + share * dy


@inner()
def is_useless(t, face, front, here, v):
    """Return whether v is so near to another vertex, or to the border, that it mends nothing."""
    limit = USELESS * face.sag
    p = front.points[v]
    if is_near(front, limit, p):
        return True
    c = t.corners[here]
    for k in range(3):
        if t.beside[here, k] == BORDER:
            metric = mean_metric(front, (c[0], c[1], c[2], -1), 3)
            x, y = foot_on_side(t, metric, c[(k + 1) % 3], c[(k + 2) % 3], v)
            # The border's side may be far off the surface; what lies over it is not.
            evaluate(face, x, y, 0)
            foot = face.D[0, 0]
            if triangle_distance(p, foot, foot, foot) < limit:
                return True
    return False


@kernel()
def put_vertex(t, face, front, start, x, y, apart):
    """A vertex at (x, y) if it is inside and none is nearer than `apart`; True if put.

    `apart` is in the metric; below zero a vertex is put whether it helps or not.
    """
    if not (0.0 <= x <= 1.0 and 0.0 <= y <= 1.0):
        return False
    v = t.used[VERTICES]
    t.xy[v, 0], t.xy[v, 1] = snapped(x), snapped(y)
    here, where = walk(t, start, v)
    if where in (OUTSIDE, ON_VERTEX):
        return False
    if where != INSIDE and t.beside[here, where] == BORDER:
        return False
    if apart > 0.0:
        c = t.corners[here]
        e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
        for k in range(3):
            dx = t.xy[t.corners[here, k], 0] - t.xy[v, 0]
            dy = t.xy[t.corners[here, k], 1] - t.xy[v, 1]
            if e * dx * dx + 2.0 * f * dx * dy + g * dy * dy < apart * apart:
                return False
    shape_at(face, t.xy[v, 0], t.xy[v, 1], front.points[v], front.forms[v])
    if apart >= 0.0:
        if is_useless(t, face, front, here, v):
            return False
        enter(front, USELESS * face.sag, v)
    t.used[VERTICES] += 1
    if where == INSIDE:
        top = split_triangle(t, here, v, front.stack)
    else:
        top = split_side(t, here, where, v, front.stack)
    settle_in(t, front, top)
    return True


@inner(error_model="numpy")
def front_place(t, front, triangle, k):
    """Return where the third corner of a well-sized triangle on side k is."""
    c = t.corners[triangle]
    e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
    # In coordinates p = r11 x + r12 y, q = r22 y the metric is even.
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
    along = ((ax - mx) ** 2 + (ay - my) ** 2 - half * half) / (2.0 * height)
    if not along > 0.0:
        return False, 0.0, 0.0
    radius = min(max(RADIUS, half), (half * half + along * along) / (2.0 * along))
    far = radius + math.sqrt(max(radius * radius - half * half, 0.0))
    q = my + far * ny
    y = q / r22
    x = (mx + far * nx - r12 * y) / r11
    return True, x, y


@inner()
def longest_inner(t, front, triangle):
    """The longest side in the metric that is no border, −1 if all are."""
    c = t.corners[triangle]
    e, f, g = mean_metric(front, (c[0], c[1], c[2], -1), 3)
    best = -1
    most = 0.0
    for k in range(3):
        if t.beside[triangle, k] == BORDER:
            continue
        p, q = c[(k + 1) % 3], c[(k + 2) % 3]
        x, y = t.xy[q, 0] - t.xy[p, 0], t.xy[q, 1] - t.xy[p, 1]
        size = e * x * x + 2.0 * f * x * y + g * y * y
        if size > most:
            best, most = k, size
    return best


@inner()
def halve(t, face, front, triangle):
    """Cut a triangle at the middle of its longest inner side, or in itself; give up else."""
    c = t.corners[triangle]
    if turn(t.xy, c[0], c[1], c[2]) > SMALLEST:
        k = longest_inner(t, front, triangle)
        if k >= 0:
            p, q = c[(k + 1) % 3], c[(k + 2) % 3]
            x, y = 0.5 * (t.xy[p, 0] + t.xy[q, 0]), 0.5 * (t.xy[p, 1] + t.xy[q, 1])
            if put_vertex(t, face, front, triangle, x, y, 0.0):
                return
        x = (t.xy[c[0], 0] + t.xy[c[1], 0] + t.xy[c[2], 0]) / 3.0
        y = (t.xy[c[0], 1] + t.xy[c[1], 1] + t.xy[c[2], 1]) / 3.0
        if put_vertex(t, face, front, triangle, x, y, 0.0):
            return
    t.state[triangle] = GIVEN_UP


@inner()
def full(t, spare):
    """Return whether there is no more room for a vertex."""
    return t.used[VERTICES] + spare >= t.xy.shape[0]


@inner()
def advance(t, face, front):
    """Look at what is in the queue until it is empty; False if room ran out."""
    while front.ring[1] > 0:
        if full(t, 2):
            return False
        here = pop(front)
        if is_good(t, front, here):
            for k in range(3):
                other = t.beside[here, k]
                if other != BORDER and t.state[other] == NEW:
                    push(front, other)
            continue
        best = -1
        for k in range(3):
            other = t.beside[here, k]
            if other == BORDER or is_good(t, front, other):
                has_place, x, y = front_place(t, front, here, k)
                if has_place and put_vertex(t, face, front, here, x, y, CLOSEST):
                    best = 3
                    break
                best = k
        if best >= 0 and best < 3:
            halve(t, face, front, here)
    return True


@inner()
def queue_all(t, front):
    """Everything that was not looked at yet into the queue."""
    for here in range(t.used[TRIANGLES]):
        if t.state[here] == NEW:
            push(front, here)


@kernel()
def relax(t, front, rounds):
    """Turn sides until Delaunay in the metric, or `rounds` times over all."""
    for _ in range(rounds):
        turned = 0
        for here in range(t.used[TRIANGLES]):
            for k in range(3):
                other = t.beside[here, k]
                if other == BORDER or other < here:
                    continue
                a = t.corners[here, k]
                b, c = t.corners[here, (k + 1) % 3], t.corners[here, (k + 2) % 3]
                d = t.corners[other, opposite(t, here, k)]
                metric = mean_metric(front, (a, b, c, d), 4)
                if cross_sum(t.xy, a, b, c, d, metric) < 0.0 and flip(t, here, k):
                    turned += 1
        if turned == 0:
            return
