"""Bound the second-order Taylor remainder of an element over a parameter box.

With the Taylor polynomial T of S = A/w about the middle of the box and D = S − T, the polynomial
B = A − w T = w D begins with terms of third order. The sum of the magnitudes of its coefficients in
powers about the middle bounds B and its derivatives, and the quotient rule bounds D:

    |D_x| ≤ (|B_x| + |w_x| |D|)/w_min,   |D_xx| ≤ (|B_xx| + 2 |w_x| |D_x| + |w_xx| |D|)/w_min, …

Bounds of the third derivatives of a quotient grow with the slopes of the weights; these bounds tend
to the values by the third derivatives in the middle as the box shrinks.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.bounds_nb import cell_bounds
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inlined, inner
from contiga.jit.scratch import scratch

N_COEFS = 8
"""Number of coefficients of B in a direction: degree five at most, plus two of T."""
D10, D01, D20, D11, D02 = 0, 1, 2, 3, 4


@inner(linked=False, error_model="numpy")
def centred_coefficients(elements, e, cell, a):
    """Write the coefficients of (A, w) over a cell in powers of x, y in [-1, 1] to a[8, 8, 4].

    The rest of `a` becomes zero. Returns the degrees in s and t.
    """
    p = elements.table[e]["degree"][0]
    q = elements.table[e]["degree"][1]
    start = elements.table[e]["monomial"]
    a[:] = 0.0
    for i in range(p + 1):
        for j in range(q + 1):
            for c in range(4):
                a[i, j, c] = elements.coefs[start + (i * (q + 1) + j) * 4 + c]
    at = 0.5 * (cell[0] + cell[1]) - elements.table[e]["about"][0]
    half = 0.5 * (cell[1] - cell[0])
    # Powers along the first direction become powers of (x − at)/half; the loop runs over all
    # columns of the array, as a loop of constant length has no branches.
    for k in range(p):
        for i in range(p - 1, k - 1, -1):
            for m in range(N_COEFS):
                for c in range(4):
                    a[i, m, c] += at * a[i + 1, m, c]
    factor = 1.0
    for i in range(1, p + 1):
        factor *= half
        for m in range(N_COEFS):
            for c in range(4):
                a[i, m, c] *= factor
    at = 0.5 * (cell[2] + cell[3]) - elements.table[e]["about"][1]
    half = 0.5 * (cell[3] - cell[2])
    for m in range(p + 1):
        for k in range(q):
            for i in range(q - 1, k - 1, -1):
                for c in range(4):
                    a[m, i, c] += at * a[m, i + 1, c]
        factor = 1.0
        for i in range(1, q + 1):
            factor *= half
            for c in range(4):
                a[m, i, c] *= factor
    return p, q


@inner(error_model="numpy")
def taylor(a, h):
    """Write S and its derivatives by x and y to second order in the middle to h[:3, :6]."""
    i = 1.0 / a[0, 0, 3]
    for c in range(3):
        v = a[0, 0, c] * i
        x = (a[1, 0, c] - a[1, 0, 3] * v) * i
        y = (a[0, 1, c] - a[0, 1, 3] * v) * i
        h[c, 0] = v
        h[c, 1] = x
        h[c, 2] = y
        h[c, 3] = 2.0 * (a[2, 0, c] - a[1, 0, 3] * x - a[2, 0, 3] * v) * i
        h[c, 4] = (a[1, 1, c] - a[1, 0, 3] * y - a[0, 1, 3] * x - a[1, 1, 3] * v) * i
        h[c, 5] = 2.0 * (a[0, 2, c] - a[0, 1, 3] * y - a[0, 2, 3] * v) * i


@inlined()
def _add_term(total, i, j, size):
    """Return a total with the largest value and derivatives of a term `size` x^i y^j added."""
    return (
        total[0] + size,
        total[1] + i * size,
        total[2] + j * size,
        total[3] + i * (i - 1) * size,
        total[4] + i * j * size,
        total[5] + j * (j - 1) * size,
    )


@inlined()
def _remainder_coef(a, h, c, i, j):
    """Return coordinate c of the coefficient of x^i y^j of B.

    `i` and `j` are three indices each: its own and the two before (`_previous`).
    """
    return (
        a[i[0], j[0], c]
        - h[c, 0] * a[i[0], j[0], 3]
        - h[c, 1] * a[i[1], j[0], 3]
        - h[c, 2] * a[i[0], j[1], 3]
        - 0.5 * h[c, 3] * a[i[2], j[0], 3]
        - h[c, 4] * a[i[1], j[1], 3]
        - 0.5 * h[c, 5] * a[i[0], j[2], 3]
    )


@inlined()
def _previous(i):
    """Return the index before i; before 0 comes the last index, of a coefficient that is 0."""
    return (i - 1) & (N_COEFS - 1)


@inner(linked=False, error_model="numpy")
def sums_of(a, p, q, h, normal, sums):
    """Write bounds of B (0), of its part along the normal (1) and of w (2) to sums[3, 6].

    A row bounds the polynomial and its derivatives to second order over x, y in [-1, 1]; for w its
    value in the middle is subtracted before. Returns a lower bound of the weight, which may be
    negative.
    """
    total = along = weight = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(p + 1):
        for j in range(q + 1):
            if i + j > 0:
                weight = _add_term(weight, i, j, abs(a[i, j, 3]))
    for i in range(p + 3):
        i1 = _previous(i)
        i2 = _previous(i1)
        for j in range(max(3 - i, 0), q + 3):
            j1 = _previous(j)
            j2 = _previous(j1)
            x = _remainder_coef(a, h, 0, (i, i1, i2), (j, j1, j2))
            y = _remainder_coef(a, h, 1, (i, i1, i2), (j, j1, j2))
            z = _remainder_coef(a, h, 2, (i, i1, i2), (j, j1, j2))
            total = _add_term(total, i, j, math.sqrt(x * x + y * y + z * z))
            along = _add_term(along, i, j, abs(x * normal[0] + y * normal[1] + z * normal[2]))
    for k in range(6):
        sums[0, k], sums[1, k], sums[2, k] = total[k], along[k], weight[k]
    return a[0, 0, 3] - weight[0]


@inner(error_model="numpy")
def quotient_remainder(b, w, min_slope, remainder):
    """Write the bounds of the derivatives of D from those of B and w to remainder[5].

    `b` and `w` are rows of `sums_of`, `min_slope` is a lower bound of the weight, not of a slope.
    """
    i = 1.0 / min_slope
    d = b[0] * i
    remainder[D10] = (b[1] + w[1] * d) * i
    remainder[D01] = (b[2] + w[2] * d) * i
    remainder[D20] = (b[3] + 2.0 * w[1] * remainder[D10] + w[3] * d) * i
    remainder[D11] = (b[4] + w[1] * remainder[D01] + w[2] * remainder[D10] + w[4] * d) * i
    remainder[D02] = (b[5] + 2.0 * w[2] * remainder[D01] + w[5] * d) * i


@inner(error_model="numpy")
def unit_normal(h):
    """Return the unit normal (x, y, z) of the derivatives `h`; zeros if there is none."""
    x = h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2]
    y = h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2]
    z = h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2]
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@inner(error_model="numpy")
def remainder_of(elements, e, cell, h, remainder):
    """Write bounds of D_x, D_y, D_xx, D_xy, D_yy over a cell to remainder[2, 5].

    Row 0 bounds their lengths, row 1 their parts along the normal. x and y run over [-1, 1] in the
    cell; `h` gets the derivatives by them in its middle. Returns False if the weights allow no
    bound. Elements without monomials are bounded by their third derivatives, the same in both rows.
    """
    if elements.table[e]["monomial"] >= 0:
        a, sums = scratch(N_COEFS, N_COEFS, 4), scratch(3, 6)
        p, q = centred_coefficients(elements, e, cell, a)
        taylor(a, h)
        min_slope = sums_of(a, p, q, h, unit_normal(h), sums)
        if not min_slope > 0.0:
            return False
        quotient_remainder(sums[0], sums[2], min_slope, remainder[0])
        quotient_remainder(sums[1], sums[2], min_slope, remainder[1])
        return True
    hs = 0.5 * (cell[1] - cell[0])
    ht = 0.5 * (cell[3] - cell[2])
    evaluate(elements, e, 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]), h)
    for c in range(3):
        h[c, 1] *= hs
        h[c, 2] *= ht
        h[c, 3] *= hs * hs
        h[c, 4] *= hs * ht
        h[c, 5] *= ht * ht
    bound = scratch(9)
    cell_bounds(elements, e, cell, bound)
    xxx = bound[5] * hs**3
    xxy = bound[6] * hs * hs * ht
    xyy = bound[7] * hs * ht * ht
    yyy = bound[8] * ht**3
    for k in range(2):
        remainder[k, D10] = 0.5 * (xxx + 2.0 * xxy + xyy)
        remainder[k, D01] = 0.5 * (xxy + 2.0 * xyy + yyy)
        remainder[k, D20] = xxx + xxy
        remainder[k, D11] = xxy + xyy
        remainder[k, D02] = xyy + yyy
    return True
