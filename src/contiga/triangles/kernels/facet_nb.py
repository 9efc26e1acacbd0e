"""One point and one triangle: the closest point, and normals and features there."""

from __future__ import annotations

import math

from numba.core.compiler import Compiler

from contiga.arrays.codes import AT_BORDER, EDGE, FACE, NO_TRIANGLE, OK, VERTEX
from contiga.jit import inner

NEIGHBOUR, VERTICES, TRIANGLE = 0, 3, 6
"""Columns of `link`."""
A, B, C, N = 0, 12, 15, 9
"""Columns of the corners and the normal in `shape`."""
INSIDE_TOL = 1e-12
"""Negative barycentric coordinates that count as inside: rounding of points over an edge."""


# These kernels are optimised by themselves, not only in their callers, where they would be too
# large to be inlined: a walk would take a fifth longer.
@inner(pipeline_class=Compiler)
def _on_edge(shape, s, a, b, x, y, z):
    """Return the squared distance to the edge between corners in columns a and b, and the place.

    The place of the closest point is a share of the edge from a on, 0 or 1 at its ends.
    """
    ex = shape[s, b] - shape[s, a]
    ey = shape[s, b + 1] - shape[s, a + 1]
    ez = shape[s, b + 2] - shape[s, a + 2]
    vx = x - shape[s, a]
    vy = y - shape[s, a + 1]
    vz = z - shape[s, a + 2]
    t = (vx * ex + vy * ey + vz * ez) / (ex * ex + ey * ey + ez * ez)
    if t >= 1.0:
        t = 1.0
        vx = x - shape[s, b]
        vy = y - shape[s, b + 1]
        vz = z - shape[s, b + 2]
    elif t <= 0.0:
        t = 0.0
    else:
        vx -= t * ex
        vy -= t * ey
        vz -= t * ez
    return vx * vx + vy * vy + vz * vz, t


@inner(pipeline_class=Compiler)
def closest_on(shape, s, x, y, z):
    """Return the closest point of triangle s: squared distance, place, and two numbers.

    Place 0: inside, with the barycentric coordinates u, v. 1, 2, 3: on edge 0, 1, 2, with the share
    of the edge from its first corner on, and zero. 4, 5, 6: corner 0, 1, 2, with zeros. For a point
    beside the triangle only the edges with a negative coordinate can contain the closest point.
    """
    vx = x - shape[s, 0]
    vy = y - shape[s, 1]
    vz = z - shape[s, 2]
    u = vx * shape[s, 3] + vy * shape[s, 4] + vz * shape[s, 5]
    v = vx * shape[s, 6] + vy * shape[s, 7] + vz * shape[s, 8]
    if u >= -INSIDE_TOL and v >= -INSIDE_TOL and u + v <= 1.0 + INSIDE_TOL:
        gap = vx * shape[s, 9] + vy * shape[s, 10] + vz * shape[s, 11]
        return gap * gap, 0, u, v
    best = math.inf
    edge = 0
    share = 0.0
    if v < 0.0:
        best, share = _on_edge(shape, s, A, B, x, y, z)
    if u + v > 1.0:
        square, t = _on_edge(shape, s, B, C, x, y, z)
        if square < best:
            best = square
            edge = 1
            share = t
    if u < 0.0:
        square, t = _on_edge(shape, s, C, A, x, y, z)
        if square < best:
            best = square
            edge = 2
            share = t
    if share == 0.0:
        return best, 4 + edge, 0.0, 0.0
    if share == 1.0:
        return best, 4 + (edge + 1) % 3, 0.0, 0.0
    return best, 1 + edge, share, 0.0


