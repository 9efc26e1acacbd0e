"""Check triangles of a face against the surface, and split those farther from it than the sag."""

from __future__ import annotations

import numpy as np

from contiga.geometry.kernels.chord_nb import triangle_distance
from contiga.geometry.kernels.height_nb import all_below, plane_of
from contiga.geometry.kernels.refine_nb import (
    CHECKED,
    GOOD,
    NEW,
    SAG_SHARE,
    advance,
    halve,
    insert_vertex,
    is_full,
    is_good,
    queue_new,
)
from contiga.geometry.kernels.shape_nb import evaluate
from contiga.geometry.kernels.triangulation_nb import BORDER, TRIANGLES
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

SAMPLE_WEIGHTS = np.array(
    [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [1 / 3, 1 / 3, 1 / 3]]
)
"""Samples of a triangle in barycentric coordinates: the middles of its sides, where the surface may
lie over the neighbour, and the centroid."""


@inner()
def miss_at(t, face, front, triangle, x, y):
    """Return the distance of the surface's point at (x, y) from a triangle and its neighbours.

    The nearest of them counts; none is looked at after one within `SAG_SHARE` of the sag.
    Overwrites `face.D`.
    """
    evaluate(face, x, y, 0)
    nearest = np.inf
    for k in range(-1, 3):
        candidate = triangle if k < 0 else t.neighbours[triangle, k]
        if candidate == BORDER:
            continue
        c = t.corners[candidate]
        miss = triangle_distance(
            face.D[0, 0], front.points[c[0]], front.points[c[1]], front.points[c[2]]
        )
        nearest = min(nearest, miss)
        if nearest <= face.sag * SAG_SHARE:
            break
    return nearest


@inner()
def largest_miss(t, face, front, triangle):
    """Return the largest `miss_at` the samples of a triangle, and x and y of that sample.

    Samples on a side that a neighbour has checked, or on the border, are skipped.
    """
    c = t.corners[triangle]
    largest, px, py = -1.0, 0.0, 0.0
    for i in range(4):
        if i < 3:
            neighbour = t.neighbours[triangle, (i + 2) % 3]
            if neighbour == BORDER or t.state[neighbour] == CHECKED:
                continue
        x = y = 0.0
        for k in range(3):
            x += SAMPLE_WEIGHTS[i, k] * t.xy[c[k], 0]
            y += SAMPLE_WEIGHTS[i, k] * t.xy[c[k], 1]
        miss = miss_at(t, face, front, triangle, x, y)
        if miss > largest:
            largest, px, py = miss, x, y
    return largest, px, py


@inner()
def prove_sag(t, face, front, heights, triangle):
    """Return whether the surface over a triangle is proved within the sag of its plane, and (x, y).

    If not, (x, y) is a place that misses, or where the proof does not close. Triangles without area
    pass.
    """
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
def check_sag(t, face, front, heights, triangle):
    """Return whether a triangle is within the sag, by samples and then by proof; and (x, y).

    If not, (x, y) is the place for a new vertex.
    """
    miss, x, y = largest_miss(t, face, front, triangle)
    if miss > SAG_SHARE * face.sag:
        return False, x, y
    return prove_sag(t, face, front, heights, triangle)


@kernel()
def refine(t, face, front, heights):
    """Split triangles until all are within the sag or too small to be split.

    Returns True then, False if the memory is full: the caller enlarges it and calls again.
    """
    queue_new(t, front)
    while True:
        if not advance(t, face, front):
            return False
        all_checked = True
        for triangle in range(t.used[TRIANGLES]):
            if is_full(t, 2):
                return False
            if t.state[triangle] == NEW and not is_good(t, front, triangle):
                halve(t, face, front, triangle)
                all_checked = False
            if t.state[triangle] != GOOD:
                continue
            is_within, x, y = check_sag(t, face, front, heights, triangle)
            if is_within:
                t.state[triangle] = CHECKED
                continue
            all_checked = False
            t.state[triangle] = NEW
            if not insert_vertex(t, face, front, triangle, x, y, 0.0):
                halve(t, face, front, triangle)
        if all_checked:
            return True
