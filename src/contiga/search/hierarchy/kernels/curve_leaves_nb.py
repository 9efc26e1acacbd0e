"""Leaves over the trimming pieces: stretches of one element each, with rigorous bounds.

Besides bounds of derivatives a leaf has the inward direction at its middle, a unit vector
perpendicular to the curve and to the normal of the face, and its largest deviation in the stretch.
If a point is on the inner side of a complete stretch, the face has points nearer than the stretch.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import POLE
from contiga.arrays.kernels.rows_nb import double_rows, put
from contiga.arrays.kernels.sort_nb import sort
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.bounds_nb import cell_bounds, derivative_bounds, restrict
from contiga.elements.kernels.element_nb import locate
from contiga.geometry.kernels.trim_nb import parameter_at, point_in_trim
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.hierarchy.kernels.curve_nb import curve_point, piece_parameters

MIN_WIDTH = 1e-7
"""Least width of the rectangle around a p-curve that runs along a parameter line."""
MIN_STRETCH = 1e-12
"""Least length of a stretch (share of a piece) between two element sides: a shorter one is a
point."""
ROUNDING = 1e-14
"""Rounding of a tangent, as a share of the parameters: it matters in pieces that close gaps, which
may be 1e-10 long."""
POLE_TOL = 1e-12
"""Largest distance (local parameters) of a p-curve that runs along a side of its element."""
MAX_DEVIATION = 2.0
"""Deviation of an unknown inward direction: two unit vectors never differ by more."""
SIDE_OFFSET, OFFSET_RATIO, N_OFFSETS = 1e-5, 0.1, 3
"""First offset from a piece at which the face is tested, as a share of its patch's rectangle, ratio
of successive offsets, and their number."""


@inner()
def _element_breaks(grid, trims, piece, cuts):
    """Write the sorted parameters at which a piece passes from element to element to `cuts`.

    They begin with 0 and end with 1; returns their number.
    """
    row = grid.patches[trims.piece_patch[piece]]
    coefs = trims.piece_coefs[piece]
    degree = trims.piece_degree[piece]
    ends = trims.piece_ends[piece]
    cuts[0] = 0.0
    cuts[1] = 1.0
    n = 2
    for axis in range(2):
        low = min(ends[axis], ends[axis + 2])
        high = max(ends[axis], ends[axis + 2])
        first = row["u"][0] if axis == 0 else row["v"][0]
        last = row["u"][1] if axis == 0 else row["v"][1]
        for k in range(first, last):
            if low < grid.breaks[k] < high:
                cuts[n] = parameter_at(coefs, degree, axis, grid.breaks[k])
                n += 1
    sort(cuts[:n])
    return n


@inner(linked=False)
def _inner_side(trims, piece):
    """Return 1 if the face is to the left of a piece in (u, v), −1 to the right, 0 if undecided.

    Places on both sides of the piece's middle are tested against the trims at `N_OFFSETS` falling
    distances; all have to agree. Places beyond the patch's rectangle count as outside.
    """
    c = scratch(3, 3)
    piece_parameters(trims, piece, 0.5, c)
    patch = trims.piece_patch[piece]
    domain = trims.domain[patch]
    wide, high = domain[1] - domain[0], domain[3] - domain[2]
    x, y = c[1, 0] / wide, c[1, 1] / high
    length = math.hypot(x, y)
    if length == 0.0:
        return 0.0
    deviation = SIDE_OFFSET / length
    sides = 0
    for _ in range(N_OFFSETS):
        for sense in (1, -1):
            u, v = c[0, 0] - sense * deviation * y * wide, c[0, 1] + sense * deviation * x * high
            # Beyond the rectangle there is no face.
            if domain[0] <= u <= domain[1] and domain[2] <= v <= domain[3]:
                sides += sense * point_in_trim(trims, patch, u, v)
        deviation *= OFFSET_RATIO
    if sides == N_OFFSETS:
        return 1.0
    return -1.0 if sides == -N_OFFSETS else 0.0


@inner()
def _inward_direction(tables, piece, middle, side, bound, box, bend):
    """Return the inward direction in the middle of a stretch, and how far it and the normal turn.

    The second number is the largest deviation of the direction in the stretch, the third the sine
    of the largest turn of the normal of the face. If `side` is unknown (0), the direction is to the
    left, and its deviation `MAX_DEVIATION`. Where tangent or normal vanish, it is zero and the sine
    1. `bound` are the bounds of the element over the rectangle `box` about the stretch (low and
    high s, low and high t), `bend` is the largest change of C' from the middle to an end.
    """
    elements, grid, trims = tables
    h = scratch(4, 6)
    d = scratch(3, 3)
    _, s, t = curve_point(elements, grid, trims, piece, middle, h, d)
    tangent = (d[1, 0], d[1, 1], d[1, 2])
    normal = cross(column(h, 1), column(h, 2))
    speed, area = math.sqrt(dot(tangent, tangent)), math.sqrt(dot(normal, normal))
    ds, dt = max(s - box[0], box[1] - s), max(t - box[2], box[3] - t)
    change_s = bound[2] * ds + bound[3] * dt
    change_t = bound[3] * ds + bound[4] * dt
    change = bound[0] * change_t + bound[1] * change_s
    if speed * area == 0.0:
        return (0.0, 0.0, 0.0), MAX_DEVIATION, 1.0
    x, y, z = cross(normal, tangent)
    scale = (-1.0 if side < 0.0 else 1.0) / (area * speed)
    # A change by a share q < 1 of its length turns a vector by arcsin q at most, and changes the
    # unit vector by √2 q at most.
    is_known = side != 0.0 and bend < speed and change < area
    deviation = math.sqrt(2.0) * (bend / speed + change / area) if is_known else MAX_DEVIATION
    return (x * scale, y * scale, z * scale), deviation, min(change / area, 1.0)


@inner()
def _stretch_bounds(tables, piece, side, stretch, net, bound):
    """Write the bounds of a stretch inside one element to bound[9], as `curve_leaves` lists them.

    The bounds of |C'|, |C''| and |C'''| follow by the chain rule from bounds of the p-curve in (s,
    t) and of the element over the rectangle around it; along a pole all are zero, and the inward
    direction is unknown. `side` is the result of `_inner_side`, `net` is work.
    """
    elements, grid, trims = tables
    t0, t1 = stretch
    n = trims.piece_degree[piece]
    c = scratch(3, 3)
    piece_parameters(trims, piece, 0.5 * (t0 + t1), c)
    e = locate(grid, trims.piece_patch[piece], c[0, 0], c[0, 1])[0]
    coefs = np.empty(4 * (n + 1))
    corner = scratch(2, 3)
    u0, u1, v0, v1 = elements.table[e]["box"]
    for i in range(n + 1):
        x, y, w = trims.piece_coefs[piece, i]
        coefs[4 * i] = (x - w * u0) / (u1 - u0) - 0.5 * w
        coefs[4 * i + 1] = (y - w * v0) / (v1 - v0) - 0.5 * w
        coefs[4 * i + 2] = 0.0
        coefs[4 * i + 3] = w
    restrict(coefs, (n, 0), (t0 - 0.5, t1 - 0.5, -0.5, 0.5), net)
    derivative_bounds(net, (n, 0), (t1 - t0, 1.0), bound, corner[0], corner[1])
    p1 = bound[0]
    p2 = bound[2]
    p3 = bound[5]
    for end in range(4):
        x, axis = (-0.5, 0.5)[end % 2], end // 2
        deviation = max(abs(corner[0, axis] - x), abs(corner[1, axis] - x))
        if elements.table[e]["kind"][end] == POLE and deviation <= POLE_TOL:
            for k in range(9):
                bound[k] = 0.0
            bound[6], bound[8] = MAX_DEVIATION, 1.0
            return
    low_s, low_t = max(corner[0, 0] - MIN_WIDTH, -0.5), max(corner[0, 1] - MIN_WIDTH, -0.5)
    low_s, low_t = min(low_s, 0.5 - MIN_WIDTH), min(low_t, 0.5 - MIN_WIDTH)
    high_s, high_t = (
        max(corner[1, 0] + MIN_WIDTH, low_s + MIN_WIDTH),
        max(corner[1, 1] + MIN_WIDTH, low_t + MIN_WIDTH),
    )
    box = low_s, min(high_s, 0.5), low_t, min(high_t, 0.5)
    cell_bounds(elements, e, box, bound)
    l1 = math.hypot(bound[0], bound[1])
    l2 = max(bound[2], bound[4]) + bound[3]
    l3 = bound[5] + 3.0 * bound[6] + 3.0 * bound[7] + bound[8]
    second = l2 * p1 * p1 + l1 * p2
    reach = bound[0] * max(abs(u0), abs(u1), u1 - u0) / (u1 - u0)
    reach += bound[1] * max(abs(v0), abs(v1), v1 - v0) / (v1 - v0)
    bend = 0.5 * (t1 - t0) * second + ROUNDING * reach
    inward, deviation, sine = _inward_direction(
        tables, piece, 0.5 * (t0 + t1), side, bound, box, bend
    )
    bound[0] = l1 * p1
    bound[1] = second
    bound[2] = l3 * p1**3 + 3.0 * l2 * p1 * p2 + l1 * p3
    bound[3], bound[4], bound[5] = inward
    bound[6], bound[7], bound[8] = deviation, side, sine


@kernel()
def curve_leaves(elements, grid, trims, flatness, depth):
    """Return rows (n, 20) of the leaves of all trimming pieces, piece by piece.

    A row is: element −1 − piece, box (t0, t1, 0, 0), bounds (9), low (3) and high corner (3). The
    bounds are of |C'|, |C''| and |C'''|, the inward direction (3), its largest deviation, the side
    of the piece on which the face is, and the sine of the largest turn of the normal of the face.
    Stretches end at the sides of elements; they are halved, at most `depth` times, until they
    depart from their tangent by no more than `flatness` of half their length. Those shorter than
    `MIN_STRETCH` have no row.
    """
    tables = (elements, grid, trims)
    rows = np.empty((64, 20))
    n = 0
    cuts = np.empty(grid.breaks.shape[0] + 2)
    stack = scratch(64, 3)
    bound = scratch(9)
    net = scratch(16, 4)
    h = scratch(4, 6)
    d = scratch(3, 3)
    for piece in range(trims.piece_degree.shape[0]):
        n_breaks = _element_breaks(grid, trims, piece, cuts)
        side = _inner_side(trims, piece)
        for i in range(n_breaks - 1):
            if cuts[i + 1] - cuts[i] < MIN_STRETCH:
                continue
            put(stack, 0, (cuts[i], cuts[i + 1], 0.0))
            top = 1
            while top > 0:
                top -= 1
                t0, t1, level = stack[top]
                _stretch_bounds(tables, piece, side, (t0, t1), net, bound)
                if 0.25 * bound[1] * (t1 - t0) > flatness * bound[0] and level < depth:
                    middle = 0.5 * (t0 + t1)
                    put(stack, top, (t0, middle, level + 1.0))
                    put(stack, top + 1, (middle, t1, level + 1.0))
                    top += 2
                    continue
                if n == rows.shape[0]:
                    rows = double_rows(rows)
                put(rows, n, (-1.0 - piece, t0, t1, 0.0, 0.0))
                for c in range(9):
                    rows[n, 5 + c] = bound[c]
                # The box about the ends, widened by the bulge of the stretch over its chord.
                bulge = 0.125 * bound[1] * (t1 - t0) ** 2
                for end in range(2):
                    e = curve_point(elements, grid, trims, piece, t1 if end == 1 else t0, h, d)[0]
                    for c in range(3):
                        x = d[0, c] + elements.table[e]["origin"][c]
                        rows[n, 14 + c] = min(x - bulge, rows[n, 14 + c] if end == 1 else math.inf)
                        rows[n, 17 + c] = max(x + bulge, rows[n, 17 + c] if end == 1 else -math.inf)
                n += 1
    return rows[:n]
