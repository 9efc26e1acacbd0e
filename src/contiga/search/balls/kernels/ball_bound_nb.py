"""The corner values of cells: what all other cells of the body leave of their touching balls.

A hierarchy of boxes over the cells is gone through from each cell, near parts first; parts beyond
a ball that holds all its touching balls take nothing.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.balls.ball_records import BallLimits, PlaneWork, Samples
from contiga.search.balls.kernels.ball_plane_nb import clear_ball, far_box, lower, unit_normal
from contiga.search.hierarchy.kernels.tree_nb import box_distance2

SAFE = 1.0 - 1e-8
"""Radii are shrunk by this for rounding."""
GAIN = 1.25
"""A half of which no more than so many times as much is proved as of the whole is not cut again."""
SAMPLES = 5
GOALS = 2.0
"""Radii beyond this many goals are not worth a loss of smaller ones."""


@inner()
def _is_home(home, b):
    """Return whether cell b lies in the smooth block of `home`."""
    if home["cap"] >= 0:
        return home["cap"] == b["cap"]
    if home["patch"] != b["patch"]:
        return False
    box = home["uv"]
    uv = b["uv"]
    slack = 1e-9 * (box[1] - box[0]), 1e-9 * (box[3] - box[2])
    for i in range(3):
        u = (0.0, 1.0, -1.0)[i] * home["period"][0]
        if i > 0 and u == 0.0:
            continue
        if not (uv[0] + u >= box[0] - slack[0] and uv[1] + u <= box[1] + slack[0]):
            continue
        for j in range(3):
            v = (0.0, 1.0, -1.0)[j] * home["period"][1]
            if j > 0 and v == 0.0:
                continue
            if uv[2] + v >= box[2] - slack[1] and uv[3] + v <= box[3] + slack[1]:
                return True
    return False


@inner()
def _touching(q, x, normal):
    """Radius of the ball that touches at q, on the side of `normal`, and passes through x."""
    square = 0.0
    height = 0.0
    for c in range(3):
        d = x[c] - q[c]
        square += d * d
        height += d * normal[c]
    return 0.5 * square / height if height > 1e-12 * math.sqrt(square) else math.inf


@inner()
def _take_samples(elements, trims, centre, a, cap, samples):
    """Points, normals and touching radii by bend of five places of a cell; how many are in."""
    point, normal, above = samples.point, samples.normal, samples.above
    h = scratch(4, 6)
    e = a["element"]
    n = 0
    origin = elements.table[e]["origin"]
    box = a["box"]
    for k in range(SAMPLES):
        x = (0.5, 0.05, 0.05, 0.95, 0.95)[k]
        y = (0.5, 0.05, 0.95, 0.05, 0.95)[k]
        s = box[0] + x * (box[1] - box[0])
        t = box[2] + y * (box[3] - box[2])
        if a["state"] == 2:
            u, w = parameters(elements, e, s, t)
            if point_in_trim(trims, a["patch"], u, w) == 0:
                continue
        evaluate(elements, e, s, t, h)
        for c in range(3):
            point[n, c] = h[c, 0] + (origin[c] - centre[c])
        if not unit_normal(h, normal[n]):
            continue
        above[n, 0] = cap
        above[n, 1] = cap
        above[n, 2] = x
        above[n, 3] = y
        # How the surface bends there, towards either side.
        ee = ff = gg = l = m = r = 0.0
        for c in range(3):
            ee += h[c, 1] * h[c, 1]
            ff += h[c, 1] * h[c, 2]
            gg += h[c, 2] * h[c, 2]
            l += normal[n, c] * h[c, 3]
            m += normal[n, c] * h[c, 4]
            r += normal[n, c] * h[c, 5]
        det = ee * gg - ff * ff
        if det > 0.0:
            mean = 0.5 * (ee * r - 2.0 * ff * m + gg * l) / det
            root = math.sqrt(max(mean * mean - (l * r - m * m) / det, 0.0))
            if root - mean > 0.0:
                above[n, 0] = min(above[n, 0], 1.0 / (root - mean))
            if mean + root > 0.0:
                above[n, 1] = min(above[n, 1], 1.0 / (mean + root))
        n += 1
    return n


@inner()
def _lower_samples(samples, n, b, side):
    point, normal, above = samples.point, samples.normal, samples.above
    sign = -1.0 if side == 0 else 1.0
    m = scratch(3)
    for k in range(n):
        for c in range(3):
            m[c] = sign * normal[k, c]
        for i in range(4):
            x = b["corner"][i]
            above[k, side] = min(above[k, side], _touching(point[k], (x[0], x[1], x[2]), m))
        x = b["middle"]
        above[k, side] = min(above[k, side], _touching(point[k], (x[0], x[1], x[2]), m))


@inner()
def _bound_cell(body, a, home, limits, value, samples, count):
    """Lower the corner values (2, 4) of cell a by every cell of the tree; `count` samples too."""
    cells, tree, order = body.cells, body.tree, body.order
    work = PlaneWork(scratch(4), scratch(3), scratch(3), scratch(4), scratch(6))
    normal = scratch(2, 3)
    for c in range(3):
        normal[0, c] = -a["normal"][c]
        normal[1, c] = a["normal"][c]
    clear = scratch(2, 4)
    for side in range(2):
        _clear(a, normal[side], side, value[side], clear[side])
    stack = stack_int64(256)
    stack[0] = 0
    top = 1
    affects = np.empty(2, np.bool_)
    while top > 0:
        top -= 1
        node = stack[top]
        for side in range(2):
            x, y, z, r = clear[side, 0], clear[side, 1], clear[side, 2], clear[side, 3]
            affects[side] = (
                r > 0.0
                and box_distance2(tree, node, x, y, z) < r * r
                and not far_box(a, tree, node, normal[side], value[side], work)
            )
        if not (affects[0] or affects[1]):
            continue
        first = tree[node]["first"]
        if tree[node]["count"] == 0:
            x = a["middle"]
            near = box_distance2(tree, first, x[0], x[1], x[2])
            far = box_distance2(tree, first + 1, x[0], x[1], x[2])
            swap = 1 if far < near else 0
            stack[top] = first + 1 - swap
            stack[top + 1] = first + swap
            top += 2
            continue
        for i in range(first, first + tree[node]["count"]):
            b = cells[order[i]]
            if _is_home(home, b):
                continue
            for side in range(2):
                if affects[side] and lower(a, b, (normal[side], side), limits, value[side], work):
                    _clear(a, normal[side], side, value[side], clear[side])
                    _lower_samples(samples, count, b, side)


@inner()
def _clear(a, normal, side, v, ball):
    """Set the ball beyond which nothing lowers `v`: its middle and radius, 0 where all is lost."""
    ball[3] = 0.0
    if max(max(v[0], v[1]), max(v[2], v[3])) > 0.0:
        ball[0], ball[1], ball[2], ball[3] = clear_ball(a, normal, side, v)


@kernel()
def bound_cells(body, surface, homes, limits, result, start, stop):
    """Compute corner radii (2, 4) and the unproved share of rows start … stop of a body's cells.

    `body` is a `CellTree`, `surface` a `CentredSurface`, `limits` are `BallLimits`, and `result` is
    `CellBounds`.
    """
    cells = body.cells
    elements, trims, centre = surface.elements, surface.trims, surface.centre
    size, cap, goal = limits.size, limits.cap, limits.goal
    rows, value, want = result.rows, result.value, result.want
    samples = Samples(scratch(SAMPLES, 3), scratch(SAMPLES, 3), scratch(SAMPLES, 4))
    enough = BallLimits(size, cap, GOALS * goal)
    for i in range(start, stop):
        k = rows[i]
        a = cells[k]
        home = homes[a["home"]]
        known = value[k].copy()
        for side in range(2):
            value[k, side, :] = min(cap, SAFE * home["near"][side])
        n = _take_samples(elements, trims, centre, a, cap, samples)
        if home["near"][0] > 0.0 or home["near"][1] > 0.0:
            _bound_cell(body, a, home, enough, value[k], samples, n)
        gained = False
        for side in range(2):
            new, old = 0.0, 0.0
            for corner in range(4):
                value[k, side, corner] *= SAFE
                new += max(value[k, side, corner], 0.0)
                old += max(known[side, corner], 0.0)
            if old >= new:  # what was known of the whole holds for its half
                for corner in range(4):
                    value[k, side, corner] = known[side, corner]
            gained |= old == 0.0 or new > GAIN * old
        # The share of the samples at which less than half of the possible radius is proved.
        want[k] = 0.0
        if gained and n > 0:
            wanting, above = 0.0, samples.above
            for m in range(n):
                x, y = above[m, 2], above[m, 3]
                for side in range(2):
                    v = value[k, side]
                    sure = (1.0 - x) * ((1.0 - y) * v[0] + y * v[1])
                    sure += x * ((1.0 - y) * v[2] + y * v[3])
                    if sure < 0.5 * min(above[m, side], goal):
                        wanting += 1.0
            want[k] = 0.5 * wanting / n
