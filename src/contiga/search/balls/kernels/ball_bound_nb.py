"""The corner values of cells: the bound of their touching balls by all other cells of the body.

A hierarchy of boxes over the cells is traversed from each cell, near parts first; parts outside a
ball that contains all touching balls of the cell do not change its values.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.balls.ball_records import BallLimits, PlaneWork, Samples
from contiga.search.balls.kernels.ball_plane_nb import (
    box_is_far,
    enclosing_ball,
    lower_by_cell,
    unit_normal,
)
from contiga.search.hierarchy.kernels.tree_nb import box_distance2

SAFETY = 1.0 - 1e-8
"""Factor of radii that covers rounding."""
MIN_GAIN = 1.25
"""Ratio of the radii of a half to those of the whole cell below which the half is not cut again."""
N_SAMPLES = 5
"""Number of sample places of a cell."""
MAX_GOALS = 2.0
"""Radius, in goals, beyond which a larger one is not worth a loss of smaller ones."""


@inner()
def _is_in_block(block, b):
    """Return whether cell b is in a smooth block, also one period of a closed patch away.

    The cells of a block that is a cap are the cells with this cap.
    """
    if block["cap"] >= 0:
        return block["cap"] == b["cap"]
    if block["patch"] != b["patch"]:
        return False
    box = block["uv"]
    uv = b["uv"]
    slack = 1e-9 * (box[1] - box[0]), 1e-9 * (box[3] - box[2])
    for i in range(3):
        u = (0.0, 1.0, -1.0)[i] * block["period"][0]
        if i > 0 and u == 0.0:
            continue
        if not (uv[0] + u >= box[0] - slack[0] and uv[1] + u <= box[1] + slack[0]):
            continue
        for j in range(3):
            v = (0.0, 1.0, -1.0)[j] * block["period"][1]
            if j > 0 and v == 0.0:
                continue
            if uv[2] + v >= box[2] - slack[1] and uv[3] + v <= box[3] + slack[1]:
                return True
    return False


@inner()
def _sample_cell(elements, trims, centre, a, cap, samples):
    """Write points, normals, and upper bounds of the radii of a cell at five places to `samples`.

    The bounds are the radii of curvature there, at most `cap`. Returns the number of samples that
    are not trimmed away and have a normal.
    """
    point, normal, above = samples.point, samples.normal, samples.above
    h = scratch(4, 6)
    e = a["element"]
    n = 0
    origin = elements.table[e]["origin"]
    box = a["box"]
    for k in range(N_SAMPLES):
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
        # The principal curvatures there.
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
    """Lower the radii `above` of n samples on `side` by touching balls through places of cell b.

    The places are its corners and middle. Points that are not in front of the sample, on `side`, do
    not count.
    """
    sign = -1.0 if side == 0 else 1.0
    for k in range(n):
        for i in range(5):
            square = 0.0
            height = 0.0
            for c in range(3):
                x = b["middle"][c] if i == 4 else b["corner"][i, c]
                d = x - samples.point[k, c]
                square += d * d
                height += d * (sign * samples.normal[k, c])
            if height > 1e-12 * math.sqrt(square):
                samples.above[k, side] = min(samples.above[k, side], 0.5 * square / height)


@inner()
def _bound_cell(body, a, block, limits, value, samples, count):
    """Lower the corner `value` (2, 4) of cell a, and its `count` samples, by all cells of the tree.

    Cells of its smooth block, and boxes that no touching ball of the cell reaches, are skipped.
    """
    cells, tree, order = body.cells, body.tree, body.order
    work = PlaneWork(scratch(4), scratch(3), scratch(3), scratch(4), scratch(6))
    normal = scratch(2, 3)
    for c in range(3):
        normal[0, c] = -a["normal"][c]
        normal[1, c] = a["normal"][c]
    balls = scratch(2, 4)
    for side in range(2):
        _set_enclosing_ball(a, normal[side], side, value[side], balls[side])
    stack = stack_int64(256)
    stack[0] = 0
    top = 1
    is_affected = np.empty(2, np.bool_)
    while top > 0:
        top -= 1
        node = stack[top]
        for side in range(2):
            x, y, z, r = balls[side, 0], balls[side, 1], balls[side, 2], balls[side, 3]
            is_affected[side] = (
                r > 0.0
                and box_distance2(tree, node, x, y, z) < r * r
                and not box_is_far(a, tree, node, normal[side], value[side], work)
            )
        if not (is_affected[0] or is_affected[1]):
            continue
        first = tree[node]["first"]
        if tree[node]["count"] == 0:
            x = a["middle"]
            first_square = box_distance2(tree, first, x[0], x[1], x[2])
            second_square = box_distance2(tree, first + 1, x[0], x[1], x[2])
            swap = 1 if second_square < first_square else 0
            stack[top] = first + 1 - swap
            stack[top + 1] = first + swap
            top += 2
            continue
        for i in range(first, first + tree[node]["count"]):
            b = cells[order[i]]
            if _is_in_block(block, b):
                continue
            for side in range(2):
                if not is_affected[side]:
                    continue
                if lower_by_cell(a, b, (normal[side], side), limits, value[side], work):
                    _set_enclosing_ball(a, normal[side], side, value[side], balls[side])
                    _lower_samples(samples, count, b, side)


@inner()
def _set_enclosing_ball(a, normal, side, v, ball):
    """Write centre and radius of the ball outside of which nothing lowers `v` to ball[4].

    The radius is 0 if no value is positive.
    """
    ball[3] = 0.0
    if max(max(v[0], v[1]), max(v[2], v[3])) > 0.0:
        ball[0], ball[1], ball[2], ball[3] = enclosing_ball(a, normal, side, v)


@kernel()
def bound_cells(body, surface, blocks, limits, result, start, stop):
    """Write corner radii (2, 4) and unproved share of the cells `rows` start … stop to `result`.

    If the radii on a side that a half inherited from its cell are as large in sum, they are kept.
    The unproved share is that of the samples of both sides with less than half of the possible
    radius, up to the goal; zero for a half that gains less than `MIN_GAIN` over its cell on both
    sides, which is not to be cut again. `body` is a `CellTree`, `surface` a `CentredSurface`,
    `limits` are `BallLimits`, and `result` is `CellBounds`.
    """
    cells = body.cells
    elements, trims, centre = surface.elements, surface.trims, surface.centre
    size, cap, goal = limits.size, limits.cap, limits.goal
    rows, value, unproved = result.rows, result.value, result.unproved
    samples = Samples(scratch(N_SAMPLES, 3), scratch(N_SAMPLES, 3), scratch(N_SAMPLES, 4))
    search_limits = BallLimits(size, cap, MAX_GOALS * goal)
    for i in range(start, stop):
        k = rows[i]
        a = cells[k]
        block = blocks[a["block"]]
        inherited = value[k].copy()
        for side in range(2):
            value[k, side, :] = min(cap, SAFETY * block["radii"][side])
        n = _sample_cell(elements, trims, centre, a, cap, samples)
        if block["radii"][0] > 0.0 or block["radii"][1] > 0.0:
            _bound_cell(body, a, block, search_limits, value[k], samples, n)
        has_gain = False
        for side in range(2):
            new_sum, old_sum = 0.0, 0.0
            for corner in range(4):
                value[k, side, corner] *= SAFETY
                new_sum += max(value[k, side, corner], 0.0)
                old_sum += max(inherited[side, corner], 0.0)
            if old_sum >= new_sum:  # the bound of the whole cell holds for its half
                for corner in range(4):
                    value[k, side, corner] = inherited[side, corner]
            has_gain |= old_sum == 0.0 or new_sum > MIN_GAIN * old_sum
        # The share of the samples at which less than half of the possible radius is proved.
        unproved[k] = 0.0
        if has_gain and n > 0:
            n_poor, above = 0.0, samples.above
            for m in range(n):
                x, y = above[m, 2], above[m, 3]
                for side in range(2):
                    v = value[k, side]
                    proved = (1.0 - x) * ((1.0 - y) * v[0] + y * v[1])
                    proved += x * ((1.0 - y) * v[2] + y * v[3])
                    if proved < 0.5 * min(above[m, side], goal):
                        n_poor += 1.0
            unproved[k] = 0.5 * n_poor / n
