"""The fast lane of tracking gives what the careful walk gives."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.search import _project_nb
from contiga.search.projection import bin_by_element, empty_projection
from contiga.search.tables import tables_of

PATCHES = {
    "polynomial": cg.shapes.bumpy_plate(),
    "rational": cg.shapes.torus(),
    "with poles": cg.shapes.sphere(),
}


def lanes_only(body, points, start):
    tables = tables_of(body)
    order, blocks = bin_by_element(tables, start.patch, start.uv)
    out, back = empty_projection(len(points)), np.zeros(len(points), np.uint8)
    _project_nb.project_lanes(
        tables, points, start.uv, (order, blocks), (out, back), 0, len(blocks)
    )
    return out, back == 0


def walk_only(body, points, start):
    tables, out = tables_of(body), empty_projection(len(points))
    rows = np.arange(len(points), dtype=np.int32)
    _project_nb.project_tracked(tables, points, (start.patch, start.uv), rows, out, 0, len(points))
    return out


@pytest.mark.parametrize("kind", PATCHES)
def test_lanes_and_walk_agree(kind):
    body = cg.Body([PATCHES[kind]])
    rng = np.random.default_rng(0)
    uv = rng.random((3000, 2))
    p = PATCHES[kind].evaluate(uv) + rng.uniform(-0.02, 0.02, (3000, 1)) * PATCHES[kind].normal(uv)
    start = body.project(p)
    q = p + 0.002 * rng.normal(size=p.shape)
    fast, done = lanes_only(body, q, start)
    slow = walk_only(body, q, start)
    assert done.mean() > 0.6
    for a, b in ((fast.point, slow.point), (fast.gap, slow.gap), (fast.normal, slow.normal)):
        np.testing.assert_allclose(a[done], b[done], atol=1e-11)
    np.testing.assert_array_equal(fast.feature[done], slow.feature[done])


def test_points_on_the_surface_are_done_in_the_fast_lane():
    body = cg.Body([PATCHES["rational"]])
    uv = np.random.default_rng(1).random((2000, 2))
    p = PATCHES["rational"].evaluate(uv)
    start = body.project(p)
    _, done = lanes_only(body, p, start)
    assert done.mean() > 0.95


@pytest.mark.interpreted
def test_the_order_of_the_bins_is_stable_and_complete():
    body = cg.Body([cg.shapes.bumpy_plate(waves=1)])
    n = 70
    uv = np.random.default_rng(2).random((n, 2))
    patch = np.zeros(n, np.int32)
    patch[[3, 50]] = -1
    order, blocks = bin_by_element(tables_of(body), patch, uv)
    np.testing.assert_array_equal(np.sort(order), np.setdiff1d(np.arange(n), [3, 50]))
    assert (np.diff(blocks[:, 0]) >= 0).all()
    for _, first, last in blocks:
        assert 0 < last - first <= 16
        assert (np.diff(order[first:last]) > 0).all()
