"""Cells of elements with rigorous bounds of their derivatives, normals and curvatures.

A cell is a rectangle of one element. Its own parameters (x, y) go from −1/2 to 1/2. Let a, b be
the derivatives at its middle, n its normal there, and (a b) = Q R with orthonormal columns of Q:
lengths and curvatures are measured in the coordinates R (dx, dy), in which the metric of the middle
is the identity. All bounds come from Bernstein coefficients, as in `bounds_nb`.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.bounds_nb import derivative_bounds, restrict
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.balls.kernels.ball_plane_nb import unit_normal

MAX_CHANGE = 0.98
"""Relative change of derivatives from those of the middle above which a cell bounds nothing."""


@inner()
def _difference_range(g, degree, order):
    """Return the least and largest coefficient of a difference of the scalar net `g`.

    `order` (a, b) are its orders in s and t: the range of that derivative over −1/2 … 1/2. Zeros
    above the degree.
    """
    p, q = degree
    a, b = order
    if a > p or b > q:
        return 0.0, 0.0
    work = g.copy()
    factor = 1.0
    for m in range(a):
        factor *= p - m
        for i in range(p - m):
            for j in range(q + 1):
                work[i * (q + 1) + j] = work[(i + 1) * (q + 1) + j] - work[i * (q + 1) + j]
    for m in range(b):
        factor *= q - m
        for i in range(p + 1 - a):
            for j in range(q - m):
                work[i * (q + 1) + j] = work[i * (q + 1) + j + 1] - work[i * (q + 1) + j]
    low = math.inf
    high = -math.inf
    for i in range(p + 1 - a):
        for j in range(q + 1 - b):
            low = min(low, work[i * (q + 1) + j])
            high = max(high, work[i * (q + 1) + j])
    return factor * low, factor * high


@inner()
def _largest_difference(g, degree, order):
    """Return the largest absolute coefficient of the difference of `order` of a net."""
    low, high = _difference_range(g, degree, order)
    return max(-low, high)


@inner()
def _quotient_range(g, degree, order, weights, slack):
    """Return bounds of the difference of `g` over a weight within `weights`, widened by `slack`."""
    low, high = _difference_range(g, degree, order)
    min_weight, max_weight = weights
    return min(low / min_weight, low / max_weight) - slack, max(
        high / min_weight, high / max_weight
    ) + slack


@inner()
def deviation(cell, da, db):
    """Return the norm of a change of the derivatives by at most (da, db), in the cell's metric."""
    r11, r12, r22 = cell["metric"]
    return math.hypot(da / r11, (db + da * abs(r12) / r11) / r22)


@inner()
def normal_curvatures(cell, slack):
    """Return the range of N·S''(d, d) over |R d|², N any unit vector near the cell's normal.

    `slack` is the largest |N − n|. Positive is towards the normal.
    """
    r11, r12, r22 = cell["metric"]
    form = cell["form"]
    # N = cos·n + sin·(a tangent): only the tangent has a product with the tangential part of S''.
    more = slack * cell["slide"] + 0.5 * slack * slack * cell["second"]
    i11 = 1.0 / r11
    i22 = 1.0 / r22
    i12 = -r12 * i11 * i22
    min_curvature = math.inf
    max_curvature = -math.inf
    for side in range(2):  # the diagonal of S'' at its lower, then its upper bounds
        sign = 2.0 * side - 1.0
        ss = form[side] + sign * more[0]
        tt = form[4 + side] + sign * more[2]
        for other in range(2):
            st = form[2 + other] + (2.0 * other - 1.0) * more[1]
            m11 = ss * i11 * i11
            m12 = i11 * (ss * i12 + st * i22)
            m22 = ss * i12 * i12 + 2.0 * st * i12 * i22 + tt * i22 * i22
            middle = 0.5 * (m11 + m22)
            reach = math.hypot(0.5 * (m11 - m22), m12)
            low, high = middle - reach, middle + reach
            if side == 0:
                min_curvature = min(min_curvature, low)
            else:
                max_curvature = max(max_curvature, high)
    return min_curvature, max_curvature


