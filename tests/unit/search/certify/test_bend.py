"""Bounds of curvatures, speeds and widths hold at every point of a cell, and tend to the truth."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import few
from tests.unit.search import plain
from tests.unit.search.plain import tracking_tables_of
from tests.unit.search.sheets import SHEETS, inside, truth

import contiga as cg
from contiga.search.certify.kernels.bend_nb import bend_bounds, bend_work


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
    tables, rng = tracking_tables_of(cg.Body([patch])), np.random.default_rng(3)
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


def uneven(rng):
    """A trough whose parameters run unevenly along it and across it, turned in its plane."""
    x = np.array([0.0, 0.5 + rng.uniform(-0.15, 0.15), 1.0])
    x, y = np.meshgrid(x, [0.0, 0.5 + rng.uniform(-0.15, 0.15), 1.0], indexing="ij")
    z = rng.normal() * np.array([0.1, -0.1, 0.1])[:, None] + 0.0 * y
    c, s = np.cos(0.5), np.sin(0.5)
    askew = rng.integers(0, 2)
    net = np.stack([x + askew * (c * y - x), y + askew * s * x, z], axis=-1)
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    return cg.NurbsSurface((2, 2), (knots, knots), net)


@pytest.mark.interpreted
@pytest.mark.parametrize("name", [*SHEETS, "uneven"])
def test_bounds_hold_in_cells_from_those_too_large_for_them(name):
    rng = np.random.default_rng(5)
    bend, work, told = np.empty(6), bend_work(), 0
    for _ in range(few(6, 2)):
        patch = uneven(rng) if name == "uneven" else SHEETS[name](rng)
        elements = plain.elements(cg.Body([patch]))
        for size in (1.0, 0.7, 0.5, 0.35, 0.2, 0.1):
            low = rng.uniform(-0.5, 0.5 - size, 2)
            cell = (low[0], low[0] + size, low[1], low[1] + size)
            if not bend_bounds(elements, 0, cell, bend, work):
                continue
            told += 1
            ends = np.linspace(0.0, 1.0, 9) * size + low[:, None] + 0.5
            uv = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 2)
            inner, outer, *speeds = truth(patch, uv)
            assert bend[0] >= inner.max() * (1 - 1e-9) - 1e-9
            assert bend[1] >= outer.max() * (1 - 1e-9) - 1e-9
            assert (bend[2:4] >= [v.max() * (1 - 1e-9) for v in speeds[:2]]).all()
            assert (bend[4:] <= [v.min() * (1 + 1e-9) for v in speeds[2:]]).all()
    assert told > few(5, 1)
