"""Bounds of curvatures beside a side that is one point."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.plain import tracking_tables_of
from tests.unit.search.sheets import inside, truth

import contiga as cg
from contiga.search.certify.kernels.bend_nb import bend_work
from contiga.search.certify.kernels.pole_nb import pole_bounds, pole_side


def pointed(turn):
    """A bowl, its rim a random closed curve, whose side is a pole; the tip leans by `turn`."""
    rng = np.random.default_rng(5)
    rows = [np.zeros((4, 3))]
    for k, height in ((1, 0.0), (2, 0.2), (3, 0.5)):
        x = np.linspace(0.0, 1.0, 4)
        row = k * np.column_stack([np.cos(x), np.sin(x), 0 * x])
        row[:, 2] = height + 0.05 * (k - 1) * rng.normal(size=4) + turn * k * x
        rows.append(row)
    knots = np.repeat([0.0, 1.0], 4)
    net = np.stack(rows, axis=1)
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.8, 1.2, (4, 4)))


@pytest.mark.parametrize("way", ["low", "high", "first", "turned"])
def test_bounds_hold_beside_a_pole_whichever_side_it_is(way):
    patch = pointed(0.0)
    patch = {
        "low": patch,
        "high": patch.transposed().flipped().transposed(),
        "first": patch.transposed(),
        "turned": patch.flipped(),
    }[way]
    tables, rng = tracking_tables_of(cg.Body([patch])), np.random.default_rng(6)
    kind = tables.elements.table[0]["kind"]
    side = int(np.flatnonzero(kind == 3)[0])
    bend, work = np.empty(6), bend_work()
    for size in (0.05, 0.02):
        for along in (-0.5, 0.1, 0.3):
            near = (-0.5, size - 0.5) if side % 2 == 0 else (0.5 - size, 0.5)
            beside = (along, along + size)
            cell = (*near, *beside) if side < 2 else (*beside, *near)
            assert pole_side(tables.elements, 0, cell) == side
            assert pole_bounds(tables.elements, 0, cell, side, bend, work)
            uv, span = inside(patch, tables, 0, cell, rng)
            inner, outer, s, t, w_s, w_t = truth(patch, uv)
            assert bend[0] >= inner.max()
            assert bend[1] >= outer.max()
            assert bend[2] >= s.max() * span[0]
            assert bend[3] >= t.max() * span[1]
            width, truly = (bend[4], w_s) if side < 2 else (bend[5], w_t)
            assert 0.0 < width <= truly.min() * span[side // 2]


def test_the_tip_of_a_cone_has_no_bound():
    tables = tracking_tables_of(cg.Body([pointed(0.3)]))
    side = int(np.flatnonzero(tables.elements.table[0]["kind"] == 3)[0])
    cell = (0.0, 0.1, -0.5, -0.4)
    assert side == 2
    assert not pole_bounds(tables.elements, 0, cell, side, np.empty(6), bend_work())


def test_the_bound_at_the_pole_of_a_sphere_is_about_twice_its_curvature():
    tables = tracking_tables_of(cg.Body([cg.shapes.sphere(radius=2.0)]))
    bend = np.empty(6)
    cell = (0.0, 0.0625, -0.5, -0.4375)
    assert pole_bounds(tables.elements, 0, cell, 2, bend, bend_work())
    assert 0.5 <= max(bend[:2]) <= 1.1
