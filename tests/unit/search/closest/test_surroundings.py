"""Bounds of derivatives around elements hold the derivatives of the surface there."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.geometry.test_net import bent
from tests.unit.search.test_deformable import BODIES

from contiga.elements.kernels.element_nb import evaluate
from contiga.search.closest.surroundings import blocks_of, surroundings_of
from contiga.search.deformable import deformable_of


@pytest.mark.parametrize("name", BODIES)
def test_they_hold_the_derivatives_of_all_elements_around(name: str) -> None:
    body = BODIES[name]()
    deformable = deformable_of(body)
    tables = deformable.at(bent(body, 1, 0.02)).tables
    blocks = blocks_of(deformable.refit.table)
    around = surroundings_of(blocks, tables.leaves)
    table, h = tables.elements.table, np.zeros((4, 6))
    rng = np.random.default_rng(0)
    for e in rng.choice(len(table), min(len(table), 12), replace=False):
        wide = table["box"][e, 1::2] - table["box"][e, ::2]
        for other in np.unique(blocks.elements[e]):
            assert table["patch"][other] == table["patch"][e]
            scale = wide / (table["box"][other, 1::2] - table["box"][other, ::2])
            low, high = table["box"][other, ::2], table["box"][other, 1::2]
            ends = (np.stack([low, high]) - table["box"][e, ::2]) / wide - 0.5
            reach = around.reach[e].reshape(2, 2)
            assert (ends >= reach[:, 0] - 1e-9).all()
            assert (ends <= reach[:, 1] + 1e-9).all()
            for s, t in rng.uniform(-0.5, 0.5, (4, 2)):
                evaluate(tables.elements, int(other), s, t, h)
                sizes = np.linalg.norm(h[:3, 1:], axis=0)
                u, v = scale
                by = sizes * [u, v, u * u, u * v, v * v]
                assert (by <= around.bound[e, :5] * (1.0 + 1e-9)).all()


def test_nothing_is_known_beside_what_is_trimmed_away_and_across_kinks() -> None:
    body = BODIES["holed"]()
    deformable = deformable_of(body)
    tables = deformable.at(body.net.points).tables
    around = surroundings_of(blocks_of(deformable.refit.table), tables.leaves)
    gone = ~np.isin(np.arange(len(tables.elements.table)), tables.leaves["element"])
    assert np.isinf(around.bound[gone]).all()
    brick = deformable_of(BODIES["box"]())
    np.testing.assert_array_equal(blocks_of(brick.refit.table).reach, [[-0.5, 0.5, -0.5, 0.5]] * 6)
