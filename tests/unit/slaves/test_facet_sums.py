"""From points of facets to their corners and back: sums, and their transpose."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.slaves.kernels.facet_sums_nb import from_corners, to_corners

pytestmark = pytest.mark.interpreted
FIRST = 7


@pytest.mark.parametrize("corners", [3, 4])
def test_sums_at_corners_are_the_transpose_of_points(corners: int) -> None:
    rng = np.random.default_rng(1)
    nodal, shape = rng.standard_normal((FIRST, 3)), rng.dirichlet(np.ones(corners), 4)
    facets = rng.integers(0, FIRST, (5, corners)).astype(np.int32)
    rows = np.array([7, 8, 13, 14, 20, 26], np.int32)
    facet, k = np.divmod(rows - FIRST, 4)
    points = np.empty((len(rows), 3))
    from_corners(rows, FIRST, nodal, facets, shape, points)
    expected = np.einsum("qj,qja->qa", shape[k], nodal[facets[facet]])
    np.testing.assert_allclose(points, expected, rtol=1e-14, atol=1e-15)
    values, sums = rng.standard_normal((len(rows), 3)), np.ones((FIRST, 3))
    to_corners(rows, FIRST, values, facets, shape, sums)
    wanted = np.ones((FIRST, 3))
    np.add.at(wanted, facets[facet], shape[k][:, :, None] * values[:, None, :])
    np.testing.assert_allclose(sums, wanted, rtol=1e-14, atol=1e-15)
