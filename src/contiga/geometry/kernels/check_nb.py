"""Triangles of a face held against the surface, and cut where it is farther than allowed."""

from __future__ import annotations

import numpy as np

from contiga.geometry.kernels.chord_nb import triangle_distance
from contiga.geometry.kernels.height_nb import all_below, plane_of
from contiga.geometry.kernels.refine_nb import (
    ALLOWED,
    CHECKED,
    GOOD,
    NEW,
    advance,
    full,
    halve,
    is_good,
    put_vertex,
    queue_all,
)
from contiga.geometry.kernels.shape_nb import evaluate
from contiga.geometry.kernels.triangulation_nb import BORDER, TRIANGLES
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

PLACES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [1 / 3, 1 / 3, 1 / 3]])
"""Where a triangle is sampled, as shares of its corners: on sides, where the surface may lie over
the triangle beside it, and inside."""


@inner()
def miss_at(t, face, front, triangle, x, y):
    """Distance of a place of the surface from a triangle or those beside it."""
    evaluate(face, x, y, 0)
    most = np.inf
    for k in range(-1, 3):
        here = triangle if k < 0 else t.beside[triangle, k]
        if here == BORDER:
            continue
        c = t.corners[here]
        miss = triangle_distance(
            face.D[0, 0], front.points[c[0]], front.points[c[1]], front.points[c[2]]
        )
        most = min(most, miss)
        if most <= face.sag * ALLOWED:
            break
    return most


@inner()
def largest_miss(t, face, front, triangle):
    """Largest miss at places over a triangle, and the place.

    What a triangle beside it has seen, or is on the border, is left out.
    """
    c = t.corners[triangle]
    most, px, py = -1.0, 0.0, 0.0
    for i in range(4):
        if i < 3:
            other = t.beside[triangle, (i + 2) % 3]
            if other == BORDER or t.state[other] == CHECKED:
                continue
        x = y = 0.0
        for k in range(3):
            x += PLACES[i, k] * t.xy[c[k], 0]
            y += PLACES[i, k] * t.xy[c[k], 1]
        miss = miss_at(t, face, front, triangle, x, y)
        if miss > most:
            most, px, py = miss, x, y
    return most, px, py


@inner()
def proved(t, face, front, heights, triangle):
    """Return whether the surface keeps the distance from a triangle's plane, or where not."""
    c = t.corners[triangle]
    m = heights.middle
    uv = scratch(3, 2)
    points = scratch(3, 3)
    for k in range(3):
        for d in range(2):
            uv[k, d] = face.frame[d] + t.xy[c[k], d] * face.frame[2 + d]
        for d in range(3):
            points[k, d] = front.points[c[k], d] - m[d]
    plane = scratch(4)
    if not plane_of(points[0], points[1], points[2], plane):
        return True, 0.0, 0.0
    below, u, v = all_below(heights, uv, plane, face.sag)
    return below, (u - face.frame[0]) / face.frame[2], (v - face.frame[1]) / face.frame[3]


@inner()
def keeps(t, face, front, heights, triangle):
    """Return whether a triangle keeps the distance, and a place for a vertex if not."""
    miss, x, y = largest_miss(t, face, front, triangle)
    if miss > ALLOWED * face.sag:
        return False, x, y
    return proved(t, face, front, heights, triangle)


@kernel()
def refine(t, face, front, heights):
    """Cut triangles until all keep the distance; False if room ran out: call it again then."""
    queue_all(t, front)
    while True:
        if not advance(t, face, front):
            return False
        whole = True
        for here in range(t.used[TRIANGLES]):
            if full(t, 2):
                return False
            if t.state[here] == NEW and not is_good(t, front, here):
                halve(t, face, front, here)
                whole = False
            if t.state[here] != GOOD:
                continue
            kept, x, y = keeps(t, face, front, heights, here)
            if kept:
                t.state[here] = CHECKED
                continue
            whole = False
            t.state[here] = NEW
            if not put_vertex(t, face, front, here, x, y, 0.0):
                halve(t, face, front, here)
        if whole:
            return True
