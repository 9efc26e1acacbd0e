"""Where a place beyond an element goes on: on a plane it is the same point."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.stress.tracking import slivers
from tests.unit.search import plain

import contiga as cg
from contiga.arrays.codes import CREASE, POLE
from contiga.elements.kernels import element_nb
from contiga.search.track.kernels import onward_nb

pytestmark = pytest.mark.interpreted


@njit
def next_element(tables, e, s, t):
    return onward_nb.next_element(tables, e, s, t)


@njit
def holder(tables, e, uv):
    """The element of the patch of e that holds (u, v)."""
    patch = tables.elements.table[e]["patch"]
    return element_nb.locate(tables.grid, patch, uv[0], uv[1])[0]


def patch_of(tables, e):
    return tables.elements.table[e]["patch"]


def at(body, patch, uv):
    return body.patches[patch].evaluate(np.array([uv]))[0]


def beyond(body, tables, e, s, t):
    """The point of a plane that (s, t) of an element is, inside of it or not."""
    table = tables.elements.table
    box, patch = table[e]["box"], table[e]["patch"]
    origin = at(body, patch, box[[0, 2]])
    along = at(body, patch, box[[1, 2]]) - origin, at(body, patch, box[[0, 3]]) - origin
    return origin + (s + 0.5) * along[0] + (t + 0.5) * along[1]


@pytest.fixture(scope="module")
def cut():
    """A plane cut into slivers, and its tables."""
    body = cg.Body(slivers(cg.shapes.plane()))
    return body, plain.joined(body)


def test_over_sides_slivers_and_corners_of_a_plane_it_is_the_same_point(cut):
    (body, tables), rng = cut, np.random.default_rng(1)
    gone = corners = 0
    for _ in range(few(1000, 100)):
        e = int(rng.integers(len(tables.elements.table)))
        s, t = rng.uniform(-0.98, 0.98, 2)
        point = beyond(body, tables, e, s, t)
        other, uv = next_element(tables, e, s, t)
        if other < 0 or max(abs(s), abs(t)) <= 0.5:
            continue
        gone += 1
        corners += int(min(abs(s), abs(t)) > 0.5)
        assert other == holder(tables, other, uv)
        np.testing.assert_allclose(at(body, patch_of(tables, other), uv), point, rtol=0, atol=1e-12)
    assert gone > few(300, 30)
    assert corners > few(80, 8)


def test_from_a_sliver_it_may_be_as_far_as_is_near_in_the_next(cut):
    body, tables = cut
    # 0.01 wide, and turned about: its t runs across it.
    narrow = int(np.flatnonzero(tables.elements.table["patch"] == 7 + 2)[0])
    other, uv = next_element(tables, narrow, 0.0, 4.0)
    where = beyond(body, tables, narrow, 0.0, 4.0)
    np.testing.assert_allclose(at(body, patch_of(tables, other), uv), where, rtol=0, atol=1e-12)
    assert next_element(tables, narrow, 0.0, 40.0)[0] == -1


def test_over_borders_creases_and_poles_and_to_no_number_it_does_not_go_on():
    plane = plain.joined(cg.Body([cg.shapes.plane()]))
    assert next_element(plane, 0, 0.6, 0.0)[0] == -1
    assert next_element(plane, 0, np.nan, 0.0)[0] == -1
    ball = plain.joined(cg.Body([cg.shapes.sphere()]))
    floor = cg.shapes.bilinear([0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0])
    wall = cg.shapes.bilinear([1, 0, 0], [1, 0, 1], [1, 1, 0], [1, 1, 1])
    fold = plain.joined(cg.Body([floor, wall]))
    for tables, kind in ((ball, POLE), (fold, CREASE)):
        e, side = np.argwhere(tables.elements.table["kind"] == kind)[0]
        place = ((-0.6, 0.0), (0.6, 0.0), (0.0, -0.6), (0.0, 0.6))[side]
        assert next_element(tables, int(e), *place)[0] == -1
