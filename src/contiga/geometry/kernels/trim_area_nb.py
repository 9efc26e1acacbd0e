"""Kernels for areas and moments of trimmed patches: Green's theorem along the monotone pieces.

They add to `out`: (1,) for an area or the flux of S, (10,) for the flux of 1, S, S ⊗ S times S.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.kernels.sort_nb import count_up_to, sort
from contiga.geometry.kernel_records import FLUX
from contiga.geometry.kernels.quadrature_nb import bernstein, jacobian
from contiga.geometry.kernels.trim_nb import bernstein_at, parameter_at, point_in_trim
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch


@inner()
def flux(A, A_u, A_v):
    """Return S · (S_u × S_v) from the homogeneous point (4,) and its derivatives.

    The components of the derivatives along S drop out of the product, which leaves the divisor w³.
    """
    x = A_u[1] * A_v[2] - A_u[2] * A_v[1]
    y = A_u[2] * A_v[0] - A_u[0] * A_v[2]
    z = A_u[0] * A_v[1] - A_u[1] * A_v[0]
    return (A[0] * x + A[1] * y + A[2] * z) / A[3] ** 3


@inner()
def add_moments(A, A_u, A_v, weight, out):
    """Add `weight` times S · (S_u × S_v) to out[0], and times 1, S, S ⊗ S to an `out` of ten.

    Order: 1, x, y, z, xx, yy, zz, xy, yz, xz.
    """
    value = weight * flux(A, A_u, A_v)
    out[0] += value
    if out.size > 1:
        x, y, z = A[0] / A[3], A[1] / A[3], A[2] / A[3]
        out[1] += value * x
        out[2] += value * y
        out[3] += value * z
        out[4] += value * x * x
        out[5] += value * y * y
        out[6] += value * z * z
        out[7] += value * x * y
        out[8] += value * y * z
        out[9] += value * x * z


@inner()
def _linear_combination(shares, points):
    """Return Σ shares[i] points[i] of homogeneous points (n, 4), as a tuple."""
    x = y = z = w = 0.0
    for i in range(shares.size):
        x += shares[i] * points[i, 0]
        y += shares[i] * points[i, 1]
        z += shares[i] * points[i, 2]
        w += shares[i] * points[i, 3]
    return x, y, z, w


@inner()
def _add_element(coefs, basis_s, basis_t, rule, factor, out):
    """Add `factor` ∫ … ds over one element along a line of constant ``t`` to `out`.

    The integrand is that of `add_moments` for the kind FLUX of rule, else |S_s × S_t|. `basis_s`
    and `basis_t` are Bernstein polynomials and slopes: in ``s`` at the nodes, in ``t`` on the line.
    """
    B, dB = basis_s
    C, dC = basis_t
    weights = rule.weights
    row = np.empty((coefs.shape[0], 4))
    row_t = np.empty((coefs.shape[0], 4))
    for i in range(coefs.shape[0]):
        row[i, 0], row[i, 1], row[i, 2], row[i, 3] = _linear_combination(C, coefs[i])
        row_t[i, 0], row_t[i, 1], row_t[i, 2], row_t[i, 3] = _linear_combination(dC, coefs[i])
    for k in range(weights.size):
        A, A_s, A_t = (
            _linear_combination(B[k], row),
            _linear_combination(dB[k], row),
            _linear_combination(B[k], row_t),
        )
        weight = factor * weights[k]
        if rule.kind == FLUX:
            add_moments(A, A_s, A_t, weight, out)
        else:
            out[0] += weight * jacobian(A, A_s, A_t)


@inner(linked=False)
def add_strip(grid, start, place, rule, factor, out):
    """Add `factor` ∫ … du from u = `start` to the u of `place` (u, v) to `out`, by element.

    `grid` is a `BezierGrid`, `rule` a `GaussRule`, whose kind decides on the integrand.
    """
    coefs, u_breaks, v_breaks = grid.coefs, grid.u_breaks, grid.v_breaks
    nodes, parts = rule.nodes, rule.parts
    p, q = coefs.shape[2] - 1, coefs.shape[3] - 1
    u, v = place
    low, high = min(start, u), max(start, u)
    j = min(max(count_up_to(v_breaks, v) - 1, 0), v_breaks.size - 2)
    height = v_breaks[j + 1] - v_breaks[j]
    C, dC = np.empty(q + 1), np.empty(q + 1)
    bernstein(q, (v - v_breaks[j]) / height, C, dC)
    B, dB = np.empty((nodes.size, p + 1)), np.empty((nodes.size, p + 1))
    first = last = -1.0  # the part of B and dB: most elements are integrated in full
    i = min(max(count_up_to(u_breaks, low) - 1, 0), u_breaks.size - 2)
    # ds = du / width cancels the width in S_s = S_u · width; dt does not.
    signed = factor / height if u >= start else -factor / height
    while i < u_breaks.size - 1 and u_breaks[i] < high:
        width = u_breaks[i + 1] - u_breaks[i]
        a = max(low - u_breaks[i], 0.0) / width
        b = min(high - u_breaks[i], width) / width
        for k in range(parts):
            s, e = a + (b - a) * k / parts, a + (b - a) * (k + 1) / parts
            if s != first or e != last:
                first, last = s, e
                for n in range(nodes.size):
                    bernstein(p, s + (e - s) * nodes[n], B[n], dB[n])
            _add_element(coefs[i, j], (B, dB), (C, dC), rule, signed * (e - s), out)
        i += 1


@inner()
def _knot_crossings(tables, piece, u_breaks, v_breaks):
    """Return ascending parameters, 0 and 1 included, at which a piece crosses element borders."""
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    crossings = np.empty(2 + u_breaks.size + v_breaks.size)
    crossings[0], crossings[1] = 0.0, 1.0
    n = 2
    for axis in range(2):
        first = coefs[0, axis] / coefs[0, 2]
        last = coefs[degree, axis] / coefs[degree, 2]
        for level in u_breaks if axis == 0 else v_breaks:
            if min(first, last) < level < max(first, last):
                crossings[n] = parameter_at(coefs, degree, axis, level)
                n += 1
    crossings = crossings[:n]
    sort(crossings)
    return crossings


@inner()
def add_piece(tables, piece, start, grid, rule, sign, out):
    """Add `sign` ∫ F dv along a piece to `out`; ``F(u, v)`` is the strip integral from u = `start`.

    Points outside the rectangle are moved to its sides in u, and left out in v.
    """
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    u0, u1, v0, v1 = (
        tables.domain[tables.piece_patch[piece], 0],
        tables.domain[tables.piece_patch[piece], 1],
        tables.domain[tables.piece_patch[piece], 2],
        tables.domain[tables.piece_patch[piece], 3],
    )
    nodes, weights, parts = rule.nodes, rule.weights, rule.parts
    breaks = _knot_crossings(tables, piece, grid.u_breaks, grid.v_breaks)
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
                place = (min(max(x / w, u0), u1), v)
                add_strip(grid, start, place, rule, sign * weights[k] * width * slope, out)


@inner()
def _is_inside(tables, patch, u, v):
    """Return `point_in_trim` of (u, v); 0 outside the patch's rectangle."""
    d = tables.domain[patch]
    if u < d[0] or u > d[1] or v < d[2] or v > d[3]:
        return 0
    return point_in_trim(tables, patch, u, v)


