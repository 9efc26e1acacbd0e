"""What an element departs from its Taylor polynomial by, over a cell."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.search.kernels import rest_nb
from contiga.search.tables import tables_of

pytestmark = pytest.mark.interpreted


@njit
def rest_of(elements, e, cell, h, rest):
    return rest_nb.rest_of(elements, e, cell, h, rest)


def rough(seed):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, 4)], indexing="ij")
    net = np.stack([x, y, 0 * x], axis=-1) + 0.1 * rng.normal(size=(4, 4, 3))
    knots = np.repeat([0.0, 1.0], 4)
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.6, 1.6, (4, 4)))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [0.3, 0.05])
def test_the_rest_is_bounded_and_the_bound_is_no_waste(seed, size):
    patch = rough(seed)
    elements = tables_of(cg.Body([patch])).elements
    rng, h, rest = np.random.default_rng(seed), np.zeros((4, 6)), np.empty((2, 5))
    low = rng.uniform(-0.5, 0.5 - size, 2)
    cell = (low[0], low[0] + size, low[1], low[1] + size)
    assert rest_of(elements, 0, cell, h, rest)
    xy = rng.uniform(-1.0, 1.0, (500, 2))
    uv = low + 0.5 + 0.5 * size * (xy + 1.0)
    half = 0.5 * size
    D = patch.derivatives(uv, 2)
    x, y = xy.T[:, :, None]
    v = h[:3].T
    # the derivatives by x and y of what the polynomial of second order leaves
    left = [
        D[:, 1, 0] * half - (v[1] + x * v[3] + y * v[4]),
        D[:, 0, 1] * half - (v[2] + x * v[4] + y * v[5]),
        D[:, 2, 0] * half**2 - v[3],
        D[:, 1, 1] * half**2 - v[4],
        D[:, 0, 2] * half**2 - v[5],
    ]
    most = np.array([np.linalg.norm(d, axis=1).max() for d in left])
    assert (most <= rest[0] * (1.0 + 1e-9) + 1e-13).all()
    if size < 0.1:
        assert (rest[0] <= 6.0 * most).all()
