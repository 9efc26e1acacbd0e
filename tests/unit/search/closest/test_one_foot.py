"""One point's foot by Newton's method: that of the whole search, where it is in reach."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search import plain
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.records import empty_projection
from contiga.search.closest.closest_records import FootRecord
from contiga.search.closest.kernels import one_foot_nb
from contiga.search.tables import tables_of
from contiga.statuses import Feature, Status

pytestmark = pytest.mark.interpreted


@njit
def newton_foot(tables, e, start, point):
    return one_foot_nb.newton_foot(tables, e, start, point)


@njit
def may_continue(elements, e, s, t):
    return one_foot_nb.may_continue(elements, e, s, t)


@njit
def write_certified(out, k, patch, uv, record):
    one_foot_nb.write_certified(out, k, patch, uv, record)


def element_at(tables, u, v):
    box = tables.elements.table["box"]
    held = (box[:, 0] <= u) & (u <= box[:, 1]) & (box[:, 2] <= v) & (v <= box[:, 3])
    return int(np.flatnonzero(held)[0])


def test_feet_are_those_of_the_whole_search_in_the_element_and_in_the_next():
    plate = cg.shapes.bumpy_plate(waves=2)
    body = cg.Body([few(plate, plate.restricted((0.0, 0.25), (0.0, 0.25)))])
    tables = tables_of(body)
    rng, width = np.random.default_rng(1), few(1.0, 0.25)
    uv = width * rng.uniform(0.1, 0.9, (few(60, 15), 2))
    p = body.patches[0].evaluate(uv) + 0.01 * body.patches[0].normal(uv)
    feet, gone_on = body.project(p), 0
    for k, (u, v) in enumerate(uv + width**0.5 * rng.uniform(-0.05, 0.05, uv.shape)):
        e = element_at(tables, u, v)
        at, place, own, (point, normal, gap) = newton_foot(tables, e, (u, v), tuple(p[k]))
        if at < 0:
            continue
        gone_on += at != e
        box = tables.elements.table[at]["box"]
        assert max(abs(place[0]), abs(place[1])) <= 0.5
        np.testing.assert_allclose(own[0], box[0] + (place[0] + 0.5) * (box[1] - box[0]))
        np.testing.assert_allclose(own, feet.uv[k], rtol=0, atol=1e-11)
        np.testing.assert_allclose(point, feet.point[k], rtol=0, atol=1e-12)
        np.testing.assert_allclose(normal, feet.normal[k], rtol=0, atol=1e-11)
        np.testing.assert_allclose(gap, feet.gap[k], rtol=0, atol=1e-12)
    assert gone_on >= few(3, 1)


def test_there_is_none_past_a_border_nor_far_off_nor_in_what_is_trimmed_away():
    body = holed_plate(waves=1)
    tables = plain.joined(body)
    gone = np.flatnonzero(tables.elements.table["trim"] == 2)
    for point in ((0.5, 0.0, 50.0), (1.7, 0.0, 0.0)):
        assert newton_foot(tables, 0, (0.0, 0.0), point)[0] == -1
    for e in gone[:3]:
        u, _, v, _ = tables.elements.table[e]["box"]
        assert newton_foot(tables, int(e), (u, v), (0.0, 0.0, 0.0))[0] == -1


def test_what_leaves_its_element_is_gone_on_with_across_smooth_sides_of_its_patch_alone():
    tables = plain.joined(cg.Body([cg.shapes.bumpy_plate(waves=1)]))
    plate, inside = tables.elements, element_at(tables, 0.3, 0.3)
    assert may_continue(plate, inside, 0.7, -0.6)
    assert not may_continue(plate, inside, 1.2, 0.0)
    assert not may_continue(plate, inside, 0.0, np.nan)
    assert not may_continue(plate, 0, -0.7, 0.0)  # over the border
    torus = plain.joined(cg.Body([cg.shapes.torus()])).elements
    assert not may_continue(torus, 0, -0.7, 0.0)  # over the seam


def test_a_record_that_is_written_is_a_proved_foot():
    out = empty_projection(2)
    record = FootRecord((1.0, 2.0, 3.0), (0.0, 0.0, 1.0), -0.5)
    write_certified(out, 1, 3, (0.25, 0.5), record)
    assert (out.patch[1], out.gap[1], out.certified[1]) == (3, -0.5, 1)
    assert (out.feature[1], out.status[1]) == (Feature.FACE, Status.OK)
    np.testing.assert_array_equal(out.uv[1], [0.25, 0.5])
    np.testing.assert_array_equal(out.point[1], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(out.normal[1], [0.0, 0.0, 1.0])
