"""A filter of two poles that runs forward and backward over a signal.

It has the transposed direct form II (Oppenheim and Schafer, Discrete-Time Signal Processing, 6.3.4)
and the order of sums of scipy.signal.lfilter: the same bits if its compiler fuses no products and
sums. The import of scipy.signal would take half a second.
"""

from __future__ import annotations

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import kernel


@kernel()
def forward_and_back(values, a, b):
    """Filter each column of (n, k) `values` in place, forward and back, by coefficients (3,) `a` of
    inputs and (2,) `b` of outputs; each pass starts settled on its first value."""
    a0, a1, a2 = a[0], a[1], a[2]
    b1, b2 = b[0], b[1]
    n, columns = values.shape
    for column in range(columns):
        for backward in range(2):
            # relative to the first value, a filter at rest is settled on it
            first = values[backward * (n - 1), column]
            z1 = z2 = 0.0
            for k in range(n):
                row = n - 1 - k if backward else k
                x = values[row, column] - first
                y = z1 + a0 * x
                z1 = z2 + a1 * x + b1 * y
                z2 = a2 * x + b2 * y
                values[row, column] = y + first
