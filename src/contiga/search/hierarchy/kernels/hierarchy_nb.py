"""Leaves over the elements: their parts in boxes, with bounds of the derivatives."""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import OUT
from contiga.elements.kernels.bounds_nb import subdivide
from contiga.jit import kernel


@kernel()
def surface_leaves(elements, flatness, depth):
    """Element (n,), box (n, 4), bound (n, 9), low and high (n, 3) of all surface leaves."""
    most = 1 << depth
    boxes = np.empty((most, 4))
    bounds = np.empty((most, 9))
    corners = np.empty((most, 6))
    total = 0
    counts = np.zeros(elements.table.shape[0], np.int64)
    for e in range(elements.table.shape[0]):
        if elements.table[e]["trim"] != OUT:
            counts[e] = subdivide(elements, e, flatness, depth, boxes, bounds, corners)
            total += counts[e]
    element = np.empty(total, np.int32)
    box = np.empty((total, 4))
    bound = np.empty((total, 9))
    low = np.empty((total, 3))
    high = np.empty((total, 3))
    k = 0
    for e in range(elements.table.shape[0]):
        if elements.table[e]["trim"] == OUT:
            continue
        subdivide(elements, e, flatness, depth, boxes, bounds, corners)
        for i in range(counts[e]):
            element[k] = e
            for c in range(box.shape[1]):
                box[k, c] = boxes[i, c]
            for c in range(bound.shape[1]):
                bound[k, c] = bounds[i, c]
            for c in range(3):
                low[k, c] = corners[i, c] + elements.table[e]["origin"][c]
                high[k, c] = corners[i, 3 + c] + elements.table[e]["origin"][c]
            k += 1
    return element, box, bound, low, high
