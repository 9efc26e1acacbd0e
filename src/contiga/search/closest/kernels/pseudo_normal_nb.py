"""The sum of the normals around a kink, weighted by angle: it decides the side of a point there.

Every face at an edge or vertex counts with the angle that it subtends there (Baerentzen & Aanaes
2005, doi 10.1109/TVCG.2005.49): π inside an edge, the angle between its two borders at a corner.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import parameters
from contiga.elements.kernels.sides_nb import normal_at, side_point
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.around_nb import MAX_AROUND, around, collapsed_side
from contiga.search.closest.kernels.global_nb import DISTANCE_MARGIN, MIN_GAIN, closest
from contiga.search.closest.kernels.global_scope_nb import on_patch
from contiga.search.hierarchy.kernels.curve_nb import (
    ELEMENT,
    S,
    curve_point,
    piece_parameters,
    surface_foot,
)
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.hierarchy.kernels.tree_nb import box_distance2

JOINT_TOL = 1e-7
"""Distance below which faces at a common edge meet, however narrow it is, as a share of the body's
size."""
END_TOL = 1e-6
"""Distance to an end of a trimming piece, as a share of it, below which a foot may be a corner."""
CORNER_STEP = 1e-5
"""Distance from a corner, as a share of the patch, at which inside and outside are told apart."""
POLE_ARCS = 4
"""Number of arcs into which a collapsed side is divided."""
MAX_PATCHES = 32
"""Largest number of patches listed near one point."""
CORNER_TOL = 1e-7
"""Distance to a corner of a loop, as a share of the patch, below which a place is that corner:
where faces are cut along splines, their corners miss each other by more than rounding, or have a
tiny edge."""
MAX_TINY_EDGES = 4
"""Largest number of consecutive tiny edges that are skipped."""
SNAP_TOL = 1e-7
"""Distance to a side of an element (local parameters) below which a place is moved onto it."""
FRONTAL = 0.99
"""Cosine of the angle to its normal from which on a point sees a face frontally."""


@inner()
def _angle(ax, ay, az, bx, by, bz):
    """Return the angle between two vectors, 0 to π."""
    cross = math.sqrt(
        (ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2
    )
    return math.atan2(cross, ax * bx + ay * by + az * bz)


@inner()
def _add_elements(tables, foot, only, total, h):
    """Add the normals of the elements around a foot, weighted by angle, to total[3].

    Elements of other patches than `only` (−1: all count), or outside the trims, are skipped.
    Returns the number of all elements around, skipped ones too, and their list (MAX_AROUND,).
    """
    elements = tables.elements
    list_e = np.empty(MAX_AROUND, np.int64)
    list_st = scratch(MAX_AROUND, 2)
    n = around(elements, foot, list_e, list_st)
    for k in range(n):
        e = list_e[k]
        s = list_st[k, 0]
        t = list_st[k, 1]
        if only >= 0 and elements.table[e]["patch"] != only:
            continue
        if not in_face(elements, tables.trims, e, s, t):
            continue
        pole = collapsed_side(elements, e, s, t)
        if pole >= 0:  # along the collapsed side each normal has its share of the angle
            column = 1 if pole < 2 else 2
            px = py = pz = 0.0
            for arc in range(POLE_ARCS + 1):
                s, t = side_point(pole, arc / POLE_ARCS - 0.5)
                normal_at(elements, e, s, t, h)
                dx, dy, dz = h[0, column], h[1, column], h[2, column]
                if arc > 0:
                    weight = _angle(px, py, pz, dx, dy, dz)
                    s, t = side_point(pole, (arc - 0.5) / POLE_ARCS - 0.5)
                    x, y, z = normal_at(elements, e, s, t, h)
                    total[0] += weight * x
                    total[1] += weight * y
                    total[2] += weight * z
                px, py, pz = dx, dy, dz
            continue
        x, y, z = normal_at(elements, e, s, t, h)
        if abs(s) < 0.5 or abs(t) < 0.5:
            weight = math.pi
        else:
            sign = -1.0 if (s > 0.0) != (t > 0.0) else 1.0
            weight = _angle(
                h[0, 1], h[1, 1], h[2, 1], sign * h[0, 2], sign * h[1, 2], sign * h[2, 2]
            )
        total[0] += weight * x
        total[1] += weight * y
        total[2] += weight * z
    return n, list_e


@inner()
def _is_point(trims, patch, p, q):
    """Return whether two places (u, v) of a patch coincide to within `CORNER_TOL`."""
    domain = trims.domain[patch]
    u = abs(q[0] - p[0])
    v = abs(q[1] - p[1])
    return u <= CORNER_TOL * (domain[1] - domain[0]) and v <= CORNER_TOL * (domain[3] - domain[2])


@inner()
def _is_short(trims, piece):
    """Return whether a trimming piece is a point of its patch: its ends are one place."""
    ends = trims.piece_ends[piece]
    return _is_point(trims, trims.piece_patch[piece], (ends[0], ends[1]), (ends[2], ends[3]))


@inner()
def _joined_piece(trims, piece, end):
    """Return the piece of the same patch that continues a piece at its `end` (0 or 1), or −1.

    Both meet at exactly the same (u, v). Pieces that are points are skipped; −1 after
    `MAX_TINY_EDGES` of them.
    """
    patch = trims.piece_patch[piece]
    for _ in range(MAX_TINY_EDGES):
        ends = trims.piece_ends[piece]
        x = ends[2 * end]
        y = ends[2 * end + 1]
        next_piece = -1
        for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
            other = trims.piece_ends[k]
            if k != piece and other[2 - 2 * end] == x and other[3 - 2 * end] == y:
                next_piece = k
                break
        if next_piece < 0 or not _is_short(trims, next_piece):
            return next_piece
        piece = next_piece
    return -1


@inner()
def _corner_angle(tables, nearest, h):
    """Return the angle of a trimmed face at its border point `nearest`: π except at corners.

    The angle at a corner of a loop is that of the tangents of both pieces in space, or 2π minus
    that angle if the face is on the reflex side. It is π, too, where no piece continues the other,
    or where they continue straight or have no direction.
    """
    piece = int(-1 - nearest[ELEMENT])
    t = nearest[S]
    trims = tables.trims
    end = 1 if t > 0.5 else 0
    if _is_short(trims, piece):
        piece = _joined_piece(trims, piece, 0)
        end = 1
        if piece < 0:
            return math.pi
    elif END_TOL < t < 1.0 - END_TOL:
        return math.pi
    next_piece = _joined_piece(trims, piece, end)
    if next_piece < 0:
        return math.pi
    d = scratch(3, 3)
    c = scratch(3, 3)
    sign = -1.0 if end == 1 else 1.0  # both tangents away from the corner
    curve_point(tables.elements, tables.grid, trims, piece, float(end), h, d)
    ax, ay, az = sign * d[1, 0], sign * d[1, 1], sign * d[1, 2]
    curve_point(tables.elements, tables.grid, trims, next_piece, float(1 - end), h, d)
    bx, by, bz = -sign * d[1, 0], -sign * d[1, 1], -sign * d[1, 2]
    angle = _angle(ax, ay, az, bx, by, bz)
    domain = tables.trims.domain[trims.piece_patch[piece]]
    wide = domain[1] - domain[0]
    high = domain[3] - domain[2]
    piece_parameters(trims, piece, float(end), c)
    u, v = c[0, 0], c[0, 1]
    au, av = sign * c[1, 0] / wide, sign * c[1, 1] / high
    piece_parameters(trims, next_piece, float(1 - end), c)
    bu, bv = -sign * c[1, 0] / wide, -sign * c[1, 1] / high
    a = math.hypot(au, av)
    b = math.hypot(bu, bv)
    if a == 0.0 or b == 0.0:
        return math.pi
    mu, mv = au / a + bu / b, av / a + bv / b
    m = math.hypot(mu, mv)
    if m < 1e-6:
        return math.pi
    u += CORNER_STEP * mu / m * wide
    v += CORNER_STEP * mv / m * high
    is_convex = point_in_trim(trims, trims.piece_patch[piece], u, v) == 1
    return angle if is_convex else 2.0 * math.pi - angle


@inner()
def _snapped(x):
    """Return a parameter, moved onto a side of its element if it is that near."""
    if x < SNAP_TOL - 0.5:
        return -0.5
    return 0.5 if x > 0.5 - SNAP_TOL else x


@inner()
def joint_reach(tables, e):
    """Return the largest distance, length, of an edge of element `e` from the faces at it."""
    return max(tables.elements.table[e]["edge_tolerance"], JOINT_TOL * tables.scale[0])


@inner()
def patches_near(tables, point, reach, patches):
    """List the patches that may be within `reach` of a point in patches[MAX_PATCHES].

    Returns their number, −1 if there are more; the boxes of their leaves decide. A face with many
    holes has an edge with a hundred others: to search each of them takes longer than one query of
    the hierarchy.
    """
    tree = tables.tree
    leaves = tables.leaves
    x, y, z = point
    nodes = stack_int64(128)
    nodes[0] = 0
    top = 1 if leaves.shape[0] > 0 else 0
    n_patches = 0
    while top > 0:
        top -= 1
        node = nodes[top]
        if box_distance2(tree, node, x, y, z) > reach * reach:
            continue
        first = tree[node]["first"]
        count = tree[node]["count"]
        if count == 0:
            nodes[top] = first
            nodes[top + 1] = first + 1
            top += 2
        for k in range(first, first + count):
            patch = leaves[k]["patch"]
            if not is_listed(patches, n_patches, patch):
                if n_patches == MAX_PATCHES:
                    return -1
                patches[n_patches] = patch
                n_patches += 1
    return n_patches


@inner()
def is_listed(patches, n_patches, patch):
    """Return whether a patch is among the first n_patches of a list.

    True for any patch if that number is −1.
    """
    for i in range(n_patches):
        if patches[i] == patch:
            return True
    return n_patches < 0


@inner()
def _add_face(tables, patch, place, nearest, total, h):
    """Add the weighted normal of the face `patch` to total[3] if it passes through `place`.

    `place` is (point, tolerance); the weight is that of `_add_normal_at`. `nearest` is overwritten.
    """
    if math.isfinite(closest(tables, place[0], on_patch(patch), place[1], nearest, h)):
        _add_normal_at(tables, patch, nearest, total, h)


@inner(linked=False)
def _add_normal_at(tables, patch, nearest, total, h):
    """Add the normal of the face `patch` at its place `nearest` to total[3], weighted by its angle.

    `nearest`, on a kink, is overwritten at a corner of the face's loops.
    """
    e, s, t = surface_foot(tables, nearest, h)
    # At a corner of its loops a face counts with the angle that it subtends there.
    trims, uv = tables.trims, parameters(tables.elements, e, s, t)
    for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        ends = trims.piece_ends[k]
        if _is_point(trims, patch, uv, (ends[0], ends[1])):
            nearest[ELEMENT] = float(-1 - k)
            nearest[S] = 0.0
            break
    if nearest[ELEMENT] >= 0:
        place = (e, _snapped(s), _snapped(t))
        # The side of the element may be outside a trimmed face that touches it, as a disc touches
        # the sides of its square.
        if not in_face(tables.elements, tables.trims, *place):
            place = (e, s, t)
        _add_elements(tables, place, patch, total, h)
        return
    weight = _corner_angle(tables, nearest, h)
    x, y, z = normal_at(tables.elements, e, s, t, h)
    total[0] += weight * x
    total[1] += weight * y
    total[2] += weight * z


@inner(linked=False)
def pseudo_normal(tables, foot, nearest, total, h):
    """Write the angle-weighted sum of the normals of all faces at a foot on a kink to total[3].

    The sum is not normalised. Beside the foot's own face the adjoining faces count that pass within
    `joint_reach` of the foot. `nearest` holds the foot if a search has found it on a trimming
    piece, otherwise its element is 0 or more; it is overwritten.
    """
    elements = tables.elements
    total[:] = 0.0
    e, s, t = foot
    normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    point = (h[0, 0] + origin[0], h[1, 0] + origin[1], h[2, 0] + origin[2])
    place = (point, joint_reach(tables, e))
    grid = tables.grid
    home = elements.table[e]["patch"]
    neighbours = grid.patches[home]["adjacent"]
    nearby = stack_int64(MAX_PATCHES)
    n_nearby = patches_near(tables, point, place[1], nearby)
    if tables.trims.trimmed[home] != 0:
        first_neighbour = neighbours[0]
        if nearest[ELEMENT] < 0.0:  # the search has found it on its own face, a third of the time
            _add_normal_at(tables, home, nearest, total, h)
            first_neighbour += 1
        for k in range(first_neighbour, neighbours[1]):
            if is_listed(nearby, n_nearby, grid.adjacent[k]):
                _add_face(tables, grid.adjacent[k], place, nearest, total, h)
        return
    n, list_e = _add_elements(tables, foot, -1, total, h)
    for k in range(neighbours[0] + 1, neighbours[1]):
        is_counted = not (grid.loose[k] and is_listed(nearby, n_nearby, grid.adjacent[k]))
        for i in range(n):
            is_counted = is_counted or elements.table[list_e[i]]["patch"] == grid.adjacent[k]
        if not is_counted:
            _add_face(tables, grid.adjacent[k], place, nearest, total, h)


@inner(linked=False)
def side_of_most_frontal(tables, home, place, nearest, h):
    """Return the height (length) of a point over the face that it sees most frontally.

    It is positive on the free side; callers use its sign. `place` is (point, distance of its foot
    on an edge of the element `home`), `nearest` is work. Where the faces at an edge do not fit, a
    face that reaches past the other is seen from behind. Of several faces that are seen frontally
    the nearest counts: beyond the end of an edge may be a face that has no part in that edge. Zero
    where no face is found.
    """
    point, distance = place
    edge_tolerance = tables.elements.table[home]["edge_tolerance"]
    limit = distance * DISTANCE_MARGIN + edge_tolerance + 2.0 * MIN_GAIN * tables.scale[1]
    patch = tables.elements.table[home]["patch"]
    neighbours = tables.grid.patches[patch]["adjacent"]
    nearby = stack_int64(MAX_PATCHES)
    n_nearby = patches_near(tables, point, limit, nearby)
    best_cosine = best_square = 0.0
    side = 0.0
    for k in range(neighbours[0], neighbours[1]):
        other = tables.grid.adjacent[k]
        if not is_listed(nearby, n_nearby, other):
            continue
        if not math.isfinite(closest(tables, point, on_patch(other), limit, nearest, h)):
            continue
        e, s, t = surface_foot(tables, nearest, h)
        n = normal_at(tables.elements, e, s, t, h)
        origin = tables.elements.table[e]["origin"]
        square = height = 0.0
        for c in range(3):
            r = point[c] - origin[c] - h[c, 0]
            square += r * r
            height += r * n[c]
        cosine = min(abs(height) / math.sqrt(square), FRONTAL) if square > 0.0 else 0.0
        if cosine > best_cosine or (cosine == best_cosine == FRONTAL and square < best_square):
            best_cosine = cosine
            best_square = square
            side = height
    return side
