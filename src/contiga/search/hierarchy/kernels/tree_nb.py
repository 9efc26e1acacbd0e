"""A binary hierarchy of boxes, split by the surface area heuristic.

The area of a box is proportional to the probability that a query opens it; of the splits at the
borders of equal bins along each axis, the one with the smallest sum of area times number of boxes
is made (Wald, On fast construction of SAH-based bounding volume hierarchies, 2007). Queries open
half as many nodes as with splits at the median.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.sort_nb import sort_by
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

LEAF_SIZE = 2
N_BINS = 16
N_BIN_ROWS = N_BINS + 1
"""The bins, and their sum from one end."""
MAX_SAH_DEPTH = 40
"""Level below which boxes are split at their median, so that no hierarchy is deeper than the stacks
of its queries."""
COUNT = 6
"""Column of a bin with the number of its boxes; before it are their low and high corners."""


@inner()
def _clear(bins, k):
    for c in range(3):
        bins[k, c] = math.inf
        bins[k, 3 + c] = -math.inf
    bins[k, COUNT] = 0.0


@inner()
def _add(bins, k, other, j):
    """Add bin j of `other` to bin k."""
    for c in range(3):
        bins[k, c] = min(bins[k, c], other[j, c])
        bins[k, 3 + c] = max(bins[k, 3 + c], other[j, 3 + c])
    bins[k, COUNT] += other[j, COUNT]


@inner()
def _cost(bins, k):
    """Return half the surface of the box of bin k, times the number of its boxes."""
    x, y, z = bins[k, 3] - bins[k, 0], bins[k, 4] - bins[k, 1], bins[k, 5] - bins[k, 2]
    return (x * y + y * z + z * x) * bins[k, COUNT]


@inner()
def _bin_of(x, low, high):
    """Return the bin of a middle at x in the range `low` … `high`."""
    return min(int((x - low) / (high - low) * N_BINS), N_BINS - 1)


@inner()
def _best_cut(boxes, middle, rows, axis, ends, bins):
    """Return the first bin behind the best cut along an axis, and the sum of the parts' `_cost`.

    They are 0 and infinity if no cut has boxes on both sides. `ends` is the range of the middles,
    `bins` is work.
    """
    for k in range(N_BIN_ROWS):
        _clear(bins, k)
    for i in rows:
        _add(bins, _bin_of(middle[i, axis], ends[0], ends[1]), boxes, i)
    right = scratch(N_BINS)
    for k in range(N_BINS - 1, 0, -1):
        _add(bins, N_BINS, bins, k)
        right[k] = _cost(bins, N_BINS)
    _clear(bins, N_BINS)
    best, cut = math.inf, 0
    for k in range(1, N_BINS):
        _add(bins, N_BINS, bins, k - 1)
        cost = _cost(bins, N_BINS) + right[k]
        if cost < best:
            best, cut = cost, k
    return cut, best


@inner()
def _split(boxes, middle, rows, level, spare, bins):
    """Sort `rows` in place, those of the first child first; return the number of its rows.

    The cut is the one of least cost of all axes, and keeps the order of rows on both sides. From
    level `MAX_SAH_DEPTH` on, and for boxes with one middle, rows are sorted along the axis of the
    largest extent of the middles, and cut at the median. `spare` and `bins` are work.
    """
    best, extent, cut, cut_axis, axis = math.inf, 0.0, 0, 0, 0
    ends = (0.0, 0.0)
    for c in range(3):
        low = math.inf
        high = -math.inf
        for i in rows:
            low = min(low, middle[i, c])
            high = max(high, middle[i, c])
        if high - low > extent:
            axis = c
            extent = high - low
        if level < MAX_SAH_DEPTH and high > low:
            bin_cut, cost = _best_cut(boxes, middle, rows, c, (low, high), bins)
            if cost < best:
                best, cut, cut_axis, ends = cost, bin_cut, c, (low, high)
    if cut == 0:
        sort_by(middle, axis, rows, spare)
        return rows.size // 2
    n = n_behind = 0
    for i in rows:
        if _bin_of(middle[i, cut_axis], ends[0], ends[1]) < cut:
            rows[n] = i
            n += 1
        else:
            spare[n_behind] = i
            n_behind += 1
    for k in range(n_behind):
        rows[n + k] = spare[k]
    return n


@kernel()
def build(low, high):
    """Return node arrays (low, high, first, count) and the order of boxes `low`, `high` (n, 3).

    The root is row 0, the two children of an inner node follow one another. A node of leaves has at
    most `LEAF_SIZE` boxes, at `first` in the order; without boxes the root is empty.
    """
    n = low.shape[0]
    order = np.empty(n, np.int32)
    spare = np.empty(n, np.int32)
    middle = np.empty((n, 3))
    boxes = np.empty((n, 7))
    for i in range(n):
        order[i] = i
        boxes[i, COUNT] = 1.0
        for c in range(3):
            middle[i, c] = 0.5 * (low[i, c] + high[i, c])
            boxes[i, c] = low[i, c]
            boxes[i, 3 + c] = high[i, c]
    size = max(1, 2 * n)
    node_low = np.empty((size, 3))
    node_high = np.empty((size, 3))
    first = np.zeros(size, np.int32)
    count = np.zeros(size, np.int32)
    bins = scratch(N_BIN_ROWS, 7)
    stack = np.empty((128, 4), np.int64)
    put(stack, 0, (0, 0, n, 0))
    top = 1
    n_nodes = 1
    while top > 0:
        top -= 1
        node, start, stop, level = stack[top]
        for c in range(3):
            node_low[node, c] = math.inf
            node_high[node, c] = -math.inf
            for k in range(start, stop):
                node_low[node, c] = min(node_low[node, c], low[order[k], c])
                node_high[node, c] = max(node_high[node, c], high[order[k], c])
        if stop - start <= LEAF_SIZE:
            first[node] = start
            count[node] = stop - start
            continue
        rows = order[start:stop]
        half = start + _split(boxes, middle, rows, level, spare[start:stop], bins)
        first[node] = n_nodes
        put(stack, top, (n_nodes, start, half, level + 1))
        put(stack, top + 1, (n_nodes + 1, half, stop, level + 1))
        n_nodes += 2
        top += 2
    return (
        node_low[:n_nodes].copy(),
        node_high[:n_nodes].copy(),
        first[:n_nodes].copy(),
        count[:n_nodes].copy(),
        order,
    )


@inner()
def box_distance2(tree, node, x, y, z):
    """Return the squared distance from (x, y, z) to a node's box, zero inside."""
    low = tree[node]["low"]
    high = tree[node]["high"]
    a = max(low[0] - x, x - high[0], 0.0)
    b = max(low[1] - y, y - high[1], 0.0)
    c = max(low[2] - z, z - high[2], 0.0)
    return a * a + b * b + c * c


@inner()
def open_node(tree, first, point, nodes, bounds, top):
    """Put the two children at `first` on the stack `nodes` from row `top` on, the nearer one last.

    The squared distances of their boxes from `point` go to the same rows of `bounds`.
    """
    x, y, z = point
    a = box_distance2(tree, first, x, y, z)
    b = box_distance2(tree, first + 1, x, y, z)
    nearer = 0 if a <= b else 1
    nodes[top] = first + 1 - nearer
    bounds[top] = b if nearer == 0 else a
    nodes[top + 1] = first + nearer
    bounds[top + 1] = a if nearer == 0 else b


@inner()
def next_leaves(tree, point, limit, nodes, bounds, top):
    """Return the next leaf node within the squared distance `limit`, and the new size of the stack.

    −1 and 0 are returned if there is none. Inner nodes on the way are replaced by their children.
    bounds[size] is the squared distance of the node that is returned.
    """
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
