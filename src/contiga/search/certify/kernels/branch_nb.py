"""The certificate of a tracked foot: that it is on the branch its start was on.

A point moves straight from P(0) to P(1); x_0 and x_1 are stationary points of f_0 and f_1, where
f_τ(x) = |x − P(τ)|²/2 on the surface. With w = P(τ) − x, normal N and m = N·w, along a geodesic

    f'' = 1 − κ m,        κ its normal curvature there (zero at a focal point of the surface).

Let B be the ball of all x whose way to x_1 in the surface is no longer than r, κ_i and κ_o the
largest normal curvatures in B towards N and away from it, κ_m the larger, and t the length of the
tangential part of P(1) − P(0) at x_1. What is known at x_1 bounds m in B: |w| ≤ |w_1| + r, hence
the tangential part of w is at most t + c r, c = 1 + κ_m (|w_1| + r), hence

    |m − m_1| ≤ κ_m r (t + c r/2),    m_1 between its values for P(0) and P(1).

Let μ = 1 − max(κ_i m, −κ_o m) over these m. **If μ > 0, μ r > t, x_0 ∈ B and B has no border and no
kink in it, x_0 and x_1 are joined by one branch**: at x_1 the slope of f_τ is (1 − τ) t at most,
so along every geodesic from there f_τ rises beyond (1 − τ) t/μ < r, and no stationary point of any
f_τ is nearer to the rim of B. In B all of them are nondegenerate minima, and so their branches run
over all τ and neither end nor meet. At τ = 1 there is one of them, x_1; so there is one at τ = 0,
x_0. Nothing but first and second derivatives has been used: knot lines where the curvature jumps,
seams and smooth joints of patches are nothing special.

The curvatures are rigorous bounds (`bend_nb`, `pole_nb`), those kept of the surroundings of every
foot (`neighbourhood_nb`). What they do not prove is counted as unproved: feet beside creases, edges
and borders, close to focal points, and those of long ways.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import IN, OK, SMOOTH
from contiga.elements.kernels.element_nb import locate
from contiga.geometry.kernels.trim_nb import box_state
from contiga.jit import inlined, inner, kernel
from contiga.search.certify.certify_records import Seen
from contiga.search.certify.kernels.part_nb import PARTS, part_of

WIDER = 1.1
"""The ball is this many times as large as what has to be in it."""


@inlined()
def holds(curvature, seen, r):
    """Return whether μ > 0 and μ r > t; curvature = (κ_i, κ_o), the motion is `Seen`."""
    m, far, slip = seen.heights, seen.far, seen.slip
    k = max(curvature[0], curvature[1])
    change = k * r * (slip + 0.5 * (1.0 + k * (far + r)) * r)
    high = max(m[0], m[1], 0.0) + change
    low = min(m[0], m[1], 0.0) - change
    least = 1.0 - max(curvature[0] * high, -curvature[1] * low)
    return (least > 0.0) & (least * r > slip)


@inlined()
def ball_radius(curvature, room, margin, way, seen, tolerance):
    """Radius of a ball about a foot that proves a start at the end of a `way`, or 0.

    `curvature` = (κ_i, κ_o) holds where no way of length `room` leads out, `margin` is the way to
    where the surface may end or bend, the motion is `Seen`. No branches: for lanes, too.
    """
    m, slip = seen.heights, seen.slip
    inner, outer = curvature
    least = 1.0 - max(inner * max(m[0], m[1], 0.0), -outer * min(m[0], m[1], 0.0))
    r = WIDER * max(way + tolerance, slip / least)
    good = (least > 0.0) & (r <= room) & (margin > r) & holds(curvature, seen, r)
    return r if good else 0.0


@inner(error_model="numpy")
def is_whole(tables, patch, foot, far_u, far_v):
    """Return whether nothing is trimmed away from the box around the foot (u, v) of a patch."""
    if tables.trims.trimmed[patch] == 0:
        return True
    u, v = foot
    domain = tables.trims.domain[patch]
    # Nor where the box has no bound.
    if not (far_u <= domain[1] - domain[0] and far_v <= domain[3] - domain[2]):
        return False
    return box_state(tables.trims, patch, u - far_u, u + far_u, v - far_v, v + far_v) == IN


@inner(error_model="numpy")
def way_within(neighbourhood, box, foot, start):
    """Length of a way from a foot (u, v) to a start (u, v) of its patch, at most; infinite where
    that is not in its surroundings."""
    u, v = foot
    u0, v0 = start
    block = neighbourhood["block"]
    if not (block[0] <= u0 <= block[1] and block[2] <= v0 <= block[3]):
        return math.inf
    way = abs(u0 - u) * neighbourhood["speed"][0] + abs(v0 - v) * neighbourhood["speed"][1]
    side = neighbourhood["pole"]
    if side >= 0:  # or by the pole
        edge, axis = box[side], 0 if side < 2 else 1
        off = abs(u - edge) + abs(u0 - edge) if axis == 0 else abs(v - edge) + abs(v0 - edge)
        way = min(way, off * neighbourhood["speed"][axis])
    return way


@inner(error_model="numpy")
def _part_along(side, s, t):
    """Parts that (s, t) is away from a side, and the one along it."""
    part = part_of(s, t)
    i, j = part // PARTS, part % PARTS
    off, along = (i, j) if side < 2 else (j, i)
    return (off if side & 1 == 0 else PARTS - 1 - off), along


@inner(error_model="numpy")
def _from_side(row, speed, side, s, t):
    """Length of the way from (s, t) straight to a side of its element `row`, at most."""
    axis = 0 if side < 2 else 1
    off = 0.5 + (s if side < 2 else t) * (1.0 if side & 1 == 0 else -1.0)
    return off * (row["box"][2 * axis + 1] - row["box"][2 * axis]) * speed[axis]


@inner(error_model="numpy")
def _speeds_to(neighbourhoods, n, place, sides):
    """Speeds (two) in the parts of element n from place = (s, t) to two of its sides, or to one."""
    home = part_of(place[0], place[1])
    i, j = home // PARTS, home % PARTS
    one, other = sides
    first_i = 0 if one == 0 or other == 0 else i
    last_i = PARTS - 1 if one == 1 or other == 1 else i
    first_j = 0 if one == 2 or other == 2 else j
    last_j = PARTS - 1 if one == 3 or other == 3 else j
    speed_s, speed_t = 0.0, 0.0
    for a in range(first_i, last_i + 1):
        for b in range(first_j, last_j + 1):
            speed = neighbourhoods[n, a * PARTS + b]["speed"]
            speed_s, speed_t = max(speed_s, speed[0]), max(speed_t, speed[1])
    return speed_s, speed_t


@inner(linked=False, error_model="numpy")
def way_beyond(table, neighbourhoods, foot, start):
    """Return an upper bound of the way from a foot to a start, over a smooth side.

    It goes along the side as far as the start stands, and over it: elements are joined point by
    point, with the same parameter along the side or that from the other end.
    """
    e, s, t = foot
    n, s0, t0 = start
    element, other = table[e], table[n]
    neighbourhood, neighbourhood0 = (
        neighbourhoods[e, part_of(s, t)],
        neighbourhoods[n, part_of(s0, t0)],
    )
    way = math.inf
    if neighbourhood["pole"] >= 0 or neighbourhood0["pole"] >= 0:
        return way
    for side in range(4):
        if element["neighbour"][side] != n or element["kind"][side] != SMOOTH:
            continue
        there = element["neighbour_side"][side]
        _, k = _part_along(side, s, t)
        off0, k0 = _part_along(there, s0, t0)
        x, x0 = (t if side < 2 else s), (t0 if there < 2 else s0)
        if element["flip"][side] == 1:
            k0 = PARTS - 1 - k0
            x0 = -x0
        if off0 >= neighbourhood["reach"][side] or abs(k - k0) > 1:
            continue
        axis = 1 if side < 2 else 0
        aside = abs(x - x0) * (element["box"][2 * axis + 1] - element["box"][2 * axis])
        speed = (neighbourhood["speed"][0], neighbourhood["speed"][1])
        speeds = _speeds_to(neighbourhoods, n, (s0, t0), (there, there))
        over = _from_side(element, speed, side, s, t) + _from_side(other, speeds, there, s0, t0)
        way = min(way, aside * neighbourhood["speed"][axis] + over + element["width"][side])
    return way if way < math.inf else _way_round(table, neighbourhoods, foot, start)


@inner(error_model="numpy")
def _way_round(table, neighbourhoods, foot, start):
    """Do the same over a corner where four elements meet, by way of that."""
    e, s, t = foot
    n, s0, t0 = start
    element, other = table[e], table[n]
    neighbourhood = neighbourhoods[e, part_of(s, t)]
    way = math.inf
    for pair in range(4):
        side, beside = pair & 1, 2 + (pair >> 1)
        smooth = element["kind"][side] == SMOOTH and element["kind"][beside] == SMOOTH
        if not smooth or neighbourhood["reach"][side] == 0 or neighbourhood["reach"][beside] == 0:
            continue
        between, first = table[element["neighbour"][side]], element["neighbour_side"][side]
        on = (2 if first < 2 else 0) + ((beside & 1) ^ element["flip"][side])
        if between["kind"][on] != SMOOTH or between["neighbour"][on] != n:
            continue
        there = between["neighbour_side"][on]
        back = (2 if there < 2 else 0) + ((first & 1) ^ between["flip"][on])
        off, _ = _part_along(back, s0, t0)
        off_beside, _ = _part_along(there, s0, t0)
        if off >= neighbourhood["reach"][side] or off_beside >= neighbourhood["reach"][beside]:
            continue
        speed = (neighbourhood["speed"][0], neighbourhood["speed"][1])
        speeds = _speeds_to(neighbourhoods, n, (s0, t0), (there, back))
        to = _from_side(element, speed, side, s, t) + _from_side(element, speed, beside, s, t)
        on_from = _from_side(other, speeds, there, s0, t0)
        on_from += _from_side(other, speeds, back, s0, t0)
        way = min(way, to + on_from + element["width"][side] + between["width"][on])
    return way


@inner(error_model="numpy")
def by_neighbourhood(neighbourhood, box, foot, way, seen, tolerance):
    """`ball_radius` about a foot (u, v) by the bounds kept around it, of an element in `box`.

    Trims are left to be looked at.
    """
    if way == math.inf:
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
    return ball_radius(curvature, neighbourhood["room"], margin, way, seen, tolerance)


@inlined()
def seen_from(foot, n, a, b, tolerance):
    """A motion from a to b as `Seen` from a foot with normal n."""
    x, y, z = a[0] - foot[0], a[1] - foot[1], a[2] - foot[2]
    first = x * x + y * y + z * z
    m0 = x * n[0] + y * n[1] + z * n[2]
    x, y, z = b[0] - foot[0], b[1] - foot[1], b[2] - foot[2]
    second = x * x + y * y + z * z
    m1 = x * n[0] + y * n[1] + z * n[2]
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    way = x * x + y * y + z * z
    along = x * n[0] + y * n[1] + z * n[2]
    # The difference of the squares is rounded by 1e-16 of the larger.
    slip = math.sqrt(max(way - along * along, 0.0) + 1e-15 * way) + 4.0 * tolerance
    return Seen((m0, m1), math.sqrt(max(first, second)), slip)


@inner(error_model="numpy")
def kept_ball(tables, patches, foot, start, seen):
    """Radius of a ball that proves a foot (u, v) by the bounds kept around it, or 0.

    `patches` are those of the start and of the foot, `start` is its (u, v), `seen` as in
    `by_neighbourhood`.
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
    way = math.inf
    if patch == before:
        way = way_within(neighbourhood, box, foot, start)
    if way == math.inf and trimmed[before] == 0 and trimmed[patch] == 0:
        last = locate(tables.grid, before, start[0], start[1])
        way = way_beyond(table, neighbourhoods, (e, s, t), last)
    r = by_neighbourhood(neighbourhood, box, foot, way, seen, tables.scale[1])
    if r > 0.0 and trimmed[patch] != 0:
        width = neighbourhood["width"]
        r = r if is_whole(tables, patch, foot, r / width[0], r / width[1]) else 0.0
    return r


@kernel(error_model="numpy")
def certify_rows(tables, points, left, m, out):
    """Certify the feet of the first m rows `left` (`Left`) by the bounds kept around them.

    `points` (n, 3) are where the points are now.
    """
    rows, before, patch, uv = left.rows, left.before, left.patch, left.uv
    for j in range(m):
        k = rows[j]
        a = (before[j, 0], before[j, 1], before[j, 2])
        b = (points[k, 0], points[k, 1], points[k, 2])
        if patch[j] < 0 or not math.isfinite(a[0] + a[1] + a[2] + b[0] + b[1] + b[2]):
            continue
        # A foot on a kink or an end is refused by its surroundings; one on a pole may not be.
        if out.status[k] != OK:
            continue
        x = (out.point[k, 0], out.point[k, 1], out.point[k, 2])
        n = (out.normal[k, 0], out.normal[k, 1], out.normal[k, 2])
        seen = seen_from(x, n, a, b, tables.scale[1])
        patches, start = (patch[j], out.patch[k]), (uv[j, 0], uv[j, 1])
        foot = (out.uv[k, 0], out.uv[k, 1])
        if kept_ball(tables, patches, foot, start, seen) > 0.0:
            out.certified[k] = 1
