"""Adaptive Gauss quadrature of area and length over Bézier elements."""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

MAX_DEPTH = 20
"""Deep enough for |N| with a kink along a line; a smooth element needs one or two levels."""
MAX_BOXES = 2**18
"""For all elements of a surface; a kink along a line takes some ten thousand to 1e-10."""
MIN_BOXES = 2**12
NOISE = 1e-15
"""Share of size² by which rounding of points changes areas, as of a torus without thickness."""


@inner()
def bernstein(degree, t, values, slopes):
    """Write the degree + 1 Bernstein polynomials on [0, 1] at `t`, as `values` and `slopes`."""
    values[0] = 1.0
    slopes[0] = 0.0
    for j in range(1, degree + 1):
        if j == degree:
            slopes[0] = -degree * values[0]
            for r in range(1, degree):
                slopes[r] = degree * (values[r - 1] - values[r])
            slopes[degree] = degree * values[degree - 1]
        saved = 0.0
        for r in range(j):
            share = values[r]
            values[r] = saved + (1.0 - t) * share
            saved = t * share
        values[j] = saved


@inner()
def jacobian(A, A_u, A_v):
    """Return |S_u × S_v| from the homogeneous point and its derivatives, four numbers each."""
    w = A[3]
    a = scratch(3)
    b = scratch(3)
    for d in range(3):
        a[d] = (A_u[d] - A_u[3] / w * A[d]) / w
        b[d] = (A_v[d] - A_v[3] / w * A[d]) / w
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    return math.sqrt(x * x + y * y + z * z)


@inner()
def _four(a):
    """Return an array of four as a tuple."""
    return a[0], a[1], a[2], a[3]


@inner()
def box_area(coefs, box, nodes, weights):
    """Return the area of an element over ``box`` = (u0, u1, v0, v1, …) of [0, 1]², by one rule."""
    p = coefs.shape[0] - 1
    q = coefs.shape[1] - 1
    B = np.empty(p + 1)
    dB = np.empty(p + 1)
    n = nodes.size
    C = np.empty((n, q + 1))
    dC = np.empty((n, q + 1))
    for k in range(n):
        bernstein(q, box[2] + (box[3] - box[2]) * nodes[k], C[k], dC[k])
    row = np.empty((q + 1, 4))
    row_u = np.empty((q + 1, 4))
    A = scratch(3, 4)
    total = 0.0
    for i in range(n):
        bernstein(p, box[0] + (box[1] - box[0]) * nodes[i], B, dB)
        row[:] = 0.0
        row_u[:] = 0.0
        for a in range(p + 1):
            for b in range(q + 1):
                for d in range(4):
                    row[b, d] += B[a] * coefs[a, b, d]
                    row_u[b, d] += dB[a] * coefs[a, b, d]
        for j in range(n):
            A[:] = 0.0
            for b in range(q + 1):
                for d in range(4):
                    A[0, d] += C[j, b] * row[b, d]
                    A[1, d] += C[j, b] * row_u[b, d]
                    A[2, d] += dC[j, b] * row[b, d]
            total += weights[i] * weights[j] * jacobian(_four(A[0]), _four(A[1]), _four(A[2]))
    return total * (box[1] - box[0]) * (box[3] - box[2])


@inner()
def element_area(coefs, nodes, weights, rtol, floor, max_boxes):
    """Return the area of an element (p + 1, q + 1, 4), quartered where four boxes and one differ.

    A box is final if the two differ by no more than `rtol` of its area, or its share of `floor`, an
    absolute area for the element; after `MAX_DEPTH` levels or `max_boxes` boxes it is in any case.
    """
    # Rows: the box (u0, u1, v0, v1), its value and its depth.
    stack = np.zeros((3 * MAX_DEPTH + 4, 6))
    stack[0, 1] = 1.0
    stack[0, 3] = 1.0
    stack[0, 4] = box_area(coefs, stack[0], nodes, weights)
    top = 1
    boxes = 0
    total = 0.0
    while top > 0:
        top -= 1
        boxes += 1
        u0, u1, v0, v1 = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        coarse, depth = stack[top, 4], stack[top, 5]
        fine = 0.0
        for k in range(4):
            part = stack[top + k]
            part[0] = 0.5 * (u0 + u1) if k % 2 else u0
            part[1] = u1 if k % 2 else 0.5 * (u0 + u1)
            part[2] = 0.5 * (v0 + v1) if k // 2 else v0
            part[3] = v1 if k // 2 else 0.5 * (v0 + v1)
            part[4] = box_area(coefs, part, nodes, weights)
            part[5] = depth + 1.0
            fine += part[4]
        allowed = max(rtol * fine, floor * (u1 - u0) * (v1 - v0))
        # In this form a box that is NaN is final, too, and not quartered for ever.
        if not abs(fine - coarse) > allowed or depth >= MAX_DEPTH or boxes >= max_boxes:
            total += fine
        else:
            top += 4
    return total


