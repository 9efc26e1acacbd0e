"""Leaves of the hierarchy: boxes of elements with bounds, stretches of trimming pieces."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._bounds_nb import subdivide
from contiga.search._curve_nb import curve_point

OUT = 0
SAFETY = 2.0
"""Widening of a curve leaf: the sampled second difference bounds the bulge only to second order."""


@njit(cache=True)
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
            box[k] = boxes[i]
            bound[k] = bounds[i]
            low[k] = corners[i, :3] + elements.table[e]["origin"]
            high[k] = corners[i, 3:] + elements.table[e]["origin"]
            k += 1
    return element, box, bound, low, high


@njit(cache=True)
def curve_leaves(elements, grid, trims, stretches):
    """As `surface_leaves`, for the trimming pieces: element −1 − piece, box (t0, t1, 0, 0)."""
    n = trims.piece_degree.shape[0]
    element = np.empty(n * stretches, np.int32)
    box = np.zeros((n * stretches, 4))
    bound = np.zeros((n * stretches, 9))
    low = np.empty((n * stretches, 3))
    high = np.empty((n * stretches, 3))
    samples = 9
    x = np.empty((samples, 3))
    h = np.empty((4, 6))
    d = np.empty((3, 3))
    for k in range(n * stretches):
        piece = k // stretches
        t0 = (k % stretches) / stretches
        t1 = (k % stretches + 1) / stretches
        element[k] = -1 - piece
        box[k, 0] = t0
        box[k, 1] = t1
        for i in range(samples):
            e = curve_point(elements, grid, trims, piece, t0 + (t1 - t0) * i / (samples - 1), h, d)[0]
            for c in range(3):
                x[i, c] = d[0, c] + elements.table[e]["origin"][c]
        bend = 0.0
        for i in range(1, samples - 1):
            square = 0.0
            for c in range(3):
                square += (x[i - 1, c] - 2.0 * x[i, c] + x[i + 1, c]) ** 2
            bend = max(bend, square)
        bend = SAFETY * math.sqrt(bend)
        for c in range(3):
            low[k, c] = x[:, c].min() - bend
            high[k, c] = x[:, c].max() + bend
    return element, box, bound, low, high
