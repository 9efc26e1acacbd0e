"""Connected regions of a graph."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from contiga.area.kernels import components_nb

pytestmark = pytest.mark.interpreted


def test_regions_of_a_graph_are_its_connected_components():
    rng = np.random.default_rng(2)
    n = 60
    ends = rng.integers(0, n, (45, 2))
    graph = coo_matrix((np.ones(len(ends)), ends.T), (n, n)).tocsr()
    graph = graph + graph.T
    rows = np.flatnonzero(rng.random(n) < 0.8).astype(np.int32)
    place = np.full(n, -1, np.int32)
    label = components_nb.graph_components(
        graph.indptr.astype(np.int64), graph.indices.astype(np.int32), rows, place
    )
    count, other = connected_components(graph[rows][:, rows], directed=False)
    assert label.max() + 1 == count
    assert len({*zip(label.tolist(), other.tolist(), strict=True)}) == count
    # Numbered as they come.
    assert [label[k] for k in np.unique(label, return_index=True)[1]] == list(range(count))
    assert (np.diff(np.unique(label, return_index=True)[1]) > 0).all()
