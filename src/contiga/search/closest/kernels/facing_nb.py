"""The closest feet that do not face away from a guard and have the point behind them.

They measure the depth of a point that the nearest wall of a body must not push, because it is
opposite to the wall that holds the point. At a kink the normal is the direction to the foot. The
search starts from the foot at the end of a walk from the last foot, and finds that foot or a nearer
foot.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import EDGE, FACE, MAX_ITERATIONS, NOT_FINITE, OK
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import evaluate, locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.closest.kernels.foot_nb import continued_foot, write_foot
from contiga.search.closest.kernels.global_nb import closest
from contiga.search.closest.kernels.global_scope_nb import Scope, is_admissible
from contiga.search.closest.kernels.pseudo_normal_nb import joint_reach
from contiga.search.closest.kernels.walk_nb import walk
from contiga.search.hierarchy.kernels.curve_nb import ELEMENT, LEFT_OUT, S, T, polish, surface_foot
from contiga.search.hierarchy.kernels.face_nb import in_face

DISTANCE_TOL = 1e-6
"""Relative difference of distances that count as equal."""
MAX_TRIES = 8
"""Largest number of candidate feet where edges are minima of one face only."""


@inner(linked=False)
def _write_guarded(tables, k, point, distance, out, nearest, h):
    """Write row k of `out`: the foot `nearest` of a guarded search, at a distance.

    If a walk from there ends inside a face at the same distance, its end is the foot. Otherwise the
    foot is `nearest`, an EDGE, whose normal points from the point to the foot, and whose gap is
    minus their distance (normal and gap of the face if they almost touch). The status is OK; the
    row is certified if the search left out nothing. A place on a trimming curve is polished in
    `nearest`.
    """
    if nearest[ELEMENT] < 0:
        polish(tables, nearest, point, h)
    foot = surface_foot(tables, nearest, h)
    status, e, s, t, feature = walk(tables.elements, foot, point, tables.scale[1], h)
    if status == OK and feature == FACE and in_face(tables.elements, tables.trims, e, s, t):
        write_foot(tables, k, (e, s, t), OK, FACE, point, out, h)
        if abs(abs(out.gap[k]) - distance) <= DISTANCE_TOL * distance + tables.scale[1]:
            out.certified[k] = 1 if nearest[LEFT_OUT] == 0.0 else 0
            return
    write_foot(tables, k, foot, OK, EDGE, point, out, h)
    out.certified[k] = 1 if nearest[LEFT_OUT] == 0.0 else 0
    square = 0.0
    for c in range(3):
        square += (out.point[k, c] - point[c]) ** 2
    foot_distance = math.sqrt(square)
    if foot_distance > 4.0 * tables.scale[1]:
        out.gap[k] = -foot_distance
        for c in range(3):
            out.normal[k, c] = (out.point[k, c] - point[c]) / foot_distance


@inner()
def _descends_across_edge(tables, k, point, out, nearest, h):
    """Return whether row k of `out`, a foot on an edge, is no minimum of the distance.

    It is no minimum if a foot continued from it over the edge is closer by more than the gap
    between the faces there. Overwrites `nearest`.
    """
    start = locate(tables.grid, out.patch[k], out.uv[k, 0], out.uv[k, 1])
    _, e, s, t, _ = continued_foot(tables, start, point, nearest, h)
    evaluate(tables.elements, e, s, t, h)
    before = after = 0.0
    for c in range(3):
        before += (point[c] - out.point[k, c]) ** 2
        after += (point[c] - tables.elements.table[e]["origin"][c] - h[c, 0]) ** 2
    before, after = math.sqrt(before), math.sqrt(after)
    return after < before - DISTANCE_TOL * before - joint_reach(tables, start[0])


@kernel()
def project_facing(tables, points, guards, limits, starts, out, start, stop):
    """Write the feet of points[start:stop] that face their `guards` (n, 3) to the rows of `out`.

    `limits` are `FacingLimits`, `starts` are the `SurfacePlaces` to start from, patch −1 for none:
    an admissible foot at the end of a walk bounds the search. Edges that are no minimum are
    skipped. Rows without a foot within the limits, or after `MAX_TRIES` such edges, are blank with
    the status MAX_ITERATIONS, those of points that are not finite with NOT_FINITE.
    """
    h = scratch(4, 6)
    nearest, walk_foot = scratch(4), scratch(4)
    elements, patch, uv = tables.elements, starts.patch, starts.uv
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            blank_foot(out, k, NOT_FINITE)
            continue
        guard = (guards[k, 0], guards[k, 1], guards[k, 2])
        scope = Scope(-1, guard, limits.cosine, limits.min_distance[k])
        # The distance of the foot at the end of a walk from the start, if it is admissible.
        walk_distance = math.inf
        if patch[k] >= 0:
            foot = locate(tables.grid, patch[k], uv[k, 0], uv[k, 1])
            status, e, s, t, _ = walk(elements, foot, point, tables.scale[1], h)
            is_foot = status == OK and in_face(elements, tables.trims, e, s, t)
            if is_foot and is_admissible(elements, (e, s, t), point, scope, h):
                walk_foot[ELEMENT], walk_foot[S], walk_foot[T] = e, s, t
                square = 0.0
                for c in range(3):
                    square += (point[c] - elements.table[e]["origin"][c] - h[c, 0]) ** 2
                walk_distance = math.sqrt(square)
        walk_distance = walk_distance if walk_distance <= limits.max_distance[k] else math.inf
        for _ in range(MAX_TRIES):
            distance = closest(
                tables, point, scope, min(walk_distance, limits.max_distance[k]), nearest, h
            )
            if math.isfinite(distance):
                _write_guarded(tables, k, point, distance, out, nearest, h)
            elif math.isfinite(walk_distance):
                walk_foot[LEFT_OUT] = nearest[LEFT_OUT]
                _write_guarded(tables, k, point, walk_distance, out, walk_foot, h)
            else:
                blank_foot(out, k, MAX_ITERATIONS)
            is_on_edge = out.status[k] == OK and out.feature[k] == EDGE
            if not (is_on_edge and _descends_across_edge(tables, k, point, out, nearest, h)):
                break
            min_distance = -out.gap[k] * (1.0 + DISTANCE_TOL) + tables.scale[1]
            scope = Scope(-1, guard, limits.cosine, min_distance)
            walk_distance = walk_distance if walk_distance >= min_distance else math.inf
        else:
            blank_foot(out, k, MAX_ITERATIONS)
