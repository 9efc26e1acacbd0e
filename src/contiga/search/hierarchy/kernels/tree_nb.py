"""A binary hierarchy of boxes, each cut where the surface area heuristic says.

The area of a box is the chance that a query comes by; of the cuts at the borders of equal bins
along each axis that one is made after which the areas, times how many boxes are in them, are least
(Wald, On fast construction of SAH-based bounding volume hierarchies, 2007). Queries open half as
many nodes as if boxes were halved at their median.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.sort_nb import sort_by
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

LEAF_SIZE = 2
BINS = 16
ROWS = BINS + 1
"""The bins, and their sum from one end on."""
DEEP = 40
"""Levels below which boxes are halved at their median, so that no hierarchy is deeper than its
queries have room for."""
COUNT = 6
"""Column of a bin that says how many boxes are in it; before it are low and high of these."""


@inner()
def _clear(bins, k):
    for c in range(3):
        bins[k, c] = math.inf
        bins[k, 3 + c] = -math.inf
    bins[k, COUNT] = 0.0


@inner()
def _add(bins, k, other, j):
    """Let bin k hold what bin j of `other` holds, too."""
    for c in range(3):
        bins[k, c] = min(bins[k, c], other[j, c])
        bins[k, 3 + c] = max(bins[k, 3 + c], other[j, 3 + c])
    bins[k, COUNT] += other[j, COUNT]


@inner()
def _cost(bins, k):
    """Half the surface of the box of bin k, times how many boxes it holds."""
    x, y, z = bins[k, 3] - bins[k, 0], bins[k, 4] - bins[k, 1], bins[k, 5] - bins[k, 2]
    return (x * y + y * z + z * x) * bins[k, COUNT]


@inner()
def _bin_of(x, least, most):
    """The bin of a middle at x, of those at `least` … `most`."""
    return min(int((x - least) / (most - least) * BINS), BINS - 1)


@inner()
def _best_cut(boxes, middle, rows, axis, ends, bins):
    """The first bin behind the best cut along an axis, and its cost."""
    for k in range(ROWS):
        _clear(bins, k)
    for i in rows:
        _add(bins, _bin_of(middle[i, axis], ends[0], ends[1]), boxes, i)
    right = scratch(BINS)
    for k in range(BINS - 1, 0, -1):
        _add(bins, BINS, bins, k)
        right[k] = _cost(bins, BINS)
    _clear(bins, BINS)
    best, cut = math.inf, 0
    for k in range(1, BINS):
        _add(bins, BINS, bins, k - 1)
        cost = _cost(bins, BINS) + right[k]
        if cost < best:
            best, cut = cost, k
    return cut, best


@inner()
def _put_before(middle, rows, axis, ends, cut, spare):
    """Move the rows of bins before `cut` to the front, in their order; how many there are."""
    n = behind = 0
    for i in rows:
        if _bin_of(middle[i, axis], ends[0], ends[1]) < cut:
            rows[n] = i
            n += 1
        else:
            spare[behind] = i
            behind += 1
    for k in range(behind):
        rows[n + k] = spare[k]
    return n


@inner()
def _cut(boxes, middle, rows, level, spare, bins):
    """Put the rows of one child before those of the other; how many the first has."""
    best, wide, cut, cut_axis, axis = math.inf, 0.0, 0, 0, 0
    ends = (0.0, 0.0)
    for c in range(3):
        least = math.inf
        most = -math.inf
        for i in rows:
            least = min(least, middle[i, c])
            most = max(most, middle[i, c])
        if most - least > wide:
            axis = c
            wide = most - least
        if level < DEEP and most > least:
            at, cost = _best_cut(boxes, middle, rows, c, (least, most), bins)
            if cost < best:
                best, cut, cut_axis, ends = cost, at, c, (least, most)
    if cut > 0:
        return _put_before(middle, rows, cut_axis, ends, cut, spare)
    sort_by(middle, axis, rows, spare)
    return rows.size // 2


@kernel()
def build(low, high):
    """Node arrays (low, high, first, count) and the order of the n boxes `low`, `high` (n, 3)."""
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
    bins = scratch(ROWS, 7)
    stack = np.empty((128, 4), np.int64)
    put(stack, 0, (0, 0, n, 0))
    top = 1
    used = 1
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
        half = start + _cut(boxes, middle, rows, level, spare[start:stop], bins)
        first[node] = used
        put(stack, top, (used, start, half, level + 1))
        put(stack, top + 1, (used + 1, half, stop, level + 1))
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
