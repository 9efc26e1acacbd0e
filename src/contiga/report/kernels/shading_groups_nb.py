"""Corners of facets that share a normal."""

from __future__ import annotations

import contiga.num.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.num.jit import kernel
from contiga.num.kernels.union_nb import root, unite


@kernel()
def joined(pairs, parent, group):
    """Number the sets that (k, 2) `pairs` join in the order of their first members: `group` (n,).

    `parent` (n,) is 0 … n − 1 to begin with. Returns how many sets there are. To import
    scipy.sparse.csgraph takes ten times as long as this with all around it.
    """
    for k in range(pairs.shape[0]):
        unite(parent, pairs[k, 0], pairs[k, 1])
    count = 0
    for i in range(parent.shape[0]):
        first = root(parent, i)
        if first == i:
            group[i] = count
            count += 1
        else:
            group[i] = group[first]
    return count
