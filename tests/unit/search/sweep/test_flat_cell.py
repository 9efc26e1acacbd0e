"""A path over the tangent plane of a cell, and where it passes over a rectangle."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.search.sweep.kernels import flat_cell_nb

pytestmark = pytest.mark.interpreted


@njit
def over_plane(h, r, d):
    return flat_cell_nb.over_plane(h, r, d)


@njit
def passage(box, line, pad):
    return flat_cell_nb._passage(box, line, pad)


def test_a_path_over_a_plane_in_its_own_parameters():
    rng = np.random.default_rng(0)
    for a, b, r, d in rng.normal(size=(30, 4, 3)):
        h = np.zeros((4, 6))
        h[:3, 1], h[:3, 2] = a, b
        found, line, most = over_plane(h, tuple(r), tuple(d))
        assert found
        ab = np.stack([a, b], axis=1)
        np.testing.assert_allclose(line[:2], np.linalg.lstsq(ab, r)[0], atol=1e-9)
        np.testing.assert_allclose(line[2:], np.linalg.lstsq(ab, d)[0], atol=1e-9)
        # the rows of the pseudo-inverse: how far a displacement of length one gets
        np.testing.assert_allclose(most, np.linalg.norm(np.linalg.pinv(ab), axis=1), rtol=1e-9)


def test_two_parallel_tangents_span_no_plane():
    h = np.zeros((4, 6))
    h[:3, 1], h[:3, 2] = [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]
    assert not over_plane(h, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0))[0]


def test_a_line_passes_over_a_rectangle_between_its_sides():
    box, none = (-0.5, 0.5, -0.5, 0.5), (0.0, 0.0)
    assert passage(box, (-1.0, 0.0, 1.0, 0.0), none) == (0.5, 1.5)
    assert passage(box, (-1.0, 0.0, 1.0, 0.0), (0.1, 0.0)) == pytest.approx((0.4, 1.6))
    low, high = passage(box, (-1.0, 0.7, 1.0, 0.0), none)
    assert low > high
    low, high = passage(box, (-1.0, -2.5, 1.0, 1.0), none)
    assert low > high
