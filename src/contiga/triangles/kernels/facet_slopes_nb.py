"""Derivatives of the depth and the normal at feet on triangles, with respect to their points.

Inside a triangle the normal stays, on an edge it turns about it, at a corner about that. Normals
that are interpolated from the corners turn as the foot moves, and the depth falls along the way to
the foot all the same.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE
from contiga.arrays.kernels.foot_slopes_nb import is_along, write_kink_slopes, write_slopes
from contiga.arrays.kernels.vector_nb import dot, minus
from contiga.jit import inner, kernel
from contiga.triangles.kernels.facet_nb import VERTICES, A, B, C, N

SAME = 1e-9
"""Relative difference of lengths that count as one."""
SMALL = 10.0
"""Lengths below which points are one: a shorter way has no direction."""


@inner()
def _three(shape, s, i):
    return shape[s, i], shape[s, i + 1], shape[s, i + 2]


@inner()
def _edge_of(shape, s, u, v):
    """The edge of triangle s that a foot with these coordinates is on, as a unit vector."""
    w = 1.0 - u - v
    one, other = A, B
    if u <= v and u <= w:
        one, other = C, A
    elif w <= v:
        one, other = B, C
    d = minus(_three(shape, s, other), _three(shape, s, one))
    size = 1.0 / math.sqrt(dot(d, d))
    return d[0] * size, d[1] * size, d[2] * size


@inner()
def _interpolated(facets, s, k, d, true, feet, out):
    """Row k of `out` for normals that are interpolated between corners.

    The foot moves by the part of dp along the unit vector d on an edge, across the normal `true` of
    the triangle inside it (d zero), and not at a corner (`true` zero as well).
    """
    shape, link, corner = facets.shape, facets.link, facets.corner
    on_edge = dot(d, d) > 0.0
    u, v = feet.uv[k, 0], feet.uv[k, 1]
    a, b, c = (link[s, VERTICES], link[s, VERTICES + 1], link[s, VERTICES + 2])
    square = 0.0
    for i in range(3):
        square += ((1.0 - u - v) * corner[a, i] + u * corner[b, i] + v * corner[c, i]) ** 2
    size = math.sqrt(square)
    inside = dot(true, true) > 0.0
    for j in range(3):
        du, dv = shape[s, 3 + j], shape[s, 6 + j]
        if on_edge:
            du = d[j] * (d[0] * shape[s, 3] + d[1] * shape[s, 4] + d[2] * shape[s, 5])
            dv = d[j] * (d[0] * shape[s, 6] + d[1] * shape[s, 7] + d[2] * shape[s, 8])
        elif not inside:
            du = dv = 0.0
        along = 0.0
        for i in range(3):
            turn = du * (corner[b, i] - corner[a, i]) + dv * (corner[c, i] - corner[a, i])
            out.normal[k, i, j] = turn / size if size > 0.0 else 0.0
            along += feet.normal[k, i] * out.normal[k, i, j]
        for i in range(3):
            out.normal[k, i, j] -= along * feet.normal[k, i]


@kernel(error_model="numpy")
def slopes(facets, slot, smooth, points, feet, out, start, stop):
    """Fill rows start … stop of `out`, `FootSlopes`; `feet` is a `Projection` of as many points
    (k, 3), whose triangles stand in the places `slot`."""
    shape, small = facets.shape, SMALL * facets.scale[1]
    none = (0.0, 0.0, 0.0)
    for k in range(start, stop):
        s = slot[feet.patch[k]]
        plane = _three(shape, s, N)
        d, inside = none, feet.feature[k] == FACE
        own = (feet.normal[k, 0], feet.normal[k, 1], feet.normal[k, 2])
        normal, is_turned = plane if smooth else own, smooth
        if not inside:
            at = (feet.point[k, 0], feet.point[k, 1], feet.point[k, 2])
            r = minus((points[k, 0], points[k, 1], points[k, 2]), at)
            if feet.feature[k] == EDGE:
                d = _edge_of(shape, s, feet.uv[k, 0], feet.uv[k, 1])
            size = math.sqrt(dot(r, r))
            # On a border the gap may be the height over the triangle's plane, whose normal stays.
            if size > small and abs(size - abs(feet.gap[k])) <= max(small, SAME * size):
                away = 1.0 / feet.gap[k]
                normal = (r[0] * away, r[1] * away, r[2] * away)
                # Off a shell of half a thickness the normal is the way there, whatever the kind.
                is_turned = smooth and not is_along(r, own, small)
                write_kink_slopes(k, d, d, normal, feet.gap[k], out)
            else:
                inside = True
        if inside:
            write_slopes(k, (-normal[0], -normal[1], -normal[2]), none, none, none, none, out)
        if is_turned:
            _interpolated(facets, s, k, d, plane if feet.feature[k] == FACE else none, feet, out)
