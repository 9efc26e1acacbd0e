"""The greatest penetration as a smooth function of all of them, with its gradient.

λ_max alone has a gradient that jumps from point to point where another becomes the deepest, and
none where several are. Here the points less than the share η of it above the deepest count, too:
m is the gauge (Luxemburg norm) of the penetrations,

    Σ_i max(1 + (λ_i/m − 1)/η, 0)² = 1,

convex, of degree one, never falling in any λ_i, with a continuous gradient (Rockafellar, Convex
Analysis, section 15). It is λ_max where the deepest point is alone in that layer, whatever else is
in contact, and less than λ_max/(1 − η) for any number of points. No smooth function is λ_max both
for one point and for several that are equally deep, so a share of η is left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import FloatArray

WIDTH = 0.005
"""η."""


class Deepest(NamedTuple):
    """The greatest penetration of n points."""

    depth: float
    """m ≥ λ_max, zero where all are."""
    weight: FloatArray
    """(n,) ∂m/∂λ_i ≥ 0; their sum is between 1 and 1/(1 − η)."""
    curvature: float
    """The largest eigenvalue of ∂²m/∂λ_i∂λ_j, 1/length, which is zero but for points that share."""
    layer: float
    """η m p·y of `deepest`, length: what the second derivative is over; zero where one carries."""


def deepest(penetration: FloatArray) -> Deepest:
    """M and its gradient, of `penetration` (n,) ≥ 0, n ≥ 1; where all are zero equal weights.

    With p the parentheses above, y = λ/m and w the weights, all of the points that share, the
    second derivative along d is |d − y (w·d)|²/(η m p·y). As w·y = 1 that takes y away from d along
    a slant, which makes d longer by |y| |w| at most.

    >>> found = deepest(np.array([2.0, 1.0, 1.995]))
    >>> 2.0 <= found.depth < 2.0 / (1.0 - WIDTH), (found.weight > 0.0).tolist()
    (True, [True, False, True])
    """
    n, most = len(penetration), float(penetration.max())
    if not most > 0.0:
        return Deepest(0.0, np.full(n, 1.0 / n), 0.0, 0.0)
    relative = penetration / most
    near = np.flatnonzero(relative > 1.0 - WIDTH)
    y = relative[near]
    gap = (1.0 - WIDTH) * (1.0 - y) / WIDTH
    top = _root(y, gap)
    part = np.maximum(top * y - gap, 0.0)
    shrunk = 1.0 - WIDTH * (1.0 - top)  # λ_max/m
    on = part > 0.0
    whole = float((part * y).sum() * shrunk)
    part_on, scaled, depth = part[on] / whole, y[on] * shrunk, most / shrunk
    weight = np.zeros(n)
    weight[near[on]] = part_on
    layer = WIDTH * depth * whole
    if len(part_on) == 1 or layer < np.finfo(float).tiny:  # one over it would be no number
        return Deepest(depth, weight, 0.0, 0.0)
    slant = float((part_on * part_on).sum() * (scaled * scaled).sum())
    return Deepest(depth, weight, slant / layer, layer)


def _root(y: FloatArray, gap: FloatArray) -> float:
    """The x in (0, 1] with Σ max(x y − gap, 0)² = 1, where one y is 1 and its gap 0.

    By Newton from above, where the function is convex and rises: until it goes down no more.
    """
    x = 1.0
    while True:
        part = np.maximum(x * y - gap, 0.0)
        lower = x - float((part * part).sum() - 1.0) / (2.0 * float((part * y).sum()))
        if not 0.0 < lower < x:
            return x
        x = lower
