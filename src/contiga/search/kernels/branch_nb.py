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

The curvatures are rigorous bounds (`bend_nb`, `pole_nb`), here those kept of the surroundings of
every foot (`ring_nb`). What they do not prove is left to `follow_nb`.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.element_nb import locate
from contiga.geometry.kernels.trim_nb import box_state
from contiga.num.codes import IN, OK
from contiga.num.jit import inlined, inner, kernel
from contiga.search.kernels.ring_nb import part_of

WIDER = 1.1
"""The ball is this many times as large as what has to be in it."""
FOLLOW = 1
"""Flag of rows to be followed part by part."""


@inner(error_model="numpy")
def holds(curvature, m, far, slip, r):
    """Whether μ > 0 and μ r > t; curvature = (κ_i, κ_o), m = m_1 for P(0) and P(1)."""
    k = max(curvature[0], curvature[1])
    change = k * r * (slip + 0.5 * (1.0 + k * (far + r)) * r)
    high = max(m[0], m[1], 0.0) + change
    low = min(m[0], m[1], 0.0) - change
    least = 1.0 - max(curvature[0] * high, -curvature[1] * low)
    return least > 0.0 and least * r > slip


@inner(error_model="numpy")
def is_whole(tables, patch, foot, far_u, far_v):
    """Whether nothing is trimmed away from the box around the foot (u, v) of a patch."""
    if tables.trims.trimmed[patch] == 0:
        return True
    u, v = foot
    domain = tables.trims.domain[patch]
    # Nor where the box has no bound.
    if not (far_u <= domain[1] - domain[0] and far_v <= domain[3] - domain[2]):
        return False
    return box_state(tables.trims, patch, u - far_u, u + far_u, v - far_v, v + far_v) == IN


@inner(error_model="numpy")
def _by_pole(ring, box, u, v, u0, v0):
    """Length of the way from (u0, v0) to (u, v) by the pole, at most."""
    side = ring["pole"]
    edge = box[side]
    if side < 2:
        return (abs(u - edge) + abs(u0 - edge)) * ring["speed"][0]
    return (abs(v - edge) + abs(v0 - edge)) * ring["speed"][1]


@inner(error_model="numpy")
def by_ring(ring, box, foot, start, seen, tolerance):
    """Radius of a ball that proves the start (u, v) of a foot (u, v) of one patch, or 0.

    `ring` holds the bounds kept around the foot, `box` is that of its element, `seen` is (m, far,
    slip). Trims are left to be looked at.
    """
    u, v = foot
    u0, v0 = start
    m, far, slip = seen
    block = ring["block"]
    if not (block[0] <= u0 <= block[1] and block[2] <= v0 <= block[3]):
        return 0.0
    way = abs(u0 - u) * ring["speed"][0] + abs(v0 - v) * ring["speed"][1]
    if ring["pole"] >= 0:
        way = min(way, _by_pole(ring, box, u, v, u0, v0))
    inner = ring["curvature"][0]
    outer = ring["curvature"][1]
    least = 1.0 - max(inner * max(m[0], m[1], 0.0), -outer * min(m[0], m[1], 0.0))
    if not least > 0.0:
        return 0.0
    r = WIDER * max(way + tolerance, slip / least)
    if not (r <= ring["room"] and holds((inner, outer), m, far, slip, r)):
        return 0.0
    ends = ring["ends"]
    width_u, width_v = ring["width"][0], ring["width"][1]
    if (
        (ends[0] and not (u - box[0]) * width_u > r)
        or (ends[1] and not (box[1] - u) * width_u > r)
        or (ends[2] and not (v - box[2]) * width_v > r)
        or (ends[3] and not (box[3] - v) * width_v > r)
    ):
        return 0.0
    return r


@inlined()
def seen_from(foot, n, a, b, tolerance):
    """(m for P(0), m for P(1)), the larger distance, and t, of a foot with normal n and a motion
    from a to b."""
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
    return (m0, m1), math.sqrt(max(first, second)), slip


@inlined()
def kept_ball(tables, taken, patch, foot, start, seen):
    """Radius of a ball that proves a foot (u, v) of a patch by the bounds kept around it, or 0.

    `taken` is (grid, table of elements, rings) out of `tables`: where many feet are asked for they
    are taken out once. `start` and `seen` as in `by_ring`.
    """
    grid, table, rings = taken
    e, s, t = locate(grid, patch, foot[0], foot[1])
    ring = rings[e, part_of(s, t)]
    r = by_ring(ring, table[e]["box"], foot, start, seen, tables.scale[1])
    if r > 0.0 and tables.trims.trimmed[patch] != 0:
        width = ring["width"]
        r = r if is_whole(tables, patch, foot, r / width[0], r / width[1]) else 0.0
    return r


@kernel(error_model="numpy")
def certify_rows(tables, points, before, starts, results, start, stop):
    """Certify feet start … stop by the bounds kept around them.

    `results` is (projection, flags). A row is flagged FOLLOW where that is not enough.
    """
    patch, uv = starts
    out, back = results
    # Taken out of their tuples once: to hand those on costs more than the test.
    table = tables.elements.table
    rings = tables.rings
    grid = tables.grid
    tolerance = tables.scale[1]
    point, normal, foot_uv = out.point, out.normal, out.uv
    for k in range(start, stop):
        back[k] = 0
        a = (before[k, 0], before[k, 1], before[k, 2])
        b = (points[k, 0], points[k, 1], points[k, 2])
        if patch[k] < 0 or not math.isfinite(a[0] + a[1] + a[2] + b[0] + b[1] + b[2]):
            continue
        back[k] = FOLLOW
        # A foot on a kink or an end is refused by its surroundings; one on a pole may not be.
        if out.status[k] != OK or out.patch[k] != patch[k]:
            continue
        x = (point[k, 0], point[k, 1], point[k, 2])
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        seen = seen_from(x, n, a, b, tolerance)
        foot = (foot_uv[k, 0], foot_uv[k, 1])
        r = kept_ball(tables, (grid, table, rings), patch[k], foot, (uv[k, 0], uv[k, 1]), seen)
        if r > 0.0:
            back[k] = 0
            out.certified[k] = 1
