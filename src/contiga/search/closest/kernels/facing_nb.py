"""The closest feet that do not face away from a guard and have the point behind them.

That is how deep a point is that the nearest wall of a body must not push, as it is opposite to the
wall that holds it. At a kink the normal is the way to the foot. The search starts from the foot
that a walk from the last one comes to: it is that one, or nearer.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE, MAX_ITERATIONS, NOT_FINITE, OK
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.foot_nb import write_foot
from contiga.search.closest.kernels.global_among_nb import Among, is_guarded
from contiga.search.closest.kernels.global_nb import closest
from contiga.search.closest.kernels.walk_nb import walk
from contiga.search.hierarchy.kernels.curve_nb import polish, surface_foot
from contiga.search.hierarchy.kernels.face_nb import in_face

SAME = 1e-6
"""Share of the distance by which a walk that stays may change it."""


@inner(linked=False)
def _write_guarded(tables, k, point, distance, out, found, h):
    """Row k of `out`: the foot that a guarded search has `found` at a distance."""
    if found[0] < 0:
        polish(tables, found, point, h)
    foot = surface_foot(tables, found, h)
    status, e, s, t, feature = walk(tables.elements, foot, point, tables.scale[1], h)
    if status == OK and feature == FACE and in_face(tables.elements, tables.trims, e, s, t):
        write_foot(tables, k, (e, s, t), OK, FACE, point, out, h)
        if abs(abs(out.gap[k]) - distance) <= SAME * distance + tables.scale[1]:
            out.certified[k] = 1 if found[3] == 0.0 else 0
            return
    write_foot(tables, k, foot, OK, EDGE, point, out, h)
    out.certified[k] = 1 if found[3] == 0.0 else 0
    square = 0.0
    for c in range(3):
        square += (out.point[k, c] - point[c]) ** 2
    away = math.sqrt(square)
    if away > 4.0 * tables.scale[1]:
        out.gap[k] = -away
        for c in range(3):
            out.normal[k, c] = (out.point[k, c] - point[c]) / away


@inner(linked=False)
def _known(tables, point, among, start, found, h):
    """Distance of the foot that a walk from `start` (patch, u, v) comes to, and `found` that, if it
    is one that is looked for; else infinite."""
    if start[0] < 0:
        return math.inf
    elements = tables.elements
    foot = locate(tables.grid, start[0], start[1], start[2])
    status, e, s, t, _ = walk(elements, foot, point, tables.scale[1], h)
    place = (e, s, t)
    if status != OK or not in_face(elements, tables.trims, e, s, t):
        return math.inf
    if not is_guarded(elements, place, point, among, h):
        return math.inf
    found[0], found[1], found[2], found[3] = e, s, t, 0.0
    square = 0.0
    for c in range(3):
        square += (point[c] - elements.table[e]["origin"][c] - h[c, 0]) ** 2
    return math.sqrt(square)


@kernel()
def project_facing(tables, points, guards, limits, starts, out, start, stop):
    """Feet of the points start … stop that do not face away from their `guards` (n, 3).

    `limits` is (cosine of their normals and the guards at least, (n,) how near they may be),
    `starts` (patch, uv) where to look first, patch −1 for nowhere. Rows where there is no such foot
    are MAX_ITERATIONS.
    """
    least, floor = limits
    h = scratch(4, 6)
    found, first = scratch(4), scratch(4)
    patch, uv = starts
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        among = Among(-1, (guards[k, 0], guards[k, 1], guards[k, 2]), least, floor[k])
        known = _known(tables, point, among, (patch[k], uv[k, 0], uv[k, 1]), first, h)
        distance = closest(tables, point, among, known, found, h)
        if math.isfinite(distance):
            _write_guarded(tables, k, point, distance, out, found, h)
        elif math.isfinite(known):
            first[3] = found[3]
            _write_guarded(tables, k, point, known, out, first, h)
        else:
            blank_foot(out, k, MAX_ITERATIONS)
