"""Feet continued from the last ones by walking over adjoining triangles.

From the closest point of a triangle the walk goes to an adjoining triangle that is closer, across
the edge or around the corner of that point, until none is: a local minimum of the distance,
connected to the last foot. The distance decreases at every step, so no triangle is visited twice.
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

MAX_STEPS = 1 << 20
"""Largest number of triangles of a walk."""


# These kernels are optimised by themselves, not only in their callers, where they would be too
# large to be inlined: a walk would take a fifth longer.
@inner(pipeline_class=Compiler)
def _nearest_around(facets, number, best, point):
    """Return the closest point on the triangles around a vertex or a crowded edge.

    Returns squared distance, slot, place and its two numbers; the slot is −1 if no triangle is
    closer than the squared distance `best`. Of equally close triangles the first in `around`
    counts.
    """
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
    the minimum was reached within `MAX_STEPS`.
    """
    shape = facets.shape
    link = facets.link
    best, place, a, b = first
    for _ in range(MAX_STEPS):
        if place == 0:
            return s, place, a, b, True
        if place < 4:
            neighbour = link[s, place - 1]
            if neighbour == NO_TRIANGLE:
                return s, place, a, b, True
            if neighbour >= 0:
                square, p, u, v = closest_on(shape, neighbour, point[0], point[1], point[2])
                if square >= best:
                    return s, place, a, b, True
                best = square
                s = neighbour
                place = p
                a = u
                b = v
                continue
            new = _nearest_around(facets, -2 - neighbour, best, point)
        else:
            new = _nearest_around(facets, link[s, VERTICES + place - 4], best, point)
        if new[1] < 0:
            return s, place, a, b, True
        best, s, place, a, b = new
    return s, place, a, b, False


@kernel()
def project_tracked(facets, points, starts, smooth, out, start, stop):
    """Write the feet of rows start … stop − 1 to `out`, continued from `starts` (WalkStarts).

    Rows of slot −1 are skipped. A foot inside the triangle of the last foot is certified if the
    last point also was over that triangle: the path between both feet is straight, because
    triangles are convex. A walk without a minimum gets the status MAX_ITERATIONS at its last place;
    a point that is not finite gets a blank row with NOT_FINITE; for other statuses see
    `write_kink`. If `smooth`, normals are interpolated.
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
        out.certified[k] = 0
        if place == 0 and before.shape[0] > 0:
            # The last foot of a point that was not finite compares as not inside.
            last_place = closest_on(shape, s, before[k, 0], before[k, 1], before[k, 2])[1]
            out.certified[k] = 1 if last_place == 0 else 0
        is_solved = True
        if place != 0:
            s, place, a, b, is_solved = walk(facets, s, (square, place, a, b), point)
        patch[k] = link[s, TRIANGLE]
        if place == 0:
            write_face(shape, k, s, a, b, point, out)
        else:
            write_kink(facets, k, (s, place, a), point, True, out)
        if smooth:
            smooth_normal(facets, s, k, out)
        if not is_solved:
            out.status[k] = MAX_ITERATIONS
