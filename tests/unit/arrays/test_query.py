"""What all searches share: the way between two points, and what of it is rounding."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.arrays.kernels import query_nb

pytestmark = pytest.mark.interpreted


@njit
def direction(p, q):
    return query_nb.direction(p, q)


@njit
def slack_of(p, q, size):
    return query_nb.slack_of(p, q, size)


@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_a_way_has_its_length_and_direction_at_any_scale(scale):
    length, way = direction(np.zeros(3), scale * np.array([2.0, -3.0, 6.0]))
    assert length == pytest.approx(7.0 * scale, rel=1e-15)
    np.testing.assert_allclose(way, np.array([2.0, -3.0, 6.0]) / 7.0, rtol=1e-15)


def test_a_way_that_leads_nowhere_has_no_direction():
    assert direction(np.ones(3), np.ones(3)) == (0.0, (0.0, 0.0, 0.0))
    length, way = direction(np.zeros(3), np.array([np.inf, 0.0, 0.0]))
    assert length == np.inf
    assert way == (0.0, 0.0, 0.0)


def test_rounding_grows_with_the_largest_coordinate_and_the_size_of_the_body():
    near = slack_of(np.zeros(3), np.ones(3), 1.0)
    assert np.finfo(float).eps < near < 1e-12
    assert slack_of(np.zeros(3), np.array([1.0, -1e6, 0.0]), 1.0) > 1e5 * near
    assert slack_of(np.zeros(3), np.ones(3), 1e6) > 1e5 * near


@njit
def begin_path(out, p, q, size):
    return query_nb.begin_path(out, 0, p, q, size)


def test_a_path_that_is_not_finite_has_no_length_and_says_so():
    out = cg.Body([cg.shapes.plane()]).first_hit([[0.0, 0.0, 1.0]], [[0.0, 0.0, -1.0]])
    for k in range(3):
        for bad in (np.nan, np.inf):
            a, b = np.zeros(3), np.ones(3)
            b[k] = bad
            for p, q in ((a, b), (b, a)):
                out.status[0] = cg.Status.OK
                assert begin_path(out, p, q, 1.0)[0] == 0.0
                assert out.status[0] == cg.Status.NOT_FINITE
    length, way, slack = begin_path(out, np.zeros(3), np.array([0.0, 3.0, 4.0]), 1.0)
    assert (length, way) == (5.0, (0.0, 0.6, 0.8))
    assert slack == slack_of(np.zeros(3), np.array([0.0, 3.0, 4.0]), 1.0)
    assert out.status[0] == cg.Status.NO_HIT
    assert np.isnan(out.fraction[0])
