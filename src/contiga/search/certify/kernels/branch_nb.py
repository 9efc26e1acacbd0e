"""The certificate of a tracked foot: it is on the same branch as its start.

A point moves straight from P(0) to P(1); x_0 and x_1 are stationary points of f_0 and f_1, where
f_τ(x) = |x − P(τ)|²/2 on the surface. With w = P(τ) − x, normal N and m = N·w, along a geodesic

    f'' = 1 − κ m,        κ its normal curvature there (zero at a focal point of the surface).

Let B be the ball of all x whose distance to x_1 within the surface is no longer than r, κ_i and κ_o
the largest normal curvatures in B towards N and away from it, κ_m the larger, and t the length of
the tangential part of P(1) − P(0) at x_1. The values at x_1 bound m in B: |w| ≤ |w_1| + r, hence
the tangential part of w is at most t + c r, c = 1 + κ_m (|w_1| + r), hence

    |m − m_1| ≤ κ_m r (t + c r/2),    m_1 between its values for P(0) and P(1).

Let μ = 1 − max(κ_i m, −κ_o m) over these m. **If μ > 0, μ r > t, x_0 ∈ B and B has no border and no
kink in it, x_0 and x_1 are joined by one branch**: at x_1 the slope of f_τ is (1 − τ) t at most,
so along every geodesic from there f_τ rises beyond (1 − τ) t/μ < r, and no stationary point of any
f_τ is nearer to the rim of B. In B all of them are nondegenerate minima, and so their branches run
over all τ and neither end nor meet. At τ = 1 there is one of them, x_1; so there is one at τ = 0,
x_0. The proof uses first and second derivatives only: knot lines where the curvature jumps, seams
and smooth joints of patches need no special treatment.

The curvatures are rigorous bounds (`bend_nb`, `pole_nb`) over the neighbourhood of every foot
(`neighbourhood_nb`). Feet without this proof count as unproved: next to creases, edges and borders,
close to focal points, and after long motions.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import IN, OK, SMOOTH
from contiga.elements.kernels.element_nb import locate
from contiga.geometry.kernels.trim_nb import box_state
from contiga.jit import inlined, inner, kernel
from contiga.search.certify.certify_records import Motion
from contiga.search.certify.kernels.part_nb import N_PARTS, part_of

BALL_MARGIN = 1.1
"""Ratio of the radius of the ball to the distance that it has to contain."""


@inlined()
def proof_holds(curvature, motion, r):
    """Return whether μ > 0 and μ r > t; curvature = (κ_i, κ_o), the motion is `Motion`."""
    m, distance, slip = motion.heights, motion.distance, motion.slip
    k = max(curvature[0], curvature[1])
    change = k * r * (slip + 0.5 * (1.0 + k * (distance + r)) * r)
    high = max(m[0], m[1], 0.0) + change
    low = min(m[0], m[1], 0.0) - change
    mu = 1.0 - max(curvature[0] * high, -curvature[1] * low)
    return (mu > 0.0) & (mu * r > slip)


@inlined()
def ball_radius(curvature, room, margin, path, motion, tolerance):
    """Return the radius of a ball about a foot that certifies a start in the ball; 0 if unproved.

    `path` bounds the distance of the start from the foot within the surface. One radius is tried:
    `BALL_MARGIN` times the least that may do. `curvature` = (κ_i, κ_o) holds in a neighbourhood
    that no path shorter than `room` leaves, `margin` is the distance to a border or a kink, the
    motion is `Motion`, `tolerance` is a length. No branches, so that lanes can use it.
    """
    m, slip = motion.heights, motion.slip
    inner, outer = curvature
    mu = 1.0 - max(inner * max(m[0], m[1], 0.0), -outer * min(m[0], m[1], 0.0))
    r = BALL_MARGIN * max(path + tolerance, slip / mu)
    is_proved = (mu > 0.0) & (r <= room) & (margin > r) & proof_holds(curvature, motion, r)
    return r if is_proved else 0.0


@inner(error_model="numpy")
def is_untrimmed(tables, patch, foot, half_u, half_v):
    """Return whether a box around the foot (u, v) of a patch is proved to be untrimmed.

    False proves nothing: of a trimmed patch, boxes are refused that a trimming curve may touch, or
    with a half side longer than the domain.
    """
    if tables.trims.trimmed[patch] == 0:
        return True
    u, v = foot
    domain = tables.trims.domain[patch]
    # Unbounded boxes are refused, too.
    if not (half_u <= domain[1] - domain[0] and half_v <= domain[3] - domain[2]):
        return False
    return box_state(tables.trims, patch, u - half_u, u + half_u, v - half_v, v + half_v) == IN


@inner(error_model="numpy")
def path_within(neighbourhood, box, foot, start):
    """Return an upper bound of the path from a foot (u, v) to a start (u, v) in its patch.

    The shorter of the straight one and, near a pole, the one over it; infinite if the start is
    outside the neighbourhood's block. `box` is that of the foot's element.
    """
    u, v = foot
    u0, v0 = start
    block = neighbourhood["block"]
    if not (block[0] <= u0 <= block[1] and block[2] <= v0 <= block[3]):
        return math.inf
    path = abs(u0 - u) * neighbourhood["speed"][0] + abs(v0 - v) * neighbourhood["speed"][1]
    side = neighbourhood["pole"]
    if side >= 0:  # or over the pole
        edge, axis = box[side], 0 if side < 2 else 1
        off = abs(u - edge) + abs(u0 - edge) if axis == 0 else abs(v - edge) + abs(v0 - edge)
        path = min(path, off * neighbourhood["speed"][axis])
    return path


@inner(error_model="numpy")
def _parts_from_side(side, s, t):
    """Return the number of parts between (s, t) and a side, and the index of the part along it."""
    part = part_of(s, t)
    i, j = part // N_PARTS, part % N_PARTS
    off, along = (i, j) if side < 2 else (j, i)
    return (off if side & 1 == 0 else N_PARTS - 1 - off), along


@inner(error_model="numpy")
def _path_to_side(row, speed, side, s, t):
    """Return an upper bound of the straight path from (s, t) to a side of its element `row`."""
    axis = 0 if side < 2 else 1
    off = 0.5 + (s if side < 2 else t) * (1.0 if side & 1 == 0 else -1.0)
    return off * (row["box"][2 * axis + 1] - row["box"][2 * axis]) * speed[axis]


@inner(error_model="numpy")
def _speeds_towards(neighbourhoods, n, place, sides):
    """Return bounds of |S_u|, |S_v| in element n, from the part at place = (s, t) to two sides.

    They hold over the rectangle of parts that reaches both sides, which may be the same.
    """
    home = part_of(place[0], place[1])
    i, j = home // N_PARTS, home % N_PARTS
    side_a, other = sides
    first_i = 0 if side_a == 0 or other == 0 else i
    last_i = N_PARTS - 1 if side_a == 1 or other == 1 else i
    first_j = 0 if side_a == 2 or other == 2 else j
    last_j = N_PARTS - 1 if side_a == 3 or other == 3 else j
    speed_s, speed_t = 0.0, 0.0
    for a in range(first_i, last_i + 1):
        for b in range(first_j, last_j + 1):
            speed = neighbourhoods[n, a * N_PARTS + b]["speed"]
            speed_s, speed_t = max(speed_s, speed[0]), max(speed_t, speed[1])
    return speed_s, speed_t


@inner(linked=False, error_model="numpy")
def path_across_side(table, neighbourhoods, foot, start):
    """Return an upper bound of the path from a foot to a start across a smooth side.

    The path runs along the side to the place of the start, and across it: elements are joined point
    by point, with the same parameter along the side, or the reversed one. If no such path reaches
    the start within the neighbourhood, one around a corner is tried. Infinite if that does not,
    either, or a pole is near. `foot` and `start` are (element, s, t).
    """
    e, s, t = foot
    n, s0, t0 = start
    element, other = table[e], table[n]
    neighbourhood, neighbourhood0 = (
        neighbourhoods[e, part_of(s, t)],
        neighbourhoods[n, part_of(s0, t0)],
    )
    path = math.inf
    if neighbourhood["pole"] >= 0 or neighbourhood0["pole"] >= 0:
        return path
    for side in range(4):
        if element["neighbour"][side] != n or element["kind"][side] != SMOOTH:
            continue
        side_there = element["neighbour_side"][side]
        _, k = _parts_from_side(side, s, t)
        off0, k0 = _parts_from_side(side_there, s0, t0)
        x, x0 = (t if side < 2 else s), (t0 if side_there < 2 else s0)
        if element["flip"][side] == 1:
            k0 = N_PARTS - 1 - k0
            x0 = -x0
        if off0 >= neighbourhood["reach"][side] or abs(k - k0) > 1:
            continue
        axis = 1 if side < 2 else 0
        shift = abs(x - x0) * (element["box"][2 * axis + 1] - element["box"][2 * axis])
        speed = (neighbourhood["speed"][0], neighbourhood["speed"][1])
        speeds = _speeds_towards(neighbourhoods, n, (s0, t0), (side_there, side_there))
        over = _path_to_side(element, speed, side, s, t) + _path_to_side(
            other, speeds, side_there, s0, t0
        )
        path = min(path, shift * neighbourhood["speed"][axis] + over + element["width"][side])
    return path if path < math.inf else _path_around_corner(table, neighbourhoods, foot, start)


@inner(error_model="numpy")
def _path_around_corner(table, neighbourhoods, foot, start):
    """Return an upper bound of the path over a corner where four elements meet.

    The path crosses two smooth sides, each by its straight path; infinite if there is none.
    """
    e, s, t = foot
    n, s0, t0 = start
    element, other = table[e], table[n]
    neighbourhood = neighbourhoods[e, part_of(s, t)]
    path = math.inf
    for pair in range(4):
        side, adjacent = pair & 1, 2 + (pair >> 1)
        is_smooth = element["kind"][side] == SMOOTH and element["kind"][adjacent] == SMOOTH
        if (
            not is_smooth
            or neighbourhood["reach"][side] == 0
            or neighbourhood["reach"][adjacent] == 0
        ):
            continue
        between, first = table[element["neighbour"][side]], element["neighbour_side"][side]
        on = (2 if first < 2 else 0) + ((adjacent & 1) ^ element["flip"][side])
        if between["kind"][on] != SMOOTH or between["neighbour"][on] != n:
            continue
        side_there = between["neighbour_side"][on]
        side_back = (2 if side_there < 2 else 0) + ((first & 1) ^ between["flip"][on])
        off, _ = _parts_from_side(side_back, s0, t0)
        off_beside, _ = _parts_from_side(side_there, s0, t0)
        if off >= neighbourhood["reach"][side] or off_beside >= neighbourhood["reach"][adjacent]:
            continue
        speed = (neighbourhood["speed"][0], neighbourhood["speed"][1])
        speeds = _speeds_towards(neighbourhoods, n, (s0, t0), (side_there, side_back))
        to = _path_to_side(element, speed, side, s, t) + _path_to_side(
            element, speed, adjacent, s, t
        )
        on_from = _path_to_side(other, speeds, side_there, s0, t0)
        on_from += _path_to_side(other, speeds, side_back, s0, t0)
        path = min(path, to + on_from + element["width"][side] + between["width"][on])
    return path


@inner(error_model="numpy")
def ball_by_neighbourhood(neighbourhood, box, foot, path, motion, tolerance):
    """Return the `ball_radius` about a foot (u, v) by its neighbourhood; 0 if unproved.

    `box` is that of the foot's element, `path` as there, or infinite for none. Trims are not
    tested.
    """
    if path == math.inf:
        return 0.0
    u, v = foot
    ends = neighbourhood["ends"]
    width_u, width_v = neighbourhood["width"][0], neighbourhood["width"][1]
    margin = math.inf
    if ends[0]:
        margin = min(margin, (u - box[0]) * width_u)
    if ends[1]:
        margin = min(margin, (box[1] - u) * width_u)
    if ends[2]:
        margin = min(margin, (v - box[2]) * width_v)
    if ends[3]:
        margin = min(margin, (box[3] - v) * width_v)
    curvature = (neighbourhood["curvature"][0], neighbourhood["curvature"][1])
    return ball_radius(curvature, neighbourhood["room"], margin, path, motion, tolerance)


@inlined()
def motion_from(foot, n, a, b, tolerance):
    """Return the motion from a to b as a `Motion` relative to a foot with normal n.

    `slip` includes its rounding and four tolerances of the foot.
    """
    x, y, z = a[0] - foot[0], a[1] - foot[1], a[2] - foot[2]
    first = x * x + y * y + z * z
    m0 = x * n[0] + y * n[1] + z * n[2]
    x, y, z = b[0] - foot[0], b[1] - foot[1], b[2] - foot[2]
    second = x * x + y * y + z * z
    m1 = x * n[0] + y * n[1] + z * n[2]
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    step2 = x * x + y * y + z * z
    normal_step = x * n[0] + y * n[1] + z * n[2]
    # The difference of the squares is rounded by 1e-16 of the larger.
    slip = math.sqrt(max(step2 - normal_step * normal_step, 0.0) + 1e-15 * step2) + 4.0 * tolerance
    return Motion((m0, m1), math.sqrt(max(first, second)), slip)


@inner(error_model="numpy")
def certified_ball(tables, patches, foot, start, motion):
    """Return the radius of the ball in which the neighbourhood certifies the foot (u, v), or 0.

    `patches` are the patches of the start and of the foot, `start` is the (u, v) of the start,
    `motion` is relative to the foot. If the patch of either is trimmed, both have to be on one
    patch, and the ball has to be clear of its trims.
    """
    table, neighbourhoods, trimmed = (
        tables.elements.table,
        tables.neighbourhoods,
        tables.trims.trimmed,
    )
    before, patch = patches
    e, s, t = locate(tables.grid, patch, foot[0], foot[1])
    neighbourhood = neighbourhoods[e, part_of(s, t)]
    box = table[e]["box"]
    path = math.inf
    if patch == before:
        path = path_within(neighbourhood, box, foot, start)
    if path == math.inf and trimmed[before] == 0 and trimmed[patch] == 0:
        last = locate(tables.grid, before, start[0], start[1])
        path = path_across_side(table, neighbourhoods, (e, s, t), last)
    r = ball_by_neighbourhood(neighbourhood, box, foot, path, motion, tables.scale[1])
    if r > 0.0 and trimmed[patch] != 0:
        width = neighbourhood["width"]
        r = r if is_untrimmed(tables, patch, foot, r / width[0], r / width[1]) else 0.0
    return r


@kernel(error_model="numpy")
def certify_rows(tables, points, pending, m, out):
    """Certify the feet of the first m rows `pending` (`PendingRows`) by their neighbourhoods.

    `points` (n, 3) are the present points. Sets `out.certified` of proved rows to 1 and changes
    nothing else; rows without a start, whose points are not finite, or whose status is not OK are
    skipped.
    """
    rows, before, patch, uv = pending.rows, pending.before, pending.patch, pending.uv
    for j in range(m):
        k = rows[j]
        a = (before[j, 0], before[j, 1], before[j, 2])
        b = (points[k, 0], points[k, 1], points[k, 2])
        if patch[j] < 0 or not math.isfinite(a[0] + a[1] + a[2] + b[0] + b[1] + b[2]):
            continue
        # The neighbourhood refuses a foot on a kink or a border; it may accept one on a pole.
        if out.status[k] != OK:
            continue
        x = (out.point[k, 0], out.point[k, 1], out.point[k, 2])
        n = (out.normal[k, 0], out.normal[k, 1], out.normal[k, 2])
        motion = motion_from(x, n, a, b, tables.scale[1])
        patches, start = (patch[j], out.patch[k]), (uv[j, 0], uv[j, 1])
        foot = (out.uv[k, 0], out.uv[k, 1])
        if certified_ball(tables, patches, foot, start, motion) > 0.0:
            out.certified[k] = 1
