"""Kernels of the trim tables: monotone pieces, the cell grid, the exact in/out test.

A piece is a rational Bézier segment of a p-curve, monotone in u and in v, as homogeneous
Bernstein coefficients (wu, wv, w). Its end points are stored separately, with the same bits as
the neighbours in the loop, so that the half-open crossing rule ``v_low <= v < v_high`` counts
every vertex exactly once, whatever rounding does in between.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import CUT, IN, OUT
from contiga.jit import inner, kernel
from contiga.pointer_records import pass_by_pointer

MARGIN = 1e-9
"""Widening of a piece when cells are marked, as a share of the domain; far above rounding."""
ON_CURVE = 1e-12
"""Points this close to a trim curve (share of the domain) count as inside."""


@pass_by_pointer
class TrimTables(NamedTuple):
    """Trims of all patches of a body as flat arrays (n pieces, m patches, c cells)."""

    piece_coefs: np.ndarray
    """(n, maxdeg + 1, 3) homogeneous Bernstein coefficients (wu, wv, w)."""
    piece_degree: np.ndarray
    """(n,) int32."""
    piece_ends: np.ndarray
    """(n, 4) u, v at the start and u, v at the end, the same at neighbours in the loop."""
    piece_patch: np.ndarray
    """(n,) int32."""
    piece_edge: np.ndarray
    """(n,) int32 index into ``body.edges``, −1 if the p-curve belongs to none."""
    piece_loop: np.ndarray
    """(n, 2) int32 loop and index of the p-curve in it."""
    patch_start: np.ndarray
    """(m + 1,) int64 pieces of a patch are ``patch_start[k]:patch_start[k + 1]``."""
    trimmed: np.ndarray
    """(m,) int8, 0 for a patch that is its whole natural rectangle."""
    domain: np.ndarray
    """(m, 4) u0, u1, v0, v1."""
    grid_shape: np.ndarray
    """(m, 2) int64 cells along u and v, zero for untrimmed patches."""
    grid_start: np.ndarray
    """(m + 1,) int64 first cell of a patch; cells are stored u fastest."""
    cell_state: np.ndarray
    """(c,) int8 OUT, IN or CUT."""
    cell_parity: np.ndarray
    """(c,) int8 crossings to the right of the cell, modulo 2, on the cell's lower line."""
    cell_start: np.ndarray
    """(c + 1,) int64 into `cell_pieces`."""
    cell_pieces: np.ndarray
    """int32 pieces that meet the cell."""
    toggle_start: np.ndarray
    """(c + 1,) int64 into `toggles`."""
    toggles: np.ndarray
    """v values inside the cell's row at which `cell_parity` flips."""


@inner()
def bernstein_at(coefs, degree, k, t):
    """Return component k of a segment at t in [0, 1], by the nested Bernstein form.

    With coefficients of one sign no digits cancel.
    """
    s = 1.0 - t
    power = 1.0
    binomial = 1.0
    value = coefs[0, k]
    for i in range(1, degree + 1):
        power *= t
        binomial = binomial * (degree - i + 1) / i
        value = value * s + binomial * power * coefs[i, k]
    return value


@kernel()
def parameter_at(coefs, degree, axis, value):
    """Return t in [0, 1] at which the monotone coordinate `axis` of a piece takes `value`.

    Values beyond an end give that end. Regula falsi with the Illinois step inside a bracket,
    which is halved when three steps have not shrunk it to an eighth (near a turning point);
    ends when the residual is rounding.
    """
    ga = coefs[0, axis] - value * coefs[0, 2]
    gb = coefs[degree, axis] - value * coefs[degree, 2]
    if ga == 0.0:
        return 0.0
    if gb == 0.0:
        return 1.0
    if (ga > 0.0) == (gb > 0.0):
        return 0.0 if abs(ga) * coefs[degree, 2] < abs(gb) * coefs[0, 2] else 1.0
    if degree == 1:
        return ga / (ga - gb)
    rounding = 2e-16 * (abs(coefs[0, axis]) + abs(coefs[degree, axis]))
    a, b = 0.0, 1.0
    side = 0
    width = 2.0
    for iteration in range(250):
        t = (a * gb - b * ga) / (gb - ga)
        if iteration % 3 == 2:
            if b - a > 0.125 * width:
                t = 0.5 * (a + b)
            width = b - a
        if not (a < t < b):
            t = 0.5 * (a + b)
        g = bernstein_at(coefs, degree, axis, t) - value * bernstein_at(coefs, degree, 2, t)
        if abs(g) <= rounding or b - a <= 2.3e-16:
            return t
        if (g > 0.0) == (gb > 0.0):
            b, gb = t, g
            if side == 1:
                ga *= 0.5
            side = 1
        else:
            a, ga = t, g
            if side == -1:
                gb *= 0.5
            side = -1
    return 0.5 * (a + b)


