"""The binary hierarchy of boxes."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import few

import contiga as cg
from contiga.search.hierarchy.build import tree_over
from contiga.search.hierarchy.kernels import tree_nb
from contiga.search.tables import tables_of


def test_inner_boxes_hold_their_children():
    tree = tables_of(cg.Body([cg.shapes.torus()])).tree
    for node in tree[tree["count"] == 0]:
        for child in tree[node["first"] : node["first"] + 2]:
            assert (node["low"] <= child["low"]).all()
            assert (child["high"] <= node["high"]).all()


def levels(tree):
    level = np.zeros(len(tree), int)
    for k in np.flatnonzero(tree["count"] == 0):
        level[tree["first"][k] : tree["first"][k] + 2] = level[k] + 1
    return level


def random_boxes(n):
    rng = np.random.default_rng(n)
    low = rng.random((n, 3))
    return low, low + 0.1 * rng.random((n, 3)) ** 4


SHRINKING = np.repeat(0.5 ** np.arange(few(900, 120))[:, None], 3, axis=1)


@pytest.mark.interpreted
@pytest.mark.parametrize(
    "boxes",
    [
        *(random_boxes(n) for n in (1, 2, 3, 7, 200)),
        (np.zeros((50, 3)), np.ones((50, 3))),
        (SHRINKING, SHRINKING),
        (1e-60 * random_boxes(60)[0], 1e-60 * random_boxes(60)[1]),
    ],
)
def test_each_box_is_in_one_leaf_which_holds_it(boxes):
    low, high = boxes
    tree, order = tree_over(low, high)
    assert sorted(order) == list(range(len(low)))
    ends = tree[tree["count"] > 0]
    ends = ends[np.argsort(ends["first"])]
    assert (ends["count"] <= tree_nb.LEAF_SIZE).all()
    assert (ends["first"] == np.concatenate([[0], np.cumsum(ends["count"])[:-1]])).all()
    of = np.repeat(np.arange(len(ends)), ends["count"])
    assert (ends["low"][of] <= low[order]).all()
    assert (high[order] <= ends["high"][of]).all()
    # Searches have room for 128 nodes that wait, one a level and one more.
    assert levels(tree).max() < 100


def opened(tree, points):
    """How many nodes hold each point, on average."""
    within = (tree["low"] <= points[:, None]) & (points[:, None] <= tree["high"])
    return within.all(axis=2).sum(axis=1).mean()


def test_boxes_of_two_kinds_are_told_apart():
    # Long thin boxes among small ones: halved at their medians, all nodes would be long.
    low, high = random_boxes(400)
    high[::20, 0] = low[::20, 0] + 1.0
    tree, _ = tree_over(low, high)
    points = np.random.default_rng(1).random((300, 3))
    held = (low <= points[:, None]) & (points[:, None] <= high)
    assert opened(tree, points) < 12.0 + 6.0 * held.all(axis=2).sum(axis=1).mean()
