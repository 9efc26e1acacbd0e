"""The hierarchy over triangles: every box holds what is under it, each triangle is there once."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.kernels.boxes_nb import NO_CHILD, WIDTH
from contiga.triangles.kernels.facet_nb import TRIANGLE


@pytest.mark.parametrize("tol", [0.5, 0.05, 0.002])
def test_boxes_hold_their_children_and_each_triangle_once(tol):
    mesh = cg.shapes.torus(major=2.0, minor=0.5).tessellate(tol)
    facets = tables_of(mesh).facets
    seen = np.zeros(len(mesh.triangles), int)
    p = facets.shape[:, [0, 1, 2, *range(12, 18)]].reshape(-1, 3, 3)
    for node, children in enumerate(facets.child):
        box = facets.box[node].reshape(2, 3, WIDTH)
        for lane, child in enumerate(children):
            low, high = box[:, :, lane]
            if child == NO_CHILD:
                assert np.isinf(low).all()
            elif child < 0:
                seen[facets.link[-1 - child, TRIANGLE]] += 1
                assert (low <= p[-1 - child]).all()
                assert (high >= p[-1 - child]).all()
            else:
                inner = facets.box[child].reshape(2, 3, WIDTH)
                there = facets.child[child] != NO_CHILD
                np.testing.assert_array_equal(inner[0][:, there].min(axis=1), low)
                np.testing.assert_array_equal(inner[1][:, there].max(axis=1), high)
    assert (seen == 1).all()


def test_nodes_over_triangles_are_full():
    mesh = cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.002)
    child = tables_of(mesh).facets.child
    over = child[:, 0] < 0
    assert (child[over] != NO_CHILD).sum() > 0.95 * WIDTH * over.sum()


def test_reach_is_a_lower_bound_of_the_distance_and_not_far_from_it():
    mesh = cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.01)
    points = np.random.default_rng(0).normal(size=(500, 3)) * 3.0
    rows = np.arange(500, dtype=np.int32)[::2].copy()
    reach = np.full(500, -1.0)
    mesh.surface.safe_distance(points, rows, reach)
    assert (reach[1::2] == -1.0).all()
    distance = np.abs(mesh.project(points[rows]).gap)
    assert (reach[rows] <= distance * (1.0 + 1e-12)).all()
    assert (reach[rows] >= distance - 0.2).all()
