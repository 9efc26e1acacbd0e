"""Feet continued from the last ones by walking over adjoining triangles.

From the closest point of a triangle the walk goes to an adjoining triangle that comes closer,
across the edge or around the corner where that point lies, until none does: a local minimum of
the distance, the one that is continued from where the foot was. The distance falls at every step,
so no triangle is visited twice.
"""

from __future__ import annotations

import math

from numba import njit

from contiga.search.faceted._facet_nb import (
    BORDER,
    MAX_ITERATIONS,
    NOT_FINITE,
    blank,
    closest_on,
    write_foot,
)

STEPS = 1 << 20
"""Triangles of one walk at most."""


@njit(cache=True)
def _nearest_of(facets, list_, first, last, best, point):
    """Of the triangles list_[first:last] the one that comes closer than `best`, or −1."""
    found = -1
    place = 0
    a = 0.0
    b = 0.0
    for i in range(first, last):
        square, p, u, v = closest_on(facets, list_[i], point[0], point[1], point[2])
        if square < best:
            best = square
            found = list_[i]
            place = p
            a = u
            b = v
    return best, found, place, a, b


@njit(cache=True)
def walk(facets, s, point):
    """The local minimum that is reached from triangle s: slot, place, two numbers, solved."""
    best, place, a, b = closest_on(facets, s, point[0], point[1], point[2])
    for _ in range(STEPS):
        if place == 0:
            return s, place, a, b, True
        if place < 4:
            other = facets.neighbour[s, place - 1]
            if other == BORDER:
                return s, place, a, b, True
            if other >= 0:
                square, p, u, v = closest_on(facets, other, point[0], point[1], point[2])
                if square >= best:
                    return s, place, a, b, True
                best = square
                s = other
                place = p
                a = u
                b = v
                continue
            f = -2 - other
            new = _nearest_of(
                facets, facets.fan, facets.fan_first[f], facets.fan_first[f + 1], best, point
            )
        else:
            v = facets.vertex[s, place - 4]
            new = _nearest_of(
                facets, facets.ring, facets.ring_first[v], facets.ring_first[v + 1], best, point
            )
        if new[1] < 0:
            return s, place, a, b, True
        best, s, place, a, b = new
    return s, place, a, b, False


@njit(cache=True, nogil=True)
def project_tracked(facets, points, patch, smooth, out, start, stop):
    """Feet of rows start … stop continued from the triangles `patch`; rows of −1 are left out."""
    for k in range(start, stop):
        if patch[k] < 0 or facets.slot[patch[k]] < 0:
            continue
        x = points[k, 0]
        y = points[k, 1]
        z = points[k, 2]
        if not math.isfinite(x + y + z):
            blank(out, k, NOT_FINITE)
            continue
        s, place, a, b, solved = walk(facets, facets.slot[patch[k]], (x, y, z))
        write_foot(facets, k, (s, place, a, b), (x, y, z), (True, smooth), out)
        if not solved:
            out.status[k] = MAX_ITERATIONS
