"""Corners of facets that share a normal."""

from __future__ import annotations

import numpy as np

from contiga.arrays.kernels.union_nb import set_numbers, unite
from contiga.jit import kernel


@kernel()
def joined(pairs, n):
    """Return the set (n,) of each of 0 … n − 1 that `pairs` (k, 2) join, numbered by first members.

    The import of scipy.sparse.csgraph takes ten times as long as this with all around it.
    """
    parent = np.arange(n).astype(np.int32)
    for k in range(pairs.shape[0]):
        unite(parent, pairs[k, 0], pairs[k, 1])
    return set_numbers(parent)