@inner(pipeline_class=Compiler)
def is_beyond(shape, s, x, y, z, limit):
    """Return whether triangle s is certainly farther than the squared distance `limit`.

    The test uses the height over its plane, and within the plane the distance to the lines of the
    sides at its first corner: a coordinate u < 0 is −u / |g1| away from its side. The third side is
    left out, because the coordinate across it cancels on slivers: False does not mean that the
    triangle is nearer. `closest_on` takes three times as long; with this test the search takes 0.8
    of the time.
    """
    vx = x - shape[s, 0]
    vy = y - shape[s, 1]
    vz = z - shape[s, 2]
    gap = vx * shape[s, 9] + vy * shape[s, 10] + vz * shape[s, 11]
    in_plane = limit - gap * gap
    if in_plane < 0.0:
        return True
    a, b, c = shape[s, 3], shape[s, 4], shape[s, 5]
    u = vx * a + vy * b + vz * c
    if u < 0.0 and u * u > in_plane * (a * a + b * b + c * c):
        return True
    a, b, c = shape[s, 6], shape[s, 7], shape[s, 8]
    v = vx * a + vy * b + vz * c
    return v < 0.0 and v * v > in_plane * (a * a + b * b + c * c)


@inner(pipeline_class=Compiler)
def barycentric(place, a, b):
    """Return (u, v) of a place of `closest_on`: foot = (1 − u − v) A + u B + v C."""
    if place == 0:
        u = min(max(a, 0.0), 1.0)
        return u, min(max(b, 0.0), 1.0 - u)
    if place == 1:
        return a, 0.0
    if place == 2:
        return 1.0 - a, a
    if place == 3:
        return 0.0, 1.0 - a
    if place == 5:
        return 1.0, 0.0
    if place == 6:
        return 0.0, 1.0
    return 0.0, 0.0


@inner(pipeline_class=Compiler)
def write_face(shape, k, s, u, v, point, out):
    """Write row k of the projection for a foot inside triangle s, without `patch`, `certified`."""
    x, y, z = point
    nx = shape[s, 9]
    ny = shape[s, 10]
    nz = shape[s, 11]
    gap = (x - shape[s, 0]) * nx + (y - shape[s, 1]) * ny + (z - shape[s, 2]) * nz
    u = min(max(u, 0.0), 1.0)
    out.uv[k, 0] = u
    out.uv[k, 1] = min(max(v, 0.0), 1.0 - u)
    out.point[k, 0] = x - gap * nx
    out.point[k, 1] = y - gap * ny
    out.point[k, 2] = z - gap * nz
    out.normal[k, 0] = nx
    out.normal[k, 1] = ny
    out.normal[k, 2] = nz
    out.gap[k] = gap
    out.feature[k] = FACE
    out.status[k] = OK


