"""Proof that two triangles stay within a distance of the piece of surface above them.

A piece lies in the hull of its control points, and the distance to a triangle is a convex
function: it is largest at a corner of that hull. The hull is cut along the triangles' common
edge, each part is held against its own triangle, and where that does not suffice the piece is
quartered.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

MAX_DEPTH = 4


@inner(linked=False)
def cut(coefs, axis, t, keep_low):
    """Replace Bernstein coefficients (p + 1, q + 1, d) by those of the part below or above `t`.

    By de Casteljau's algorithm along `axis`; `keep_low` chooses the part below.
    """
    p = coefs.shape[axis] - 1
    for r in range(1, p + 1):
        for k in range(p - r + 1):
            # The point that changes, and the one it moves towards.
            i = p - k if keep_low else k
            neighbour = i - 1 if keep_low else i + 1
            share = 1.0 - t if keep_low else t
            for j in range(coefs.shape[1 - axis]):
                for d in range(coefs.shape[2]):
                    if axis == 0:
                        coefs[i, j, d] += share * (coefs[neighbour, j, d] - coefs[i, j, d])
                    else:
                        coefs[j, i, d] += share * (coefs[j, neighbour, d] - coefs[j, i, d])


@kernel(linked=True)
def restrict(coefs, axis, low, high):
    """Replace Bernstein coefficients by those over ``[low, high]`` of [0, 1] along `axis`."""
    if high < 1.0:
        cut(coefs, axis, high, True)
    if low > 0.0:
        cut(coefs, axis, low / high, False)


@kernel(linked=True)
def triangle_distance(x, a, b, c):
    """Return the distance from a point x to a triangle abc.

    By its Voronoi regions (Ericson, Real-Time Collision Detection). For a triangle without area it
    may be too large, never too small.
    """
    abx, aby, abz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    acx, acy, acz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    px, py, pz = x[0] - a[0], x[1] - a[1], x[2] - a[2]
    d1 = abx * px + aby * py + abz * pz
    d2 = acx * px + acy * py + acz * pz
    qx, qy, qz = x[0] - b[0], x[1] - b[1], x[2] - b[2]
    d3 = abx * qx + aby * qy + abz * qz
    d4 = acx * qx + acy * qy + acz * qz
    rx, ry, rz = x[0] - c[0], x[1] - c[1], x[2] - c[2]
    d5 = abx * rx + aby * ry + abz * rz
    d6 = acx * rx + acy * ry + acz * rz
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    # Shares s, t of the two sides at the nearest point a + s ab + t ac.
    s = 0.0
    t = 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        pass
    elif d3 >= 0.0 and d4 <= d3:
        s = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        t = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        s = d1 / (d1 - d3)
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        t = d2 / (d2 - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6 and (d4 - d3) + (d5 - d6) > 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - t
    elif va + vb + vc > 0.0:
        s = vb / (va + vb + vc)
        t = vc / (va + vb + vc)
    # In a triangle without area a corner is taken: an upper bound on the distance.
    ex = px - s * abx - t * acx
    ey = py - s * aby - t * acy
    ez = pz - s * abz - t * acz
    return math.sqrt(ex * ex + ey * ey + ez * ez)


@inner()
def cutting_plane(quad, plane):
    """Write the normal, not of length 1, of a plane through the diagonal 02, towards corner 3.

    It is the part of the vector from corner 1 to corner 3 perpendicular to the diagonal.
    """
    square = 0.0
    dot_product = 0.0
    for d in range(3):
        edge = quad[2, d] - quad[0, d]
        square += edge * edge
        dot_product += edge * (quad[3, d] - quad[1, d])
    share = dot_product / square if square > 0.0 else 0.0
    for d in range(3):
        plane[d] = quad[3, d] - quad[1, d] - share * (quad[2, d] - quad[0, d])


@inner()
def hull_within(points, quad, tol):
    """Return whether the hull of `points` (n, 3) is proved within `tol` of triangles 012 and 023.

    That holds if all points are within `tol` of one triangle; or, cut along the diagonal, if the
    points on each side are within it of their triangle, and the points at which lines between the
    sides are cut are within it of both triangles.
    """
    n = points.shape[0]
    first = True
    second = True
    plane = scratch(3)
    cutting_plane(quad, plane)
    height = np.zeros(n)
    x = scratch(3)
    is_split = True
    for i in range(n):
        d1 = triangle_distance(points[i], quad[0], quad[1], quad[2])
        d2 = triangle_distance(points[i], quad[0], quad[2], quad[3])
        for d in range(3):
            height[i] += (points[i, d] - quad[0, d]) * plane[d]
        first = first and d1 <= tol
        second = second and d2 <= tol
        is_split = is_split and (d1 if height[i] <= 0.0 else d2) <= tol
    if first or second:
        return True
    if not is_split:
        return False
    for i in range(n):
        if height[i] > 0.0:
            continue
        for j in range(n):
            if height[j] <= 0.0:
                continue
            share = height[i] / (height[i] - height[j])
            for d in range(3):
                x[d] = points[i, d] + share * (points[j, d] - points[i, d])
            if triangle_distance(x, quad[0], quad[1], quad[2]) > tol:
                return False
            if triangle_distance(x, quad[0], quad[2], quad[3]) > tol:
                return False
    return True


@inner()
def to_points(coefs, points):
    """Write the Cartesian control points of a piece (p + 1, q + 1, 4) to `points`, row by row."""
    m = coefs.shape[1]
    for i in range(coefs.shape[0]):
        for j in range(m):
            for d in range(3):
                points[i * m + j, d] = coefs[i, j, d] / coefs[i, j, 3]


@inner()
def copy_piece(source, target):
    """Copy `source` to `target` by entries: numba takes seconds to compile the slice assignment."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            for d in range(source.shape[2]):
                target[i, j, d] = source[i, j, d]


