"""A hierarchy of boxes with eight children per node, built by halving at medians.

Ranges are halved along the longest axis of their centres, at multiples of eight, so that the nodes
over the triangles are full. The boxes of a node are stored side by side (structure of arrays): one
pass of eight lanes computes the distances to all of them.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel

WIDTH = 8
"""Number of children of a node."""
NO_CHILD = 2147483647
"""Child of a node that has fewer; its box is at infinity."""


@inner()
def _quickselect(values, order, start, stop, place):
    """Partly sort order[start:stop] by `values`: none larger before `place`, none smaller after."""
    low = start
    high = stop - 1
    while low < high:
        a = values[order[low]]
        b = values[order[(low + high) // 2]]
        c = values[order[high]]
        pivot = max(min(a, b), min(max(a, b), c))
        i = low
        j = high
        while i <= j:
            while values[order[i]] < pivot:
                i += 1
            while values[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if place <= j:
            high = j
        elif place >= i:
            low = i
        else:
            return


@inner()
def _median_split(middle, order, start, stop):
    """Partly sort order[start:stop] along its longest axis; return where the second half starts.

    The first half is rounded up to a multiple of `WIDTH`, if that leaves a second one.
    """
    widest = -1.0
    axis = 0
    for c in range(3):
        low = math.inf
        high = -math.inf
        for i in range(start, stop):
            value = middle[c, order[i]]
            low = min(low, value)
            high = max(high, value)
        if high - low > widest:
            widest = high - low
            axis = c
    count = stop - start
    half = (count // 2 + WIDTH - 1) // WIDTH * WIDTH
    if half >= count:
        half = count // 2
    _quickselect(middle[axis], order, start, stop, start + half)
    return start + half


@inner()
def _split_range(middle, order, start, stop, cuts):
    """Halve the longest part of a range until there are eight, or none has more than eight boxes.

    The first half is rounded up to a multiple of `WIDTH`. Partly sorts order[start:stop], writes
    the bounds of the parts to `cuts`, and returns the number of parts.
    """
    cuts[0] = start
    cuts[1] = stop
    n = 1
    while n < WIDTH:
        longest = 0
        for i in range(1, n):
            if cuts[i + 1] - cuts[i] > cuts[longest + 1] - cuts[longest]:
                longest = i
        if cuts[longest + 1] - cuts[longest] <= WIDTH:
            break
        middle_row = _median_split(middle, order, cuts[longest], cuts[longest + 1])
        for i in range(n, longest, -1):
            cuts[i + 1] = cuts[i]
        cuts[longest + 1] = middle_row
        n += 1
    return n


@kernel()
def build(low, high):
    """Return the nodes (box, child) over boxes `low`, `high` (3, n), and the order of the boxes.

    Node 0 is the root, and children follow their parents. Child −1 − i is the box order[i], `order`
    (n,); see `Facets` for the layout of `box` and `child`.
    """
    n = low.shape[1]
    order = np.empty(n, np.int32)
    middle = np.empty((3, n))
    for i in range(n):
        order[i] = i
        for c in range(3):
            middle[c, i] = 0.5 * (low[c, i] + high[c, i])
    max_nodes = max(1, n)
    start_of = np.empty(max_nodes, np.int64)
    stop_of = np.empty(max_nodes, np.int64)
    start_of[0] = 0
    stop_of[0] = n
    child = np.full((max_nodes, WIDTH), NO_CHILD, np.int32)
    cuts = np.empty(WIDTH + 1, np.int64)
    n_nodes = 1
    node = 0
    while node < n_nodes:
        start = start_of[node]
        stop = stop_of[node]
        if stop - start <= WIDTH:
            for i in range(start, stop):
                child[node, i - start] = -1 - i
        else:
            parts = _split_range(middle, order, start, stop, cuts)
            for i in range(parts):
                child[node, i] = n_nodes
                start_of[n_nodes] = cuts[i]
                stop_of[n_nodes] = cuts[i + 1]
                n_nodes += 1
        node += 1
    box = np.full((n_nodes, 6 * WIDTH), math.inf)
    for k in range(n_nodes - 1, -1, -1):
        for l in range(WIDTH):
            item = child[k, l]
            if item == NO_CHILD:
                continue
            for c in range(3):
                box_low = math.inf
                box_high = -math.inf
                if item < 0:
                    box_low = low[c, order[-1 - item]]
                    box_high = high[c, order[-1 - item]]
                else:
                    for j in range(WIDTH):
                        if child[item, j] != NO_CHILD:
                            box_low = min(box_low, box[item, c * WIDTH + j])
                            box_high = max(box_high, box[item, (3 + c) * WIDTH + j])
                box[k, c * WIDTH + l] = box_low
                box[k, (3 + c) * WIDTH + l] = box_high
    return box, child[:n_nodes].copy(), order


@inner()
def box_distances(box, node, x, y, z, out):
    """Write the squared distances of a point from the boxes of a node's children to out[WIDTH].

    Zero inside a box, infinite where there is no child.
    """
    for l in range(WIDTH):
        a = max(box[node, l] - x, x - box[node, 24 + l], 0.0)
        b = max(box[node, 8 + l] - y, y - box[node, 32 + l], 0.0)
        c = max(box[node, 16 + l] - z, z - box[node, 40 + l], 0.0)
        out[l] = a * a + b * b + c * c


@inner()
def insert_sorted(nodes, bounds, base, top, node, bound):
    """Insert a node into the stack from `base` on by its bound; return the new number of nodes.

    Bounds descend from `base` on, so that the nearest node is on top.
    """
    i = top
    while i > base and bounds[i - 1] < bound:
        bounds[i] = bounds[i - 1]
        nodes[i] = nodes[i - 1]
        i -= 1
    bounds[i] = bound
    nodes[i] = node
    return top + 1
