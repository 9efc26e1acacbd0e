"""Leaves over the trimming pieces: stretches of one element each, with rigorous bounds.

Beside the bounds of derivatives a leaf has the way into the face in its middle, a unit vector
square to the curve and to the normal of the face, and how far it is off that anywhere in the
stretch. Where all of a stretch has a point on its inner side, the face has points nearer than it.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import POLE
from contiga.arrays.kernels.rows_nb import doubled, put
from contiga.arrays.kernels.sort_nb import sort
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.bounds_nb import cell_bounds, derivative_bounds, restrict
from contiga.elements.kernels.element_nb import locate
from contiga.geometry.kernels.trim_nb import parameter_at, point_in_trim
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.hierarchy.kernels.curve_nb import curve_point, piece_parameters

THIN = 1e-7
"""Width a rectangle is given around a p-curve that runs along a parameter line."""
SHORTEST = 1e-12
"""A stretch (share of a piece) shorter than this between two element sides is a point."""
ROUNDING = 1e-14
"""Of a tangent, as a share of how far the parameters are from zero: it tells in pieces that close
gaps, which may be 1e-10 long."""
ON_POLE = 1e-12
"""A p-curve this near a side of its element (local parameters) runs along it."""
NOTHING_KNOWN = 2.0
"""How far the way into a face may be off at most: two unit vectors always are no farther."""
BESIDE, NEARER, STEPS = 1e-5, 0.1, 3
"""How far beside a piece the face is looked for, as a share of its patch's rectangle, and then that
many times with this factor between."""


@inner()
def _cuts(grid, trims, piece, cuts):
    """Parameters at which a piece passes from element to element, 0 and 1 among them, sorted."""
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
    """1 where the face is to the left of a piece in (u, v), −1 to the right, 0 where neither or
    both are."""
    c = scratch(3, 3)
    piece_parameters(trims, piece, 0.5, c)
    patch = trims.piece_patch[piece]
    domain = trims.domain[patch]
    wide, high = domain[1] - domain[0], domain[3] - domain[2]
    x, y = c[1, 0] / wide, c[1, 1] / high
    length = math.hypot(x, y)
    if length == 0.0:
        return 0.0
    off = BESIDE / length
    sides = 0
    for _ in range(STEPS):
        for sense in (1, -1):
            u, v = c[0, 0] - sense * off * y * wide, c[0, 1] + sense * off * x * high
            # Beyond the rectangle there is no face.
            if domain[0] <= u <= domain[1] and domain[2] <= v <= domain[3]:
                sides += sense * point_in_trim(trims, patch, u, v)
        off *= NEARER
    if sides == STEPS:
        return 1.0
    return -1.0 if sides == -STEPS else 0.0


@inner()
def _way_in(tables, piece, middle, side, bound, box, bend):
    """The way into the face in the middle of a stretch, how far it is off that anywhere, and the
    sine of the largest turn of the normal of the face. Where `side` is not known it is the way to
    the left.

    `bound` are those of the element over the rectangle `box` about the stretch (low and high s, low
    and high t), `bend` is by how much C' changes from the middle to an end at most.
    """
    elements, grid, trims = tables
    h = scratch(4, 6)
    d = scratch(3, 3)
    _, s, t = curve_point(elements, grid, trims, piece, middle, h, d)
    along = (d[1, 0], d[1, 1], d[1, 2])
    normal = cross(column(h, 1), column(h, 2))
    speed, area = math.sqrt(dot(along, along)), math.sqrt(dot(normal, normal))
    ds, dt = max(s - box[0], box[1] - s), max(t - box[2], box[3] - t)
    change_s = bound[2] * ds + bound[3] * dt
    change_t = bound[3] * ds + bound[4] * dt
    change = bound[0] * change_t + bound[1] * change_s
    if speed * area == 0.0:
        return (0.0, 0.0, 0.0), NOTHING_KNOWN, 1.0
    x, y, z = cross(normal, along)
    scale = (-1.0 if side < 0.0 else 1.0) / (area * speed)
    # Vectors that are off by a share q < 1 of their lengths turn by arcsin q at most, and unit
    # vectors by √2 q.
    known = side != 0.0 and bend < speed and change < area
    off = math.sqrt(2.0) * (bend / speed + change / area) if known else NOTHING_KNOWN
    return (x * scale, y * scale, z * scale), off, min(change / area, 1.0)


@inner()
def _bounds(tables, piece, side, stretch, net, bound):
    """Bounds of |C'|, |C''|, |C'''| over a stretch inside one element, into bound[:3]; the way into
    the face and how far it is off, into bound[3:7]; the side and the sine of the normal, bound[7:].

    By the chain rule, from bounds of the p-curve in (s, t) and of the element over the rectangle
    around it; zero along a pole. `side` is of `_inner_side`.
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
        off = max(abs(corner[0, axis] - x), abs(corner[1, axis] - x))
        if elements.table[e]["kind"][end] == POLE and off <= ON_POLE:
            for k in range(9):
                bound[k] = 0.0
            bound[6], bound[8] = NOTHING_KNOWN, 1.0
            return
    low_s, low_t = max(corner[0, 0] - THIN, -0.5), max(corner[0, 1] - THIN, -0.5)
    low_s, low_t = min(low_s, 0.5 - THIN), min(low_t, 0.5 - THIN)
    high_s, high_t = max(corner[1, 0] + THIN, low_s + THIN), max(corner[1, 1] + THIN, low_t + THIN)
    box = low_s, min(high_s, 0.5), low_t, min(high_t, 0.5)
    cell_bounds(elements, e, box, bound)
    l1 = math.hypot(bound[0], bound[1])
    l2 = max(bound[2], bound[4]) + bound[3]
    l3 = bound[5] + 3.0 * bound[6] + 3.0 * bound[7] + bound[8]
    second = l2 * p1 * p1 + l1 * p2
    reach = bound[0] * max(abs(u0), abs(u1), u1 - u0) / (u1 - u0)
    reach += bound[1] * max(abs(v0), abs(v1), v1 - v0) / (v1 - v0)
    bend = 0.5 * (t1 - t0) * second + ROUNDING * reach
    way, off, sine = _way_in(tables, piece, 0.5 * (t0 + t1), side, bound, box, bend)
    bound[0] = l1 * p1
    bound[1] = second
    bound[2] = l3 * p1**3 + 3.0 * l2 * p1 * p2 + l1 * p3
    bound[3], bound[4], bound[5] = way
    bound[6], bound[7], bound[8] = off, side, sine


