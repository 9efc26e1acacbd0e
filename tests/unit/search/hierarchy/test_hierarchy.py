"""Boxes of the hierarchy hold what they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.holed import leaf_boxes

import contiga as cg
from contiga.elements.kernels import element_nb
from contiga.search.hierarchy import build
from contiga.search.tables import tables_of


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


@pytest.mark.interpreted
def test_tables_are_kept_as_long_as_the_body():
    body = cg.Body([cg.shapes.plane()])
    assert tables_of(body) is tables_of(body)
    assert len(tables_of(body).leaves) == 1


def test_bodies_of_many_curved_faces_have_fewer_leaves_and_the_same_closest_points(monkeypatch):
    body = cg.Body([cg.shapes.torus()])
    p = body.patches[0].evaluate(np.random.default_rng(1).random((200, 2))) * 1.2
    feet, fine = body.project(p), len(tables_of(body).leaves)
    monkeypatch.setattr(build, "MAX_FLAT_LEAVES", fine - 1)
    coarse = cg.Body([cg.shapes.torus()])
    assert len(tables_of(coarse).leaves) < 0.5 * fine  # 1,168 of 3,856
    np.testing.assert_allclose(coarse.project(p).point, feet.point, atol=1e-10)
