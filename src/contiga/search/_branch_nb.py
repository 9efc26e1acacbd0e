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

The curvatures are rigorous bounds (`_bend_nb`, `_pole_nb`), here those kept of the surroundings of
every foot (`_ring_nb`). What they do not prove is left to `_follow_nb`.
"""

from __future__ import annotations

import math

from numba import njit

from contiga.geometry._trim_nb import box_state
from contiga.search._element_nb import locate, parameters
from contiga.search._ring_nb import part_of

OK, IN = 0, 1
WIDER = 1.1
"""The ball is this many times as large as what has to be in it."""
FOLLOW = 1
"""Flag of rows to be followed part by part."""


@njit(cache=True, error_model="numpy")
def holds(curvature, m, far, slip, r):
    """Whether μ > 0 and μ r > t; curvature = (κ_i, κ_o), m = m_1 for P(0) and P(1)."""
    k = max(curvature[0], curvature[1])
    change = k * r * (slip + 0.5 * (1.0 + k * (far + r)) * r)
    high = max(m[0], m[1], 0.0) + change
    low = min(m[0], m[1], 0.0) - change
    least = 1.0 - max(curvature[0] * high, -curvature[1] * low)
    return least > 0.0 and least * r > slip


@njit(cache=True, error_model="numpy")
def is_whole(tables, e, s, t, far_s, far_t):
    """Whether nothing is trimmed away from the box around (s, t) of element e."""
    patch = tables.elements.table[e]["patch"]
    if tables.trims.trimmed[patch] == 0:
        return True
    if not far_s + far_t < 2.0:  # nor where the box has no bound
        return False
    box = tables.elements.table[e]["box"]
    u, v = parameters(tables.elements, e, s, t)
    du = far_s * (box[1] - box[0])
    dv = far_t * (box[3] - box[2])
    return box_state(tables.trims, patch, u - du, u + du, v - dv, v + dv) == IN


@njit(cache=True, error_model="numpy")
def _by_pole(ring, s, t, s0, t0):
    """Length of the way from (s0, t0) to (s, t) by the pole, at most."""
    side = ring["pole"]
    edge = -0.5 if side & 1 == 0 else 0.5
    if side < 2:
        return (abs(s - edge) + abs(s0 - edge)) * ring["speed"][0]
    return (abs(t - edge) + abs(t0 - edge)) * ring["speed"][1]


@njit(cache=True, error_model="numpy")
def by_ring(tables, foot, start, m, far, slip):
    """Whether the bounds kept around `foot` = (e, s, t) prove the start (u, v) of its patch."""
    e, s, t = foot
    ring = tables.rings[e, part_of(s, t)]
    u, v = start
    block = ring["block"]
    if not (block[0] <= u <= block[1] and block[2] <= v <= block[3]):
        return False
    box = tables.elements.table[e]["box"]
    s0 = (u - box[0]) / (box[1] - box[0]) - 0.5
    t0 = (v - box[2]) / (box[3] - box[2]) - 0.5
    way = abs(s0 - s) * ring["speed"][0] + abs(t0 - t) * ring["speed"][1]
    if ring["pole"] >= 0:
        way = min(way, _by_pole(ring, s, t, s0, t0))
    in_, out = ring["curvature"][0], ring["curvature"][1]
    least = 1.0 - max(in_ * max(m[0], m[1], 0.0), -out * min(m[0], m[1], 0.0))
    if not least > 0.0:
        return False
    r = WIDER * max(way + tables.scale[1], slip / least)
    if not (r <= ring["room"] and holds((in_, out), m, far, slip, r)):
        return False
    ends = ring["ends"]
    width_s, width_t = ring["width"][0], ring["width"][1]
    if (
        (ends[0] and (s + 0.5) * width_s <= r)
        or (ends[1] and (0.5 - s) * width_s <= r)
        or (ends[2] and (t + 0.5) * width_t <= r)
        or (ends[3] and (0.5 - t) * width_t <= r)
    ):
        return False
    return is_whole(tables, e, s, t, r / width_s, r / width_t)


@njit(cache=True, error_model="numpy")
def seen_from(foot_point, normal, path, tolerance):
    """(m for P(0), m for P(1)), the larger distance, and t, of a foot and the motion `path`."""
    way2 = along = first = second = m0 = m1 = 0.0
    for c in range(3):
        w0 = path[0][c] - foot_point[c]
        w1 = path[1][c] - foot_point[c]
        m0 += w0 * normal[c]
        m1 += w1 * normal[c]
        first += w0 * w0
        second += w1 * w1
        way2 += (w1 - w0) ** 2
        along += (w1 - w0) * normal[c]
    # The difference of the squares is rounded by 1e-16 of the larger.
    slip = math.sqrt(max(way2 - along * along, 0.0) + 1e-15 * way2) + 4.0 * tolerance
    return (m0, m1), math.sqrt(max(first, second)), slip


@njit(cache=True, nogil=True, error_model="numpy")
def certify_rows(tables, points, before, starts, results, start, stop):
    """Certify feet start … stop by the bounds kept around them.

    `results` is (projection, flags). A row is flagged FOLLOW where that is not enough.
    """
    patch, uv = starts
    out, back = results
    for k in range(start, stop):
        back[k] = 0
        if patch[k] < 0 or not math.isfinite(before[k, 0] + before[k, 1] + before[k, 2]):
            continue
        # A foot on a kink or an end is refused by its surroundings; one on a pole may not be.
        if out.status[k] == OK and out.patch[k] == patch[k]:
            foot = locate(tables.grid, patch[k], out.uv[k, 0], out.uv[k, 1])
            m, far, slip = seen_from(
                out.point[k], out.normal[k], (before[k], points[k]), tables.scale[1]
            )
            if by_ring(tables, foot, (uv[k, 0], uv[k, 1]), m, far, slip):
                out.certified[k] = 1
                continue
        if math.isfinite(points[k, 0] + points[k, 1] + points[k, 2]):
            back[k] = FOLLOW