@kernel()
def curve_leaves(elements, grid, trims, flatness, depth):
    """Rows (n, 20) of the leaves of all trimming pieces: element −1 − piece, box (t0, t1, 0, 0),
    bounds (9), low (3) and high corner (3).

    The first three bounds are of |C'|, |C''| and |C'''|; the next are the way into the face and how
    far it is off at most, the side of the piece that the face is on, and the sine of the angle by
    which the normal of the face turns at most. Stretches end at the sides of elements and are
    halved until they are flat, `depth` times at most.
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
        most = _cuts(grid, trims, piece, cuts)
        side = _inner_side(trims, piece)
        for i in range(most - 1):
            if cuts[i + 1] - cuts[i] < SHORTEST:
                continue
            put(stack, 0, (cuts[i], cuts[i + 1], 0.0))
            top = 1
            while top > 0:
                top -= 1
                t0, t1, level = stack[top]
                _bounds(tables, piece, side, (t0, t1), net, bound)
                if 0.25 * bound[1] * (t1 - t0) > flatness * bound[0] and level < depth:
                    middle = 0.5 * (t0 + t1)
                    put(stack, top, (t0, middle, level + 1.0))
                    put(stack, top + 1, (middle, t1, level + 1.0))
                    top += 2
                    continue
                if n == rows.shape[0]:
                    rows = doubled(rows)
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
