"""Rigorous bounds of an element's derivatives over a box, from Bernstein coefficients.

The derivative of a Bézier element is a Bézier element of the coefficient differences, so the
largest difference bounds it. For a rational element S = A/w the quotient rule turns bounds on
A, w and their derivatives into bounds on S: with the origin moved into the box, |S| ≤ R and

    |S_s| ≤ (|A_s| + |w_s| R)/w_min,    |S_ss| ≤ (|A_ss| + 2|w_s||S_s| + |w_ss| R)/w_min, …
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch


@inner()
def _restrict_line(net, n, stride, start, a, b):
    """Restrict Bernstein coefficients net[start + i*stride, :], i = 0..n, to [a, b] in place.

    De Casteljau's algorithm is applied at both ends; 0 ≤ a < b ≤ 1.
    """
    for c in range(4):
        for k in range(1, n + 1):  # de Casteljau at b: keep the left part
            for i in range(n, k - 1, -1):
                x = net[start + (i - 1) * stride, c]
                net[start + i * stride, c] = x + b * (net[start + i * stride, c] - x)
        r = a / b if b > 0.0 else 0.0
        for k in range(1, n + 1):  # then at a/b: keep the right part
            for i in range(n - k + 1):
                x = net[start + i * stride, c]
                net[start + i * stride, c] = x + r * (net[start + (i + 1) * stride, c] - x)


@inner(linked=False)
def restrict(coefs, degree, box, net):
    """Write the Bernstein coefficients of the element on a box to net[(p + 1)(q + 1), 4].

    `box` is s0, s1, t0, t1 in [-1/2, 1/2]; `coefs` are the element's own, flat, and not changed.
    """
    p, q = degree
    for k in range((p + 1) * (q + 1)):
        for c in range(4):
            net[k, c] = coefs[4 * k + c]
    for j in range(q + 1):
        _restrict_line(net, p, q + 1, j, box[0] + 0.5, box[1] + 0.5)
    for i in range(p + 1):
        _restrict_line(net, q, 1, i * (q + 1), box[2] + 0.5, box[3] + 0.5)


@inner()
def _differences(net, shape, stride, step, factor, out):
    """Write the differences of coefficients `step` places apart to `out`, and return their bounds.

    They are taken for the first `shape` = (rows, columns) of a net, none if one is not positive;
    rows begin `stride` places apart. The bounds are the largest |A| and |w|, times `factor`.
    """
    top = 0.0
    top_w = 0.0
    for i in range(shape[0]):
        for k in range(i * stride, i * stride + shape[1]):
            for c in range(4):
                out[k, c] = net[k + step, c] - net[k, c]
            top = max(top, out[k, 0] ** 2 + out[k, 1] ** 2 + out[k, 2] ** 2)
            top_w = max(top_w, abs(out[k, 3]))
    return factor * math.sqrt(top), factor * top_w


@inner(linked=False)
def derivative_bounds(net, degree, size, bound, low, high):
    """Write bounds of the derivatives over a box with coefficients `net` and two sides `size`.

    They go into bound[9], for orders 10, 01, 20, 11, 02, 30, 21, 12, 03, and the corners of the
    box around the control points into `low` and `high`, relative to the element's origin. Changes
    `net`: its origin moves to the middle of that box.
    """
    p, q = degree
    n = (p + 1) * (q + 1)
    w_min = net[0, 3]
    for c in range(3):
        low[c] = math.inf
        high[c] = -math.inf
    for k in range(n):
        w_min = min(w_min, net[k, 3])
        for c in range(3):
            x = net[k, c] / net[k, 3]
            low[c] = min(low[c], x)
            high[c] = max(high[c], x)
    radius = 0.0
    for k in range(n):
        square = 0.0
        for c in range(3):
            middle = 0.5 * (low[c] + high[c])
            square += (net[k, c] / net[k, 3] - middle) ** 2
            net[k, c] -= net[k, 3] * middle
        radius = max(radius, square)
    radius = math.sqrt(radius)
    # Each order follows from the one before; orders above the degree are 0.
    m = q + 1
    pp, qq = p * (p - 1), q * (q - 1)
    first_diff, second_diff, third_diff = np.empty((n, 4)), np.empty((n, 4)), np.empty((n, 4))
    a10, w10 = _differences(net, (p, m), m, m, p, first_diff)
    a20, w20 = _differences(first_diff, (p - 1, m), m, m, pp, second_diff)
    a30, w30 = _differences(second_diff, (p - 2, m), m, m, pp * (p - 2), third_diff)
    a21, w21 = _differences(second_diff, (p - 1, q), m, 1, pp * q, third_diff)
    a11, w11 = _differences(first_diff, (p, q), m, 1, p * q, second_diff)
    a12, w12 = _differences(second_diff, (p, q - 1), m, 1, p * qq, third_diff)
    a01, w01 = _differences(net, (p + 1, q), m, 1, q, first_diff)
    a02, w02 = _differences(first_diff, (p + 1, q - 1), m, 1, qq, second_diff)
    a03, w03 = _differences(second_diff, (p + 1, q - 2), m, 1, qq * (q - 2), third_diff)
    v = 1.0 / w_min
    k10 = (a10 + w10 * radius) * v
    k01 = (a01 + w01 * radius) * v
    k20 = (a20 + 2.0 * w10 * k10 + w20 * radius) * v
    k11 = (a11 + w10 * k01 + w01 * k10 + w11 * radius) * v
    k02 = (a02 + 2.0 * w01 * k01 + w02 * radius) * v
    k30 = (a30 + 3.0 * w10 * k20 + 3.0 * w20 * k10 + w30 * radius) * v
    k21 = (a21 + 2.0 * w10 * k11 + w01 * k20 + w20 * k01 + 2.0 * w11 * k10 + w21 * radius) * v
    k12 = (a12 + 2.0 * w01 * k11 + w10 * k02 + w02 * k10 + 2.0 * w11 * k01 + w12 * radius) * v
    k03 = (a03 + 3.0 * w01 * k02 + 3.0 * w02 * k01 + w03 * radius) * v
    hs, ht = size
    bound[0] = k10 / hs
    bound[1] = k01 / ht
    bound[2] = k20 / hs**2
    bound[3] = k11 / (hs * ht)
    bound[4] = k02 / ht**2
    bound[5] = k30 / hs**3
    bound[6] = k21 / (hs**2 * ht)
    bound[7] = k12 / (hs * ht**2)
    bound[8] = k03 / ht**3


@inner()
def cell_bounds(elements, e, cell, bound):
    """Write the derivative bounds over one cell of element e into bound[9].

    `cell` is s0, s1, t0, t1. They are tighter than those of its leaf, above all at a pole.
    """
    cell_box(elements, e, cell, bound, scratch(2, 3))


@inner()
def cell_box(elements, e, cell, bound, corner):
    """Write `cell_bounds`, and the box of the cell's control points into `corner` (2, 3).

    The box is relative to the element's origin.
    """
    table = elements.table[e]
    p = table["degree"][0]
    q = table["degree"][1]
    start = table["bernstein"]
    n = (p + 1) * (q + 1)
    net = np.empty((n, 4))
    restrict(elements.coefs[start : start + 4 * n], (p, q), cell, net)
    size = (cell[1] - cell[0], cell[3] - cell[2])
    derivative_bounds(net, (p, q), size, bound, corner[0], corner[1])


@inner()
def _is_farther(net, degree, limit):
    """Return whether |A|² − limit² w² > 0 is proved on the complete box with coefficients `net`.

    True if all its coefficients are positive; False proves nothing. The Bernstein coefficients of
    the product of two polynomials are the convolution of theirs, each times a binomial (Farouki &
    Rajan 1988, doi 10.1016/0167-8396(88)90016-7); only their sign matters. Changes `net`:
    multiplied by the binomials, weights also by `limit`.
    """
    p, q = degree
    binomial_p = 1.0
    for i in range(p + 1):
        binomial = binomial_p
        for j in range(q + 1):
            for c in range(3):
                net[i * (q + 1) + j, c] *= binomial
            net[i * (q + 1) + j, 3] *= binomial * limit
            binomial *= (q - j) / (j + 1.0)
        binomial_p *= (p - i) / (i + 1.0)
    for k in range(2 * p + 1):
        for m in range(2 * q + 1):
            total = 0.0
            for i in range(max(0, k - p), min(k, p) + 1):
                row = i * (q + 1)
                back = (k - i) * (q + 1) + m
                for j in range(max(0, m - q), min(m, q) + 1):
                    a = net[row + j]
                    b = net[back - j]
                    total += a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - a[3] * b[3]
            if total <= 0.0:
                return False
    return True


@kernel()
def is_beyond_limit(elements, e, cell, point, limit, bound):
    """Return whether all of a cell is proved farther than `limit` from `point`.

    `point` is relative to the element's origin. If it is not proved, or `limit` is 0, the result is
    False, and the derivative bounds over this cell are written into `bound` (9,).
    """
    table = elements.table[e]
    p = table["degree"][0]
    q = table["degree"][1]
    start = table["bernstein"]
    n = (p + 1) * (q + 1)
    coefs = elements.coefs[start : start + 4 * n]
    net = np.empty((n, 4))
    moved = np.empty((n, 4))
    corner = scratch(2, 3)
    restrict(coefs, (p, q), cell, net)
    for k in range(n):
        for c in range(3):
            moved[k, c] = net[k, c] - net[k, 3] * point[c]
        moved[k, 3] = net[k, 3]
    if limit > 0.0 and _is_farther(moved, (p, q), limit):
        return True
    size = (cell[1] - cell[0], cell[3] - cell[2])
    derivative_bounds(net, (p, q), size, bound, corner[0], corner[1])
    return False


@inner()
def split_direction(bound, size, flatness):
    """Return the direction in which to halve a box: 0 for s, 1 for t, −1 if the box is flat.

    Flat: the surface departs from its tangent parallelogram by `flatness` of the box's larger
    extent at most. Otherwise an extent more than three times the other is halved first, else the
    direction that bends more, s on a tie.
    """
    hs = 0.5 * size[0]
    ht = 0.5 * size[1]
    bend_s = 0.5 * bound[2] * hs * hs
    bend_t = 0.5 * bound[4] * ht * ht
    twist = bound[3] * hs * ht
    extent_s = bound[0] * hs
    extent_t = bound[1] * ht
    if bend_s + bend_t + twist <= flatness * max(extent_s, extent_t):
        return -1
    if extent_s > 3.0 * extent_t:
        return 0
    if extent_t > 3.0 * extent_s:
        return 1
    return 0 if bend_s >= bend_t else 1


@inner()
def subdivide(elements, e, flatness, depth, rows):
    """Write the leaves of element e to the first of `rows` (m, 20); return their number.

    A row is e, the box in (s, t), nine bounds, and the low and the high corner of the box around
    the control points, body axes. A leaf is flat by `split_direction`, or results from `depth`
    halvings; `rows` must have room for all.
    """
    p = elements.table[e]["degree"][0]
    q = elements.table[e]["degree"][1]
    start = elements.table[e]["bernstein"]
    n = (p + 1) * (q + 1)
    coefs = elements.coefs[start : start + 4 * n]
    net = np.empty((n, 4))
    stack = scratch(64, 5)
    put(stack, 0, (-0.5, 0.5, -0.5, 0.5, 0.0))
    top = 1
    count = 0
    while top > 0:
        top -= 1
        s0, s1, t0, t1, level = stack[top]
        row = rows[count]
        restrict(coefs, (p, q), (s0, s1, t0, t1), net)
        size = (s1 - s0, t1 - t0)
        derivative_bounds(net, (p, q), size, row[5:14], row[14:17], row[17:20])
        direction = split_direction(row[5:14], size, flatness)
        if direction < 0 or level >= depth:
            put(rows, count, (float(e), s0, s1, t0, t1))
            for c in range(3):
                row[14 + c] += elements.table[e]["origin"][c]
                row[17 + c] += elements.table[e]["origin"][c]
            count += 1
        elif direction == 0:
            m = 0.5 * (s0 + s1)
            put(stack, top, (s0, m, t0, t1, level + 1.0))
            put(stack, top + 1, (m, s1, t0, t1, level + 1.0))
            top += 2
        else:
            m = 0.5 * (t0 + t1)
            put(stack, top, (s0, s1, t0, m, level + 1.0))
            put(stack, top + 1, (s0, s1, m, t1, level + 1.0))
            top += 2
    return count
