"""The edge segment of an edge that runs through a cell of a face: which it is, where, how it bends.

A cell about a foot is cut by trimming pieces, or reaches the natural side of its patch. If all of
these are one connected stretch of one edge, it is an **edge segment**: the face ends there, on one
side of it, and nowhere else in the cell. Its pieces are kept as homogeneous Bernstein coefficients
over their stretches in the cell, in parameters (x, y) that run over [-1, 1]² there. Its first two
derivatives in space follow from those and from the bounds of the cell (`bend_nb`):

    C' = S_x x' + S_y y',    C'' = S_xx x'² + 2 S_xy x' y' + S_yy y'² + S_x x'' + S_y y'',

each a value and the largest departure from it.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.geometry.kernels.trim_nb import ON_CURVE, bernstein_at, parameter_at
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.certify.certify_records import EdgeSegment
from contiga.search.certify.kernels.bend_nb import length
from contiga.search.certify.kernels.rest_nb import D01, D02, D10, D11, D20

MOST = 4
"""Pieces of one edge segment."""
DEGREE = 16
AT_END = 1e-9
"""A stretch this close to the end of its piece (share of its parameter) reaches it."""
KINK = 1e-6
"""Largest sine of the angle between two pieces of a smooth edge segment, in parameters."""
STEPS = 8


@inner(error_model="numpy")
def segment_work():
    """An edge segment for `segment_in` to fill."""
    return EdgeSegment(np.empty((MOST, DEGREE, 3)), np.empty(MOST, np.int64))


@inner(error_model="numpy")
def _in_range(trims, piece, axis, low, high):
    """Where on a piece one coordinate lies between two values: (t0, t1), or (1, 0) nowhere."""
    ends = trims.piece_ends[piece]
    a = ends[axis]
    b = ends[2 + axis]
    if max(a, b) < low or min(a, b) > high:
        return 1.0, 0.0
    if min(a, b) >= low and max(a, b) <= high:
        return 0.0, 1.0
    coefs = trims.piece_coefs[piece]
    degree = trims.piece_degree[piece]
    first = 0.0
    last = 1.0
    if min(a, b) < low:
        t = parameter_at(coefs, degree, axis, low)
        if a < b:
            first = t
        else:
            last = t
    if max(a, b) > high:
        t = parameter_at(coefs, degree, axis, high)
        if a < b:
            last = t
        else:
            first = t
    return first, last


@inner(error_model="numpy")
def with_hair(trims, patch, cell):
    """A cell (u0, u1, v0, v1) of a patch, widened by more than the rounding of its pieces."""
    domain = trims.domain[patch]
    hair_u = 4.0 * ON_CURVE * max(domain[1] - domain[0], abs(domain[0]), abs(domain[1]))
    hair_v = 4.0 * ON_CURVE * max(domain[3] - domain[2], abs(domain[2]), abs(domain[3]))
    return cell[0] - hair_u, cell[1] + hair_u, cell[2] - hair_v, cell[3] + hair_v


@inner(error_model="numpy")
def through(trims, piece, cell):
    """Where on a piece it runs through a cell: (t0, t1), t0 > t1 where it does not."""
    ends = trims.piece_ends[piece]
    u0, u1, v0, v1 = cell
    if max(ends[0], ends[2]) < u0 or min(ends[0], ends[2]) > u1:
        return 1.0, 0.0
    if max(ends[1], ends[3]) < v0 or min(ends[1], ends[3]) > v1:
        return 1.0, 0.0
    a0, a1 = _in_range(trims, piece, 0, u0, u1)
    b0, b1 = _in_range(trims, piece, 1, v0, v1)
    return max(a0, b0), min(a1, b1)


@inner(linked=False, error_model="numpy")
def stretch(trims, piece, span, cell, coefs):
    """Coefficients of a piece over span = [t0, t1] into coefs, in parameters that run over
    [-1, 1]² in a cell (u0, u1, v0, v1); returns its degree."""
    t0, t1 = span
    u, v = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3])
    half_u, half_v = 0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2])
    n = trims.piece_degree[piece]
    for i in range(n + 1):
        w = trims.piece_coefs[piece, i, 2]
        coefs[i, 0] = (trims.piece_coefs[piece, i, 0] - u * w) / half_u
        coefs[i, 1] = (trims.piece_coefs[piece, i, 1] - v * w) / half_v
        coefs[i, 2] = w
    for c in range(3):
        for k in range(1, n + 1):  # the part behind t0
            for i in range(n - k + 1):
                coefs[i, c] += t0 * (coefs[i + 1, c] - coefs[i, c])
        x = (t1 - t0) / (1.0 - t0)
        for k in range(1, n + 1):  # of that the part before t1
            for i in range(n, k - 1, -1):
                coefs[i, c] += (1.0 - x) * (coefs[i - 1, c] - coefs[i, c])
    return n


@inner(error_model="numpy")
def _follows(trims, one, other, first, second):
    """Whether the stretch `second` of a piece goes on smoothly where `first` of another ends."""
    if not (first[1] > 1.0 - AT_END and second[0] < AT_END):
        return False
    a = trims.piece_ends[one]
    b = trims.piece_ends[other]
    return a[2] == b[0] and a[3] == b[1]


@inner(error_model="numpy")
def _slope(coefs, n, end):
    """Direction (x', y') of a stretch at its start (0) or end (1)."""
    i = 0 if end == 0 else n - 1
    a, b = coefs[i], coefs[i + 1]
    return b[0] / b[2] - a[0] / a[2], b[1] / b[2] - a[1] / a[2]


@inner(error_model="numpy")
def _is_smooth(segment, n):
    """Whether the stretches of an edge segment go on from one to the next without a kink."""
    coefs, degree = segment.coefs, segment.degree
    for k in range(n - 1):
        a = _slope(coefs[k], degree[k], 1)
        b = _slope(coefs[k + 1], degree[k + 1], 0)
        size = math.hypot(a[0], a[1]) * math.hypot(b[0], b[1])
        if not (abs(a[0] * b[1] - a[1] * b[0]) <= KINK * size and a[0] * b[0] + a[1] * b[1] > 0.0):
            return False
    return True


@inner(error_model="numpy")
def segment_in(trims, patch, cell, segment):
    """The edge segment of one edge in a cell (u0, u1, v0, v1) of a trimmed patch.

    Returns (edge, number of its stretches in `segment`): edge −1 and no stretch where no piece
    meets the cell, edge −2 where what meets it is no segment.
    """
    coefs, degree = segment.coefs, segment.degree
    wide = with_hair(trims, patch, cell)
    pieces = stack_int64(MOST)
    span = scratch(MOST, 2)
    n = 0
    edge = -1
    for k in range(trims.patch_start[patch], trims.patch_start[patch + 1]):
        first, last = through(trims, k, wide)
        if first > last + AT_END:
            continue
        if n == MOST or trims.piece_edge[k] < 0 or (n > 0 and trims.piece_edge[k] != edge):
            return -2, 0
        if last <= first:
            return -2, 0
        edge = trims.piece_edge[k]
        pieces[n] = k
        span[n, 0], span[n, 1] = first, last
        n += 1
    if n == 0:
        return -1, 0
    start = 0
    links = 0
    for k in range(n):
        other = (k + 1) % n
        if n > 1 and _follows(trims, pieces[k], pieces[other], span[k], span[other]):
            links += 1
        else:
            start = other
    if links != n - 1:
        return -2, 0
    for k in range(n):
        i = (start + k) % n
        degree[k] = stretch(trims, pieces[i], (span[i, 0], span[i, 1]), cell, coefs[k])
    return (edge, n) if _is_smooth(segment, n) else (-2, 0)


@inner(error_model="numpy")
def side_segment(side, segment):
    """The natural side of a cell as its edge segment: one stretch."""
    coefs, degree = segment.coefs, segment.degree
    across = -1.0 if side & 1 == 0 else 1.0
    for i in range(2):
        coefs[0, i, side // 2] = across
        coefs[0, i, 1 - side // 2] = 2.0 * i - 1.0
        coefs[0, i, 2] = 1.0
    degree[0] = 1
    return 1


@inner(error_model="numpy")
def place_on(segment, k, t):
    """(x, y) at t of stretch k, and its slope there."""
    coefs, degree = segment.coefs, segment.degree
    n = degree[k]
    w = bernstein_at(coefs[k], n, 2, t)
    x = bernstein_at(coefs[k], n, 0, t) / w
    y = bernstein_at(coefs[k], n, 1, t) / w
    dx = dy = dw = 0.0
    basis = 1.0
    for i in range(n):  # the derivative's own Bernstein form
        basis = (1.0 - t) ** (n - 1 - i) * t**i * _choose(n - 1, i)
        dx += n * basis * (coefs[k, i + 1, 0] - coefs[k, i, 0])
        dy += n * basis * (coefs[k, i + 1, 1] - coefs[k, i, 1])
        dw += n * basis * (coefs[k, i + 1, 2] - coefs[k, i, 2])
    return x, y, (dx - x * dw) / w, (dy - y * dw) / w


@inner(error_model="numpy")
def _choose(n, i):
    value = 1.0
    for k in range(i):
        value *= (n - k) / (k + 1.0)
    return value


@inner(error_model="numpy")
def anchor(segment, n, at, metric):
    """The place of an edge segment next to (x, y) = at: (stretch, t), by the metric (E, F, G)
    there.

    Any place of the edge segment would do for what is proved with it; a near one proves more.
    """
    best = math.inf
    nearest = (0, 0.0)
    for k in range(n):
        for start in (0.0, 0.5, 1.0):
            t = start
            for _ in range(STEPS):
                x, y, dx, dy = place_on(segment, k, t)
                x -= at[0]
                y -= at[1]
                slope = metric[0] * x * dx + metric[1] * (x * dy + y * dx) + metric[2] * y * dy
                speed = metric[0] * dx * dx + 2.0 * metric[1] * dx * dy + metric[2] * dy * dy
                new = min(max(t - slope / speed, 0.0), 1.0) if speed > 0.0 else t
                if new == t:
                    break
                t = new
            x, y, dx, dy = place_on(segment, k, t)
            x -= at[0]
            y -= at[1]
            square = metric[0] * x * x + 2.0 * metric[1] * x * y + metric[2] * y * y
            if square < best:
                best = square
                nearest = (k, t)
    return nearest


@inner(error_model="numpy")
def _about(low, high):
    return 0.5 * (low + high), 0.5 * (high - low)


@inner(error_model="numpy")
def _over(value, rest, spread):
    """A value ± rest divided by a weight of 1 ± spread."""
    return value, (rest + abs(value) * spread) / (1.0 - spread)


@inner(error_model="numpy")
def _differences(coefs, n, c, order):
    """Range of the derivative of a Bernstein polynomial: (middle, half)."""
    if n < order:
        return 0.0, 0.0
    low = math.inf
    high = -math.inf
    for i in range(n - order + 1):
        d = coefs[i + 1, c] - coefs[i, c]
        d = n * d if order == 1 else n * (n - 1) * (coefs[i + 2, c] - coefs[i + 1, c] - d)
        low = min(low, d)
        high = max(high, d)
    return _about(low, high)


@inner(error_model="numpy")
def _slopes(coefs, n, c, w, spread):
    """x' and x'' of a coordinate of a stretch: (value, rest) each.

    With X = (numerator − x_c w): x' = (X' − (x − x_c) w')/w, and so on; `w` is the middle of the
    weights and `spread` how far they depart from it, as a share.
    """
    low = math.inf
    high = -math.inf
    for i in range(n + 1):
        low = min(low, coefs[i, c] / coefs[i, 2])
        high = max(high, coefs[i, c] / coefs[i, 2])
    middle, wide = _about(low, high)
    shifted = np.empty((n + 1, 2))
    for i in range(n + 1):
        shifted[i, 0] = (coefs[i, c] - middle * coefs[i, 2]) / w
        shifted[i, 1] = coefs[i, 2] / w
    w1, w1_rest = _differences(shifted, n, 1, 1)
    w2, w2_rest = _differences(shifted, n, 1, 2)
    a, a_rest = _differences(shifted, n, 0, 1)
    x1, x1_rest = _over(a, a_rest + wide * (abs(w1) + w1_rest), spread)
    a, a_rest = _differences(shifted, n, 0, 2)
    a_rest += wide * (abs(w2) + w2_rest)
    a -= 2.0 * x1 * w1
    a_rest += 2.0 * (abs(x1) * w1_rest + x1_rest * (abs(w1) + w1_rest))
    x2, x2_rest = _over(a, a_rest, spread)
    return x1, x1_rest, x2, x2_rest


@inner(linked=False, error_model="numpy")
def stretch_bend(segment, k, bending):
    """Bound the bending of stretch k of an edge.

    Returns C'' near the middle, the largest deviation from it, the least and the largest |C'|, and
    the largest curvature in space; infinite if there is no bound. `bend_bounds` has filled
    `bending` for the cell.
    """
    h, rest = bending.derivatives, bending.rest
    coefs, degree = segment.coefs, segment.degree
    n = degree[k]
    low = math.inf
    high = -math.inf
    for i in range(n + 1):
        low = min(low, coefs[k, i, 2])
        high = max(high, coefs[k, i, 2])
    w, spread = _about(low, high)
    nothing = (0.0, 0.0, 0.0)
    if not (low > 0.0 and spread < 0.5 * w):
        return nothing, math.inf, 0.0, math.inf, math.inf
    x1, x1_rest, x2, x2_rest = _slopes(coefs[k], n, 0, w, spread / w)
    y1, y1_rest, y2, y2_rest = _slopes(coefs[k], n, 1, w, spread / w)
    most_x = abs(x1) + x1_rest
    most_y = abs(y1) + y1_rest
    s_x, s_y = length(h, 1), length(h, 2)
    s_xx, s_xy, s_yy = length(h, 3), length(h, 4), length(h, 5)
    change_x = s_xx + s_xy + rest[0, D10]
    change_y = s_xy + s_yy + rest[0, D01]
    rest1 = s_x * x1_rest + s_y * y1_rest + change_x * most_x + change_y * most_y
    rest2 = rest[0, D20] * most_x**2 + s_xx * (2.0 * abs(x1) + x1_rest) * x1_rest
    rest2 += rest[0, D02] * most_y**2 + s_yy * (2.0 * abs(y1) + y1_rest) * y1_rest
    rest2 += 2.0 * rest[0, D11] * most_x * most_y
    rest2 += 2.0 * s_xy * (abs(x1) * y1_rest + abs(y1) * x1_rest + x1_rest * y1_rest)
    rest2 += s_x * x2_rest + change_x * (abs(x2) + x2_rest)
    rest2 += s_y * y2_rest + change_y * (abs(y2) + y2_rest)
    c1 = scratch(3)
    c2 = scratch(3)
    for c in range(3):
        c1[c] = h[c, 1] * x1 + h[c, 2] * y1
        c2[c] = h[c, 3] * x1 * x1 + 2.0 * h[c, 4] * x1 * y1 + h[c, 5] * y1 * y1
        c2[c] += h[c, 1] * x2 + h[c, 2] * y2
    size1 = math.sqrt(c1[0] ** 2 + c1[1] ** 2 + c1[2] ** 2)
    size2 = math.sqrt(c2[0] ** 2 + c2[1] ** 2 + c2[2] ** 2)
    cross = math.sqrt(
        (c1[1] * c2[2] - c1[2] * c2[1]) ** 2
        + (c1[2] * c2[0] - c1[0] * c2[2]) ** 2
        + (c1[0] * c2[1] - c1[1] * c2[0]) ** 2
    )
    least = size1 - rest1
    if not least > 0.0:
        return nothing, math.inf, 0.0, math.inf, math.inf
    bent = (cross + (size1 + rest1) * rest2 + rest1 * size2) / least**3
    return (c2[0], c2[1], c2[2]), rest2, least, size1 + rest1, bent
