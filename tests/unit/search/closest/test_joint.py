"""How well two faces meet along their common edge."""

from __future__ import annotations

import numpy as np
from tests.unit.search.folds import trimmed_fold

import contiga as cg
from contiga.search.tables import tables_of


def test_joints_tell_how_far_the_surface_turns_and_how_wide_their_edge_is():
    for turn in (0.0, 1e-3, 1.0):
        body = trimmed_fold(turn, 6e-6)
        joint = tables_of(body).joints.edges[0]
        np.testing.assert_allclose(joint["turn"], 1.02 * turn, atol=1e-12)
        assert sorted(joint["patch"].tolist()) == [0, 1]
        assert 6e-6 <= joint["width"] <= 7e-6


def test_a_border_is_no_joint():
    body = trimmed_fold(1.0)
    body = cg.Body(body.patches, trims=body.trims, edges=[])
    assert len(tables_of(body).joints.edges) == 0
