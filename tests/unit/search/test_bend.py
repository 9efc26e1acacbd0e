"""Bounds of curvatures, speeds and widths hold at every point of a cell, and tend to the truth."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.search.kernels.bend_nb import bend_bounds, bend_work
from contiga.search.tables import tables_of

from .sheets import inside, truth


def rough(seed, degrees):
    """A random rational sheet of one element over the unit square."""
    rng = np.random.default_rng(seed)
    knots = [np.repeat([0.0, 1.0], p + 1) for p in degrees]
    shape = [p + 1 for p in degrees]
    x, y = np.meshgrid(*[np.linspace(0, 1, n) for n in shape], indexing="ij")
    net = np.stack([x, y, 0 * x], axis=-1) + rng.normal(size=(*shape, 3)) * [0.04, 0.04, 0.1]
    return cg.NurbsSurface(degrees, knots, net, rng.uniform(0.6, 1.6, shape))


SURFACES = {
    "bicubic": rough(0, (3, 3)),
    "quintic": rough(1, (5, 2)),
    "seventh": rough(2, (7, 3)),
    "torus": cg.shapes.torus(),
    "cylinder": cg.shapes.cylinder(),
}


@pytest.mark.parametrize("name", SURFACES)
def test_bounds_hold_in_every_cell_and_become_tight(name):
    patch = SURFACES[name]
    tables, rng = tables_of(cg.Body([patch])), np.random.default_rng(3)
    bend, work = np.empty(6), bend_work()
    for size, most in ((0.3, np.inf), (0.05, np.inf), (0.005, 1.5)):
        for _ in range(20):
            e = int(rng.integers(len(tables.elements.table)))
            low = rng.uniform(-0.5, 0.5 - size, 2)
            cell = (low[0], low[0] + size, low[1], low[1] + size)
            good = bend_bounds(tables.elements, e, cell, bend, work)
            assert good or size > 0.01
            if not good:
                continue
            uv, span = inside(patch, tables, e, cell, rng)
            inner, outer, s, t, w_s, w_t = truth(patch, uv)
            assert bend[0] >= inner.max() - 1e-9
            assert bend[1] >= outer.max() - 1e-9
            assert bend[2] >= s.max() * span[0] * (1 - 1e-9)
            assert bend[3] >= t.max() * span[1] * (1 - 1e-9)
            assert bend[4] <= w_s.min() * span[0] * (1 + 1e-9)
            assert bend[5] <= w_t.min() * span[1] * (1 + 1e-9)
            assert max(bend[:2]) <= most * max(inner.max(), outer.max(), 0.1)
