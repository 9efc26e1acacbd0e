"""An order of points along a space-filling curve, so that successive points are close."""

from __future__ import annotations

import math

import numpy as np

from contiga.jit import inner, kernel

BITS = 7
"""Number of bits of each coordinate: 128 cells along the longest side."""


@inner()
def _spread_bits(n):
    """Return the bits of n with two zeros between them."""
    n = (n | (n << 8)) & 0x0300F00F
    n = (n | (n << 4)) & 0x030C30C3
    return (n | (n << 2)) & 0x09249249


@kernel()
def along_space(points, rows, low, width):
    """Return `rows` in the order of the Morton codes of their points; equal codes keep their order.

    Cells divide a cube of edge `width` from the corner `low` on; points outside count to the cells
    at its border, points that are not finite to the first cell.
    """
    n = rows.shape[0]
    cells = (1 << BITS) - 1
    code = np.zeros(n, np.int32)
    scale = (cells + 1) / width
    for i in range(n):
        k = rows[i]
        total = 0
        if math.isfinite(points[k, 0] + points[k, 1] + points[k, 2]):
            for c in range(3):
                place = int(min(max((points[k, c] - low[c]) * scale, 0.0), float(cells)))
                total |= _spread_bits(place) << c
        code[i] = total
    # Two passes of a stable counting sort over the halves of the code.
    half = (3 * BITS + 1) // 2
    order = np.arange(n).astype(np.int32)
    buffer = np.empty(n, np.int32)
    for shift in (0, half):
        first = np.zeros((1 << half) + 1, np.int32)
        for i in range(n):
            first[((code[i] >> shift) & ((1 << half) - 1)) + 1] += 1
        for i in range(1 << half):
            first[i + 1] += first[i]
        for i in range(n):
            key = (code[order[i]] >> shift) & ((1 << half) - 1)
            buffer[first[key]] = order[i]
            first[key] += 1
        order, buffer = buffer, order
    for i in range(n):
        buffer[i] = rows[order[i]]
    return buffer
