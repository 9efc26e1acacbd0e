"""Facets that touch in part: their cut at the edge of contact, and the area of their parts."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import OK
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64

# Fraction at which an edge is cut whose outer end lies inside without being in contact.
MIDDLE = 0.5


@kernel()
def cuts(corner, feet, n_c, fraction):
    """Find where contact ends on the edges of the facets, by the signed gap at their ends.

    `corner` is (m, 3) indices of the corners, those below n_c in contact. `fraction` (m, 3) is
    filled for edge k (corner k to k + 1) with the fraction from its end in contact; `MIDDLE` if the
    other end has a gap ≤ 0, 1 if the edge is not cut or needs a search. Returns the edges (e,) that
    need one, facet * 3 + k: the foot of their end out of contact is not on the surface.
    """
    border = np.empty(3 * corner.shape[0], np.int64)
    n = 0
    for f in range(corner.shape[0]):
        for k in range(3):
            a = corner[f, k]
            b = corner[f, (k + 1) % 3]
            fraction[f, k] = 1.0
            if (a < n_c) == (b < n_c):
                continue
            if b < n_c:
                a, b = b, a
            if feet.status[b] != OK:
                border[n] = 3 * f + k
                n += 1
            elif feet.gap[b] > 0.0:
                depth = max(-feet.gap[a], 0.0)
                fraction[f, k] = depth / (depth + feet.gap[b])
            else:
                fraction[f, k] = MIDDLE
    return border[:n].copy()


@inner()
def polygon_of(inside, fraction, f, polygon, edge):
    """Write the corners of the part of facet `f` that is in contact; return their number, 0 to 4.

    `inside` (3,) tells which corners of the facet are in contact; `fraction` (m, 3) is the fraction
    of each edge from its end in contact to the cut. `polygon` (4, 3) gets the barycentric
    coordinates of the corners found, in order around the facet, `edge` (4,) the edge on which each
    lies, or −1 − k for corner k of the facet.
    """
    n = 0
    for k in range(3):
        if inside[k]:
            polygon[n, :] = 0.0
            polygon[n, k] = 1.0
            edge[n] = -1 - k
            n += 1
        l = (k + 1) % 3
        if inside[k] != inside[l]:
            t = fraction[f, k] if inside[k] else 1.0 - fraction[f, k]
            polygon[n, :] = 0.0
            polygon[n, k] = 1.0 - t
            polygon[n, l] = t
            edge[n] = k
            n += 1
    return n


@inner()
def hand_over(share, inside):
    """Distribute the shares of corners out of contact over the others, in proportion to theirs.

    `share` (3,) is changed; the proportions are equal if the other shares are zero.
    """
    inner_sum = 0.0
    outer_sum = 0.0
    count = 0
    for k in range(3):
        if inside[k]:
            inner_sum += share[k]
            count += 1
        else:
            outer_sum += share[k]
            share[k] = 0.0
    for k in range(3):
        if inside[k]:
            share[k] += outer_sum * (share[k] / inner_sum if inner_sum > 0.0 else 1.0 / count)


@kernel()
def slave_pieces(nodes, points, corner, n_c, fraction, share, start, stop):
    """Write the area in contact of facets start … stop (corners `nodes`), split to the corners.

    Each corner gets in `share` (m, 3) the integral of its linear shape function over the part in
    contact; corners out of contact hand theirs over. For `corner`, n_c and `fraction` see `cuts`.
    """
    polygon = scratch(4, 3)
    edge = stack_int64(4)
    inside = np.empty(3, np.bool_)
    for f in range(start, stop):
        area = _triangle_area(points[nodes[f, 0]], points[nodes[f, 1]], points[nodes[f, 2]])
        for k in range(3):
            inside[k] = corner[f, k] < n_c
            share[f, k] = 0.0
        n = polygon_of(inside, fraction, f, polygon, edge)
        for j in range(1, n - 1):
            a, b, c = polygon[0], polygon[j], polygon[j + 1]
            determinant = (
                a[0] * (b[1] * c[2] - b[2] * c[1])
                - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
            )
            part = area * abs(determinant)
            for k in range(3):
                share[f, k] += part * (polygon[0, k] + polygon[j, k] + polygon[j + 1, k]) / 3.0
        hand_over(share[f], inside)


@inner()
def _triangle_area(a, b, c):
    """Return the area of a triangle in space."""
    x1, y1, z1 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    x2, y2, z2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x = y1 * z2 - z1 * y2
    y = z1 * x2 - x1 * z2
    z = x1 * y2 - y1 * x2
    return 0.5 * math.sqrt(x * x + y * y + z * z)


@kernel()
def slave_whole(rows, points, corner, share, start, stop):
    """Write a third of the area of each of facets start … stop for each corner into `share`.

    Corner c of a facet is at points[rows[c]].
    """
    for f in range(start, stop):
        share[f, :] = (
            _triangle_area(
                points[rows[corner[f, 0]]], points[rows[corner[f, 1]]], points[rows[corner[f, 2]]]
            )
            / 3.0
        )


@kernel()
def gather(corner, share, area):
    """Add the shares of facets' corners to the nodal areas (n_c,), in order.

    Corners from n_c on, out of contact, are left out.
    """
    for f in range(corner.shape[0]):
        for k in range(3):
            if corner[f, k] < area.shape[0]:
                area[corner[f, k]] += share[f, k]
