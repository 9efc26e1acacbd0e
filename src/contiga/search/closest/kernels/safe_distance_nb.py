"""Lower bound of the distance of a point: how far it can go before it can touch."""

from __future__ import annotations

import math

from contiga.jit import kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.hierarchy.kernels.tree_nb import next_leaves


@kernel()
def box_distance(tree, points, rows, safe_distance, start, stop):
    """Write the distance of points[rows] to the nearest box of a leaf to safe_distance[rows].

    Zero inside a box; infinite for points that are not finite, and for a body without leaves.
    """
    nodes = stack_int64(128)
    bounds = scratch(128)
    has_leaves = tree.shape[0] > 1 or tree[0]["count"] > 0
    for i in range(start, stop):
        k = rows[i]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not math.isfinite(point[0] + point[1] + point[2]):
            safe_distance[k] = math.inf
            continue
        best = math.inf
        nodes[0] = 0
        bounds[0] = 0.0
        top = 1 if has_leaves else 0
        while top > 0:
            node, top = next_leaves(tree, point, best, nodes, bounds, top)
            if node >= 0:
                best = bounds[top]
        safe_distance[k] = math.sqrt(best)
