"""How far the surface turns where two faces meet along their common edge."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.folds import trimmed_fold

import contiga as cg
from contiga.search.closest.trimmed_edges import edge_turns
from contiga.search.tables import tables_of


@pytest.mark.parametrize("turn", [0.0, 1e-3, 1.0])
def test_edges_tell_how_far_the_surface_turns(turn):
    body = trimmed_fold(turn, 6e-6)
    np.testing.assert_allclose(edge_turns(body, tables_of(body)), [1.02 * turn], atol=1e-12)


def test_a_border_is_no_edge():
    body = trimmed_fold(1.0)
    body = cg.Body(body.patches, trims=body.trims, edges=[])
    assert len(edge_turns(body, tables_of(body))) == 0
