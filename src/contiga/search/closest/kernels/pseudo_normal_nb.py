"""The sum of the normals around a kink, weighted by angle: it decides the side of a point there.

Every face at an edge or vertex counts with the angle it takes there (Baerentzen & Aanaes 2005,
doi 10.1109/TVCG.2005.49): half a turn inside an edge, the angle between its two borders at a
corner.
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
from contiga.search.closest.kernels.global_among_nb import on_patch
from contiga.search.closest.kernels.global_nb import PRUNE, SEEN, closest
from contiga.search.hierarchy.kernels.curve_nb import (
    ELEMENT,
    S,
    curve_point,
    piece_parameters,
    surface_foot,
)
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.hierarchy.kernels.tree_nb import box_distance2

JOIN = 1e-7
"""Faces closer than this share of the body's size at a common edge meet, however narrow it is."""
AT_END = 1e-6
"""A foot this close (share of a trimming piece) to its end may be a corner."""
LOOK = 1e-5
"""How far from a corner, as a share of the patch, its inside is told from its outside."""
POLE_ARCS = 4
NEAR = 32
"""Patches listed near one point."""
CORNER = 1e-7
"""Places of a patch this close (share of it) to a corner of its loops are the corner: where faces
are cut along splines, their corners miss each other by more than rounding, or have a tiny edge."""
MAX_TINY_EDGES = 4
"""Tiny edges in a row that are passed over."""
SNAP = 1e-7
SQUARELY = 0.99
"""Cosine of the angle to its normal from which a point sees a face squarely."""


