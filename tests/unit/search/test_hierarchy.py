"""Boxes of the hierarchy hold what they stand for."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import contiga as cg
from contiga.elements.kernels import element_nb
from contiga.search.kernels import curve_nb
from contiga.search.tables import tables_of


def holed_plate(waves=2):
    """A bumpy plate with a round hole about its middle, the outer border as p-curves too."""
    patch = cg.shapes.bumpy_plate(waves=waves)
    square = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(square)
    )
    hole = (cg.shapes.circle(radius=0.2, centre=[0.5, 0.5, 0]),)
    return cg.Body([patch], trims=[(outer, hole)])


def leaf_boxes(tables):
    low, high = np.empty((2, len(tables.leaves), 3))
    for node in tables.tree[tables.tree["count"] > 0]:
        own = slice(node["first"], node["first"] + node["count"])
        low[own], high[own] = node["low"], node["high"]
    return low, high


@pytest.mark.parametrize("patch", [cg.shapes.sphere(), cg.shapes.bumpy_plate(), cg.shapes.cone()])
def test_leaves_cover_their_elements_and_lie_in_their_boxes(patch):
    tables = tables_of(cg.Body([patch]))
    area = np.zeros(len(tables.elements.table))
    low, high = leaf_boxes(tables)
    h = np.empty((4, 6))
    rng = np.random.default_rng(0)
    for k, leaf in enumerate(tables.leaves):
        s0, s1, t0, t1 = leaf["box"]
        area[leaf["element"]] += (s1 - s0) * (t1 - t0)
        for s, t in rng.random((4, 2)):
            place = s0 + s * (s1 - s0), t0 + t * (t1 - t0)
            element_nb.evaluate(tables.elements, leaf["element"], *place, h)
            x = h[:3, 0] + tables.elements.table[leaf["element"]]["origin"]
            assert (low[k] <= x).all()
            assert (x <= high[k]).all()
    np.testing.assert_allclose(area, 1.0, atol=1e-12)


def test_inner_boxes_hold_their_children():
    tree = tables_of(cg.Body([cg.shapes.torus()])).tree
    for node in tree[tree["count"] == 0]:
        for child in tree[node["first"] : node["first"] + 2]:
            assert (node["low"] <= child["low"]).all()
            assert (child["high"] <= node["high"]).all()


def test_leaves_of_trimming_curves_cover_them_and_their_bounds_hold():
    tables = tables_of(holed_plate())
    low, high = leaf_boxes(tables)
    curves = np.flatnonzero(tables.leaves["element"] < 0)
    length = np.zeros(len(tables.trims.piece_degree))
    h, d = np.empty((4, 6)), np.empty((3, 3))
    for k in curves:
        leaf = tables.leaves[k]
        piece = -1 - leaf["element"]
        t0, t1 = leaf["box"][:2]
        length[piece] += t1 - t0
        for t in np.linspace(t0, t1, 7)[1:-1]:
            e = curve_nb.curve_point(tables.elements, tables.grid, tables.trims, piece, t, h, d)[0]
            x = d[0] + tables.elements.table[e]["origin"]
            assert (low[k] <= x).all()
            assert (x <= high[k]).all()
            assert np.linalg.norm(d[1]) <= leaf["bound"][0] * (1 + 1e-12)
            assert np.linalg.norm(d[2]) <= leaf["bound"][1] * (1 + 1e-12)
    np.testing.assert_allclose(length, 1.0, atol=1e-10)


def test_feet_on_a_trimmed_edge_against_dense_sampling():
    body = holed_plate(waves=3)
    angle = np.linspace(0, 2 * np.pi, 20001)
    ring = np.column_stack([0.5 + 0.2 * np.cos(angle), 0.5 + 0.2 * np.sin(angle)])
    border = body.patches[0].evaluate(ring)
    p = np.random.default_rng(0).uniform([-0.1, -0.1, -0.3], [0.1, 0.1, 0.3], (300, 3))
    feet = body.project(p)
    least = np.array([np.linalg.norm(border - x, axis=1).min() for x in p])
    distance = np.linalg.norm(feet.point - p, axis=1)
    assert (distance <= least + 1e-12).all()
    at_edge = feet.feature == 1
    assert at_edge.sum() > 100
    assert (least - distance < 1e-6)[at_edge].all()
    assert (np.hypot(*(feet.uv - 0.5).T) >= 0.2 - 1e-12).all()


@pytest.mark.interpreted
def test_tables_are_kept_as_long_as_the_body():
    body = cg.Body([cg.shapes.plane()])
    assert tables_of(body) is tables_of(body)
    assert len(tables_of(body).leaves) == 1