@inner(linked=False)
def other_coordinate(tables, piece, axis, value):
    """Return the other coordinate of a piece where its coordinate `axis` takes a value.

    Values beyond an end give that end's.
    """
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    t = parameter_at(coefs, degree, axis, value)
    return bernstein_at(coefs, degree, 1 - axis, t) / bernstein_at(coefs, degree, 2, t)


@inner()
def u_range_in_row(tables, piece, v_low, v_high):
    """Return the interval of u that a piece covers between two lines of constant v it meets."""
    ends = tables.piece_ends[piece]
    ua, va, ub, vb = ends[0], ends[1], ends[2], ends[3]
    if va > vb:
        ua, va, ub, vb = ub, vb, ua, va
    low = ua if va >= v_low else other_coordinate(tables, piece, 1, v_low)
    high = ub if vb <= v_high else other_coordinate(tables, piece, 1, v_high)
    return min(low, high), max(low, high)


@inner()
def cell_of(tables, patch, u, v):
    """Return column and row of the cell that contains (u, v), or of the nearest one.

    The row is exact in floating point.
    """
    u0, u1 = tables.domain[patch, 0], tables.domain[patch, 1]
    v0, v1 = tables.domain[patch, 2], tables.domain[patch, 3]
    nu, nv = tables.grid_shape[patch, 0], tables.grid_shape[patch, 1]
    du = (u1 - u0) / nu
    dv = (v1 - v0) / nv
    i = min(max(int((u - u0) / du), 0), nu - 1)
    j = min(max(int((v - v0) / dv), 0), nv - 1)
    if j > 0 and v < v0 + j * dv:
        j -= 1
    elif j < nv - 1 and v >= v0 + (j + 1) * dv:
        j += 1
    return i, j


@inner()
def _crosses_right(tables, piece, u, v):
    """Return whether the ray from (u, v) towards +u crosses a piece (half-open in v)."""
    ends = tables.piece_ends[piece]
    if not (min(ends[1], ends[3]) <= v < max(ends[1], ends[3])):
        return False
    if u < min(ends[0], ends[2]):
        return True
    if u >= max(ends[0], ends[2]):
        return False
    return other_coordinate(tables, piece, 1, v) > u


@inner()
def _compare_with_piece(tables, piece, u, v, eps):
    """Return 2 for a point on a piece, 1 if the ray from it towards +u crosses the piece, else 0.

    A point is on a piece within `eps` = (u, v), measured along u, and along v too if the piece is
    nearly level there. The ray crosses by the half-open rule in v.
    """
    ends = tables.piece_ends[piece]
    low, high = min(ends[0], ends[2]), max(ends[0], ends[2])
    bottom, top = min(ends[1], ends[3]), max(ends[1], ends[3])
    if v < bottom - eps[1] or v > top + eps[1] or u > high + eps[0]:
        return 0
    spans_v = bottom <= v < top
    if u < low - eps[0]:
        return 1 if spans_v else 0
    crossing = other_coordinate(tables, piece, 1, v)
    distance = abs(crossing - u)
    if distance <= eps[0] and abs(min(max(v, bottom), top) - v) <= eps[1]:
        return 2
    is_level = distance <= 1e9 * eps[0] or top - bottom <= 1e6 * eps[1]
    if is_level and abs(other_coordinate(tables, piece, 0, u) - v) <= eps[1]:
        return 2
    return 1 if spans_v and crossing > u else 0


