"""Closest points of a mesh: branch and bound over its hierarchy.

The bound starts from the triangle of the previous point, which is near if points are sorted in
space. Of triangles at the same distance the one with the lowest number counts, so the result
depends neither on the start of the search nor on the threads.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import MAX_ITERATIONS, NO_TRIANGLE, NOT_FINITE, OK
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.triangles.facet_records import Queue
from contiga.triangles.kernels.boxes_nb import NO_CHILD, WIDTH, box_distances, insert_sorted
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

RELATIVE_SLACK = 1e-12
LENGTH_SLACK = 0.1
"""Triangles that are farther than the best by this share of the distance, plus this share of the
length below which points are one, are still examined: bounds and distances are rounded, and the
result must not depend on the order."""
HEIGHT_TOL = 1e-9
"""Largest height of a point behind a triangle over its plane, as a share of its distance:
rounding."""
SMOOTH_COSINE = math.cos(math.radians(20.0))
"""Cosine of the largest angle between adjoining triangles that represent a smooth surface."""
MAX_PENDING = 256
"""Largest number of pending nodes."""


@inner()
def _limit(best, slack):
    """Return the squared distance up to which triangles are examined, from the best one so far."""
    return best * (1.0 + RELATIVE_SLACK) + slack * (2.0 * math.sqrt(best) + slack)


@inner()
def closest(facets, point, seed, queue):
    """Return slot, place and its two numbers (see `closest_on`) of the closest point.

    `seed` is the slot from which the search starts, `queue` (`Queue`) is work.
    """
    shape, link, box, child = facets.shape, facets.link, facets.box, facets.child
    slack = LENGTH_SLACK * facets.scale[1]
    nodes, bounds, lane = queue.nodes, queue.bounds, queue.lane
    x, y, z = point
    best, place, a, b = closest_on(shape, seed, x, y, z)
    slot = seed
    limit = _limit(best, slack)
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
                if lane[l] > limit or child[node, l] == NO_CHILD:
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
                    limit = _limit(best, slack)
            continue
        base = top
        for l in range(WIDTH):
            if lane[l] <= limit and child[node, l] != NO_CHILD:
                top = insert_sorted(nodes, bounds, base, top, child[node, l], lane[l])
    return slot, place, a, b


@kernel()
def project_global(facets, points, rows, smooth, out, start, stop):
    """Write the closest points of points[rows[start:stop]] to the same rows of `out`, certified.

    Points that are not finite get blank rows with NOT_FINITE; for other statuses see `write_kink`.
    If `smooth`, normals are interpolated.
    """
    queue = Queue(stack_int64(MAX_PENDING), scratch(MAX_PENDING), scratch(WIDTH))
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
def _closest_facing(facets, point, guard, cosine, within, queue):
    """Return the same as `closest` for triangles that face a guard and have the point behind them.

    Their normals and the guard have at least the product `cosine`; their distances are within
    (min, max) = `within`, the maximum excluded. A foot on an edge or a corner must pass
    `_is_guarded_kink`. The slot is −1 if there is no such triangle.
    """
    shape, link, box, child = facets.shape, facets.link, facets.box, facets.child
    slack = LENGTH_SLACK * facets.scale[1]
    min_square, best = within[0] ** 2, within[1] ** 2
    nodes, bounds, lane = queue.nodes, queue.bounds, queue.lane
    x, y, z = point
    limit = best
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
            if lane[l] > limit or child[node, l] == NO_CHILD:
                continue
            if not is_leaf:
                top = insert_sorted(nodes, bounds, base, top, child[node, l], lane[l])
                continue
            s = -1 - child[node, l]
            nx, ny, nz = shape[s, N], shape[s, N + 1], shape[s, N + 2]
            if nx * guard[0] + ny * guard[1] + nz * guard[2] < cosine:
                continue
            vx, vy, vz = x - shape[s, 0], y - shape[s, 1], z - shape[s, 2]
            height = vx * nx + vy * ny + vz * nz
            if not height <= HEIGHT_TOL * math.sqrt(vx * vx + vy * vy + vz * vz):
                continue
            square, p, u, v = closest_on(shape, s, x, y, z)
            if not (square < best or (square == best and link[s, TRIANGLE] < link[slot, TRIANGLE])):
                continue
            if square < min_square:
                continue
            if p > 0 and not _is_guarded_kink(facets, s, point, (p, u), guard, cosine, square):
                continue
            best, place, a, b, slot = square, p, u, v, s
            limit = _limit(best, slack)
    return slot, place, a, b


@inner()
def _is_guarded_kink(facets, s, point, foot, guard, cosine, square):
    """Return whether a foot (place, share) on a kink of triangle s faces the guard as a minimum.

    The direction from the point to the foot and the guard have at least the product `cosine`, and
    the triangles across the sides of the foot are no closer. Then the kink must be sharp (more than
    20° to the next triangle, or to the vertex's normal), or the triangle nearly perpendicular to
    that direction (20°), as it is where triangles represent a smooth surface. On a border the point
    must be straight behind the triangle. `square` is the squared distance.
    """
    shape, link = facets.shape, facets.link
    u, v = barycentric(foot[0], foot[1], 0.0)
    advance = 0.0
    for c in range(3):
        foot_c = shape[s, A + c]
        foot_c += u * (shape[s, B + c] - foot_c) + v * (shape[s, C + c] - foot_c)
        advance += (foot_c - point[c]) * guard[c]
    if not advance >= cosine * math.sqrt(square):
        return False
    n = (shape[s, N], shape[s, N + 1], shape[s, N + 2])
    vx, vy, vz = point[0] - shape[s, 0], point[1] - shape[s, 1], point[2] - shape[s, 2]
    height = vx * n[0] + vy * n[1] + vz * n[2]
    if foot[0] < 4:
        at_border = link[s, foot[0] - 1] == NO_TRIANGLE
    else:
        at_border = facets.corner[link[s, VERTICES + foot[0] - 4], 3] != 0.0
    if at_border:
        tol = 4.0 * facets.scale[1]
        return square - height * height <= tol * tol
    # The distance must not fall into the triangles across the sides of s that the foot is on.
    first, second = foot[0] - 1, foot[0] - 1
    if foot[0] >= 4:
        first, second = foot[0] - 4, (foot[0] - 2) % 3
    min_square = (1.0 - RELATIVE_SLACK) * square
    for side in (first, second):
        t = link[s, side]
        if t >= 0 and closest_on(shape, t, point[0], point[1], point[2])[0] < min_square:
            return False
    if height * height >= SMOOTH_COSINE * SMOOTH_COSINE * square:
        return True
    if foot[0] < 4:
        t = link[s, first]
        if t < 0:  # more triangles meet there
            return True
        m = (shape[t, N], shape[t, N + 1], shape[t, N + 2])
    else:
        vertex = link[s, VERTICES + foot[0] - 4]
        m = (facets.corner[vertex, 0], facets.corner[vertex, 1], facets.corner[vertex, 2])
    return n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < SMOOTH_COSINE


@kernel()
def project_facing(facets, points, guards, limits, smooth, out, start, stop):
    """Write the closest feet of points[start:stop] that face their `guards` (n, 3) to `out`.

    `limits` are `FacingLimits`; the points are behind the triangles. Feet are certified, with the
    status OK. On an edge or a corner the gap is minus the distance, and the normal leads from the
    point to the foot, unless they almost touch (`write_kink`). If `smooth`, normals are
    interpolated. Rows without such a foot are blank with MAX_ITERATIONS, those of points that are
    not finite with NOT_FINITE.
    """
    queue = Queue(stack_int64(MAX_PENDING), scratch(MAX_PENDING), scratch(WIDTH))
    shape, link = facets.shape, facets.link
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        guard = (guards[k, 0], guards[k, 1], guards[k, 2])
        within = max(limits.min_distance[k], 0.0), limits.max_distance[k]
        s, place, a, b = _closest_facing(facets, point, guard, limits.cosine, within, queue)
        if s < 0:
            blank_foot(out, k, MAX_ITERATIONS)
            continue
        out.patch[k] = link[s, TRIANGLE]
        if place == 0:
            write_face(shape, k, s, a, b, point, out)
        else:
            write_kink(facets, k, (s, place, a), point, False, out)
            # The normal points from the point, which is behind, to its foot.
            square = 0.0
            for c in range(3):
                square += (out.point[k, c] - point[c]) ** 2
            distance = math.sqrt(square)
            out.status[k] = OK
            if distance > 4.0 * facets.scale[1]:
                out.gap[k] = -distance
                for c in range(3):
                    out.normal[k, c] = (out.point[k, c] - point[c]) / distance
        if smooth:
            smooth_normal(facets, s, k, out)
        out.certified[k] = 1


@kernel()
def box_distance(facets, points, rows, reach, start, stop):
    """Write the distance of points[k] from the nearest box of a triangle to reach[k].

    The rows k are rows[start:stop]. The distance is zero inside a box, infinite for points that are
    not finite.
    """
    nodes = stack_int64(MAX_PENDING)
    bounds = scratch(MAX_PENDING)
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
            is_leaf = child[node, 0] < 0
            base = top
            for l in range(WIDTH):
                square = lane[l]
                if square >= best or child[node, l] == NO_CHILD:
                    continue
                if is_leaf:
                    best = square
                    continue
                top = insert_sorted(nodes, bounds, base, top, child[node, l], square)
        reach[k] = math.sqrt(best)
