"""Bounds of derivatives and of distance hold, and are not far from the truth."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.elements.kernels import bounds_nb, element_nb
from contiga.search.tables import tables_of

ORDERS = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)]


def patch_of(seed, p, q, weights=2.0):
    rng = np.random.default_rng(seed)
    net = rng.normal(size=(p + 1, q + 1, 3))
    w = 10 ** rng.uniform(-weights / 2, weights / 2, (p + 1, q + 1))
    U, V = (np.repeat([0.0, 1.0], d + 1) for d in (p, q))
    return cg.NurbsSurface((p, q), (U, V), net, w)


@pytest.mark.parametrize(("p", "q"), [(1, 1), (3, 3), (2, 5), (7, 1)])
@pytest.mark.parametrize("cell", [(-0.5, 0.5, -0.5, 0.5), (-0.1, 0.05, 0.2, 0.5)])
def test_derivatives_stay_below_their_bounds(p, q, cell):
    patch = patch_of(p + 10 * q, p, q)
    tables = tables_of(cg.Body([patch]))
    bound = np.empty(9)
    assert not bounds_nb.is_beyond_limit(tables.elements, 0, cell, (0.0, 0.0, 0.0), 0.0, bound)
    rng = np.random.default_rng(0)
    s = rng.uniform(cell[0], cell[1], 400) + 0.5
    t = rng.uniform(cell[2], cell[3], 400) + 0.5
    D = patch.derivatives(np.column_stack([s, t]), order=3)
    for k, (a, b) in enumerate(ORDERS):
        largest = np.linalg.norm(D[:, a, b], axis=1).max()
        assert largest <= bound[k] * (1 + 1e-12) + 1e-9


@pytest.mark.parametrize(("p", "q"), [(1, 1), (3, 3), (4, 2)])
def test_a_cell_is_called_beyond_a_distance_only_when_it_is(p, q):
    patch = patch_of(p, p, q)
    tables = tables_of(cg.Body([patch]))
    origin = tables.elements.table[0]["origin"]
    bound = np.empty(9)
    uv = np.stack(np.meshgrid(*[np.linspace(0.4, 0.6, 60)] * 2), -1).reshape(-1, 2)
    surface = patch.evaluate(uv)
    proved = 0
    for point in np.random.default_rng(1).normal(size=(60, 3)) * 2:
        least = np.linalg.norm(surface - point, axis=1).min()
        local = tuple(point - origin)
        cell = (-0.1, 0.1, -0.1, 0.1)
        look = bounds_nb.is_beyond_limit
        assert not look(tables.elements, 0, cell, local, least * (1 + 1e-9), bound)
        proved += look(tables.elements, 0, cell, local, 0.9 * least, bound)
    assert proved > 40


def test_uneven_weights_are_evaluated_without_loss():
    patch = patch_of(3, 3, 3, weights=8.0)
    tables = tables_of(cg.Body([patch]))
    assert tables.elements.table[0]["form"] == 0
    h = np.empty((4, 6))
    for uv in np.random.default_rng(0).random((50, 2)):
        element_nb.evaluate(tables.elements, 0, *(uv - 0.5), h)
        expected = patch.evaluate([uv])[0] - tables.elements.table[0]["origin"]
        np.testing.assert_allclose(h[:3, 0], expected, rtol=0, atol=1e-13)
