"""Connected components of points in contact."""

from __future__ import annotations

import numpy as np

from contiga.arrays.kernels.union_nb import set_numbers, unite
from contiga.jit import kernel


@kernel()
def facet_components(whole, corner, n_c):
    """Return the region numbers (n_c,) of the points in contact, which facets join to regions.

    Regions are numbered in order of appearance.

    Parameters
    ----------
    whole : (m, 3) corners of facets, all of them below n_c
    corner : (k, 3) corners of facets that touch in part: two from 0 to n_c − 1 are joined
    """
    parent = np.arange(n_c).astype(np.int32)  # half the memory traffic
    for f in range(whole.shape[0]):
        unite(parent, whole[f, 0], whole[f, 1])
        unite(parent, whole[f, 0], whole[f, 2])
    for f in range(corner.shape[0]):
        for k in range(3):
            a = corner[f, k]
            b = corner[f, (k + 1) % 3]
            if 0 <= a < n_c and 0 <= b < n_c:
                unite(parent, a, b)
    return set_numbers(parent)


@kernel()
def graph_components(first, neighbour, rows, place):
    """Return the region numbers (n_c,) of the points `rows` (n_c,) in a graph of n points.

    Regions are numbered in order of appearance. `place` is (n,), −1; filled with the index in
    `rows` of each of them.
    """
    for i in range(rows.shape[0]):
        place[rows[i]] = i
    parent = np.arange(rows.shape[0]).astype(np.int32)
    for i in range(rows.shape[0]):
        for j in range(first[rows[i]], first[rows[i] + 1]):
            k = place[neighbour[j]]
            if k >= 0:
                unite(parent, i, k)
    return set_numbers(parent)
