"""Convert a foot to its record (point, normal, gap); continue it over edges to the next face."""

from __future__ import annotations

import math

from contiga.arrays.codes import BUDGET, EDGE, FACE, MAX_ITERATIONS, OK, TRIMMED
from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_nb import (
    DISTANCE_MARGIN,
    MIN_GAIN,
    OVER_BUDGET,
    UNRESOLVED,
    closest,
)
from contiga.search.closest.kernels.global_scope_nb import on_patch
from contiga.search.closest.kernels.pseudo_normal_nb import (
    MAX_PATCHES,
    is_listed,
    joint_reach,
    patches_near,
    pseudo_normal,
    side_of_most_frontal,
)
from contiga.search.closest.kernels.walk_nb import walk
from contiga.search.hierarchy.kernels.curve_nb import ELEMENT, LEFT_OUT, polish, surface_foot
from contiga.search.hierarchy.kernels.face_nb import in_face

MAX_FACES = 4
"""Largest number of faces that a tracked foot passes."""
EDGE_ZONE = 8.0
"""Widths of an edge within which the misfit of its faces decides the side of a point."""


@inner(linked=False)
def write_foot(tables, k, foot, status, feature, point, out, h):
    """Write row k of the projection `out`: a foot (element, s, t), with the face's gap and normal.

    The row is not certified.
    """
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
        # From the element's origin, so that no digits are lost far from the origin of the body.
        gap += (point[c] - elements.table[e]["origin"][c] - h[c, 0]) * out.normal[k, c]
    out.gap[k] = gap
    out.feature[k] = feature
    out.status[k] = status
    out.certified[k] = 0


@inner()
def turn_normal(tables, k, reference, point, out):
    """Turn the normal of row k of `out` to the line from the foot to the point, and set its gap.

    The normal is on the side of `reference` (3,), and the gap is the distance with the sign of that
    side. For a point within four tolerances of the foot the normal is `reference`, scaled to length
    one, and the gap is measured along it; if `reference` is zero, the row stays as it is.
    """
    square = 0.0
    side = 0.0
    for c in range(3):
        r = point[c] - out.point[k, c]
        square += r * r
        side += r * reference[c]
    distance = math.sqrt(square)
    length = math.sqrt(reference[0] ** 2 + reference[1] ** 2 + reference[2] ** 2)
    if distance <= 4.0 * tables.scale[1]:
        if length > 0.0:
            for c in range(3):
                out.normal[k, c] = reference[c] / length
            out.gap[k] = side / length
        return
    sign = 1.0 if side >= 0.0 else -1.0
    for c in range(3):
        out.normal[k, c] = sign * (point[c] - out.point[k, c]) / distance
    out.gap[k] = sign * distance


@inner()
def closest_within(tables, point, scope, reach, nearest, h):
    """Return the distance that `closest` finds, for a point with a foot at a distance `reach`.

    Searches within `reach` and its rounding first, then without a limit; infinite if nothing is
    found. The place is written to `nearest`.
    """
    padded = reach * DISTANCE_MARGIN + 2.0 * MIN_GAIN * tables.scale[1]
    for limit in (padded, math.inf):
        distance = closest(tables, point, scope, limit, nearest, h)
        if math.isfinite(distance):
            break
    return distance


@inner(linked=False)
def write_nearest(tables, k, point, out, nearest, h):
    """Write row k of `out`: the closest point of the body, from the `nearest` of a search.

    The foot is where a walk from there ends, if that is inside the face; otherwise the place
    itself, an EDGE. The status is AT_BORDER on an open side, TRIMMED on an open trimming curve,
    BUDGET after a search over budget, MAX_ITERATIONS after a walk that did not converge (unless
    the search was unresolved), else OK. The row is certified if the search left out nothing and the
    walk converged. On a kink the normal is along the line to the point, on the side of the
    pseudo-normal, or, near an edge whose faces do not fit, of the face that is seen most frontally.
    `nearest` is overwritten.
    """
    elements = tables.elements
    if nearest[ELEMENT] < 0:
        polish(tables, nearest, point, h)
    foot = surface_foot(tables, nearest, h)
    state = nearest[LEFT_OUT]
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
        # A foot inside the face may be closer by less than the gain that the search looks for.
        inner_foot = walk(elements, foot, point, tables.scale[1], h)
        is_inner = inner_foot[0] == OK and inner_foot[4] == FACE
        if is_inner and in_face(elements, tables.trims, *inner_foot[1:4]):
            foot = inner_foot[1:4]
            feature = FACE
        elif tables.piece_open[int(-1 - nearest[ELEMENT])] != 0.0:
            status = TRIMMED
    if state == OVER_BUDGET:
        status = BUDGET
    elif state == UNRESOLVED and status == MAX_ITERATIONS:
        status = OK  # other feet are as near, and rounding decides which is nearest
    write_foot(tables, k, foot, status, feature, point, out, h)
    out.certified[k] = 1 if state == 0.0 and status != MAX_ITERATIONS else 0
    if feature != FACE:
        total = scratch(3)
        pseudo_normal(tables, foot, nearest, total, h)
        if feature == EDGE:
            # Where the misfit of the faces at an edge counts, and the sum of their normals is
            # nearly perpendicular to the direction to the point, the most frontal face decides the
            # side.
            square = height = length = 0.0
            for c in range(3):
                r = point[c] - out.point[k, c]
                square += r * r
                height += r * total[c]
                length += total[c] * total[c]
            distance, reach = math.sqrt(square), EDGE_ZONE * joint_reach(tables, foot[0])
            side = 0.0
            if not (distance > reach or height * height > 0.25 * square * length):
                side = side_of_most_frontal(tables, foot[0], (point, distance), nearest, h)
            if side != 0.0:
                for c in range(3):
                    total[c] = math.copysign(1.0, side) * (point[c] - out.point[k, c])
        turn_normal(tables, k, total, point, out)


