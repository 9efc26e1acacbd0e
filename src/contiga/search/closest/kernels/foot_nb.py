"""From a foot to its record: point, normal, gap; crossing to the next face."""

from __future__ import annotations

import math

from contiga.arrays.codes import BUDGET, EDGE, FACE, MAX_ITERATIONS, OK, TRIMMED
from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_among_nb import on_patch
from contiga.search.closest.kernels.global_nb import DROPPED, GIVEN_UP, PRUNE, SEEN, closest
from contiga.search.closest.kernels.pseudo_normal_nb import (
    NEAR,
    is_listed,
    joint_reach,
    patches_near,
    pseudo_normal,
    side_of_squarest,
)
from contiga.search.closest.kernels.walk_nb import walk
from contiga.search.hierarchy.kernels.curve_nb import ELEMENT, LEFT_OUT, polish, surface_foot
from contiga.search.hierarchy.kernels.face_nb import in_face

HOPS = 4
BESIDE_EDGE = 8.0
"""Widths of an edge within which a point sees how its faces miss each other."""


@inner(linked=False)
def write_foot(tables, k, foot, status, feature, point, out, h):
    """Write row k of the projection `out`; the gap and normal of a face."""
    e, s, t = foot
    elements = tables.elements
    x, y, z = normal_at(elements, e, s, t, h)
    u, v = parameters(elements, e, s, t)
    out.patch[k] = elements.table[e]["patch"]
    out.uv[k, 0] = u
    out.uv[k, 1] = v
    out.normal[k, 0] = x
    out.normal[k, 1] = y
    out.normal[k, 2] = z
    gap = 0.0
    for c in range(3):
        out.point[k, c] = h[c, 0] + elements.table[e]["origin"][c]
        # Formed from the element's origin: no digits are lost far from the world's.
        gap += (point[c] - elements.table[e]["origin"][c] - h[c, 0]) * out.normal[k, c]
    out.gap[k] = gap
    out.feature[k] = feature
    out.status[k] = status
    out.certified[k] = 0


@inner()
def turn_normal(tables, k, toward, point, out):
    """Let the normal at a kink run through the point, on the side that `toward` (3,) says."""
    square = 0.0
    side = 0.0
    for c in range(3):
        r = point[c] - out.point[k, c]
        square += r * r
        side += r * toward[c]
    distance = math.sqrt(square)
    length = math.sqrt(toward[0] ** 2 + toward[1] ** 2 + toward[2] ** 2)
    if distance <= 4.0 * tables.scale[1]:
        if length > 0.0:
            for c in range(3):
                out.normal[k, c] = toward[c] / length
            out.gap[k] = side / length
        return
    sign = 1.0 if side >= 0.0 else -1.0
    for c in range(3):
        out.normal[k, c] = sign * (point[c] - out.point[k, c]) / distance
    out.gap[k] = sign * distance


@inner()
def no_farther(tables, point, among, reach, nearest, h):
    """Do as `closest` for a point with a known foot at `reach`, which is found at least."""
    seen = reach * SEEN + 2.0 * PRUNE * tables.scale[1]
    for limit in (seen, math.inf):
        distance = closest(tables, point, among, limit, nearest, h)
        if math.isfinite(distance):
            break
    return distance


@inner(linked=False)
def write_nearest(tables, k, point, out, nearest, h):
    """Row k of `out`: the closest point of the whole body, as a search has left it in `nearest`."""
    elements = tables.elements
    if nearest[ELEMENT] < 0:
        polish(tables, nearest, point, h)
    foot = surface_foot(tables, nearest, h)
    left = nearest[LEFT_OUT]
    status = OK
    feature = EDGE
    if nearest[ELEMENT] >= 0:
        status, e, s, t, feature = walk(elements, foot, point, tables.scale[1], h)
        if status == MAX_ITERATIONS or in_face(elements, tables.trims, e, s, t):
            foot = (e, s, t)
        else:
            status = OK
            feature = EDGE
    else:
        # A foot inside the face may be closer by less than the search tells apart.
        inner = walk(elements, foot, point, tables.scale[1], h)
        if inner[0] == OK and inner[4] == FACE and in_face(elements, tables.trims, *inner[1:4]):
            foot = inner[1:4]
            feature = FACE
        elif tables.piece_open[int(-1 - nearest[ELEMENT])] != 0.0:
            status = TRIMMED
    if left == GIVEN_UP:
        status = BUDGET
    elif left == DROPPED and status == MAX_ITERATIONS:
        status = OK  # others are as near: where along them the nearest is, rounding hides
    write_foot(tables, k, foot, status, feature, point, out, h)
    out.certified[k] = 1 if left == 0.0 and status != MAX_ITERATIONS else 0
    if feature != FACE:
        total = scratch(3)
        pseudo_normal(tables, foot, nearest, total, h)
        if feature == EDGE:
            # So near an edge that its faces' misfit counts, with the sum of their normals nearly
            # across the way to the point, the squarest face tells the side.
            square = along = length = 0.0
            for c in range(3):
                r = point[c] - out.point[k, c]
                square += r * r
                along += r * total[c]
                length += total[c] * total[c]
            distance, reach = math.sqrt(square), BESIDE_EDGE * joint_reach(tables, foot[0])
            side = 0.0
            if not (distance > reach or along * along > 0.25 * square * length):
                side = side_of_squarest(tables, foot[0], (point, distance), nearest, h)
            if side != 0.0:
                for c in range(3):
                    total[c] = math.copysign(1.0, side) * (point[c] - out.point[k, c])
        turn_normal(tables, k, total, point, out)


