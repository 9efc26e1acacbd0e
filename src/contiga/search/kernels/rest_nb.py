"""What an element's surface leaves its second-order Taylor polynomial by, over a box.

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
from contiga.num.jit import inner
from contiga.num.scratch import scratch

MOST = 8
"""Coefficients of B a direction: degree five at most, and two of T."""
D10, D01, D20, D11, D02 = 0, 1, 2, 3, 4


@inner(error_model="numpy")
def _shift(a, n, beside, along, at, half):
    """Powers of x along one direction turned into those of (x − at)/half, in place.

    There are n + 1 coefficients along it and `beside` + 1 along the other.
    """
    for c in range(4):
        for m in range(beside + 1):
            for k in range(n):
                for i in range(n - 1, k - 1, -1):
                    if along == 0:
                        a[c, i, m] += at * a[c, i + 1, m]
                    else:
                        a[c, m, i] += at * a[c, m, i + 1]
            factor = 1.0
            for i in range(1, n + 1):
                factor *= half
                if along == 0:
                    a[c, i, m] *= factor
                else:
                    a[c, m, i] *= factor


@inner(linked=False, error_model="numpy")
def centred(elements, e, cell, a):
    """Coefficients of (A, w) over a cell in powers of x, y in [-1, 1], into a[4, 8, 8]."""
    p = elements.table[e]["degree"][0]
    q = elements.table[e]["degree"][1]
    start = elements.table[e]["monomial"]
    a[:] = 0.0
    for i in range(p + 1):
        for j in range(q + 1):
            for c in range(4):
                a[c, i, j] = elements.coefs[start + (i * (q + 1) + j) * 4 + c]
    _shift(a, p, q, 0, 0.5 * (cell[0] + cell[1]), 0.5 * (cell[1] - cell[0]))
    _shift(a, q, p, 1, 0.5 * (cell[2] + cell[3]), 0.5 * (cell[3] - cell[2]))
    return p, q


@inner(error_model="numpy")
def taylor(a, h):
    """S and its derivatives by x and y to second order in the middle, into h[:3, :6]."""
    i = 1.0 / a[3, 0, 0]
    for c in range(3):
        v = a[c, 0, 0] * i
        x = (a[c, 1, 0] - a[3, 1, 0] * v) * i
        y = (a[c, 0, 1] - a[3, 0, 1] * v) * i
        h[c, 0] = v
        h[c, 1] = x
        h[c, 2] = y
        h[c, 3] = 2.0 * (a[c, 2, 0] - a[3, 1, 0] * x - a[3, 2, 0] * v) * i
        h[c, 4] = (a[c, 1, 1] - a[3, 1, 0] * y - a[3, 0, 1] * x - a[3, 1, 1] * v) * i
        h[c, 5] = 2.0 * (a[c, 0, 2] - a[3, 0, 1] * y - a[3, 0, 2] * v) * i


@inner(error_model="numpy")
def _at(a, c, i, j):
    return a[c, i, j] if i >= 0 and j >= 0 else 0.0


@inner(error_model="numpy")
def _size(b, normal, along):
    """Length of a vector, or of its part along the normal."""
    if along:
        return abs(b[0] * normal[0] + b[1] * normal[1] + b[2] * normal[2])
    return math.sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2])


@inner(error_model="numpy")
def _add(total, i, j, size):
    """Add the largest value and derivatives of a term x^i y^j times `size`."""
    total[0] += size
    total[1] += i * size
    total[2] += j * size
    total[3] += i * (i - 1) * size
    total[4] += i * j * size
    total[5] += j * (j - 1) * size


@inner(linked=False, error_model="numpy")
def sums_of(a, p, q, h, normal, sums):
    """Bounds of B (0), of its part along the normal (1) and of w (2) with derivatives to the
    second, into sums[3, 6]; returns the least weight."""
    sums[:] = 0.0
    for i in range(p + 1):
        for j in range(q + 1):
            if i + j > 0:
                _add(sums[2], i, j, abs(a[3, i, j]))
    b = scratch(3)
    for i in range(p + 3):
        for j in range(q + 3):
            if i + j < 3:
                continue
            for c in range(3):
                b[c] = (
                    a[c, i, j]
                    - h[c, 0] * a[3, i, j]
                    - h[c, 1] * _at(a, 3, i - 1, j)
                    - h[c, 2] * _at(a, 3, i, j - 1)
                    - 0.5 * h[c, 3] * _at(a, 3, i - 2, j)
                    - h[c, 4] * _at(a, 3, i - 1, j - 1)
                    - 0.5 * h[c, 5] * _at(a, 3, i, j - 2)
                )
            _add(sums[0], i, j, _size(b, normal, False))
            _add(sums[1], i, j, _size(b, normal, True))
    return a[3, 0, 0] - sums[2, 0]


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
def _by_third(elements, e, cell, h, rest, bound):
    """As `rest_of` for elements that have no powers: from bounds of the third derivatives."""
    hs = 0.5 * (cell[1] - cell[0])
    ht = 0.5 * (cell[3] - cell[2])
    evaluate(elements, e, 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3]), h)
    for c in range(3):
        h[c, 1] *= hs
        h[c, 2] *= ht
        h[c, 3] *= hs * hs
        h[c, 4] *= hs * ht
        h[c, 5] *= ht * ht
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


@inner(error_model="numpy")
def rest_of(elements, e, cell, h, rest, work):
    """Bounds of D_x, D_y, D_xx, D_xy, D_yy over a cell into rest[0], along the normal in rest[1].

    x and y run over [-1, 1] in the cell; `h` takes the derivatives by them in its middle. `work` is
    (a (4, 8, 8), sums (3, 6), bound (9)). False where the weights allow no bound.
    """
    a, sums, bound = work
    if elements.table[e]["monomial"] < 0:
        _by_third(elements, e, cell, h, rest, bound)
        return True
    p, q = centred(elements, e, cell, a)
    taylor(a, h)
    least = sums_of(a, p, q, h, unit_normal(h), sums)
    if not least > 0.0:
        return False
    quotient_rest(sums[0], sums[2], least, rest[0])
    quotient_rest(sums[1], sums[2], least, rest[1])
    return True
