"""Facets that touch with all or with some of their corners."""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel


@kernel()
def incidence(facets, n):
    """Return the facets at each of n points: `first` (n + 1,) and `incident` (3 m,).

    Facets at point i are incident[first[i]:first[i + 1]], ascending.
    """
    first = np.zeros(n + 1, np.int64)
    for f in range(facets.shape[0]):
        for k in range(3):
            first[facets[f, k] + 1] += 1
    for i in range(n):
        first[i + 1] += first[i]
    place = first[:-1].copy()
    incident = np.empty(first[n], np.int32)
    for f in range(facets.shape[0]):
        for k in range(3):
            i = facets[f, k]
            incident[place[i]] = f
            place[i] += 1
    return first, incident


@kernel()
def touched(topology, rows, place):
    """Find the facets with all three or with some corners in contact.

    `place` is (n,), −1; filled with the index in `rows` of every point in contact. Returns the
    corners (m, 3) in `rows` of the facets that touch with all corners, and the rows (k,) of the
    facets that touch in part. Facets are ascending if most touch, else in the order of their first
    corner in contact among `rows`.
    """
    bound = 0
    for i in range(rows.shape[0]):
        place[rows[i]] = i
        bound += topology.first[rows[i] + 1] - topology.first[rows[i]]
    facets = topology.facets
    limit = min(bound, facets.shape[0])
    whole = np.empty((limit, 3), np.int32)
    part = np.empty(limit, np.int32)
    n = 0
    m = 0
    # If most facets touch, a pass over all of them in order has fewer cache misses.
    if bound > facets.shape[0]:
        for f in range(facets.shape[0]):
            n, m = _classify(facets, f, place, whole, part, (n, m))
        return whole[:n], part[:m]
    for r in rows:
        for j in range(topology.first[r], topology.first[r + 1]):
            f = topology.incident[j]
            k = 0  # the first corner in contact
            while place[facets[f, k]] < 0:
                k += 1
            if facets[f, k] == r:
                n, m = _classify(facets, f, place, whole, part, (n, m))
    return whole[:n], part[:m]


@inner()
def _classify(facets, f, place, whole, part, counts):
    """Append facet f to `whole` (all corners in contact) or `part` (some); return their lengths.

    `counts` are the lengths before. A facet without a corner in contact is not appended.
    """
    n, m = counts
    a = place[facets[f, 0]]
    b = place[facets[f, 1]]
    c = place[facets[f, 2]]
    if a >= 0 and b >= 0 and c >= 0:
        whole[n, 0] = a
        whole[n, 1] = b
        whole[n, 2] = c
        return n + 1, m
    if a >= 0 or b >= 0 or c >= 0:
        part[m] = f
        return n, m + 1
    return n, m


@kernel()
def around(facets, part, points, place):
    """Number the corners of the facets `part`, the ones in contact first.

    `place` (n,) is the index of every point among the points in contact, or −1. Returns facets
    (m,), those of `part` with finite corners; corner (m, 3), numbers of their corners, below i for
    the inner ones and from i on for the free ones; inner (i,), indices among the points in contact;
    free (f,), rows of the points out of contact; and start (f,), the number of the nearest inner
    corner that shares a facet with each.
    """
    finite_facets = np.empty(part.shape[0], np.int32)
    inner = np.empty(2 * part.shape[0], np.int32)
    free = np.empty(2 * part.shape[0], np.int32)
    number = np.full(points.shape[0], -1, np.int32)
    m = 0
    n_i = 0
    n_f = 0
    for f in part:
        total = 0.0
        for k in range(3):
            for c in range(3):
                total += points[facets[f, k], c]
        if not math.isfinite(total):
            continue
        finite_facets[m] = f
        m += 1
        for k in range(3):
            c = facets[f, k]
            if number[c] >= 0:
                continue
            if place[c] >= 0:
                inner[n_i] = place[c]
                number[c] = n_i
                n_i += 1
            else:
                free[n_f] = c
                number[c] = n_f
                n_f += 1
    corner = np.empty((m, 3), np.int32)
    start = np.empty(n_f, np.int32)
    min_distance2 = np.full(n_f, math.inf)
    for j in range(m):
        for k in range(3):
            c = facets[finite_facets[j], k]
            corner[j, k] = number[c]
            if place[c] >= 0:
                continue
            corner[j, k] += n_i
            for l in range(3):
                d = facets[finite_facets[j], l]
                distance2 = (
                    (points[c, 0] - points[d, 0]) ** 2
                    + (points[c, 1] - points[d, 1]) ** 2
                    + (points[c, 2] - points[d, 2]) ** 2
                )
                if place[d] >= 0 and distance2 < min_distance2[number[c]]:
                    min_distance2[number[c]] = distance2
                    start[number[c]] = number[d]
    return finite_facets[:m].copy(), corner, inner[:n_i].copy(), free[:n_f].copy(), start