@inner()
def _angle(ax, ay, az, bx, by, bz):
    cross = math.sqrt(
        (ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2
    )
    return math.atan2(cross, ax * bx + ay * by + az * bz)


@inner()
def _add_elements(tables, foot, only, total, h):
    """Add the normals of the elements around a foot, of patch `only` or (−1) of all.

    Only elements that the trims leave count. Returns their number and their list.
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
        if pole >= 0:  # along the collapsed side, each normal with its share of the angle
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
    """Return whether two places (u, v) of a patch are one: see `CORNER`."""
    domain = trims.domain[patch]
    u = abs(q[0] - p[0])
    v = abs(q[1] - p[1])
    return u <= CORNER * (domain[1] - domain[0]) and v <= CORNER * (domain[3] - domain[2])


@inner()
def _is_short(trims, piece):
    """Return whether a piece is a point of its patch."""
    ends = trims.piece_ends[piece]
    return _is_point(trims, trims.piece_patch[piece], (ends[0], ends[1]), (ends[2], ends[3]))


@inner()
def _joined_piece(trims, piece, end):
    """The piece of the same loop that goes on from the end (0 or 1) of a piece, or −1.

    Pieces that are points are passed over.
    """
    patch = trims.piece_patch[piece]
    for _ in range(MAX_TINY_EDGES):
        at = trims.piece_ends[piece]
        x = at[2 * end]
        y = at[2 * end + 1]
        joined = -1
        for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
            other = trims.piece_ends[k]
            if k != piece and other[2 - 2 * end] == x and other[3 - 2 * end] == y:
                joined = k
                break
        if joined < 0 or not _is_short(trims, joined):
            return joined
        piece = joined
    return -1


@inner()
def _face_angle(tables, nearest, h):
    """Angle a trimmed face takes at its border point `nearest`: π but at the corners of a loop."""
    piece = int(-1 - nearest[ELEMENT])
    t = nearest[S]
    trims = tables.trims
    end = 1 if t > 0.5 else 0
    if _is_short(trims, piece):
        piece = _joined_piece(trims, piece, 0)
        end = 1
        if piece < 0:
            return math.pi
    elif AT_END < t < 1.0 - AT_END:
        return math.pi
    other = _joined_piece(trims, piece, end)
    if other < 0:
        return math.pi
    d = scratch(3, 3)
    c = scratch(3, 3)
    sign = -1.0 if end == 1 else 1.0  # both tangents away from the corner
    curve_point(tables.elements, tables.grid, trims, piece, float(end), h, d)
    ax, ay, az = sign * d[1, 0], sign * d[1, 1], sign * d[1, 2]
    curve_point(tables.elements, tables.grid, trims, other, float(1 - end), h, d)
    bx, by, bz = -sign * d[1, 0], -sign * d[1, 1], -sign * d[1, 2]
    angle = _angle(ax, ay, az, bx, by, bz)
    domain = tables.trims.domain[trims.piece_patch[piece]]
    wide = domain[1] - domain[0]
    high = domain[3] - domain[2]
    piece_parameters(trims, piece, float(end), c)
    u, v = c[0, 0], c[0, 1]
    au, av = sign * c[1, 0] / wide, sign * c[1, 1] / high
    piece_parameters(trims, other, float(1 - end), c)
    bu, bv = -sign * c[1, 0] / wide, -sign * c[1, 1] / high
    a = math.hypot(au, av)
    b = math.hypot(bu, bv)
    if a == 0.0 or b == 0.0:
        return math.pi
    mu, mv = au / a + bu / b, av / a + bv / b
    m = math.hypot(mu, mv)
    if m < 1e-6:
        return math.pi
    u += LOOK * mu / m * wide
    v += LOOK * mv / m * high
    inside = point_in_trim(trims, trims.piece_patch[piece], u, v) == 1
    return angle if inside else 2.0 * math.pi - angle


@inner()
def _snapped(x):
    if x < SNAP - 0.5:
        return -0.5
    return 0.5 if x > 0.5 - SNAP else x


@inner()
def joint_reach(tables, e):
    """Return how far from a foot at an edge of element `e` the faces that meet there may be."""
    return max(tables.elements.table[e]["edge_tolerance"], JOIN * tables.scale[0])


@inner()
def patches_near(tables, point, reach, near):
    """Patches that may come closer to a point than `reach`, into near[NEAR]; how many they are.

    −1: more than fit. A face of many holes has an edge with a hundred others: to search each of
    them for what is near takes longer than to ask the hierarchy once.
    """
    tree = tables.tree
    leaves = tables.leaves
    x, y, z = point
    nodes = stack_int64(128)
    nodes[0] = 0
    top = 1 if leaves.shape[0] > 0 else 0
    n = 0
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
            if not is_listed(near, n, patch):
                if n == NEAR:
                    return -1
                near[n] = patch
                n += 1
    return n


@inner()
def is_listed(near, n, patch):
    """Return whether a patch is among the first n of `near`; any may be where n is −1."""
    for i in range(n):
        if near[i] == patch:
            return True
    return n < 0


@inner()
def _add_face(tables, patch, place, nearest, total, h):
    """Add the normal of the face `patch` if it passes through `place` = (point, how near)."""
    if math.isfinite(closest(tables, place[0], on_patch(patch), place[1], nearest, h)):
        _add_found(tables, patch, nearest, total, h)


@inner(linked=False)
def _add_found(tables, patch, nearest, total, h):
    """Add the normal of the face `patch` at the place `nearest` of it, on a kink."""
    e, s, t = surface_foot(tables, nearest, h)
    # At a corner of its loops a face counts with the angle that it takes there, not as a whole.
    trims, uv = tables.trims, parameters(tables.elements, e, s, t)
    for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        ends = trims.piece_ends[k]
        if _is_point(trims, patch, uv, (ends[0], ends[1])):
            nearest[ELEMENT] = float(-1 - k)
            nearest[S] = 0.0
            break
    if nearest[ELEMENT] >= 0:
        at = (e, _snapped(s), _snapped(t))
        # The side of the element may lie outside a trimmed face that comes as near to it as a disc
        # does to its square.
        if not in_face(tables.elements, tables.trims, *at):
            at = (e, s, t)
        _add_elements(tables, at, patch, total, h)
        return
    weight = _face_angle(tables, nearest, h)
    x, y, z = normal_at(tables.elements, e, s, t, h)
    total[0] += weight * x
    total[1] += weight * y
    total[2] += weight * z


@inner(linked=False)
def pseudo_normal(tables, foot, nearest, total, h):
    """Angle-weighted sum of the normals of all faces at a foot on a kink, into total[3].

    `nearest` is the foot if it is on a trimming piece and was found by a search, and is written
    over; its element is 0 or more where that is not so.
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
    span = grid.patches[home]["adjacent"]
    near = stack_int64(NEAR)
    listed = patches_near(tables, point, place[1], near)
    if tables.trims.trimmed[home] != 0:
        first = span[0]
        if nearest[ELEMENT] < 0.0:  # on its own face it has been found: a third of the time
            _add_found(tables, home, nearest, total, h)
            first += 1
        for k in range(first, span[1]):
            if is_listed(near, listed, grid.adjacent[k]):
                _add_face(tables, grid.adjacent[k], place, nearest, total, h)
        return
    n, list_e = _add_elements(tables, foot, -1, total, h)
    for k in range(span[0] + 1, span[1]):
        known = not (grid.loose[k] and is_listed(near, listed, grid.adjacent[k]))
        for i in range(n):
            known = known or elements.table[list_e[i]]["patch"] == grid.adjacent[k]
        if not known:
            _add_face(tables, grid.adjacent[k], place, nearest, total, h)


@inner(linked=False)
def side_of_squarest(tables, home, place, nearest, h):
    """Return on which side of the face that it sees most squarely a point lies: positive is free.

    `place` is (point, how far its foot on an edge of the patch `home` is), `nearest` is work. Where
    the faces at an edge do not fit, one that reaches past the other is seen from behind. Of faces
    that are seen squarely the nearest counts: beyond the end of an edge may lie one that has no
    part in it. Zero where no face is found.
    """
    point, distance = place
    edge_tolerance = tables.elements.table[home]["edge_tolerance"]
    limit = distance * SEEN + edge_tolerance + 2.0 * PRUNE * tables.scale[1]
    patch = tables.elements.table[home]["patch"]
    span = tables.grid.patches[patch]["adjacent"]
    near = stack_int64(NEAR)
    listed = patches_near(tables, point, limit, near)
    best = least = 0.0
    side = 0.0
    for k in range(span[0], span[1]):
        other = tables.grid.adjacent[k]
        if not is_listed(near, listed, other):
            continue
        if not math.isfinite(closest(tables, point, on_patch(other), limit, nearest, h)):
            continue
        e, s, t = surface_foot(tables, nearest, h)
        n = normal_at(tables.elements, e, s, t, h)
        origin = tables.elements.table[e]["origin"]
        square = along = 0.0
        for c in range(3):
            r = point[c] - origin[c] - h[c, 0]
            square += r * r
            along += r * n[c]
        cosine = min(abs(along) / math.sqrt(square), SQUARELY) if square > 0.0 else 0.0
        if cosine > best or (cosine == best == SQUARELY and square < least):
            best = cosine
            least = square
            side = along
    return side