@inner()
def _distance2(tables, foot, point, h):
    elements = tables.elements
    e, s, t = foot
    normal_at(elements, e, s, t, h)
    total = 0.0
    for c in range(3):
        total += (h[c, 0] + elements.table[e]["origin"][c] - point[c]) ** 2
    return total


@inner()
def _edge_foot(tables, home, reach, point, nearest, h):
    """Return where a tracked foot that ran out of the face `home` leaves it: the face's closest
    point.

    One is known at the distance `reach`. Returns (open border?, element, s, t).
    """
    no_farther(tables, point, on_patch(home), reach, nearest, h)
    if nearest[ELEMENT] < 0:
        polish(tables, nearest, point, h)
    near = surface_foot(tables, nearest, h)
    is_open = nearest[ELEMENT] < 0 and tables.piece_open[int(-1 - nearest[ELEMENT])] != 0.0
    return is_open, near[0], near[1], near[2]


@inner(linked=False)
def _next_face(tables, edge, point, nearest, h):
    """Foot on the face across the edge that lies closer to the point than the edge does.

    Returns (status, element, s, t, feature, how far its face is if it is out of that, else
    −1), element −1 where no adjoining face comes closer.
    """
    elements = tables.elements
    grid = tables.grid
    e = edge[0]
    home = elements.table[e]["patch"]
    best = _distance2(tables, edge, point, h)
    best -= 1e-12 * best + tables.scale[1] ** 2
    at = (
        h[0, 0] + elements.table[e]["origin"][0],
        h[1, 0] + elements.table[e]["origin"][1],
        h[2, 0] + elements.table[e]["origin"][2],
    )
    result = (OK, -1, 0.0, 0.0, FACE, -1.0)
    reach = joint_reach(tables, e)
    span = grid.patches[home]["adjacent"]
    near = stack_int64(NEAR)
    listed = patches_near(tables, at, reach, near)
    for k in range(span[0] + 1, span[1]):
        if not (grid.loose[k] and is_listed(near, listed, grid.adjacent[k])):
            continue
        if not math.isfinite(closest(tables, at, on_patch(grid.adjacent[k]), reach, nearest, h)):
            continue
        start = surface_foot(tables, nearest, h)
        status, e2, s2, t2, feature = walk(elements, start, point, tables.scale[1], h)
        inside = in_face(elements, tables.trims, e2, s2, t2)
        square = _distance2(tables, (e2, s2, t2), point, h)
        if not inside:
            face = elements.table[e2]["patch"]
            known = math.sqrt(_distance2(tables, start, point, h))
            _, e3, s3, t3 = _edge_foot(tables, face, known, point, nearest, h)
            square = _distance2(tables, (e3, s3, t3), point, h)
        if square < best:
            best = square
            result = (status, e2, s2, t2, feature, -1.0 if inside else math.sqrt(square))
    return result


@inner(linked=False)
def continued_foot(tables, start, point, nearest, h):
    """The foot continued from `start` = (element, s, t): (status, element, s, t, feature).

    Over linked sides the walk goes on by itself; at an edge where faces meet without lining up,
    or at a trimmed edge, the adjoining faces are tried from the point where the foot arrives.
    """
    elements = tables.elements
    reach = math.sqrt(_distance2(tables, start, point, h))
    status, e, s, t, feature = walk(elements, start, point, tables.scale[1], h)
    inside = in_face(elements, tables.trims, e, s, t)
    for _ in range(HOPS):
        if status == MAX_ITERATIONS or (inside and feature == FACE):
            break
        at = (e, s, t)
        is_open = False
        if not inside:
            home = elements.table[e]["patch"]
            is_open, e0, s0, t0 = _edge_foot(tables, home, reach, point, nearest, h)
            at = (e0, s0, t0)
        new = _next_face(tables, at, point, nearest, h)
        if new[1] < 0:
            if not inside:
                e, s, t = at
                feature = EDGE
                status = TRIMMED if is_open else OK
                inside = True
            break
        status, e, s, t, feature, reach = new
        inside = reach < 0.0
    return (status if inside else TRIMMED), e, s, t, feature


@inner(linked=False)
def tracked_foot(tables, k, start, point, out, nearest, h):
    """Fill row k of `out` with the foot continued from `start` = (element, s, t)."""
    status, e, s, t, feature = continued_foot(tables, start, point, nearest, h)
    write_foot(tables, k, (e, s, t), status, feature, point, out, h)
    if feature != FACE and status == OK:
        total = scratch(3)
        nearest[ELEMENT] = e
        pseudo_normal(tables, (e, s, t), nearest, total, h)
        turn_normal(tables, k, total, point, out)
