"""Point clouds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga import clouds, shapes
from contiga.errors import GeometryError, InputError


def test_ten_by_ten_points_of_a_torus():
    """Section 5.1.3 of the thesis."""
    points = clouds.sample(shapes.torus(), 10, 10)
    assert points.shape == (100, 3)
    np.testing.assert_allclose(
        np.hypot(np.hypot(points[:, 0], points[:, 1]) - 2.0, points[:, 2]), 0.5, rtol=0, atol=1e-14
    )
    np.testing.assert_array_equal(points[0], points[90])


def test_random_points_are_on_the_surface_and_uniform_in_area():
    """Archimedes: the height of uniform points on a sphere is uniform."""
    points = clouds.random_on(shapes.sphere(), 20_000, seed=3)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, rtol=0, atol=1e-14)
    for values in (
        (points[:, 2] + 1) / 2,
        np.arctan2(points[:, 1], points[:, 0]) / (2 * math.pi) % 1,
    ):
        ranks = np.sort(values)
        distance = np.abs(ranks - (np.arange(ranks.size) + 0.5) / ranks.size).max()
        assert distance < 1.63 / math.sqrt(ranks.size)  # Kolmogorov-Smirnov, 1 % level


def test_random_points_are_uniform_on_an_uneven_map():
    """A flat plate whose parameter runs as u²: uniform points must not crowd at u = 0."""
    plate = shapes.ruled(
        shapes.NurbsCurve(2, [0, 0, 0, 1, 1, 1], [[0, 0, 0], [0, 0, 0], [1, 0, 0]]),
        shapes.NurbsCurve(2, [0, 0, 0, 1, 1, 1], [[0, 1, 0], [0, 1, 0], [1, 1, 0]]),
    )
    x = np.sort(clouds.random_on(plate, 10_000, seed=1)[:, 0])
    assert np.abs(x - (np.arange(x.size) + 0.5) / x.size).max() < 0.0163


def test_same_seed_same_points():
    surface = shapes.bumpy_plate()
    first = clouds.random_on(surface, 50, seed=7)
    np.testing.assert_array_equal(first, clouds.random_on(surface, 50, seed=7))
    assert not np.array_equal(first, clouds.random_on(surface, 50, seed=8))
    assert clouds.random_on(surface, 0).shape == (0, 3)


def test_random_points_stay_in_their_box():
    points = clouds.random_in_box((-1, 0, 5), (1, 0, 7), 1000, seed=0)
    assert (points >= [-1, 0, 5]).all()
    assert (points <= [1, 0, 7]).all()
    np.testing.assert_allclose(points.mean(axis=0), [0, 0, 6], rtol=0, atol=0.06)


def test_wrong_requests_are_refused():
    with pytest.raises(InputError, match="nu: must be a whole number within limits; found 1"):
        clouds.sample(shapes.plane(), 1, 5)
    with pytest.raises(InputError, match="n: must be a whole number"):
        clouds.random_on(shapes.plane(), -1)
    for nu, nv, name in ((10**9, 5, "nu"), (3, 10**9, "nv"), (10**4, 10**5, "nv")):
        with pytest.raises(InputError, match=rf"^{name}: .*at most 50000000"):
            clouds.sample(shapes.plane(), nu, nv)
    with pytest.raises(InputError, match=r"^n: .*at most 50000000"):
        clouds.random_on(shapes.plane(), 10**9)
    with pytest.raises(InputError, match=r"^n: .*at most 50000000"):
        clouds.random_in_box((0, 0, 0), (1, 1, 1), 10**12)
    with pytest.raises(GeometryError, match="lower corner"):
        clouds.random_in_box((1, 0, 0), (0, 1, 1), 3)
    point = shapes.bilinear(*np.zeros((4, 3)))
    with pytest.raises(GeometryError, match="no area"):
        clouds.random_on(point, 3)
