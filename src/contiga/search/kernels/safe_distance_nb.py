"""How far a point can go before it can touch: a lower bound of its distance."""

from __future__ import annotations

import math

import numpy as np

from contiga.num.jit import kernel
from contiga.search.kernels.tree_nb import box_distance2


@kernel()
def box_distance(tree, points, rows, safe_distance, start, stop):
    """Distance of points[rows] to the nearest box of a leaf into reach[rows]."""
    nodes = np.empty(128, np.int64)
    bounds = np.empty(128)
    for i in range(start, stop):
        k = rows[i]
        x = points[k, 0]
        y = points[k, 1]
        z = points[k, 2]
        if not math.isfinite(x + y + z):
            safe_distance[k] = math.inf
            continue
        best = math.inf
        nodes[0] = 0
        bounds[0] = 0.0
        top = 1
        while top > 0:
            top -= 1
            if bounds[top] >= best:
                continue
            node = nodes[top]
            first = tree[node]["first"]
            if tree[node]["count"] > 0:
                best = bounds[top]
                continue
            a = box_distance2(tree, first, x, y, z)
            b = box_distance2(tree, first + 1, x, y, z)
            near = 0 if a <= b else 1
            nodes[top] = first + 1 - near
            bounds[top] = b if near == 0 else a
            nodes[top + 1] = first + near
            bounds[top + 1] = a if near == 0 else b
            top += 2
        safe_distance[k] = math.sqrt(best)
