"""Proof that two triangles stay within a distance of the piece of surface above them.

A piece lies in the hull of its control points, and the distance to a triangle is a convex
function: it is largest at a corner of that hull. The hull is cut along the triangles' common
edge, each part is held against its own triangle, and where that does not suffice the piece is
quartered.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

MAX_DEPTH = 4


@njit(cache=True)
def cut(coefs, t, keep_low):
    """Bernstein coefficients (p + 1, ...) of the part below or above `t`, in place (axis 0)."""
    p = coefs.shape[0] - 1
    for r in range(1, p + 1):
        if keep_low:
            for i in range(p, r - 1, -1):
                coefs[i] += (1.0 - t) * (coefs[i - 1] - coefs[i])
        else:
            for i in range(p - r + 1):
                coefs[i] += t * (coefs[i + 1] - coefs[i])


@njit(cache=True)
def restrict(coefs, low, high):
    """Bernstein coefficients over ``[low, high]`` of [0, 1], in place (axis 0)."""
    if high < 1.0:
        cut(coefs, high, True)
    if low > 0.0:
        cut(coefs, low / high, False)


@njit(cache=True)
def dot(a, b):
    """Scalar product of 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def triangle_distance(x, a, b, c):
    """Distance from the point `x` to the triangle abc (Ericson, Real-Time Collision Detection)."""
    ab = b - a
    ac = c - a
    ax = x - a
    d1 = dot(ab, ax)
    d2 = dot(ac, ax)
    bx = x - b
    d3 = dot(ab, bx)
    d4 = dot(ac, bx)
    cx = x - c
    d5 = dot(ab, cx)
    d6 = dot(ac, cx)
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        r = ax
    elif d3 >= 0.0 and d4 <= d3:
        r = bx
    elif d6 >= 0.0 and d5 <= d6:
        r = cx
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        r = ax - (d1 / (d1 - d3)) * ab
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        r = ax - (d2 / (d2 - d6)) * ac
    elif va <= 0.0 and d4 >= d3 and d5 >= d6 and (d4 - d3) + (d5 - d6) > 0.0:
        r = bx - ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b)
    elif va + vb + vc > 0.0:
        r = ax - (vb / (va + vb + vc)) * ab - (vc / (va + vb + vc)) * ac
    else:
        # No area, by rounding: the nearest corner is an upper bound on the distance.
        return math.sqrt(min(dot(ax, ax), dot(bx, bx), dot(cx, cx)))
    return math.sqrt(dot(r, r))


@njit(cache=True)
def cutting_plane(quad):
    """Normal of a plane through the diagonal between the two triangles, towards the second."""
    edge = quad[2] - quad[0]
    towards = quad[3] - quad[1]
    size = dot(edge, edge)
    if size > 0.0:
        towards = towards - (dot(towards, edge) / size) * edge
    return towards


@njit(cache=True)
def hull_within(points, quad, tol):
    """Whether the hull of `points` (n, 3) is within `tol` of the triangles 012 and 023."""
    n = points.shape[0]
    first = True
    second = True
    plane = cutting_plane(quad)
    height = np.empty(n)
    parted = True
    for i in range(n):
        d1 = triangle_distance(points[i], quad[0], quad[1], quad[2])
        d2 = triangle_distance(points[i], quad[0], quad[2], quad[3])
        height[i] = dot(points[i] - quad[0], plane)
        first = first and d1 <= tol
        second = second and d2 <= tol
        parted = parted and (d1 if height[i] <= 0.0 else d2) <= tol
    if first or second:
        return True
    if not parted:
        return False
    for i in range(n):
        if height[i] > 0.0:
            continue
        for j in range(n):
            if height[j] <= 0.0:
                continue
            x = points[i] + (height[i] / (height[i] - height[j])) * (points[j] - points[i])
            if triangle_distance(x, quad[0], quad[1], quad[2]) > tol:
                return False
            if triangle_distance(x, quad[0], quad[2], quad[3]) > tol:
                return False
    return True


@njit(cache=True)
def corners_within(coefs, quad, tol):
    """Whether the four corners of a piece, which are points of the surface, are within `tol`."""
    p = coefs.shape[0] - 1
    q = coefs.shape[1] - 1
    for k in range(4):
        c = coefs[p * (k % 2), q * (k // 2)]
        x = c[:3] / c[3]
        if (
            triangle_distance(x, quad[0], quad[1], quad[2]) > tol
            and triangle_distance(x, quad[0], quad[2], quad[3]) > tol
        ):
            return False
    return True


@njit(cache=True)
def cell_within(net, tol, stack, depth, points):
    """Whether a piece (p + 1, q + 1, 4) is within `tol` of the two triangles on its corners.

    False is also the answer where the proof does not close in MAX_DEPTH quarterings.
    """
    p = net.shape[0] - 1
    q = net.shape[1] - 1
    quad = np.empty((4, 3))
    quad[0] = net[0, 0, :3] / net[0, 0, 3]
    quad[1] = net[p, 0, :3] / net[p, 0, 3]
    quad[2] = net[p, q, :3] / net[p, q, 3]
    quad[3] = net[0, q, :3] / net[0, q, 3]
    stack[0] = net
    depth[0] = 0
    top = 1
    while top > 0:
        top -= 1
        piece = stack[top].copy()
        level = depth[top]
        if not corners_within(piece, quad, tol):
            return False
        for i in range(p + 1):
            for j in range(q + 1):
                for d in range(3):
                    points[i * (q + 1) + j, d] = piece[i, j, d] / piece[i, j, 3]
        if hull_within(points, quad, tol):
            continue
        if level == MAX_DEPTH:
            return False
        for k in range(4):
            stack[top] = piece
            cut(stack[top], 0.5, k % 2 == 0)
            cut(stack[top].transpose(1, 0, 2), 0.5, k // 2 == 0)
            depth[top] = level + 1
            top += 1
    return True


@njit(cache=True)
def element_within(coefs, rows, columns, tol):
    """Whether all cells of one element, cut in `rows` × `columns`, are within `tol`."""
    p = coefs.shape[0] - 1
    q = coefs.shape[1] - 1
    stack = np.empty((3 * MAX_DEPTH + 4, p + 1, q + 1, 4))
    depth = np.empty(3 * MAX_DEPTH + 4, np.int64)
    points = np.empty(((p + 1) * (q + 1), 3))
    for r in range(rows):
        strip = coefs.copy()
        restrict(strip, r / rows, (r + 1) / rows)
        for c in range(columns):
            cell = strip.copy()
            restrict(cell.transpose(1, 0, 2), c / columns, (c + 1) / columns)
            if not cell_within(cell, tol, stack, depth, points):
                return False
    return True


@njit(cache=True)
def elements_within(coefs, rows, columns, tol, open_):
    """Clears the flags of `open_` (nu, nv) at elements that are within `tol`."""
    for i in range(coefs.shape[0]):
        for j in range(coefs.shape[1]):
            if open_[i, j]:
                open_[i, j] = not element_within(coefs[i, j], rows[i], columns[j], tol)