@inner()
def side_of_piece(tables, piece):
    """Return 1 if the face lies left of a piece, −1 if right, 0 if on both sides or on neither.

    Points a millionth, then 1e-4 and 1e-8 of the domain beside its middle decide. A piece without
    length there has 0.
    """
    patch = tables.piece_patch[piece]
    d = tables.domain[patch]
    su, sv = d[1] - d[0], d[3] - d[2]
    coefs = tables.piece_coefs[piece]
    degree = tables.piece_degree[piece]
    for step in (1e-6, 1e-4, 1e-8):
        points = scratch(2, 2)
        for k in range(2):
            t = 0.49 + 0.02 * k
            w = bernstein_at(coefs, degree, 2, t)
            points[k, 0] = bernstein_at(coefs, degree, 0, t) / w / su
            points[k, 1] = bernstein_at(coefs, degree, 1, t) / w / sv
        du, dv = points[1, 0] - points[0, 0], points[1, 1] - points[0, 1]
        length = np.sqrt(du * du + dv * dv)
        if length == 0.0:
            return 0
        # The rectangle clips the piece.
        u = min(max(0.5 * (points[0, 0] + points[1, 0]), d[0] / su), d[1] / su)
        v = min(max(0.5 * (points[0, 1] + points[1, 1]), d[2] / sv), d[3] / sv)
        left = _is_inside(
            tables, patch, (u - step * dv / length) * su, (v + step * du / length) * sv
        )
        right = _is_inside(
            tables, patch, (u + step * dv / length) * su, (v - step * du / length) * sv
        )
        if left != right:
            return 1 if left == 1 else -1
    return 0


@kernel()
def side_of_loop(tables, pieces):
    """Return 1 if the face lies left of a loop (its pieces in order), −1 if right, 0 if undecided.

    The longest piece with the face on one side decides: a loop may touch another, or run along the
    border of the rectangle and beyond it.
    """
    longest, side = 0.0, 0
    d = tables.domain[tables.piece_patch[pieces[0]]]
    for p in pieces:
        ends = tables.piece_ends[p]
        length = abs(ends[2] - ends[0]) / (d[1] - d[0]) + abs(ends[3] - ends[1]) / (d[3] - d[2])
        if length > longest:
            piece_side = side_of_piece(tables, p)
            if piece_side != 0:
                longest, side = length, piece_side
    return side


@kernel()
def add_loop(tables, pieces, grid, rule, out):
    """Add the signed contribution of a loop (its pieces in order) to integrals `out` of its patch.

    A loop whose side is undecided adds nothing.
    """
    sign = side_of_loop(tables, pieces)
    if sign == 0:
        return
    start = np.inf
    d = tables.domain[tables.piece_patch[pieces[0]]]
    for p in pieces:
        start = min(start, tables.piece_ends[p, 0], tables.piece_ends[p, 2])
    start = min(max(start, d[0]), d[1])
    # Summed separately: a small hole must not get the rounding of the large face around it.
    contribution = np.zeros(out.size)
    for p in pieces:
        add_piece(tables, p, start, grid, rule, 1.0 * sign, contribution)
    for k in range(out.size):
        out[k] += contribution[k]


@kernel()
def add_rectangle(grid, rule, out):
    """Add integrals over the whole patch to `out`: strips from side to side, by element in v."""
    u_breaks, v_breaks = grid.u_breaks, grid.v_breaks
    nodes, weights, parts = rule.nodes, rule.weights, rule.parts
    for j in range(v_breaks.size - 1):
        height = (v_breaks[j + 1] - v_breaks[j]) / parts
        for part in range(parts):
            for k in range(nodes.size):
                place = (u_breaks[-1], v_breaks[j] + (part + nodes[k]) * height)
                add_strip(grid, u_breaks[0], place, rule, weights[k] * height, out)
