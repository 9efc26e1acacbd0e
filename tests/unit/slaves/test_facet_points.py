"""Points of facets by their shape functions, one at a time."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.slaves.kernels.facet_points_nb import points_of_facets


@pytest.mark.interpreted
@pytest.mark.parametrize("corners", [3, 4])
def test_rows_asked_for_are_written_and_no_others(corners: int) -> None:
    rng = np.random.default_rng(0)
    nodal, shape = rng.standard_normal((7, 3)), rng.dirichlet(np.ones(corners), 4)
    facets = rng.integers(0, 7, (5, corners)).astype(np.int32)
    out = np.full((20, 3), np.nan)
    points_of_facets(nodal, facets, shape, out, 1, 4)
    whole = np.einsum("kj,fja->fka", shape, nodal[facets]).reshape(-1, 3)
    np.testing.assert_allclose(out[4:16], whole[4:16], rtol=1e-14, atol=1e-15)
    assert np.isnan(out[:4]).all()
    assert np.isnan(out[16:]).all()
