"""Sides looked up in a grid, and the pieces of surface it is made of."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.search.sides.kernels import side_pieces_nb
from contiga.search.sides.kernels.side_pieces_nb import PieceLimits
from contiga.search.tables import tables_of


def test_sides_that_are_known_are_right_and_their_lengths_safe():
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (3000, 3))
    side, safe = body.surface.sides(points, np.arange(3000, dtype=np.int32))
    radius = np.linalg.norm(points, axis=1)
    known = side != 0
    assert known.mean() > 0.7
    np.testing.assert_array_equal(side[known], np.where(radius[known] > 1.0, 1, -1))
    assert (safe[known] <= np.abs(radius[known] - 1.0) + 1e-9).all()
    assert (safe[known] > 0.0).all()


def test_ways_that_are_clear_meet_no_surface():
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    a, b = np.random.default_rng(1).uniform(-1.5, 1.5, (2, 2000, 3))
    clear = body.surface.clear_paths(a, b, np.arange(2000, dtype=np.int32))
    share = np.clip(-(a * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0.0, 1.0)
    near = np.linalg.norm(a + share[:, None] * (b - a), axis=1)
    ends = np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1)
    meets = (near < 1.0) & (np.maximum(*ends) > 1.0)
    assert not (clear & meets).any()
    assert clear.sum() > 50


def test_pieces_cover_the_surface_and_hold_it():
    patch = cg.shapes.torus()
    tables = tables_of(cg.Body([patch]))
    n = len(tables.elements.table)
    limits = PieceLimits(0.5, 0.5, 0.1, 1e6)
    pieces, middles = side_pieces_nb.surface_pieces(
        tables.elements, tables.trims, np.zeros(3), np.full(n, 1e-9), limits
    )
    assert set(middles[:, 0].astype(int)) == set(range(n))
    low, high = pieces[:, 0:3], pieces[:, 3:6]
    assert (high - low).max() < 1.0
    for x in patch.evaluate(
        np.random.default_rng(2).random((200, 2)) * [u[1] for u in patch.domain]
    ):
        assert ((low <= x) & (x <= high)).all(axis=1).any()