@inner(pipeline_class=Compiler)
def write_kink(facets, k, foot, point, tracked, out):
    """Write row k of the projection for a foot (slot, place, share) on an edge or a corner.

    All columns but `patch` and `certified` are written.
    The gap is the distance and the normal its direction, both signed by the pseudo-normal. Within
    rounding of the foot the normal is the pseudo-normal, and the gap the height along it. On a
    border the gap is the height over the triangle, and the normal that of the triangle, if the
    point is straight above or below it or the foot is tracked. The status is AT_BORDER on a border
    unless the point is straight above or below it, tracked or not; else it is OK.
    """
    shape = facets.shape
    link = facets.link
    tol = 4.0 * facets.scale[1]
    s, place, share = foot
    u, v = barycentric(place, share, 0.0)
    out.uv[k, 0] = u
    out.uv[k, 1] = v
    first = (place - 1) % 3
    i = A if first == 0 else B + 3 * (first - 1)
    j = B if first == 0 else (C if first == 1 else A)
    q = (shape[s, i], shape[s, i + 1], shape[s, i + 2])
    # From the corner, because the foot has larger rounding far from the origin.
    r = (point[0] - q[0], point[1] - q[1], point[2] - q[2])
    if place < 4:
        e = (shape[s, j] - q[0], shape[s, j + 1] - q[1], shape[s, j + 2] - q[2])
        q = (q[0] + share * e[0], q[1] + share * e[1], q[2] + share * e[2])
        r = (r[0] - share * e[0], r[1] - share * e[1], r[2] - share * e[2])
    square = r[0] ** 2 + r[1] ** 2 + r[2] ** 2
    out.point[k, 0], out.point[k, 1], out.point[k, 2] = q
    out.feature[k] = EDGE if place < 4 else VERTEX
    n = (shape[s, N], shape[s, N + 1], shape[s, N + 2])
    height = r[0] * n[0] + r[1] * n[1] + r[2] * n[2]
    if place < 4:
        at_border = link[s, place - 1] == NO_TRIANGLE
    else:
        at_border = facets.corner[link[s, VERTICES + place - 4], 3] != 0.0
    is_beside = at_border and square - height * height > tol * tol
    out.status[k] = AT_BORDER if is_beside else OK
    if at_border and (tracked or not is_beside):
        out.gap[k] = height
        out.normal[k, 0], out.normal[k, 1], out.normal[k, 2] = n
        return
    reference = _pseudo_normal(facets, s, place, q)
    length = math.sqrt(reference[0] ** 2 + reference[1] ** 2 + reference[2] ** 2)
    if length == 0.0:
        reference = n
        length = 1.0
    side = r[0] * reference[0] + r[1] * reference[1] + r[2] * reference[2]
    distance = math.sqrt(square)
    if distance <= tol:
        out.gap[k] = side / length
        for c in range(3):
            out.normal[k, c] = reference[c] / length
        return
    sign = 1.0 if side >= 0.0 else -1.0
    out.gap[k] = sign * distance
    for c in range(3):
        out.normal[k, c] = sign * r[c] / distance


@inner(pipeline_class=Compiler)
def _pseudo_normal(facets, s, place, foot):
    """Return the angle-weighted sum of the normals at an edge or a corner; scaled only at a corner.

    Its side is the side of a point (Baerentzen & Aanaes 2005, doi 10.1109/TVCG.2005.49). At an edge
    of more than two triangles the triangles that contain the foot count.
    """
    shape = facets.shape
    if place >= 4:
        v = facets.link[s, VERTICES + place - 4]
        return facets.corner[v, 0], facets.corner[v, 1], facets.corner[v, 2]
    neighbour = facets.link[s, place - 1]
    x = shape[s, N]
    y = shape[s, N + 1]
    z = shape[s, N + 2]
    if neighbour >= 0:
        x += shape[neighbour, N]
        y += shape[neighbour, N + 1]
        z += shape[neighbour, N + 2]
    elif neighbour < NO_TRIANGLE:
        tol_square = (4.0 * facets.scale[1]) ** 2
        number = -2 - neighbour
        for i in range(facets.around_first[number], facets.around_first[number + 1]):
            t = facets.around[i]
            if t != s and closest_on(shape, t, foot[0], foot[1], foot[2])[0] <= tol_square:
                x += shape[t, N]
                y += shape[t, N + 1]
                z += shape[t, N + 2]
    return x, y, z


@inner(pipeline_class=Compiler)
def smooth_normal(facets, s, k, out):
    """Write the normals at the corners of triangle s, interpolated at the foot, to row k of `out`.

    Only the normal is replaced. It has length one, and is the triangle's normal if the
    interpolation is zero.
    """
    u = out.uv[k, 0]
    v = out.uv[k, 1]
    square = 0.0
    for c in range(3):
        value = (
            (1.0 - u - v) * facets.corner[facets.link[s, VERTICES], c]
            + u * facets.corner[facets.link[s, VERTICES + 1], c]
            + v * facets.corner[facets.link[s, VERTICES + 2], c]
        )
        out.normal[k, c] = value
        square += value * value
    length = math.sqrt(square)
    for c in range(3):
        out.normal[k, c] = out.normal[k, c] / length if length > 0.0 else facets.shape[s, N + c]
