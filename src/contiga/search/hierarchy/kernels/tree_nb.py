"""A binary hierarchy of boxes, built by halving at the median of the longest axis."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.sort_nb import sort_by
from contiga.jit import inner, kernel

LEAF_SIZE = 2


@kernel()
def build(low, high):
    """Node arrays (low, high, first, count) and the order of the n boxes `low`, `high` (n, 3)."""
    n = low.shape[0]
    order = np.empty(n, np.int32)
    spare = np.empty(n, np.int32)
    middle = np.empty((n, 3))
    for i in range(n):
        order[i] = i
        for c in range(3):
            middle[i, c] = 0.5 * (low[i, c] + high[i, c])
    size = max(1, 2 * n)
    node_low = np.empty((size, 3))
    node_high = np.empty((size, 3))
    first = np.zeros(size, np.int32)
    count = np.zeros(size, np.int32)
    stack = np.empty((128, 3), np.int64)
    put(stack, 0, (0, 0, n))
    top = 1
    used = 1
    while top > 0:
        top -= 1
        node, start, stop = stack[top]
        axis = 0
        widest = -math.inf
        for c in range(3):
            least = math.inf
            most = -math.inf
            node_low[node, c] = math.inf
            node_high[node, c] = -math.inf
            for k in range(start, stop):
                i = order[k]
                node_low[node, c] = min(node_low[node, c], low[i, c])
                node_high[node, c] = max(node_high[node, c], high[i, c])
                least = min(least, middle[i, c])
                most = max(most, middle[i, c])
            if most - least > widest:
                axis = c
                widest = most - least
        if stop - start <= LEAF_SIZE:
            first[node] = start
            count[node] = stop - start
            continue
        sort_by(middle, axis, order[start:stop], spare[start:stop])
        half = (start + stop) // 2
        first[node] = used
        put(stack, top, (used, start, half))
        put(stack, top + 1, (used + 1, half, stop))
        used += 2
        top += 2
    return (
        node_low[:used].copy(),
        node_high[:used].copy(),
        first[:used].copy(),
        count[:used].copy(),
        order,
    )


@inner()
def box_distance2(tree, node, x, y, z):
    """Squared distance of (x, y, z) to a node's box, zero inside."""
    low = tree[node]["low"]
    high = tree[node]["high"]
    a = max(low[0] - x, x - high[0], 0.0)
    b = max(low[1] - y, y - high[1], 0.0)
    c = max(low[2] - z, z - high[2], 0.0)
    return a * a + b * b + c * c


@inner()
def open_node(tree, first, point, nodes, bounds, top):
    """Put the two children at `first` on the stack, the nearer one last."""
    x, y, z = point
    a = box_distance2(tree, first, x, y, z)
    b = box_distance2(tree, first + 1, x, y, z)
    near = 0 if a <= b else 1
    nodes[top] = first + 1 - near
    bounds[top] = b if near == 0 else a
    nodes[top + 1] = first + near
    bounds[top + 1] = a if near == 0 else b


@inner()
def next_leaves(tree, point, limit, nodes, bounds, top):
    """The next node of leaves on the stack that is no farther than the square `limit`, −1 for none,
    and how many nodes are left; bounds[left] is its squared distance."""
    while top > 0:
        top -= 1
        if bounds[top] > limit:
            continue
        node = nodes[top]
        if tree[node]["count"] > 0:
            return node, top
        open_node(tree, tree[node]["first"], point, nodes, bounds, top)
        top += 2
    return -1, 0
