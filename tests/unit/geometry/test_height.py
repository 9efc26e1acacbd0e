"""Planes of triangles, and what of the plane lies over them."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.geometry.kernels import height_nb

pytestmark = pytest.mark.interpreted


@njit
def plane_of(a, b, c):
    plane = np.empty(4)
    return height_nb.plane_of(a, b, c, plane), plane


@njit
def is_over(uv, u, v):
    return height_nb.is_over(uv, u, v)


@njit
def is_separated(box, uv):
    return height_nb.is_separated(box, uv)


UV = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def test_a_plane_goes_through_its_corners():
    for p in np.random.default_rng(0).normal(size=(20, 3, 3)):
        found, plane = plane_of(p[0], p[1], p[2])
        assert found
        np.testing.assert_allclose(p @ plane[:3], plane[3], atol=1e-12)
        assert np.linalg.norm(plane[:3]) == pytest.approx(1.0, rel=1e-14)
        assert plane[:3] @ np.cross(p[1] - p[0], p[2] - p[0]) > 0.0


def test_three_points_of_a_line_have_no_plane():
    assert not plane_of(np.zeros(3), np.ones(3), 2.0 * np.ones(3))[0]


def test_places_over_a_triangle_are_those_in_it():
    for u, v in np.random.default_rng(1).uniform(-0.5, 1.5, (200, 2)):
        assert is_over(UV, u, v) == (u >= 0.0 and v >= 0.0 and u + v <= 1.0)


def test_a_rectangle_beside_a_triangle_meets_it_nowhere():
    assert is_separated(np.array([0.6, 1.0, 0.6, 1.0]), UV)
    assert is_separated(np.array([-0.5, -0.1, 0.0, 1.0]), UV)
    assert not is_separated(np.array([0.4, 1.0, 0.4, 1.0]), UV)
