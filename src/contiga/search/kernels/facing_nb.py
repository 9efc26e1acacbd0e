"""The closest feet that do not face away from a guard and have the point behind them.

That is how deep a point is that the nearest wall of a body must not push, as it is opposite to the
wall that holds it. At a kink the normal is the way to the foot.
"""

from __future__ import annotations

import math

from contiga.num.codes import EDGE, FACE, MAX_ITERATIONS, NOT_FINITE, OK
from contiga.num.jit import inner, kernel
from contiga.num.kernels.query_nb import blank_foot
from contiga.num.scratch import scratch
from contiga.search.kernels.curve_nb import polish, surface_foot
from contiga.search.kernels.face_nb import in_face
from contiga.search.kernels.foot_nb import write_foot
from contiga.search.kernels.global_nb import Among, closest
from contiga.search.kernels.walk_nb import walk

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


@kernel()
def project_facing(tables, points, guards, least, out, start, stop):
    """Feet of the points start … stop whose normals are within the cosine `least` of `guards`.

    Both are (n, 3), guards of length one. Rows where there is no such foot are MAX_ITERATIONS.
    """
    h = scratch(4, 6)
    found = scratch(4)
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        among = Among(-1, (guards[k, 0], guards[k, 1], guards[k, 2]), least)
        distance = closest(tables, point, among, math.inf, found, h)
        if math.isfinite(distance):
            _write_guarded(tables, k, point, distance, out, found, h)
        else:
            blank_foot(out, k, MAX_ITERATIONS)
