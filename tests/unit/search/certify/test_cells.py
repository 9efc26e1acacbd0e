"""The cell about a foot: which sides of its element it reaches."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.search.certify.kernels import cells_nb


@njit
def touched(s, t, far_s, far_t):
    return cells_nb.touched(s, t, far_s, far_t)


@njit
def cell_about(s, t, far_s, far_t):
    return cells_nb.cell_about(s, t, far_s, far_t)


@pytest.mark.interpreted
def test_a_cell_says_which_side_it_reaches():
    assert touched(0.0, 0.0, 0.4, 0.4) == -1
    assert touched(-0.3, 0.0, 0.25, 0.4) == 0
    assert touched(0.3, 0.0, 0.25, 0.4) == 1
    assert touched(0.0, -0.3, 0.4, 0.25) == 2
    assert touched(0.0, 0.3, 0.4, 0.25) == 3
    assert touched(0.3, 0.3, 0.25, 0.25) == -2


@pytest.mark.interpreted
def test_a_cell_stays_in_its_element():
    assert cell_about(0.0, 0.1, 0.2, 0.2) == pytest.approx((-0.2, 0.2, -0.1, 0.3))
    assert cell_about(0.4, -0.45, 0.2, 0.2) == pytest.approx((0.2, 0.5, -0.5, -0.25))


def test_feet_that_cross_smooth_sides_are_certified():
    """A cylinder of many elements: cells go on from one to the next, so nothing ends there."""
    knots = np.linspace(0.0, 1.0, 9)[1:-1]
    body = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0).insert_knots(v=knots)])
    z = np.linspace(-1.8, 1.7, 60)
    a = np.column_stack([np.full(60, 0.9), np.full(60, 0.2), z])
    a -= [0.0, 0.0, a[:, 2].mean() - body.bounds()[:, 2].mean()]
    feet = body.project(a + np.array([0.0, 0.0, 0.1]), start=body.project(a), mode="track")
    assert feet.certified.all()
