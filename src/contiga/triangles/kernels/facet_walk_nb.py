"""Feet continued from the last ones by walking over adjoining triangles.

From the closest point of a triangle the walk goes to an adjoining triangle that comes closer,
across the edge or around the corner where that point lies, until none does: a local minimum of
the distance, the one that is continued from where the foot was. The distance falls at every step,
so no triangle is visited twice.
"""

from __future__ import annotations

import math

import numpy as np
from numba.core.compiler import Compiler

from contiga.arrays.codes import MAX_ITERATIONS, NO_TRIANGLE, NOT_FINITE
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.jit import inner, kernel
from contiga.triangles.kernels.facet_nb import (
    TRIANGLE,
    VERTICES,
    closest_on,
    smooth_normal,
    write_face,
    write_kink,
)

STEPS = 1 << 20
"""Triangles of one walk at most."""


# Optimised on their own, not only within their callers, where they would be too large to be put
# in place of their calls: a walk would take a fifth longer.
@inner(pipeline_class=Compiler)
def _nearest_around(facets, number, best, point):
    """Return the slot around a vertex or crowded edge that comes closer than `best`, or −1."""
    nearest = -1
    place = 0
    a = 0.0
    b = 0.0
    for i in range(facets.around_first[number], facets.around_first[number + 1]):
        s = facets.around[i]
        square, p, u, v = closest_on(facets.shape, s, point[0], point[1], point[2])
        if square < best:
            best = square
            nearest = s
            place = p
            a = u
            b = v
    return best, nearest, place, a, b


@inner(pipeline_class=Compiler)
def walk(facets, s, first, point):
    """Walk from a place on triangle s to a local minimum of the distance.

    `first` is the result of `closest_on` there. Returns slot, place, its two numbers, and whether
    the minimum was reached.
    """
    shape = facets.shape
    link = facets.link
    best, place, a, b = first
    for _ in range(STEPS):
        if place == 0:
            return s, place, a, b, True
        if place < 4:
            other = link[s, place - 1]
            if other == NO_TRIANGLE:
                return s, place, a, b, True
            if other >= 0:
                square, p, u, v = closest_on(shape, other, point[0], point[1], point[2])
                if square >= best:
                    return s, place, a, b, True
                best = square
                s = other
                place = p
                a = u
                b = v
                continue
            new = _nearest_around(facets, -2 - other, best, point)
        else:
            new = _nearest_around(facets, link[s, VERTICES + place - 4], best, point)
        if new[1] < 0:
            return s, place, a, b, True
        best, s, place, a, b = new
    return s, place, a, b, False


@inner(pipeline_class=Compiler)
def _was_inside(shape, s, before, k):
    """Return whether the foot of before[k] lies inside triangle s; no, if nothing is known."""
    if before.shape[0] == 0:
        return False
    # A comparison with NaN is false: what was not finite was not inside.
    return closest_on(shape, s, before[k, 0], before[k, 1], before[k, 2])[1] == 0


@kernel()
def project_tracked(facets, points, starts, smooth, out, start, stop):
    """Feet of rows start … stop continued from `starts` (WalkStarts); rows of slot −1 are left out.

    A foot inside the triangle that held it before went there straight, because triangles are
    convex: proved.
    """
    slots, before = starts.slots, starts.before
    shape = facets.shape
    link = facets.link
    patch = out.patch
    for k in range(start, stop):
        s = np.int64(slots[k])
        if s < 0:
            continue
        x = points[k, 0]
        y = points[k, 1]
        z = points[k, 2]
        if not math.isfinite(x + y + z):
            blank_foot(out, k, NOT_FINITE)
            continue
        point = (x, y, z)
        square, place, a, b = closest_on(shape, s, x, y, z)
        out.certified[k] = 1 if place == 0 and _was_inside(shape, s, before, k) else 0
        solved = True
        if place != 0:
            s, place, a, b, solved = walk(facets, s, (square, place, a, b), point)
        patch[k] = link[s, TRIANGLE]
        if place == 0:
            write_face(shape, k, s, a, b, point, out)
        else:
            write_kink(facets, k, (s, place, a), point, True, out)
        if smooth:
            smooth_normal(facets, s, k, out)
        if not solved:
            out.status[k] = MAX_ITERATIONS
