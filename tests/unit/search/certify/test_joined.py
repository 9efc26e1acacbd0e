"""Whether one branch joins two feet, from the curvature between them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.search.certify.kernels import joined_nb


@njit
def least_bend(curvature, m):
    return joined_nb.least_bend(curvature, m)


@pytest.mark.interpreted
def test_f_bends_least_towards_the_larger_curvature():
    """Over a sphere of radius R, d inside: 1 − d/R; outside it bends all the more."""
    assert least_bend((0.5, -0.5), 1.0) == pytest.approx(0.5)
    assert least_bend((-0.5, 0.5), 1.0) == pytest.approx(1.5)
    assert least_bend((2.0, 0.0), -0.25) == pytest.approx(1.0)
    assert least_bend((0.0, 2.0), -0.25) == pytest.approx(0.5)


@pytest.mark.parametrize("depth", [0.1, 0.5, 0.9])
def test_feet_inside_a_sphere_are_joined_as_long_as_the_centre_is_far(depth):
    body = cg.Body([cg.shapes.sphere()])
    way = np.random.default_rng(0).normal(size=(200, 3))
    a = (1.0 - depth) * way / np.linalg.norm(way, axis=1)[:, None]
    b = a + 0.1 * (1.0 - depth) * np.roll(a, 1, axis=1)
    feet = body.project(b, start=body.project(a), mode="track")
    assert feet.certified.mean() > 0.95
    np.testing.assert_allclose(feet.point, b / np.linalg.norm(b, axis=1)[:, None], atol=1e-9)