@inner()
def corner_rows(p, q):
    """Return the rows of the control points at the corners of a piece, around its border."""
    return (0, p * (q + 1), p * (q + 1) + q, q)


@inner()
def corners_within(points, corners, quad, tol):
    """Return whether the four corners of a piece are within `tol` of one of two triangles each."""
    for k in corners:
        if (
            triangle_distance(points[k], quad[0], quad[1], quad[2]) > tol
            and triangle_distance(points[k], quad[0], quad[2], quad[3]) > tol
        ):
            return False
    return True


@inner()
def cell_within(net, tol, stack, depth, points):
    """Return whether a piece (p + 1, q + 1, 4) is within `tol` of the two triangles on its corners.

    False is also the answer where the proof does not close in MAX_DEPTH quarterings. `stack`,
    `depth` and `points` are work memory.
    """
    corners = corner_rows(net.shape[0] - 1, net.shape[1] - 1)
    to_points(net, points)
    quad = scratch(4, 3)
    for k in range(4):
        for d in range(3):
            quad[k, d] = points[corners[k], d]
    copy_piece(net, stack[0])
    depth[0] = 0
    top = 1
    while top > 0:
        top -= 1
        level = depth[top]
        to_points(stack[top], points)
        if not corners_within(points, corners, quad, tol):
            return False
        if hull_within(points, quad, tol):
            continue
        if level == MAX_DEPTH:
            return False
        # The quarters take the place of the piece, which is cut last.
        for k in range(3, -1, -1):
            part = stack[top + k]
            if k > 0:
                copy_piece(stack[top], part)
            cut(part, 0, 0.5, k % 2 == 0)
            cut(part, 1, 0.5, k // 2 == 0)
            depth[top + k] = level + 1
        top += 4
    return True


@inner()
def element_within(coefs, rows, columns, tol):
    """Return whether all cells of one element, cut in `rows` × `columns`, are proved within `tol`.

    Each is compared with the two triangles on its corners: see `cell_within`.
    """
    p = coefs.shape[0] - 1
    q = coefs.shape[1] - 1
    stack = np.empty((3 * MAX_DEPTH + 4, p + 1, q + 1, 4))
    depth = np.empty(3 * MAX_DEPTH + 4, np.int64)
    points = np.empty(((p + 1) * (q + 1), 3))
    strip = np.empty_like(coefs)
    cell = np.empty_like(coefs)
    for r in range(rows):
        copy_piece(coefs, strip)
        restrict(strip, 0, r / rows, (r + 1) / rows)
        for c in range(columns):
            copy_piece(strip, cell)
            restrict(cell, 1, c / columns, (c + 1) / columns)
            if not cell_within(cell, tol, stack, depth, points):
                return False
    return True


@kernel()
def elements_within(coefs, rows, columns, tol, open_):
    """Clear the flags of `open_` (nu, nv) at elements whose cells are all proved within `tol`.

    Element (i, j) is cut in rows[i] × columns[j] cells; those without a flag are skipped.
    """
    for i in range(coefs.shape[0]):
        for j in range(coefs.shape[1]):
            if open_[i, j]:
                open_[i, j] = not element_within(coefs[i, j], rows[i], columns[j], tol)
