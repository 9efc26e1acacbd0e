"""Kernels for the area of trimmed patches: Green's theorem along the monotone pieces."""

from __future__ import annotations

import numpy as np

from contiga.geometry.kernels.quadrature_nb import bernstein, jacobian
from contiga.geometry.kernels.trim_nb import bernstein_at, parameter_at, point_in_trim
from contiga.num.jit import inner, kernel


@inner()
def flux(A, A_u, A_v):
    """S · (S_u × S_v) from the homogeneous point (4,) and its derivatives.

    The parts of the derivatives along S drop out of the product, so w³ is all that divides.
    """
    x = A_u[1] * A_v[2] - A_u[2] * A_v[1]
    y = A_u[2] * A_v[0] - A_u[0] * A_v[2]
    z = A_u[0] * A_v[1] - A_u[1] * A_v[0]
    return (A[0] * x + A[1] * y + A[2] * z) / A[3] ** 3


@inner()
def element_integral(coefs, box, nodes, weights):
    """∫ |S_s × S_t| ds over ``s`` in box[0]…box[1] at ``t`` = box[2], all local to one element.

    With box[3] set the integrand is S · (S_s × S_t).
    """
    p, q = coefs.shape[0] - 1, coefs.shape[1] - 1
    B, dB = np.empty(p + 1), np.empty(p + 1)
    C, dC = np.empty(q + 1), np.empty(q + 1)
    bernstein(q, box[2], C, dC)
    row = np.zeros((p + 1, 4))
    row_t = np.zeros((p + 1, 4))
    for i in range(p + 1):
        for j in range(q + 1):
            for d in range(4):
                row[i, d] += C[j] * coefs[i, j, d]
                row_t[i, d] += dC[j] * coefs[i, j, d]
    A, A_s, A_t = np.empty(4), np.empty(4), np.empty(4)
    total = 0.0
    for k in range(nodes.size):
        bernstein(p, box[0] + (box[1] - box[0]) * nodes[k], B, dB)
        for d in range(4):
            A[d] = A_s[d] = A_t[d] = 0.0
            for i in range(p + 1):
                A[d] += B[i] * row[i, d]
                A_s[d] += dB[i] * row[i, d]
                A_t[d] += B[i] * row_t[i, d]
        value = flux(A, A_s, A_t) if box[3] > 0.0 else jacobian(A, A_s, A_t)
        total += weights[k] * value
    return total * (box[1] - box[0])


@inner()
def strip(grid, start, u, v, rule):
    """∫ |S_u × S_v| du from u = `start` to `u` at constant `v`, element by element.

    `grid` is (coefs, u_breaks, v_breaks) and `rule` (nodes, weights, parts, kind): every element
    is integrated in `parts` equal parts; `kind` 1 takes S · (S_u × S_v) instead.
    """
    coefs, u_breaks, v_breaks = grid
    nodes, weights, parts, kind = rule
    low, high = min(start, u), max(start, u)
    j = min(max(np.searchsorted(v_breaks, v, side="right") - 1, 0), v_breaks.size - 2)
    height = v_breaks[j + 1] - v_breaks[j]
    t = (v - v_breaks[j]) / height
    i = min(max(np.searchsorted(u_breaks, low, side="right") - 1, 0), u_breaks.size - 2)
    total = 0.0
    while i < u_breaks.size - 1 and u_breaks[i] < high:
        width = u_breaks[i + 1] - u_breaks[i]
        a = max(low - u_breaks[i], 0.0) / width
        b = min(high - u_breaks[i], width) / width
        for k in range(parts):
            box = (a + (b - a) * k / parts, a + (b - a) * (k + 1) / parts, t, 1.0 * kind)
            total += element_integral(coefs[i, j], box, nodes, weights)
        i += 1
    # ds = du / width cancels the width in S_s = S_u · width; dt does not.
    return total / height if u >= start else -total / height


@inner()
def _knot_crossings(tables, piece, u_breaks, v_breaks):
    """Sorted parameters of a piece, 0 and 1 included, at which it crosses borders of elements."""
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    found = np.empty(2 + u_breaks.size + v_breaks.size)
    found[0], found[1] = 0.0, 1.0
    n = 2
    for axis in range(2):
        first = coefs[0, axis] / coefs[0, 2]
        last = coefs[degree, axis] / coefs[degree, 2]
        for level in u_breaks if axis == 0 else v_breaks:
            if min(first, last) < level < max(first, last):
                found[n] = parameter_at(coefs, degree, axis, level)
                n += 1
    return np.sort(found[:n])