@inner()
def _frame_of_middle(h, hs, ht, cell):
    """Write derivatives, normal, metric and extent of the middle to the cell.

    Returns False, with only the extent set, if the derivatives span no plane.
    """
    ax, ay, az = h[0, 1] * hs, h[1, 1] * hs, h[2, 1] * hs
    bx, by, bz = h[0, 2] * ht, h[1, 2] * ht, h[2, 2] * ht
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    area = math.sqrt(nx * nx + ny * ny + nz * nz)
    r11 = math.sqrt(ax * ax + ay * ay + az * az)
    length = math.sqrt(bx * bx + by * by + bz * bz)
    cell["extent"] = 0.5 * math.hypot(r11, length)
    if not area > 1e-6 * r11 * length:
        return False
    cell["first"][0, 0] = ax
    cell["first"][0, 1] = ay
    cell["first"][0, 2] = az
    cell["first"][1, 0] = bx
    cell["first"][1, 1] = by
    cell["first"][1, 2] = bz
    cell["normal"][0] = nx / area
    cell["normal"][1] = ny / area
    cell["normal"][2] = nz / area
    cell["metric"][0] = r11
    cell["metric"][1] = (ax * bx + ay * by + az * bz) / r11
    cell["metric"][2] = area / r11
    return True


@inner()
def _normal_bounds(g, w, degree, cell):
    """Return bounds of |n·S_x| and |n·S_y|, and write the ranges of n·S'' to cell["form"].

    `g` and `w` are the nets of n·A and of the weight.
    """
    p, q = degree
    min_weight, max_weight = w[0], w[0]
    height = 0.0
    for k in range((p + 1) * (q + 1)):
        min_weight, max_weight = min(min_weight, w[k]), max(max_weight, w[k])
        height = max(height, abs(g[k]) / w[k])
    w10 = _largest_difference(w, degree, (1, 0))
    w01 = _largest_difference(w, degree, (0, 1))
    f10 = (_largest_difference(g, degree, (1, 0)) + w10 * height) / min_weight
    f01 = (_largest_difference(g, degree, (0, 1)) + w01 * height) / min_weight
    weights = (min_weight, max_weight)
    form = cell["form"]
    slack = (2.0 * w10 * f10 + _largest_difference(w, degree, (2, 0)) * height) / min_weight
    form[0], form[1] = _quotient_range(g, degree, (2, 0), weights, slack)
    slack = (w10 * f01 + w01 * f10 + _largest_difference(w, degree, (1, 1)) * height) / min_weight
    form[2], form[3] = _quotient_range(g, degree, (1, 1), weights, slack)
    slack = (2.0 * w01 * f01 + _largest_difference(w, degree, (0, 2)) * height) / min_weight
    form[4], form[5] = _quotient_range(g, degree, (0, 2), weights, slack)
    return f10, f01


@inner()
def _subtract_affine(net, degree, h, sizes, remainder):
    """Write the net of the cell less the affine map of its middle to `remainder`.

    It is one degree higher; `remainder` is zero before. (A − wL)/w with L = S + x S_x + y S_y at
    the middle has the second derivatives of A/w, but the factors of the derivatives of w in the
    quotient rule are small: without L the twist of a long cylinder would appear as large as its
    length.
    """
    p, q = degree
    for a in range(2):
        x = (a - 0.5) * sizes[0]
        for b in range(2):
            y = (b - 0.5) * sizes[1]
            for i in range(p + 2):
                k = i - a
                if k < 0 or k > p:
                    continue
                share = i / (p + 1.0) if a == 1 else 1.0 - i / (p + 1.0)
                for j in range(q + 2):
                    m = j - b
                    if m < 0 or m > q:
                        continue
                    factor = share * (j / (q + 1.0) if b == 1 else 1.0 - j / (q + 1.0))
                    old = k * (q + 1) + m
                    new = i * (q + 2) + j
                    w = net[old, 3]
                    remainder[new, 3] += factor * w
                    for c in range(3):
                        affine = h[c, 0] + x * h[c, 1] + y * h[c, 2]
                        remainder[new, c] += factor * (net[old, c] - w * affine)


