"""Closest points of a mesh: branch and bound over its hierarchy.

The bound starts from the triangle the point before came to, which is near when points come in an
order along space. Of triangles at the same distance the one of the lowest number counts, so the
answer depends neither on where the search started nor on the threads.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import MAX_ITERATIONS, NO_TRIANGLE, NOT_FINITE, OK
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.triangles.facet_records import Queue
from contiga.triangles.kernels.boxes_nb import NOBODY, WIDTH, box_distances, put
from contiga.triangles.kernels.facet_nb import (
    TRIANGLE,
    VERTICES,
    A,
    B,
    C,
    N,
    barycentric,
    closest_on,
    is_beyond,
    smooth_normal,
    write_face,
    write_kink,
)

SLACK = 1e-12
NEAR = 0.1
"""Triangles farther than the best by this share of the distance, and of the length below which
points are one, are still looked at: bounds and distances are rounded, and the answer must not
depend on which came first."""
BESIDE = 1e-9
"""Share of its distance by which a point may stand before a triangle beside it: rounding."""
FLAT = math.cos(math.radians(20.0))
"""Of the angle up to which triangles that meet stand for a smooth surface."""
DEPTH = 256


@inner()
def _limit(best, near):
    return best * (1.0 + SLACK) + near * (2.0 * math.sqrt(best) + near)


@inner()
def closest(facets, point, seed, queue):
    """Slot, place and its two numbers of the closest point; `seed` is a slot to start from."""
    shape, link, box, child = facets.shape, facets.link, facets.box, facets.child
    near = NEAR * facets.scale[1]
    nodes, bounds, lane = queue.nodes, queue.bounds, queue.lane
    x, y, z = point
    best, place, a, b = closest_on(shape, seed, x, y, z)
    slot = seed
    limit = _limit(best, near)
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] > limit:
            continue
        node = nodes[top]
        box_distances(box, node, x, y, z, lane)
        if child[node, 0] < 0:
            for l in range(WIDTH):
                if lane[l] > limit or child[node, l] == NOBODY:
                    continue
                s = -1 - child[node, l]
                if is_beyond(shape, s, x, y, z, limit):
                    continue
                square, p, u, v = closest_on(shape, s, x, y, z)
                if square < best or (square == best and link[s, TRIANGLE] < link[slot, TRIANGLE]):
                    best = square
                    place = p
                    a = u
                    b = v
                    slot = s
                    limit = _limit(best, near)
            continue
        base = top
        for l in range(WIDTH):
            if lane[l] <= limit and child[node, l] != NOBODY:
                top = put(nodes, bounds, base, top, child[node, l], lane[l])
    return slot, place, a, b


@kernel()
def project_global(facets, points, rows, smooth, out, start, stop):
    """Closest points of points[rows[start:stop]] into the same rows of `out`."""
    queue = Queue(stack_int64(DEPTH), scratch(DEPTH), scratch(WIDTH))
    shape = facets.shape
    link = facets.link
    patch = out.patch
    seed = 0
    for i in range(start, stop):
        k = rows[i]
        x = points[k, 0]
        y = points[k, 1]
        z = points[k, 2]
        if not math.isfinite(x + y + z):
            blank_foot(out, k, NOT_FINITE)
            continue
        point = (x, y, z)
        seed, place, a, b = closest(facets, point, seed, queue)
        patch[k] = link[seed, TRIANGLE]
        if place == 0:
            write_face(shape, k, seed, a, b, point, out)
        else:
            write_kink(facets, k, (seed, place, a), point, False, out)
        if smooth:
            smooth_normal(facets, seed, k, out)
        out.certified[k] = 1


@inner()
def _may_face(shape, s, point, guard, cosine):
    """Return whether triangle s does not face away from the guard and has the point behind it."""
    x, y, z = shape[s, N], shape[s, N + 1], shape[s, N + 2]
    if x * guard[0] + y * guard[1] + z * guard[2] < cosine:
        return False
    vx, vy, vz = point[0] - shape[s, 0], point[1] - shape[s, 1], point[2] - shape[s, 2]
    height = vx * x + vy * y + vz * z
    return height <= BESIDE * math.sqrt(vx * vx + vy * vy + vz * vz)


@inner()
def _closest_facing(facets, point, guard, cosine, within, queue):
    """Do as `closest` for the triangles that may face a point with its guard.

    They are `within` = (no nearer than, no farther than); the slot is −1 where there is none.
    """
    shape, link, box, child = facets.shape, facets.link, facets.box, facets.child
    near = NEAR * facets.scale[1]
    floor, ceiling = within[0] ** 2, within[1] ** 2
    nodes, bounds, lane = queue.nodes, queue.bounds, queue.lane
    x, y, z = point
    best = limit = ceiling
    slot = place = -1
    a = b = 0.0
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1
    while top > 0:
        top -= 1
        if bounds[top] > limit:
            continue
        node = nodes[top]
        box_distances(box, node, x, y, z, lane)
        is_leaf, base = child[node, 0] < 0, top
        for l in range(WIDTH):
            if lane[l] > limit or child[node, l] == NOBODY:
                continue
            if not is_leaf:
                top = put(nodes, bounds, base, top, child[node, l], lane[l])
                continue
            s = -1 - child[node, l]
            if not _may_face(shape, s, point, guard, cosine):
                continue
            square, p, u, v = closest_on(shape, s, x, y, z)
            if square < best or (square == best and link[s, TRIANGLE] < link[slot, TRIANGLE]):
                if square < floor:
                    continue
                if p > 0 and not _leads_on(shape, s, point, (p, u), guard, cosine, square):
                    continue
                if p > 0 and not _is_square(facets, s, point, (p, u), square):
                    continue
                best, place, a, b, slot = square, p, u, v, s
                limit = _limit(best, near)
    return slot, place, a, b


@inner()
def _leads_on(shape, s, point, foot, guard, cosine, square):
    """Return whether the way to a foot (place, share) on a kink does not oppose its normal."""
    u, v = barycentric(foot[0], foot[1], 0.0)
    toward = 0.0
    for c in range(3):
        on = shape[s, A + c]
        on += u * (shape[s, B + c] - shape[s, A + c]) + v * (shape[s, C + c] - shape[s, A + c])
        toward += (on - point[c]) * guard[c]
    return toward >= cosine * math.sqrt(square)


@inner()
def _is_square(facets, s, point, foot, square):
    """Return whether a foot (place, share) on a kink is one of the surface.

    The kink is sharp, or the triangle nearly square to the way there, as it is where triangles
    stand for a smooth surface. Beyond a border there is none.
    """
    shape, link = facets.shape, facets.link
    n = (shape[s, N], shape[s, N + 1], shape[s, N + 2])
    vx, vy, vz = point[0] - shape[s, 0], point[1] - shape[s, 1], point[2] - shape[s, 2]
    height = vx * n[0] + vy * n[1] + vz * n[2]
    if foot[0] < 4:
        at_border = link[s, foot[0] - 1] == NO_TRIANGLE
    else:
        at_border = facets.corner[link[s, VERTICES + foot[0] - 4], 3] != 0.0
    least = (1.0 - SLACK) * square
    if at_border:
        small = 4.0 * facets.scale[1]
        return square - height * height <= small * small
    # The sides of s that the foot is on: the distance must not fall into the triangles across.
    first, second = foot[0] - 1, foot[0] - 1
    if foot[0] >= 4:
        first, second = foot[0] - 4, (foot[0] - 2) % 3
    for side in (first, second):
        t = link[s, side]
        if t >= 0 and closest_on(shape, t, point[0], point[1], point[2])[0] < least:
            return False
    if height * height >= FLAT * FLAT * square:
        return True
    if foot[0] < 4:
        t = link[s, first]
        if t < 0:  # more triangles meet there
            return True
        m = (shape[t, N], shape[t, N + 1], shape[t, N + 2])
    else:
        v = link[s, VERTICES + foot[0] - 4]
        m = (facets.corner[v, 0], facets.corner[v, 1], facets.corner[v, 2])
    return n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < FLAT


@inner()
def _lead_there(k, point, small, out):
    """The normal of row k leads from the point, which is behind, to its foot on a kink."""
    square = 0.0
    for c in range(3):
        square += (out.point[k, c] - point[c]) ** 2
    away = math.sqrt(square)
    out.status[k] = OK
    if away > small:
        out.gap[k] = -away
        for c in range(3):
            out.normal[k, c] = (out.point[k, c] - point[c]) / away


@kernel()
def project_facing(facets, points, guards, limits, smooth, out, start, stop):
    """Closest feet of the points start … stop on triangles that do not face away.

    `limits` are `FacingLimits` with the `guards` (n, 3), and the point is behind them. Rows without
    any are MAX_ITERATIONS.
    """
    queue = Queue(stack_int64(DEPTH), scratch(DEPTH), scratch(WIDTH))
    shape, link = facets.shape, facets.link
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        guard = (guards[k, 0], guards[k, 1], guards[k, 2])
        within = max(limits.near[k], 0.0), limits.far[k]
        s, place, a, b = _closest_facing(facets, point, guard, limits.cosine, within, queue)
        if s < 0:
            blank_foot(out, k, MAX_ITERATIONS)
            continue
        out.patch[k] = link[s, TRIANGLE]
        if place == 0:
            write_face(shape, k, s, a, b, point, out)
        else:
            write_kink(facets, k, (s, place, a), point, False, out)
            _lead_there(k, point, 4.0 * facets.scale[1], out)
        if smooth:
            smooth_normal(facets, s, k, out)
        out.certified[k] = 1


@kernel()
def box_distance(facets, points, rows, reach, start, stop):
    """Distance of points[rows] to the nearest box of a triangle into reach[rows]."""
    nodes = stack_int64(DEPTH)
    bounds = scratch(DEPTH)
    lane = scratch(WIDTH)
    child = facets.child
    for i in range(start, stop):
        k = rows[i]
        x = points[k, 0]
        y = points[k, 1]
        z = points[k, 2]
        if not math.isfinite(x + y + z):
            reach[k] = math.inf
            continue
        best = math.inf
        nodes[0] = 0
        bounds[0] = 0.0
        top = 1
        while top > 0:
            top -= 1
            if bounds[top] >= best:
                continue
            node = nodes[top]
            box_distances(facets.box, node, x, y, z, lane)
            leaf = child[node, 0] < 0
            base = top
            for l in range(WIDTH):
                d = lane[l]
                if d >= best or child[node, l] == NOBODY:
                    continue
                if leaf:
                    best = d
                    continue
                top = put(nodes, bounds, base, top, child[node, l], d)
        reach[k] = math.sqrt(best)
