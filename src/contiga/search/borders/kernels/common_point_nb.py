"""Newton's method from places on two leaves to a common point.

Three equations leave one of the four parameters open: the shortest step is taken. A parameter at an
end of its leaf that the step would lead out of it is fixed, and the step is solved without it.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.borders.crossing_records import NewtonWork

MAX_STEPS = 10
"""Largest number of steps."""
SAME_POINT_FACTOR = 1e3
"""Largest distance of equal points of one pair, in tolerances of a common point."""
STEP_RATIO = 0.35
"""Largest ratio of the distances after and before a step."""
RANK_TOL = 1e-14
"""Share of its trace that is added to the diagonal of a matrix that may be singular."""

PLACES = np.array([[0.0, 0.0], [-0.6, -0.6], [-0.6, 0.6], [0.6, -0.6], [0.6, 0.6]])
"""Starting places on a leaf, in halves of its sides from its middle."""
N_PLACES, N_STARTS = len(PLACES), len(PLACES) ** 2
"""Number of these places, and of their pairs on two leaves."""


@kernel()
def nearest_starts(plates, starts):
    """Write the starts of each pair of leaves: the nearest pairs of places on their plates.

    They go to `fractions` and `distance` of `starts`, the nearest first, as many as these have
    columns.
    """
    place_on = scratch(2, N_PLACES, 3)
    distance = scratch(N_STARTS)
    for pair in range(starts.pairs.shape[0]):
        for side in range(2):
            plate = plates[starts.pairs[pair, side]]
            for i in range(N_PLACES):
                for c in range(3):
                    place_on[side, i, c] = plate["middle"][c] + PLACES[i, 0] * plate["x"][c]
                    place_on[side, i, c] += PLACES[i, 1] * plate["y"][c]
        for k in range(N_STARTS):
            a, b = place_on[0, k // N_PLACES], place_on[1, k % N_PLACES]
            x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
            distance[k] = math.sqrt(x * x + y * y + z * z)
        for i in range(starts.fractions.shape[1]):
            k = 0
            for j in range(1, N_STARTS):
                if distance[j] < distance[k]:
                    k = j
            starts.distance[pair, i] = distance[k]
            distance[k] = math.inf
            for axis in range(2):
                starts.fractions[pair, i, 0, axis] = 0.5 + 0.5 * PLACES[k // N_PLACES, axis]
                starts.fractions[pair, i, 1, axis] = 0.5 + 0.5 * PLACES[k % N_PLACES, axis]


@kernel()
def find_common_points(elements, leaves, starts, tolerance, common, start, stop):
    """Find the common points, to a `tolerance`, of the pairs start … stop.

    If several starts of a pair lead to one point, the first one counts. `starts` is `Starts`,
    `common` is `CommonPoints`, whose rows of these pairs are written: for a start without a common
    point `is_common` is False, and the rest is the place where Newton's method gave up.
    """
    work = NewtonWork(scratch(4), scratch(4), scratch(4, 3), scratch(4, 6))
    box = scratch(4, 2)
    for pair in range(start, stop):
        for side in range(2):
            leaf = leaves[starts.pairs[pair, side]]
            element_box = elements.table[leaf["element"]]["box"]
            for axis in range(2):
                k = 2 * side + axis
                box[k, 0] = leaf["box"][2 * axis]
                box[k, 1] = leaf["box"][2 * axis + 1]
                work.width[k] = element_box[2 * axis + 1] - element_box[2 * axis]
        pair_elements = (
            leaves[starts.pairs[pair, 0]]["element"],
            leaves[starts.pairs[pair, 1]]["element"],
        )
        for i in range(starts.fractions.shape[1]):
            for k in range(4):
                fraction = starts.fractions[pair, i, k // 2, k % 2]
                work.place[k] = box[k, 0] + fraction * (box[k, 1] - box[k, 0])
            limits = (starts.distance[pair, i] / STEP_RATIO, tolerance)
            is_common = _newton(elements, pair_elements, box, work, limits, common, (pair, i))
            same_dist = SAME_POINT_FACTOR * tolerance
            for j in range(i):
                square = 0.0
                for c in range(3):
                    d = common.point[pair, i, 0, c] - common.point[pair, j, 0, c]
                    square += d * d
                if common.is_common[pair, j] and square <= same_dist * same_dist:
                    is_common = False
            common.is_common[pair, i] = is_common


@inner()
def _newton(elements, pair, box, work, limits, common, at):
    """Return whether the places of `work` converge to a common point within their leaves' boxes.

    `limits` are the largest distance before the first step, and the tolerance. The method gives up
    if a step does not reduce the distance to `STEP_RATIO` of what was allowed before it, or after
    `MAX_STEPS`. The last places are written to row `at` of `common`; `work` is changed.
    """
    place, width, jacobian, h = work.place, work.width, work.jacobian, work.h
    limit, tolerance = limits
    row, i = at
    miss = scratch(3)
    step = scratch(4)
    for _ in range(MAX_STEPS + 1):
        for side in range(2):
            # The place on each leaf, and the derivatives by its two parameters.
            e, k = pair[side], 2 * side
            evaluate(elements, e, place[k], place[k + 1], h)
            u, v = parameters(elements, e, place[k], place[k + 1])
            common.uv[row, i, side, 0] = u
            common.uv[row, i, side, 1] = v
            sign = 1.0 - 2.0 * side
            for c in range(3):
                common.point[row, i, side, c] = h[c, 0] + elements.table[e]["origin"][c]
                for axis in range(2):
                    tangent = h[c, 1 + axis] / width[k + axis]
                    common.tangents[row, i, side, axis, c] = tangent
                    jacobian[k + axis, c] = sign * tangent
        square = 0.0
        for c in range(3):
            miss[c] = common.point[row, i, 1, c] - common.point[row, i, 0, c]
            square += miss[c] * miss[c]
        distance = math.sqrt(square)
        if distance <= tolerance:
            return True
        if not distance <= limit:
            return False
        limit *= STEP_RATIO
        _shortest_step(jacobian, miss, step)
        for _ in range(2):
            is_fixed = False
            for k in range(4):
                if (step[k] < 0.0 and place[k] <= box[k, 0]) or (
                    step[k] > 0.0 and place[k] >= box[k, 1]
                ):
                    jacobian[k] = 0.0
                    is_fixed = True
            if not is_fixed:
                break
            _shortest_step(jacobian, miss, step)
        for k in range(4):
            place[k] = min(max(place[k] + step[k] / width[k], box[k, 0]), box[k, 1])
    return False


@inner(inline="never")
def _shortest_step(jacobian, miss, step):
    """Write the shortest step (4,) with step · jacobian = miss (3,); zero if the jacobian is zero.

    A singular one gives the least-squares solution. The normal equations are solved by Gaussian
    elimination without pivots: their matrix is positive.
    """
    a = scratch(3, 4)
    for i in range(3):
        for j in range(3):
            a[i, j] = 0.0
            for k in range(4):
                a[i, j] += jacobian[k, i] * jacobian[k, j]
        a[i, 3] = miss[i]
    trace = a[0, 0] + a[1, 1] + a[2, 2]
    if trace == 0.0:
        for k in range(4):
            step[k] = 0.0
        return
    for i in range(3):
        a[i, i] += RANK_TOL * trace
    for i in range(3):
        for j in range(i + 1, 3):
            factor = a[j, i] / a[i, i]
            for k in range(i + 1, 4):
                a[j, k] -= factor * a[i, k]
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            a[i, 3] -= a[i, k] * a[k, 3]
        a[i, 3] /= a[i, i]
    for k in range(4):
        step[k] = jacobian[k, 0] * a[0, 3] + jacobian[k, 1] * a[1, 3] + jacobian[k, 2] * a[2, 3]
