"""Sorting in kernels, and counting in sorted arrays: numba's functions take a second to compile."""

from __future__ import annotations

from contiga.jit import inner


@inner(linked=False)
def sort(values):
    """Sort numbers in ascending order in place (Shell 1959)."""
    n = values.size
    gap = n
    while gap > 1:
        gap = max(1, 4 * gap // 9)
        for i in range(gap, n):
            value = values[i]
            k = i
            while k >= gap and values[k - gap] > value:
                values[k] = values[k - gap]
                k -= gap
            values[k] = value


@inner(linked=False)
def sort_by(keys, column, rows, spare):
    """Sort rows in ascending order of keys[row, column] in place, stably; `spare` is as long as
    `rows`."""
    n = rows.size
    width = 1
    while width < n:
        for low in range(0, n, 2 * width):
            middle = min(low + width, n)
            high = min(middle + width, n)
            i = low
            j = middle
            for k in range(low, high):
                if j == high or (i < middle and keys[rows[i], column] <= keys[rows[j], column]):
                    spare[k] = rows[i]
                    i += 1
                else:
                    spare[k] = rows[j]
                    j += 1
        for k in range(n):
            rows[k] = spare[k]
        width *= 2


@inner()
def count_below(values, x):
    """Return how many of the ascending `values` are less than x."""
    low, high = 0, values.size
    while low < high:
        middle = (low + high) // 2
        if values[middle] < x:
            low = middle + 1
        else:
            high = middle
    return low


@inner()
def count_up_to(values, x):
    """Return how many of the ascending `values` are x or less."""
    low, high = 0, values.size
    while low < high:
        middle = (low + high) // 2
        if values[middle] <= x:
            low = middle + 1
        else:
            high = middle
    return low
