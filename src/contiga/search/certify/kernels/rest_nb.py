"""Bound the second-order Taylor remainder of an element over a parameter box.

With T that polynomial of S = A/w about the middle of the box and D = S − T, the polynomial
B = A − w T = w D begins with terms of third order. The sum of the sizes of its coefficients in
powers about the middle bounds it and its derivatives, and the quotient rule those of D:

    |D_x| ≤ (|B_x| + |w_x| |D|)/w_min,   |D_xx| ≤ (|B_xx| + 2 |w_x| |D_x| + |w_xx| |D|)/w_min, …

Unlike bounds of third derivatives of a quotient, which grow with its weights' slopes, these tend
to what the third derivatives in the middle say as the box shrinks.
"""

from __future__ import annotations

import math

from contiga.elements.kernels.bounds_nb import cell_bounds
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inlined, inner
from contiga.jit.scratch import scratch

N_COEFS = 8
"""Coefficients of B a direction: degree five at most, and two of T."""
D10, D01, D20, D11, D02 = 0, 1, 2, 3, 4


@inner(linked=False, error_model="numpy")
def centred(elements, e, cell, a):
    """Coefficients of (A, w) over a cell in powers of x, y in [-1, 1], into a[8, 8, 4]."""
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
    # Powers along the first direction become those of (x − at)/half; of all the columns there is
    # room for, as a loop of that many needs no choice.
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
    """S and its derivatives by x and y to second order in the middle, into h[:3, :6]."""
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
def _with(total, i, j, size):
    """A total with the largest value and derivatives of a term x^i y^j times `size` added."""
    return (
        total[0] + size,
        total[1] + i * size,
        total[2] + j * size,
        total[3] + i * (i - 1) * size,
        total[4] + i * j * size,
        total[5] + j * (j - 1) * size,
    )


@inlined()
def _departure(a, h, c, i, j):
    """A coordinate of the coefficient of x^i y^j of B; each of i and j with the two before it."""
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
def _before(i):
    """Return the index of the coefficient before the i-th: of a zero, where that is the first."""
    return (i - 1) & (N_COEFS - 1)


@inner(linked=False, error_model="numpy")
def sums_of(a, p, q, h, normal, sums):
    """Bounds of B (0), of its part along the normal (1) and of w (2) with derivatives to the
    second, into sums[3, 6]; returns the least weight."""
    whole = along = weight = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(p + 1):
        for j in range(q + 1):
            if i + j > 0:
                weight = _with(weight, i, j, abs(a[i, j, 3]))
    for i in range(p + 3):
        i1 = _before(i)
        i2 = _before(i1)
        for j in range(max(3 - i, 0), q + 3):
            j1 = _before(j)
            j2 = _before(j1)
            x = _departure(a, h, 0, (i, i1, i2), (j, j1, j2))
            y = _departure(a, h, 1, (i, i1, i2), (j, j1, j2))
            z = _departure(a, h, 2, (i, i1, i2), (j, j1, j2))
            whole = _with(whole, i, j, math.sqrt(x * x + y * y + z * z))
            along = _with(along, i, j, abs(x * normal[0] + y * normal[1] + z * normal[2]))
    for k in range(6):
        sums[0, k], sums[1, k], sums[2, k] = whole[k], along[k], weight[k]
    return a[0, 0, 3] - weight[0]


@inner(error_model="numpy")
def quotient_rest(b, w, least, rest):
    """Bounds of D from those of B and w, into rest[5]."""
    i = 1.0 / least
    d = b[0] * i
    rest[D10] = (b[1] + w[1] * d) * i
    rest[D01] = (b[2] + w[2] * d) * i
    rest[D20] = (b[3] + 2.0 * w[1] * rest[D10] + w[3] * d) * i
    rest[D11] = (b[4] + w[1] * rest[D01] + w[2] * rest[D10] + w[4] * d) * i
    rest[D02] = (b[5] + 2.0 * w[2] * rest[D01] + w[5] * d) * i


@inner(error_model="numpy")
def unit_normal(h):
    """Unit normal of the derivatives `h`; zero where there is none."""
    x = h[1, 1] * h[2, 2] - h[2, 1] * h[1, 2]
    y = h[2, 1] * h[0, 2] - h[0, 1] * h[2, 2]
    z = h[0, 1] * h[1, 2] - h[1, 1] * h[0, 2]
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@inner(error_model="numpy")
def rest_of(elements, e, cell, h, rest):
    """Bounds of D_x, D_y, D_xx, D_xy, D_yy over a cell into rest[0], along the normal in rest[1].

    x and y run over [-1, 1] in the cell; `h` takes the derivatives by them in its middle. False
    where the weights allow no bound. Elements that have no powers are bounded by their third
    derivatives.
    """
    if elements.table[e]["monomial"] >= 0:
        a, sums = scratch(N_COEFS, N_COEFS, 4), scratch(3, 6)
        p, q = centred(elements, e, cell, a)
        taylor(a, h)
        least = sums_of(a, p, q, h, unit_normal(h), sums)
        if not least > 0.0:
            return False
        quotient_rest(sums[0], sums[2], least, rest[0])
        quotient_rest(sums[1], sums[2], least, rest[1])
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
        rest[k, D10] = 0.5 * (xxx + 2.0 * xxy + xyy)
        rest[k, D01] = 0.5 * (xxy + 2.0 * xyy + yyy)
        rest[k, D20] = xxx + xxy
        rest[k, D11] = xxy + xyy
        rest[k, D02] = xyy + yyy
    return True
