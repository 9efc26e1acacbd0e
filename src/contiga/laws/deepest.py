"""The greatest penetration as a smooth function of all penetrations, with its gradient.

The gradient of λ_max itself jumps from point to point as another becomes the deepest, and does not
exist while several are equally deep. Here all points within the share η of the greatest depth
count: m is the gauge (Luxemburg norm) of the penetrations,

    Σ_i max(1 + (λ_i/m − 1)/η, 0)² = 1,

convex, of degree one, monotone in each λ_i, with a continuous gradient (Rockafellar, Convex
Analysis, section 15). It equals λ_max if the deepest point is alone in that layer, whatever else is
in contact, and is less than λ_max/(1 − η) for any number of points. No smooth function equals λ_max
both for one point and for several equally deep ones, hence the difference of up to η.
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
    """m ≥ λ_max, zero if all penetrations are."""
    weight: FloatArray
    """(n,) ∂m/∂λ_i ≥ 0; their sum is between 1 and 1/(1 − η)."""
    curvature: float
    """Upper bound of the eigenvalues of ∂²m/∂λ_i∂λ_j, 1/length, zero if one point carries all."""
    layer: float
    """η m p·y of `deepest`, length, the divisor of ∂²m; zero if one point carries all."""


def deepest(penetration: FloatArray) -> Deepest:
    """Return m and its gradient, for `penetration` (n,) ≥ 0, n ≥ 1; equal weights if all are zero.

    Its curvature is an upper bound, and set to zero where one point counts or 1/layer overflows.
    With p the parentheses above, y = λ/m and w the weights, of the points with p > 0, the second
    derivative along d is |d − y (w·d)|²/(η m p·y). As w·y = 1, this is an oblique projection of d,
    which lengthens it by |y| |w| at most.

    >>> smooth = deepest(np.array([2.0, 1.0, 1.995]))
    >>> 2.0 <= smooth.depth < 2.0 / (1.0 - WIDTH), (smooth.weight > 0.0).tolist()
    (True, [True, False, True])
    """
    n, max_depth = len(penetration), float(penetration.max())
    if not max_depth > 0.0:
        return Deepest(0.0, np.full(n, 1.0 / n), 0.0, 0.0)
    relative = penetration / max_depth
    rows = np.flatnonzero(relative > 1.0 - WIDTH)
    y = relative[rows]
    gap = (1.0 - WIDTH) * (1.0 - y) / WIDTH
    x = _gauge_root(y, gap)
    p = np.maximum(x * y - gap, 0.0)
    ratio = 1.0 - WIDTH * (1.0 - x)  # λ_max/m
    is_loaded = p > 0.0
    product = float((p * y).sum() * ratio)
    weights, scaled, depth = p[is_loaded] / product, y[is_loaded] * ratio, max_depth / ratio
    weight = np.zeros(n)
    weight[rows[is_loaded]] = weights
    layer = WIDTH * depth * product
    if len(weights) == 1 or layer < np.finfo(float).tiny:  # 1/layer would overflow
        return Deepest(depth, weight, 0.0, 0.0)
    squared_norm = float((weights * weights).sum() * (scaled * scaled).sum())
    return Deepest(depth, weight, squared_norm / layer, layer)


def _gauge_root(y: FloatArray, gap: FloatArray) -> float:
    """Return the x in (0, 1] with Σ max(x y − gap, 0)² = 1, where one y is 1 and its gap 0.

    Newton's method from above, where the function is convex and rises, until x falls no more.
    """
    x = 1.0
    while True:
        p = np.maximum(x * y - gap, 0.0)
        lower = x - float((p * p).sum() - 1.0) / (2.0 * float((p * y).sum()))
        if not 0.0 < lower < x:
            return x
        x = lower
