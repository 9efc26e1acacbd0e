"""Groups of things that pairs join, directly or not."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from contiga.records import IndexArray, IntArray


def groups_of(first: IndexArray, second: IndexArray, n: int) -> IntArray:
    """(n,) number of the group of each of n things, of which first[k] and second[k] are joined.

    Groups are numbered as the first of their things come.

    >>> groups_of(np.array([4, 1]), np.array([2, 4]), 5).tolist()
    [0, 1, 1, 2, 1]
    """
    graph = coo_array((np.ones(len(first), np.int8), (first, second)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1])
