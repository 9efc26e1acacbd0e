"""Rows of derivatives of feet."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.arrays.kernels import foot_slopes_nb
from contiga.records import FootSlopes

pytestmark = pytest.mark.interpreted
NONE = (0.0, 0.0, 0.0)


@njit
def along(r, normal, small):
    return foot_slopes_nb.is_along(r, normal, small)


@njit
def written(depth, a, x, b, y, out):
    foot_slopes_nb.write_slopes(1, depth, a, x, b, y, out)


@njit
def kinked(d, over, normal, gap, out):
    foot_slopes_nb.write_kink_slopes(1, d, over, normal, gap, out)


def empty() -> FootSlopes:
    return FootSlopes(np.full((3, 3), np.nan), np.full((3, 3, 3), np.nan))


def test_a_way_is_along_a_normal_or_has_no_direction() -> None:
    up = (0.0, 0.0, 1.0)
    assert along((0.0, 0.0, -2.0), up, 1e-9)
    assert not along((1e-3, 0.0, 2.0), up, 1e-9)
    assert along((1e-10, 0.0, 0.0), up, 1e-9)


def test_products_go_into_one_row() -> None:
    rng = np.random.default_rng(0)
    depth, a, x, b, y = map(tuple, rng.normal(size=(5, 3)))
    out = empty()
    written(depth, a, x, b, y, out)
    np.testing.assert_array_equal(out.depth[1], depth)
    np.testing.assert_allclose(out.normal[1], np.outer(a, x) + np.outer(b, y), rtol=1e-15)
    assert np.isnan(out.normal[[0, 2]]).all()


def test_a_normal_turns_about_a_vertex_in_all_directions_and_about_an_edge_across_it() -> None:
    out = empty()
    kinked(NONE, NONE, (0.0, 0.0, 1.0), -0.5, out)
    np.testing.assert_array_equal(out.normal[1], np.diag([-2.0, -2.0, 0.0]))
    np.testing.assert_array_equal(out.depth[1], [0.0, 0.0, -1.0])
    kinked((2.0, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5, out)
    np.testing.assert_array_equal(out.normal[1], np.diag([0.0, 2.0, 0.0]))
