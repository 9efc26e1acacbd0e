"""Curves of straight pieces in kernels: n rows x, y and ∫y dx, one after the other in an array."""

from __future__ import annotations

from contiga.jit import inner


@inner(linked=False)
def piece_of(numbers, first, n, x):
    """The piece k of n points from `first` that holds x: x_k ≤ x < x_k+1, the last ones beyond."""
    low, high = 0, n - 1
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[first + middle] <= x:
            low = middle
        else:
            high = middle
    return low


@inner()
def on_piece(numbers, first, values, k, x):
    """Value on piece k at x, of values that begin at `values`, and the way to x from its start."""
    start = numbers[first + k]
    way = x - start
    a, b = numbers[values + k], numbers[values + k + 1]
    slope = (b - a) / (numbers[first + k + 1] - start)
    return a + slope * way, way


@inner()
def curve_at(numbers, first, n, x):
    """y and ∫₀ˣ y dx of a curve of n points that begins at `first`; its ends go straight on."""
    k = piece_of(numbers, first, n, x)
    y, way = on_piece(numbers, first, first + n, k, x)
    return y, numbers[first + 2 * n + k] + 0.5 * way * (numbers[first + n + k] + y)