@kernel()
def point_in_trim(tables, patch, u, v):
    """Return 1 if (u, v) belongs to the trimmed patch, 0 if it is cut away (even-odd rule).

    Exact to rounding: the pieces of one cell are intersected with the ray towards +u; the cell's
    parity counts all pieces further right. Points on a trim curve count as inside. Parameters
    outside the domain are clamped to it. A patch without trims is inside everywhere.
    """
    if tables.trimmed[patch] == 0:
        return 1
    u0, u1 = tables.domain[patch, 0], tables.domain[patch, 1]
    v0, v1 = tables.domain[patch, 2], tables.domain[patch, 3]
    u = min(max(u, u0), u1)
    v = min(max(v, v0), v1)
    i, j = cell_of(tables, patch, u, v)
    cell = tables.grid_start[patch] + j * tables.grid_shape[patch, 0] + i
    state = tables.cell_state[cell]
    if state != CUT:
        return int(state)
    parity = int(tables.cell_parity[cell])
    for k in range(tables.toggle_start[cell], tables.toggle_start[cell + 1]):
        if v >= tables.toggles[k]:
            parity ^= 1
    eps = (
        ON_CURVE * max(u1 - u0, abs(u0), abs(u1)),
        ON_CURVE * max(v1 - v0, abs(v0), abs(v1)),
    )
    for k in range(tables.cell_start[cell], tables.cell_start[cell + 1]):
        relation = _compare_with_piece(tables, tables.cell_pieces[k], u, v, eps)
        if relation == 2:
            return 1
        parity ^= relation
    return parity


@inner()
def _piece_meets_box(tables, piece, u0, u1, v0, v1):
    """Return whether a monotone piece meets a box: exact, as its u over the row is an interval."""
    ends = tables.piece_ends[piece]
    if max(ends[0], ends[2]) < u0 or min(ends[0], ends[2]) > u1:
        return False
    if max(ends[1], ends[3]) < v0 or min(ends[1], ends[3]) > v1:
        return False
    low, high = u_range_in_row(tables, piece, v0, v1)
    return high >= u0 and low <= u1


@kernel()
def box_state(tables, patch, u0, u1, v0, v1):
    """Return OUT (0), IN (1) or CUT (2) of a parameter box; IN and OUT are certain.

    The box is widened by rounding, so that a curve along its border makes it CUT.
    """
    if tables.trimmed[patch] == 0:
        return IN
    domain = tables.domain[patch]
    margin_u = 4.0 * ON_CURVE * max(domain[1] - domain[0], abs(domain[0]), abs(domain[1]))
    margin_v = 4.0 * ON_CURVE * max(domain[3] - domain[2], abs(domain[2]), abs(domain[3]))
    u0, u1, v0, v1 = u0 - margin_u, u1 + margin_u, v0 - margin_v, v1 + margin_v
    i0, j0 = cell_of(tables, patch, u0, v0)
    i1, j1 = cell_of(tables, patch, u1, v1)
    nu = tables.grid_shape[patch, 0]
    found_in = False
    found_out = False
    for j in range(j0, j1 + 1):
        for i in range(i0, i1 + 1):
            cell = tables.grid_start[patch] + j * nu + i
            state = tables.cell_state[cell]
            if state == IN:
                found_in = True
            elif state == OUT:
                found_out = True
            else:
                for k in range(tables.cell_start[cell], tables.cell_start[cell + 1]):
                    if _piece_meets_box(tables, tables.cell_pieces[k], u0, u1, v0, v1):
                        return CUT
    if found_in and found_out:
        return CUT
    if found_in:
        return IN
    if found_out:
        return OUT
    return point_in_trim(tables, patch, 0.5 * (u0 + u1), 0.5 * (v0 + v1))


@kernel()
def points_in_trim(tables, patch, uv):
    """Return (n,) bool, whether rows (u, v) of `uv` belong to a patch: see `point_in_trim`."""
    inside = np.empty(uv.shape[0], np.bool_)
    for i in range(uv.shape[0]):
        inside[i] = point_in_trim(tables, patch, uv[i, 0], uv[i, 1]) == 1
    return inside


@kernel()
def box_states(tables, patches, boxes):
    """Return (n,) `box_state` of rows (u0, u1, v0, v1), each on a patch of its own."""
    states = np.empty(boxes.shape[0], np.int32)
    for i in range(boxes.shape[0]):
        u0, u1, v0, v1 = boxes[i]
        states[i] = box_state(tables, patches[i], u0, u1, v0, v1)
    return states
