"""A triangulation in the plane that grows: exact orientation, insertion, flips, walks.

Coordinates are multiples of `GRID` within [−1, 2], so their differences are exact and the sign of
an orientation can be found exactly (the expansion of two products, Dekker 1971; Shewchuk 1997).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.jit import inner
from contiga.pointer_records import pass_by_pointer

GRID = 2.0**-49
BORDER = -1
FREE = -1
"""Mark of a side that no segment runs along."""
VERTICES, TRIANGLES = 0, 1
N_FRAME = 4
"""Number of vertices of the square around everything, which come first."""
INSIDE, ON_VERTEX, OUTSIDE = -1, -2, -3
"""Results of a walk, besides the side (0, 1, 2) that the vertex is on."""
SPLITTER = 134217729.0
"""2^27 + 1."""


@pass_by_pointer
class Triangulation(NamedTuple):
    """Memory for n vertices and m triangles, and how much of it is in use."""

    xy: np.ndarray
    """(n, 2)."""
    corners: np.ndarray
    """(m, 3) anticlockwise."""
    neighbours: np.ndarray
    """(m, 3) triangle across the side opposite each corner, `BORDER` for none."""
    marks: np.ndarray
    """(m, 3) segment along that side, `FREE` for none."""
    state: np.ndarray
    """(m,) int8, zero for a triangle that is new or was changed."""
    used: np.ndarray
    """(2,) vertices and triangles in use."""


@inner()
def two_product(a, b):
    """Return a · b as the rounded product and its exact error."""
    p = a * b
    c = SPLITTER * a
    ah = c - (c - a)
    al = a - ah
    c = SPLITTER * b
    bh = c - (c - b)
    bl = b - bh
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


@inner()
def cross(ax, ay, bx, by):
    """Return a × b; its sign is exact for multiples of `GRID` within [−9, 9]."""
    left = ax * by
    right = ay * bx
    if abs(left - right) > 1e-15 * (abs(left) + abs(right)):
        return left - right
    p, p_error = two_product(ax, by)
    q, q_error = two_product(ay, bx)
    return (p - q) + (p_error - q_error)


@inner()
def orient(xy, a, b, c):
    """Return twice the area of abc, positive if anticlockwise; its sign is exact: see `cross`."""
    return cross(xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1], xy[c, 0] - xy[a, 0], xy[c, 1] - xy[a, 1])


@inner()
def on_grid(x):
    """Return the nearest multiple of `GRID`."""
    return np.round(x / GRID) * GRID


@inner()
def corner_of(t, triangle, vertex):
    """Return which corner of `triangle` is `vertex`, −1 if none."""
    for k in range(3):
        if t.corners[triangle, k] == vertex:
            return k
    return -1


@inner()
def put(t, triangle, corners, neighbours, marks):
    """Write one triangle, with the state zero (new)."""
    for k in range(3):
        t.corners[triangle, k] = corners[k]
        t.neighbours[triangle, k] = neighbours[k]
        t.marks[triangle, k] = marks[k]
    t.state[triangle] = 0


@inner()
def relink(t, triangle, a, b, new):
    """Make `new` the neighbour of `triangle` across its side from a to b.

    Nothing changes if `triangle` is `BORDER`.
    """
    if triangle == BORDER:
        return
    for k in range(3):
        if t.corners[triangle, (k + 1) % 3] == a and t.corners[triangle, (k + 2) % 3] == b:
            t.neighbours[triangle, k] = new
            return


@inner()
def opposite(t, triangle, k):
    """Return the corner number, 0 to 2, of the neighbour across side k that is opposite to it."""
    neighbour = t.neighbours[triangle, k]
    b = t.corners[triangle, (k + 1) % 3]
    for j in range(3):
        if t.corners[neighbour, (j + 2) % 3] == b:
            return j
    return -1


@inner(linked=False)
def flip(t, triangle, k):
    """Turn side k, if the two triangles at it make a strictly convex quadrangle; True if done.

    Afterwards `triangle` is (a, b, d) and its former neighbour (a, d, c), where a was corner k.
    """
    neighbour = t.neighbours[triangle, k]
    j = opposite(t, triangle, k)
    a = t.corners[triangle, k]
    b = t.corners[triangle, (k + 1) % 3]
    c = t.corners[triangle, (k + 2) % 3]
    d = t.corners[neighbour, j]
    if orient(t.xy, a, b, d) <= 0.0 or orient(t.xy, a, d, c) <= 0.0:
        return False
    # Sides of the quadrangle: ab and ca of this triangle, bd and dc of the other.
    ab, ca = (k + 2) % 3, (k + 1) % 3
    bd, dc = (j + 1) % 3, (j + 2) % 3
    n_ab, m_ab = t.neighbours[triangle, ab], t.marks[triangle, ab]
    n_ca, m_ca = t.neighbours[triangle, ca], t.marks[triangle, ca]
    n_bd, m_bd = t.neighbours[neighbour, bd], t.marks[neighbour, bd]
    n_dc, m_dc = t.neighbours[neighbour, dc], t.marks[neighbour, dc]
    put(t, triangle, (a, b, d), (n_bd, neighbour, n_ab), (m_bd, FREE, m_ab))
    put(t, neighbour, (a, d, c), (n_dc, n_ca, triangle), (m_dc, m_ca, FREE))
    relink(t, n_bd, d, b, triangle)
    relink(t, n_ca, a, c, neighbour)
    return True


@inner(linked=False)
def position_in(t, triangle, v):
    """Return the position of v, not outside the triangle, in it: a side, INSIDE or ON_VERTEX."""
    side = INSIDE
    for k in range(3):
        if (
            orient(t.xy, t.corners[triangle, (k + 1) % 3], t.corners[triangle, (k + 2) % 3], v)
            == 0.0
        ):
            if side != INSIDE:
                return ON_VERTEX
            side = k
    return side


@inner()
def from_centre(xy, corners, v):
    """Return three times the vector from the centre of a triangle to v, exact on the `GRID`."""
    x = y = 0.0
    for a in corners:
        x += xy[v, 0] - xy[a, 0]
        y += xy[v, 1] - xy[a, 1]
    return x, y


@inner(linked=False)
def walk(t, start, v):
    """Return the triangle that v lies in, and its position: a side, INSIDE, ON_VERTEX or OUTSIDE.

    OUTSIDE comes with the triangle at whose border side the walk ended. The walk goes straight
    from the centre of `start`; vertices on its line count as left of it. Orientations are exact and
    every triangle has an area, so it meets no triangle twice.
    """
    a, b, c = t.corners[start]
    corners = (a, b, c)
    x, y = from_centre(t.xy, corners, v)
    triangle, k = start, -1
    for i in range(3):
        bx, by = from_centre(t.xy, corners, t.corners[start, (i + 1) % 3])
        cx, cy = from_centre(t.xy, corners, t.corners[start, (i + 2) % 3])
        if cross(x, y, bx, by) < 0.0 and cross(x, y, cx, cy) >= 0.0:
            k = i
    if k < 0:
        return triangle, INSIDE
    while orient(t.xy, t.corners[triangle, (k + 1) % 3], t.corners[triangle, (k + 2) % 3], v) < 0.0:
        if t.neighbours[triangle, k] == BORDER:
            return triangle, OUTSIDE
        j = opposite(t, triangle, k)
        triangle = t.neighbours[triangle, k]
        dx, dy = from_centre(t.xy, corners, t.corners[triangle, j])
        k = (j + 2) % 3 if cross(x, y, dx, dy) < 0.0 else (j + 1) % 3
    return triangle, position_in(t, triangle, v)


@inner()
def split_triangle(t, triangle, v, stack):
    """Insert v inside a triangle; write the parts, v their corner 0, to `stack`; return 3."""
    a, b, c = t.corners[triangle]
    na, nb, nc = t.neighbours[triangle]
    ma, mb, mc = t.marks[triangle]
    second = t.used[TRIANGLES]
    third = second + 1
    t.used[TRIANGLES] += 2
    put(t, triangle, (v, b, c), (na, second, third), (ma, FREE, FREE))
    put(t, second, (v, c, a), (nb, third, triangle), (mb, FREE, FREE))
    put(t, third, (v, a, b), (nc, triangle, second), (mc, FREE, FREE))
    relink(t, nb, a, c, second)
    relink(t, nc, b, a, third)
    stack[0], stack[1], stack[2] = triangle, second, third
    return 3


@inner(linked=False)
def split_side(t, triangle, k, v, stack):
    """Insert v on the inner side k; write the parts, v their corner 0, to `stack`; return 4."""
    neighbour = t.neighbours[triangle, k]
    j = opposite(t, triangle, k)
    a = t.corners[triangle, k]
    b = t.corners[triangle, (k + 1) % 3]
    c = t.corners[triangle, (k + 2) % 3]
    d = t.corners[neighbour, j]
    mark = t.marks[triangle, k]
    n_ab, m_ab = t.neighbours[triangle, (k + 2) % 3], t.marks[triangle, (k + 2) % 3]
    n_ca, m_ca = t.neighbours[triangle, (k + 1) % 3], t.marks[triangle, (k + 1) % 3]
    n_bd, m_bd = t.neighbours[neighbour, (j + 1) % 3], t.marks[neighbour, (j + 1) % 3]
    n_dc, m_dc = t.neighbours[neighbour, (j + 2) % 3], t.marks[neighbour, (j + 2) % 3]
    third = t.used[TRIANGLES]
    fourth = third + 1
    t.used[TRIANGLES] += 2
    put(t, triangle, (v, a, b), (n_ab, neighbour, third), (m_ab, mark, FREE))
    put(t, neighbour, (v, b, d), (n_bd, fourth, triangle), (m_bd, FREE, mark))
    put(t, third, (v, c, a), (n_ca, triangle, fourth), (m_ca, FREE, mark))
    put(t, fourth, (v, d, c), (n_dc, third, neighbour), (m_dc, mark, FREE))
    relink(t, n_ca, a, c, third)
    relink(t, n_dc, c, d, fourth)
    stack[0], stack[1], stack[2], stack[3] = triangle, neighbour, third, fourth
    return 4


@inner()
def cross_sum(xy, a, b, c, d, m):
    """Return a number below 0 if d lies in the circle through abc of the metric m = (E, F, G).

    It is zero within rounding. The sine of the sum of the angles at a and d over the side bc
    (cotangent form of Lawson's test), up to positive factors.
    """
    bax, bay = xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]
    cax, cay = xy[c, 0] - xy[a, 0], xy[c, 1] - xy[a, 1]
    cdx, cdy = xy[c, 0] - xy[d, 0], xy[c, 1] - xy[d, 1]
    bdx, bdy = xy[b, 0] - xy[d, 0], xy[b, 1] - xy[d, 1]
    dot_a = m[0] * bax * cax + m[1] * (bax * cay + bay * cax) + m[2] * bay * cay
    dot_d = m[0] * cdx * bdx + m[1] * (cdx * bdy + cdy * bdx) + m[2] * cdy * bdy
    sine_a = bax * cay - bay * cax
    sine_d = cdx * bdy - cdy * bdx
    total = dot_a * sine_d + sine_a * dot_d
    size = abs(dot_a * sine_d) + abs(sine_a * dot_d)
    return total if abs(total) > 1e-12 * size else 0.0
