"""Sets that are joined."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from contiga.arrays.kernels import union_nb

pytestmark = pytest.mark.interpreted


@njit
def sets(n, pairs):
    parent = np.arange(n)
    for k in range(len(pairs)):
        union_nb.unite(parent, pairs[k, 0], pairs[k, 1])
    return np.array([union_nb.root(parent, i) for i in range(n)])


@pytest.mark.parametrize("seed", range(5))
def test_sets_are_the_connected_components_each_told_by_its_first_member(seed):
    n = 60
    pairs = np.random.default_rng(seed).integers(0, n, (25 + 10 * seed, 2))
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    first = np.array([np.argmax(label == k) for k in range(count)])
    np.testing.assert_array_equal(sets(n, pairs), first[label])