@inner()
def _distance2(tables, foot, point, h):
    """Return the squared distance of a point to a foot (element, s, t)."""
    elements = tables.elements
    e, s, t = foot
    normal_at(elements, e, s, t, h)
    total = 0.0
    for c in range(3):
        total += (h[c, 0] + elements.table[e]["origin"][c] - point[c]) ** 2
    return total


@inner()
def _edge_foot(tables, home, reach, point, nearest, h):
    """Return where a tracked foot leaves the face `home`: (is on an open trim, element, s, t).

    The result is the closest point of that face, one of whose points is at the distance `reach`.
    `nearest` and `h` are work.
    """
    closest_within(tables, point, on_patch(home), reach, nearest, h)
    if nearest[ELEMENT] < 0:
        polish(tables, nearest, point, h)
    foot = surface_foot(tables, nearest, h)
    is_open = nearest[ELEMENT] < 0 and tables.piece_open[int(-1 - nearest[ELEMENT])] != 0.0
    return is_open, foot[0], foot[1], foot[2]


@inner(linked=False)
def _next_face(tables, edge, point, nearest, h):
    """Return the foot on an adjoining face that is closer to the point than `edge` (element, s, t).

    Returns (status, element, s, t, feature, reach) for the closest of the adjoining faces near the
    edge. `reach` is −1 for a foot inside its face, else the distance of that face. Element −1 where
    no adjoining face is closer.
    """
    elements = tables.elements
    grid = tables.grid
    e = edge[0]
    home = elements.table[e]["patch"]
    best = _distance2(tables, edge, point, h)
    best -= 1e-12 * best + tables.scale[1] ** 2
    edge_point = (
        h[0, 0] + elements.table[e]["origin"][0],
        h[1, 0] + elements.table[e]["origin"][1],
        h[2, 0] + elements.table[e]["origin"][2],
    )
    result = (OK, -1, 0.0, 0.0, FACE, -1.0)
    reach = joint_reach(tables, e)
    neighbours = grid.patches[home]["adjacent"]
    nearby = stack_int64(MAX_PATCHES)
    n_nearby = patches_near(tables, edge_point, reach, nearby)
    for k in range(neighbours[0] + 1, neighbours[1]):
        if not (grid.loose[k] and is_listed(nearby, n_nearby, grid.adjacent[k])):
            continue
        scope = on_patch(grid.adjacent[k])
        if not math.isfinite(closest(tables, edge_point, scope, reach, nearest, h)):
            continue
        start = surface_foot(tables, nearest, h)
        status, e1, s1, t1, feature = walk(elements, start, point, tables.scale[1], h)
        inside = in_face(elements, tables.trims, e1, s1, t1)
        square = _distance2(tables, (e1, s1, t1), point, h)
        if not inside:
            face = elements.table[e1]["patch"]
            start_distance = math.sqrt(_distance2(tables, start, point, h))
            _, e2, s2, t2 = _edge_foot(tables, face, start_distance, point, nearest, h)
            square = _distance2(tables, (e2, s2, t2), point, h)
        if square < best:
            best = square
            result = (status, e1, s1, t1, feature, -1.0 if inside else math.sqrt(square))
    return result


@inner(linked=False)
def continued_foot(tables, start, point, nearest, h):
    """Continue the foot `start` = (element, s, t); return (status, element, s, t, feature).

    Over linked sides the walk goes on by itself. At an edge where the sides of the faces do not
    coincide, or at a trimmed edge, the adjoining faces are tried from the point on the edge, at
    most `MAX_FACES` in turn. The status is that of `walk` inside a face, OK on the edge of a face
    with no closer face beyond, TRIMMED if that edge is an open trimming curve, or if the foot is
    still outside of a face at the end.
    """
    elements = tables.elements
    reach = math.sqrt(_distance2(tables, start, point, h))
    status, e, s, t, feature = walk(elements, start, point, tables.scale[1], h)
    inside = in_face(elements, tables.trims, e, s, t)
    for _ in range(MAX_FACES):
        if status == MAX_ITERATIONS or (inside and feature == FACE):
            break
        edge = (e, s, t)
        is_open = False
        if not inside:
            home = elements.table[e]["patch"]
            is_open, e0, s0, t0 = _edge_foot(tables, home, reach, point, nearest, h)
            edge = (e0, s0, t0)
        new = _next_face(tables, edge, point, nearest, h)
        if new[1] < 0:
            if not inside:
                e, s, t = edge
                feature = EDGE
                status = TRIMMED if is_open else OK
                inside = True
            break
        status, e, s, t, feature, reach = new
        inside = reach < 0.0
    return (status if inside else TRIMMED), e, s, t, feature


@inner(linked=False)
def tracked_foot(tables, k, start, point, out, nearest, h):
    """Write row k of `out`: the foot continued from `start` = (element, s, t), not certified.

    The status is that of `continued_foot`. At a kink, if it is OK, the normal is along the line to
    the point, on the side of the pseudo-normal; otherwise gap and normal are those of the face.
    """
    status, e, s, t, feature = continued_foot(tables, start, point, nearest, h)
    write_foot(tables, k, (e, s, t), status, feature, point, out, h)
    if feature != FACE and status == OK:
        total = scratch(3)
        nearest[ELEMENT] = e
        pseudo_normal(tables, (e, s, t), nearest, total, h)
        turn_normal(tables, k, total, point, out)
