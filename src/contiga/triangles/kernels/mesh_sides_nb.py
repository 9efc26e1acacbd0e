"""Numbers of the sides of triangles, without sorting them."""

from __future__ import annotations

import numpy as np

from contiga.jit import kernel

HASH_FACTOR = np.uint64(0x9E3779B97F4A7C15)
"""Odd number next to 2⁶⁴ over the golden ratio: its multiples of neighbours are far apart."""


@kernel()
def side_numbers(triangles, n):
    """Return the number of each triangle's sides (m, 3), and the times (k,) that each side occurs.

    Side j runs from corner j to the next. `triangles` (m, 3) have vertices below `n`; sides between
    the same vertices are one side in either sense. Sides are numbered in order of appearance.
    """
    m = triangles.shape[0]
    bits = 4
    while (1 << bits) < 6 * m:
        bits += 1
    keys = np.full(1 << bits, -1, np.int64)
    number = np.empty(1 << bits, np.int64)
    times = np.zeros(3 * m, np.int64)
    numbers = np.empty((m, 3), np.int64)
    count = 0
    for i in range(m):
        for j in range(3):
            a = np.int64(triangles[i, j])
            b = np.int64(triangles[i, (j + 1) % 3])
            key = min(a, b) * n + max(a, b)
            # The slot of the key in an open hash table, or the free slot where it goes.
            k = np.int64((np.uint64(key) * HASH_FACTOR) >> np.uint64(64 - bits))
            while keys[k] >= 0 and keys[k] != key:
                k = (k + 1) & (keys.size - 1)
            if keys[k] < 0:
                keys[k] = key
                number[k] = count
                count += 1
            numbers[i, j] = number[k]
            times[number[k]] += 1
    return numbers, times[:count].copy()
