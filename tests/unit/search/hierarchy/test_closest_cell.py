"""What one cell can hold: how near a plate is, and whether f is convex there."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.search.hierarchy.kernels import closest_cell_nb

pytestmark = pytest.mark.interpreted


@njit
def plate_distance(m):
    return closest_cell_nb.plate_distance(m)


@njit
def middle(h, local, hs, ht):
    return closest_cell_nb.middle(h, local, hs, ht)


def test_the_distance_to_a_plate_is_that_of_a_fine_grid():
    rng = np.random.default_rng(0)
    x = np.linspace(-1.0, 1.0, 201)
    grid = np.stack(np.meshgrid(x, x), -1).reshape(-1, 2)
    for r, a, b in rng.normal(size=(60, 3, 3)) * [[[2.0], [1.0], [1.0]]]:
        h = np.zeros((4, 6))
        h[:3, 1], h[:3, 2] = 2.0 * a, 4.0 * b
        # `local` is the point about the origin of the derivatives: r leads from it to the middle
        m = middle(h, tuple(-r), 0.5, 0.25)
        exact = np.linalg.norm(r + grid @ [a, b], axis=1).min()
        found = plate_distance(m)
        assert found <= exact + 1e-12
        assert found >= exact - 0.03


def test_products_are_those_of_the_cells_half_sides():
    h = np.random.default_rng(1).normal(size=(4, 6))
    m = middle(h, (0.1, 0.2, 0.3), 0.5, 0.25)
    r, a, b = h[:3, 0] - [0.1, 0.2, 0.3], 0.5 * h[:3, 1], 0.25 * h[:3, 2]
    np.testing.assert_allclose(
        [m.rr, m.rx, m.ry, m.xx, m.xy, m.yy], [r @ r, r @ a, r @ b, a @ a, a @ b, b @ b]
    )