@inner(linked=False)
def measure(elements, e, centre, cell):
    """Write the bounds of a cell whose element and box are set; lengths are about `centre`.

    `turn` is infinite where the middle has no plane, or derivatives change too much for bounds of
    normals and curvatures, which then are not set.
    """
    box = cell["box"]
    table = elements.table[e]
    p = table["degree"][0]
    q = table["degree"][1]
    start = table["bernstein"]
    n = (p + 1) * (q + 1)
    net = np.empty((n, 4))
    h = scratch(4, 6)
    hs = box[1] - box[0]
    ht = box[3] - box[2]
    restrict(elements.coefs[start : start + 4 * n], (p, q), (box[0], box[1], box[2], box[3]), net)
    evaluate(elements, e, 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3]), h)
    for k in range(4):
        row = k // 2 * p * (q + 1) + k % 2 * q
        for c in range(3):
            cell["corner"][k, c] = net[row, c] / net[row, 3] + (table["origin"][c] - centre[c])
    for c in range(3):
        cell["middle"][c] = h[c, 0] + (table["origin"][c] - centre[c])
    has_plane = _frame_of_middle(h, hs, ht, cell)
    g = np.zeros(n)
    if has_plane:
        for k in range(n):
            for c in range(3):
                g[k] += cell["normal"][c] * (net[k, c] - net[k, 3] * h[c, 0])
        f10, f01 = _normal_bounds(g, net[:, 3].copy(), (p, q), cell)
    bound = scratch(9)
    corner = scratch(2, 3)
    remainder = np.zeros(((p + 2) * (q + 2), 4))
    _subtract_affine(net, (p, q), h, (hs, ht), remainder)
    derivative_bounds(remainder, (p + 1, q + 1), (1.0, 1.0), bound, corner[0], corner[1])
    # Bounds of |S''| and of its part along the tangent plane of the middle. For a rational cell the
    # bound by the value at the middle and its change is about half as large.
    sizes, normal = (hs * hs, hs * ht, ht * ht), cell["normal"]
    for k in range(3):
        x, y, z = h[0, 3 + k] * sizes[k], h[1, 3 + k] * sizes[k], h[2, 3 + k] * sizes[k]
        height = x * normal[0] + y * normal[1] + z * normal[2]
        square = x * x + y * y + z * z
        change = 0.5 * (bound[5 + k] + bound[6 + k])
        cell["second"][k] = min(bound[2 + k], math.sqrt(square) + change)
        cell["slide"][k] = min(bound[2 + k], math.sqrt(max(square - height * height, 0.0)) + change)
    second = cell["second"]
    cell["bulge"] = 0.125 * (second[0] + second[2])
    cell["rise"] = cell["bulge"]
    cell["sink"] = cell["bulge"]
    cell["turn"] = math.inf
    if not has_plane:
        return
    _curvature_bounds((f10, f01), bound, cell)
    for k in range(4):
        evaluate(elements, e, box[k // 2], box[2 + k % 2], h)
        if not unit_normal(h, cell["corner_normal"][k]):
            cell["wobble"] = math.inf


@inner()
def _curvature_bounds(slopes, bound, cell):
    """Write the changes of derivatives and normals, and the curvatures, of a cell.

    `slopes` bounds n·S_x and n·S_y, `bound` the derivatives without the affine map. `turn` and the
    bounds after it stay as they are if derivatives or normals change by `MAX_CHANGE` or more.
    """
    second = cell["second"]
    form = cell["form"]
    cell["rise"] = 0.125 * (max(-form[0], 0.0) + max(-form[4], 0.0))
    cell["sink"] = 0.125 * (max(form[1], 0.0) + max(form[5], 0.0))
    change = cell["change"]
    change[0] = min(bound[0], 0.5 * (second[0] + second[1]))
    change[1] = min(bound[1], 0.5 * (second[1] + second[2]))
    turn = deviation(cell, change[0], change[1])
    if not turn < MAX_CHANGE:
        return
    slide = cell["slide"]
    shear = deviation(
        cell,
        min(change[0], 0.5 * (slide[0] + slide[1])),
        min(change[1], 0.5 * (slide[1] + slide[2])),
    )
    tilt = deviation(cell, slopes[0], slopes[1]) / (1.0 - shear)
    if not tilt < MAX_CHANGE:
        return
    cell["turn"] = turn
    cell["tilt"] = tilt
    cell["shear"] = shear
    low, high = normal_curvatures(cell, 2.0 * math.sin(0.5 * math.asin(tilt)))
    cell["bend"][0] = low / ((1.0 - shear) ** 2 if low < 0.0 else (1.0 + turn) ** 2)
    cell["bend"][1] = high / ((1.0 - shear) ** 2 if high > 0.0 else (1.0 + turn) ** 2)
    # Distance of the normals from the bilinear patch of the corners' normals. With |N_x| ≤ κ|S_x|:
    # N·N_xx = −|N_x|² and N_xx·S_i = −N·S_ixx − 2 N_x·S_ix, and likewise in y.
    r11, r12, r22 = cell["metric"]
    curvature = max(-cell["bend"][0], cell["bend"][1])
    nx = curvature * (r11 + 0.5 * (second[0] + second[1]))
    ny = curvature * (math.hypot(r12, r22) + 0.5 * (second[1] + second[2]))
    xx = deviation(cell, bound[5] + 2.0 * nx * second[0], bound[6] + 2.0 * nx * second[1])
    yy = deviation(cell, bound[7] + 2.0 * ny * second[1], bound[8] + 2.0 * ny * second[2])
    cell["wobble"] = 0.125 * (nx * nx + ny * ny + (xx + yy) / (1.0 - cell["turn"]))


@kernel()
def measure_cells(elements, centre, cells, start, stop):
    """Run `measure` for cells[start:stop]."""
    for k in range(start, stop):
        measure(elements, cells[k]["element"], centre, cells[k])