@kernel()
def grid_area(coefs, nodes, weights, rtol):
    """Return the area of all elements (nu, nv, p + 1, q + 1, 4), summed in order, to `rtol`.

    The error of an element does not count below its equal share of that of the whole, or below the
    rounding of points.
    """
    nu, nv = coefs.shape[:2]
    box = np.array([0.0, 1.0, 0.0, 1.0])
    rough = 0.0
    for i in range(nu):
        for j in range(nv):
            rough += box_area(coefs[i, j], box, nodes, weights)
    largest = 0.0
    for i in range(nu):
        for j in range(nv):
            for a in range(coefs.shape[2]):
                for b in range(coefs.shape[3]):
                    for d in range(3):
                        largest = max(largest, abs(coefs[i, j, a, b, d] / coefs[i, j, a, b, 3]))
    floor = max(rtol * rough / (nu * nv), NOISE * largest * largest)
    max_boxes = max(MIN_BOXES, MAX_BOXES // (nu * nv))
    total = 0.0
    for i in range(nu):
        for j in range(nv):
            total += element_area(coefs[i, j], nodes, weights, rtol, floor, max_boxes)
    return total


@inner()
def piece_length(coefs, low, high, nodes, weights):
    """Return the arc length of an element over ``[low, high]`` of [0, 1], by one rule."""
    p = coefs.shape[0] - 1
    B = np.empty(p + 1)
    dB = np.empty(p + 1)
    A = scratch(2, 4)
    total = 0.0
    for k in range(nodes.size):
        bernstein(p, low + (high - low) * nodes[k], B, dB)
        A[:] = 0.0
        for a in range(p + 1):
            for d in range(4):
                A[0, d] += B[a] * coefs[a, d]
                A[1, d] += dB[a] * coefs[a, d]
        w = A[0, 3]
        square = 0.0
        for d in range(3):
            square += ((A[1, d] - A[1, 3] / w * A[0, d]) / w) ** 2
        total += weights[k] * math.sqrt(square)
    return total * (high - low)


@inner()
def element_length(coefs, nodes, weights, rtol, floor):
    """Return the arc length of one element (p + 1, 4), halved where two parts disagree with one.

    The rule is that of `element_area`, without a limit on the number of parts.
    """
    limit = 2 * MAX_DEPTH
    # Rows: the ends of a part, its value and its depth.
    stack = np.zeros((limit + 2, 4))
    stack[0, 1] = 1.0
    stack[0, 2] = piece_length(coefs, 0.0, 1.0, nodes, weights)
    top = 1
    total = 0.0
    while top > 0:
        top -= 1
        low, high, coarse, depth = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        middle = 0.5 * (low + high)
        left = piece_length(coefs, low, middle, nodes, weights)
        right = piece_length(coefs, middle, high, nodes, weights)
        allowed = max(rtol * (left + right), floor * (high - low))
        if not abs(left + right - coarse) > allowed or depth >= limit:
            total += left + right
        else:
            stack[top, 1] = middle
            stack[top, 2] = left
            stack[top + 1, 0] = middle
            stack[top + 1, 1] = high
            stack[top + 1, 2] = right
            stack[top, 3] = stack[top + 1, 3] = depth + 1.0
            top += 2
    return total


@kernel()
def chain_length(coefs, nodes, weights, rtol):
    """Return the length of all elements (n, p + 1, 4), summed in order, as in `grid_area`."""
    rough = 0.0
    for i in range(coefs.shape[0]):
        rough += piece_length(coefs[i], 0.0, 1.0, nodes, weights)
    largest = 0.0
    for i in range(coefs.shape[0]):
        for a in range(coefs.shape[1]):
            for d in range(3):
                largest = max(largest, abs(coefs[i, a, d] / coefs[i, a, 3]))
    floor = max(rtol * rough / coefs.shape[0], NOISE * largest)
    total = 0.0
    for i in range(coefs.shape[0]):
        total += element_length(coefs[i], nodes, weights, rtol, floor)
    return total
