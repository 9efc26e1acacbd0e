"""The closest point of one triangle, in every region."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from tests.sample import few

import contiga as cg
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.kernels import facet_nb

pytestmark = pytest.mark.interpreted


@njit
def closest_on(shape, p):
    return facet_nb.closest_on(shape, 0, p[0], p[1], p[2])


def brute(corners, p):
    """Least squared distance over a fine grid of the triangle."""
    n = 200
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    keep = i + j <= n
    u, v = i[keep] / n, j[keep] / n
    a, b, c = corners
    grid = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return ((grid - p) ** 2).sum(axis=1).min()


@pytest.mark.parametrize("seed", range(few(3, 1)))
def test_the_closest_point_is_that_of_a_fine_grid_and_its_place_is_told(seed):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(3, 3))
    shape = tables_of(cg.TriMesh(corners, [[0, 1, 2]])).facets.shape
    own = [shape[0, 0:3], shape[0, 12:15], shape[0, 15:18]]
    places = set()
    for p in rng.normal(size=(150, 3)) * 2.0:
        square, place, x, _ = closest_on(shape, p)
        places.add(place)
        least = brute(corners, p)
        assert math.sqrt(square) == pytest.approx(math.sqrt(least), abs=0.02)
        assert square <= least + 1e-12
        if place >= 4:
            assert square == pytest.approx(((own[place - 4] - p) ** 2).sum(), rel=1e-12)
        elif place >= 1:
            a, b = own[place - 1], own[place % 3]
            assert square == pytest.approx(((a + x * (b - a) - p) ** 2).sum(), rel=1e-9)
    assert places == set(range(7))