@inner()
def piece_integral(tables, piece, start, grid, rule):
    """∮ F dv along one piece, ``F(u, v)`` the strip integral from u = `start`."""
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    u0, u1, v0, v1 = (
        tables.domain[tables.piece_patch[piece], 0],
        tables.domain[tables.piece_patch[piece], 1],
        tables.domain[tables.piece_patch[piece], 2],
        tables.domain[tables.piece_patch[piece], 3],
    )
    nodes, weights, parts, _ = rule
    breaks = _knot_crossings(tables, piece, grid[1], grid[2])
    total = 0.0
    B, dB = np.empty(degree + 1), np.empty(degree + 1)
    for s in range(breaks.size - 1):
        for part in range(parts):
            width = (breaks[s + 1] - breaks[s]) / parts
            low = breaks[s] + part * width
            for k in range(nodes.size):
                bernstein(degree, low + nodes[k] * width, B, dB)
                x, y, w, dy, dw = 0.0, 0.0, 0.0, 0.0, 0.0
                for i in range(degree + 1):
                    x += B[i] * coefs[i, 0]
                    y += B[i] * coefs[i, 1]
                    w += B[i] * coefs[i, 2]
                    dy += dB[i] * coefs[i, 1]
                    dw += dB[i] * coefs[i, 2]
                v = y / w
                slope = (dy - v * dw) / w
                if slope == 0.0 or v < v0 or v > v1:
                    continue
                u = min(max(x / w, u0), u1)
                total += weights[k] * width * slope * strip(grid, start, u, v, rule)
    return total


@inner()
def _state_beside(tables, patch, u, v):
    """`point_in_trim`, with everything outside the patch's rectangle outside."""
    d = tables.domain[patch]
    if u < d[0] or u > d[1] or v < d[2] or v > d[3]:
        return 0
    return point_in_trim(tables, patch, u, v)


@inner()
def side_of_piece(tables, piece):
    """+1 if the face lies left of a piece, −1 if right, 0 if on both sides or on neither."""
    patch = tables.piece_patch[piece]
    d = tables.domain[patch]
    su, sv = d[1] - d[0], d[3] - d[2]
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    for step in (1e-6, 1e-4, 1e-8):
        here = np.empty((2, 2))
        for k in range(2):
            t = 0.49 + 0.02 * k
            w = bernstein_at(coefs, degree, 2, t)
            here[k, 0] = bernstein_at(coefs, degree, 0, t) / w / su
            here[k, 1] = bernstein_at(coefs, degree, 1, t) / w / sv
        du, dv = here[1, 0] - here[0, 0], here[1, 1] - here[0, 1]
        length = np.sqrt(du * du + dv * dv)
        if length == 0.0:
            return 0
        u, v = 0.5 * (here[0, 0] + here[1, 0]), 0.5 * (here[0, 1] + here[1, 1])
        left = _state_beside(
            tables, patch, (u - step * dv / length) * su, (v + step * du / length) * sv
        )
        right = _state_beside(
            tables, patch, (u + step * dv / length) * su, (v - step * du / length) * sv
        )
        if left != right:
            return 1 if left == 1 else -1
    return 0


@kernel()
def loop_integral(tables, pieces, grid, rule):
    """Signed contribution of one loop (its pieces in order) to the integral over its patch."""
    longest = 0.0
    sign = 0
    start = np.inf
    patch = tables.piece_patch[pieces[0]]
    d = tables.domain[patch]
    for p in pieces:
        ends = tables.piece_ends[p]
        start = min(start, min(ends[0], ends[2]))
        length = abs(ends[2] - ends[0]) / (d[1] - d[0]) + abs(ends[3] - ends[1]) / (d[3] - d[2])
        if length > longest:
            side = side_of_piece(tables, p)
            if side != 0:
                longest, sign = length, side
    if sign == 0:
        return 0.0
    start = min(max(start, d[0]), d[1])
    total = 0.0
    for p in pieces:
        total += piece_integral(tables, p, start, grid, rule)
    return sign * total


@kernel()
def rectangle_integral(grid, rule):
    """∬ over the whole patch: strips from side to side, element by element in v."""
    _, u_breaks, v_breaks = grid
    nodes, weights, parts, _ = rule
    total = 0.0
    for j in range(v_breaks.size - 1):
        height = (v_breaks[j + 1] - v_breaks[j]) / parts
        for part in range(parts):
            for k in range(nodes.size):
                v = v_breaks[j] + (part + nodes[k]) * height
                total += weights[k] * height * strip(grid, u_breaks[0], u_breaks[-1], v, rule)
    return total
