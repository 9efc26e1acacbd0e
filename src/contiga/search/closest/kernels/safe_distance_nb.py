"""How far a point can go before it can touch: a lower bound of its distance."""

from __future__ import annotations

import math

from contiga.jit import kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.hierarchy.kernels.tree_nb import open_node


@kernel()
def box_distance(tree, points, rows, safe_distance, start, stop):
    """Distance of points[rows] to the nearest box of a leaf into safe_distance[rows]."""
    nodes = stack_int64(128)
    bounds = scratch(128)
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
            open_node(tree, first, (x, y, z), nodes, bounds, top)
            top += 2
        safe_distance[k] = math.sqrt(best)
