"""Leaves over the elements: their parts in boxes, with bounds of the derivatives."""

from __future__ import annotations

import numpy as np

from contiga.arrays.codes import OUT
from contiga.arrays.kernels.rows_nb import doubled
from contiga.elements.kernels.bounds_nb import subdivide
from contiga.jit import kernel


@kernel()
def surface_leaves(elements, flatness, depth):
    """Element (n,), box (n, 4), bound (n, 9), low and high (n, 3) of all surface leaves."""
    table = elements.table
    most = 1 << depth
    boxes = np.empty((most + table.shape[0], 4))
    bounds = np.empty((most + table.shape[0], 9))
    corners = np.empty((most + table.shape[0], 6))
    end = np.empty(table.shape[0], np.int64)
    n = 0
    for e in range(table.shape[0]):
        if table[e]["trim"] != OUT:
            if n + most > boxes.shape[0]:
                boxes, bounds, corners = doubled(boxes), doubled(bounds), doubled(corners)
            n += subdivide(elements, e, flatness, depth, boxes[n:], bounds[n:], corners[n:])
        end[e] = n
    element = np.empty(n, np.int32)
    k = 0
    for e in range(table.shape[0]):
        while k < end[e]:
            element[k] = e
            for c in range(3):
                corners[k, c] += table[e]["origin"][c]
                corners[k, 3 + c] += table[e]["origin"][c]
            k += 1
    return element, boxes[:n], bounds[:n], corners[:n, :3], corners[:n, 3:]
