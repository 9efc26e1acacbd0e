"""Smooth blocks of cells: what lies in them is not cut for each other."""

from __future__ import annotations

import pytest
from numba import config

import contiga as cg
from contiga.search.balls.radii import balls_of

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="takes minutes")


def test_a_torus_needs_few_cells() -> None:
    """Where blocks were taken for smaller than they are, it had 31,760."""
    surface = cg.Body([cg.shapes.torus()]).surface
    assert len(balls_of(surface.tables).child) < 3000
