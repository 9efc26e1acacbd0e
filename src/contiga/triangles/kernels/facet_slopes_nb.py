"""Derivatives of the depth and the normal at feet on triangles, with respect to their points.

Inside a triangle the normal is constant, on an edge it rotates about the edge, at a corner about
the corner. Normals interpolated from the corners change as the foot moves, and the depth decreases
in the direction to the foot all the same.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE
from contiga.arrays.kernels.foot_slopes_nb import is_along, write_kink_slopes, write_slopes
from contiga.arrays.kernels.vector_nb import dot, minus
from contiga.jit import inner, kernel
from contiga.triangles.kernels.facet_nb import VERTICES, A, B, C, N

LENGTH_TOL = 1e-9
"""Relative difference of lengths that count as equal."""
MIN_LENGTH = 10.0
"""Least length of a vector that has a direction, in lengths below which two points are one."""


@inner()
def _vector(shape, s, i):
    """Return the vector in columns i, i + 1, i + 2 of row s."""
    return shape[s, i], shape[s, i + 1], shape[s, i + 2]


@inner()
def _edge_direction(shape, s, u, v):
    """Return the unit vector of the edge of triangle s with the smallest barycentric coordinate.

    A foot (u, v) on an edge has a zero there; the vector runs with the sense of the triangle.
    """
    w = 1.0 - u - v
    start, end = A, B
    if u <= v and u <= w:
        start, end = C, A
    elif w <= v:
        start, end = B, C
    d = minus(_vector(shape, s, end), _vector(shape, s, start))
    size = 1.0 / math.sqrt(dot(d, d))
    return d[0] * size, d[1] * size, d[2] * size


@inner()
def _write_interpolated(facets, s, k, d, true, feet, out):
    """Write the normal's slopes in row k of `out`, for normals interpolated between corners.

    The foot moves by the part of dp along the unit vector d on an edge, perpendicular to the
    triangle's normal `true` inside it (d zero), and not at a corner (`true` zero as well).
    """
    shape, link, corner = facets.shape, facets.link, facets.corner
    on_edge = dot(d, d) > 0.0
    u, v = feet.uv[k, 0], feet.uv[k, 1]
    a, b, c = (link[s, VERTICES], link[s, VERTICES + 1], link[s, VERTICES + 2])
    square = 0.0
    for i in range(3):
        square += ((1.0 - u - v) * corner[a, i] + u * corner[b, i] + v * corner[c, i]) ** 2
    size = math.sqrt(square)
    is_inside = dot(true, true) > 0.0
    for j in range(3):
        du, dv = shape[s, 3 + j], shape[s, 6 + j]
        if on_edge:
            du = d[j] * (d[0] * shape[s, 3] + d[1] * shape[s, 4] + d[2] * shape[s, 5])
            dv = d[j] * (d[0] * shape[s, 6] + d[1] * shape[s, 7] + d[2] * shape[s, 8])
        elif not is_inside:
            du = dv = 0.0
        normal_part = 0.0
        for i in range(3):
            turn = du * (corner[b, i] - corner[a, i]) + dv * (corner[c, i] - corner[a, i])
            out.normal[k, i, j] = turn / size if size > 0.0 else 0.0
            normal_part += feet.normal[k, i] * out.normal[k, i, j]
        for i in range(3):
            out.normal[k, i, j] -= normal_part * feet.normal[k, i]


@kernel(error_model="numpy")
def slopes(facets, slot, smooth, points, feet, out, start, stop):
    """Write rows start … stop − 1 of `out` (`FootSlopes`) at `feet`, a `Projection` of `points`.

    The normal is constant at a foot inside a triangle, at a foot on a border whose gap is a height,
    and at a foot on a kink within rounding of its point; it rotates about other kinks. With
    `smooth` the normal is interpolated. `slot` has the slot of each triangle.
    """
    shape, tol = facets.shape, MIN_LENGTH * facets.scale[1]
    zero = (0.0, 0.0, 0.0)
    for k in range(start, stop):
        s = slot[feet.patch[k]]
        plane = _vector(shape, s, N)
        d, is_inside = zero, feet.feature[k] == FACE
        foot_normal = (feet.normal[k, 0], feet.normal[k, 1], feet.normal[k, 2])
        normal, is_turned = plane if smooth else foot_normal, smooth
        if not is_inside:
            foot = (feet.point[k, 0], feet.point[k, 1], feet.point[k, 2])
            r = minus((points[k, 0], points[k, 1], points[k, 2]), foot)
            if feet.feature[k] == EDGE:
                d = _edge_direction(shape, s, feet.uv[k, 0], feet.uv[k, 1])
            size = math.sqrt(dot(r, r))
            # On a border the gap may be the height over the triangle's plane, with a constant
            # normal.
            if size > tol and abs(size - abs(feet.gap[k])) <= max(tol, LENGTH_TOL * size):
                inverse_gap = 1.0 / feet.gap[k]
                normal = (r[0] * inverse_gap, r[1] * inverse_gap, r[2] * inverse_gap)
                # At half a thickness from a shell the normal is the direction to the foot.
                is_turned = smooth and not is_along(r, foot_normal, tol)
                write_kink_slopes(k, d, d, normal, feet.gap[k], out)
            else:
                is_inside = True
        if is_inside:
            write_slopes(k, (-normal[0], -normal[1], -normal[2]), zero, zero, zero, zero, out)
        if is_turned:
            true = plane if feet.feature[k] == FACE else zero
            _write_interpolated(facets, s, k, d, true, feet, out)
