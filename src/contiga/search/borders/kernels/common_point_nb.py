"""Newton's method from places on two leaves to a point that both pass through.

Of the four parameters that three equations leave open the shortest step is taken. A parameter at
an end of its leaf that the step would lead out stays, and the others go without it.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate, parameters
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.search.borders.crossing_records import LeadWork

HOPS = 10
"""Steps at most."""
SAME = 1e3
"""Points of one pair that are nearer than this, in units of how near two places meet, are one."""
NEARER = 0.35
"""Share of their distance that each step leaves of it at most."""
RANK = 1e-14
"""Share of a matrix that is added to one that may be singular."""

PLACES = np.array([[0.0, 0.0], [-0.6, -0.6], [-0.6, 0.6], [0.6, -0.6], [0.6, 0.6]])
"""Places of a leaf that are looked at, in halves of its sides from its middle."""
N_PLACES, N_STARTS = len(PLACES), len(PLACES) ** 2
"""How many these are, and their pairs on two leaves."""


@kernel()
def nearest_starts(plates, starts):
    """Fill in the starts of each pair of leaves: those of its pairs of places that are nearest to
    each other on the leaves' plates, the nearest first."""
    on = scratch(2, N_PLACES, 3)
    off = scratch(N_STARTS)
    for pair in range(starts.pairs.shape[0]):
        for side in range(2):
            plate = plates[starts.pairs[pair, side]]
            for i in range(N_PLACES):
                for c in range(3):
                    on[side, i, c] = plate["middle"][c] + PLACES[i, 0] * plate["x"][c]
                    on[side, i, c] += PLACES[i, 1] * plate["y"][c]
        for k in range(N_STARTS):
            one, two = on[0, k // N_PLACES], on[1, k % N_PLACES]
            x, y, z = one[0] - two[0], one[1] - two[1], one[2] - two[2]
            off[k] = math.sqrt(x * x + y * y + z * z)
        for i in range(starts.share.shape[1]):
            k = 0
            for other in range(1, N_STARTS):
                if off[other] < off[k]:
                    k = other
            starts.distance[pair, i] = off[k]
            off[k] = math.inf
            for axis in range(2):
                starts.share[pair, i, 0, axis] = 0.5 + 0.5 * PLACES[k // N_PLACES, axis]
                starts.share[pair, i, 1, axis] = 0.5 + 0.5 * PLACES[k % N_PLACES, axis]


@kernel()
def lead_together(elements, leaves, starts, near, common, start, stop):
    """Lead the places of the pairs start … stop together; those that come within `near` have met.

    Where several starts of a pair lead to one point, the first has met there. `starts` is
    `Starts`, `common` is `CommonPoints`.
    """
    work = LeadWork(scratch(4), scratch(4), scratch(4, 3), scratch(4, 6))
    box = scratch(4, 2)
    for pair in range(start, stop):
        for side in range(2):
            leaf = leaves[starts.pairs[pair, side]]
            whole = elements.table[leaf["element"]]["box"]
            for axis in range(2):
                k = 2 * side + axis
                box[k, 0] = leaf["box"][2 * axis]
                box[k, 1] = leaf["box"][2 * axis + 1]
                work.wide[k] = whole[2 * axis + 1] - whole[2 * axis]
        one = leaves[starts.pairs[pair, 0]]["element"]
        two = leaves[starts.pairs[pair, 1]]["element"]
        for i in range(starts.share.shape[1]):
            for k in range(4):
                share = starts.share[pair, i, k // 2, k % 2]
                work.place[k] = box[k, 0] + share * (box[k, 1] - box[k, 0])
            limit = starts.distance[pair, i] / NEARER
            met = _led_together(elements, (one, two), box, work, (limit, near), common, (pair, i))
            common.met[pair, i] = met and not _is_known(common, pair, i, SAME * near)


@inner()
def _led_together(elements, pair, box, work, limits, common, at):
    """Return whether the places of `work` come to one point."""
    place, slope = work.place, work.slope
    limit, near = limits
    miss = scratch(3)
    step = scratch(4)
    for _ in range(HOPS + 1):
        for side in range(2):
            _look_at(elements, pair[side], side, work, common, at)
        square = 0.0
        for c in range(3):
            miss[c] = common.point[at[0], at[1], 1, c] - common.point[at[0], at[1], 0, c]
            square += miss[c] * miss[c]
        off = math.sqrt(square)
        if off <= near:
            return True
        if not off <= limit:
            return False
        limit *= NEARER
        _shortest(slope, miss, step)
        for _ in range(2):
            stays = False
            for k in range(4):
                if (step[k] < 0.0 and place[k] <= box[k, 0]) or (
                    step[k] > 0.0 and place[k] >= box[k, 1]
                ):
                    slope[k] = 0.0
                    stays = True
            if not stays:
                break
            _shortest(slope, miss, step)
        for k in range(4):
            place[k] = min(max(place[k] + step[k] / work.wide[k], box[k, 0]), box[k, 1])
    return False


@inner()
def _look_at(elements, e, side, work, common, at):
    """Evaluate the place on a side's leaf, and how it moves with its two parameters."""
    h, slope, wide = work.h, work.slope, work.wide
    pair, i = at
    k = 2 * side
    s, t = work.place[k], work.place[k + 1]
    evaluate(elements, e, s, t, h)
    u, v = parameters(elements, e, s, t)
    common.uv[pair, i, side, 0] = u
    common.uv[pair, i, side, 1] = v
    sign = 1.0 - 2.0 * side
    for c in range(3):
        common.point[pair, i, side, c] = h[c, 0] + elements.table[e]["origin"][c]
        for axis in range(2):
            along = h[c, 1 + axis] / wide[k + axis]
            common.along[pair, i, side, axis, c] = along
            slope[k + axis, c] = sign * along


@inner()
def _is_known(common, pair, i, near):
    """Return whether a start before has led the same two leaves to the same point."""
    for j in range(i):
        square = 0.0
        for c in range(3):
            d = common.point[pair, i, 0, c] - common.point[pair, j, 0, c]
            square += d * d
        if common.met[pair, j] and square <= near * near:
            return True
    return False


@inner(inline="never")
def _shortest(slope, miss, step):
    """The shortest step (4,) with step · slope = miss (3,), least squares where it has no rank.

    Normal equations by Gauss's elimination, which needs no pivots: the matrix is positive.
    """
    a = scratch(3, 4)
    for i in range(3):
        for j in range(3):
            a[i, j] = 0.0
            for k in range(4):
                a[i, j] += slope[k, i] * slope[k, j]
        a[i, 3] = miss[i]
    trace = a[0, 0] + a[1, 1] + a[2, 2]
    if trace == 0.0:
        for k in range(4):
            step[k] = 0.0
        return
    for i in range(3):
        a[i, i] += RANK * trace
    for i in range(3):
        for j in range(i + 1, 3):
            share = a[j, i] / a[i, i]
            for k in range(i + 1, 4):
                a[j, k] -= share * a[i, k]
    for i in range(2, -1, -1):
        for k in range(i + 1, 3):
            a[i, 3] -= a[i, k] * a[k, 3]
        a[i, 3] /= a[i, i]
    for k in range(4):
        step[k] = slope[k, 0] * a[0, 3] + slope[k, 1] * a[1, 3] + slope[k, 2] * a[2, 3]
