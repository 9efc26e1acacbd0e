"""Sum in a fixed order: halves down to blocks, and eight strands in a block, as NumPy sums rows.

The error grows with the logarithm of their number (Higham, The accuracy of floating point
summation, 1993), and the bits are those of ``values.sum()``.
"""

from __future__ import annotations

import numpy as np

from contiga.jit import inner

BLOCK = 128
"""Largest number of terms that is not halved."""
STRANDS = 8
MAX_HALVINGS = 64


@inner(linked=False)
def _sum_block(values, first, n):
    """Sum n numbers from `first` on, no more than a block: in strands from eight on."""
    if n < STRANDS:
        total = 0.0
        for k in range(first, first + n):
            total += values[k]
        return total
    a, b, c, d = values[first], values[first + 1], values[first + 2], values[first + 3]
    e, f, g, h = values[first + 4], values[first + 5], values[first + 6], values[first + 7]
    whole = first + n - n % STRANDS
    for k in range(first + STRANDS, whole, STRANDS):
        a += values[k]
        b += values[k + 1]
        c += values[k + 2]
        d += values[k + 3]
        e += values[k + 4]
        f += values[k + 5]
        g += values[k + 6]
        h += values[k + 7]
    total = ((a + b) + (c + d)) + ((e + f) + (g + h))
    for k in range(whole, first + n):
        total += values[k]
    return total


@inner(linked=False)
def _sum_halves(values, n):
    """Sum n numbers, more than a block, by halves of whole strands, down to blocks."""
    first, count = np.zeros(MAX_HALVINGS, np.int64), np.zeros(MAX_HALVINGS, np.int64)
    left, is_summed = np.zeros(MAX_HALVINGS), np.zeros(MAX_HALVINGS, np.bool_)
    count[0], top, total = n, 0, 0.0
    while top >= 0:
        if count[top] <= BLOCK:
            total = _sum_block(values, first[top], count[top])
            top -= 1
            # This completes every sum that waited for its second half.
            while top >= 0 and is_summed[top]:
                total = left[top] + total
                top -= 1
            if top < 0:
                break
            left[top], is_summed[top] = total, True
        half = count[top] // 2
        half -= half % STRANDS
        second = is_summed[top]
        first[top + 1] = first[top] + (half if second else 0)
        count[top + 1] = count[top] - half if second else half
        top += 1
        is_summed[top] = False
    return total


@inner()
def sum_of(values, n):
    """Sum the first n of `values` (m,)."""
    return 0.0 + (_sum_block(values, 0, n) if n <= BLOCK else _sum_halves(values, n))
