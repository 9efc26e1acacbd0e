"""A lower bound of the distance, from the boxes of the leaves."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.search.closest.kernels import safe_distance_nb
from contiga.search.hierarchy.build import tree_over
from contiga.search.tables import tables_of


def test_the_bound_is_below_the_distance_and_not_far_below():
    body = cg.Body([cg.shapes.torus()])
    points = np.random.default_rng(0).uniform(-6.0, 6.0, (300, 3))
    points[5] = np.inf
    rows = np.arange(300, dtype=np.int32)
    bound = np.full(300, -1.0)
    body.surface.safe_distance(points, rows, bound)
    assert bound[5] == np.inf
    exact = np.abs(body.project(np.delete(points, 5, axis=0)).gap)
    found = np.delete(bound, 5)
    assert (found <= exact + 1e-12).all()
    far = exact > 1.0
    assert (found[far] > 0.7 * exact[far]).all()


def test_it_is_the_distance_to_the_nearest_box_of_a_leaf():
    tables = tables_of(cg.Body([cg.shapes.saddle()]))
    leaves = tables.tree[tables.tree["count"] > 0]
    points = np.random.default_rng(1).uniform(-3.0, 3.0, (50, 3))
    found = np.empty(50)
    rows = np.arange(50, dtype=np.int32)
    safe_distance_nb.box_distance(tables.tree, points, rows, found, 0, 50)
    away = np.maximum(leaves["low"] - points[:, None], points[:, None] - leaves["high"])
    expected = np.linalg.norm(np.maximum(away, 0.0), axis=2).min(axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_body_without_leaves_is_infinitely_far():
    tree, order = tree_over(np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(order) == 0
    found = np.zeros(2)
    rows = np.arange(2, dtype=np.int32)
    safe_distance_nb.box_distance(tree, np.zeros((2, 3)), rows, found, 0, 2)
    assert np.isinf(found).all()
