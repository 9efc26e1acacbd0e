"""Closest points of a curve against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import shapes
from contiga.geometry import curve_foot
from contiga.geometry.curve_foot import CurveFeet


def test_feet_on_a_circle():
    circle = shapes.circle(radius=2.0)
    points = np.random.default_rng(0).normal(size=(300, 3)) * [2.0, 2.0, 0.3]
    feet = CurveFeet(circle)
    t, distance = feet(points)
    ring = np.hypot(points[:, 0], points[:, 1])
    np.testing.assert_allclose(distance, np.hypot(ring - 2.0, points[:, 2]), rtol=0, atol=1e-12)
    reached = circle.evaluate(t)
    np.testing.assert_allclose(
        reached[:, :2], 2.0 * points[:, :2] / ring[:, None], rtol=0, atol=1e-7
    )
    low, high = circle.domain
    assert feet.period == high - low


@pytest.mark.parametrize("x", [-1.0, 0.25, 2.0])
def test_feet_on_a_line_end_at_its_ends(x):
    feet = CurveFeet(shapes.line([0, 0, 0], [1, 0, 0]))
    t, distance = feet(np.array([[x, 0.5, 0.0]]))
    beyond = max(0.0, -x, x - 1.0)
    assert distance[0] == pytest.approx(np.hypot(0.5, beyond), abs=1e-12)
    assert feet.period == 0.0
    assert t.shape == (1,)


@pytest.mark.parametrize("share", [1e-6, 1e-3, 0.4, 0.999, 1.0 - 1e-6])
def test_feet_beside_the_seam_of_a_closed_curve_are_on_their_side_of_it(share):
    # At the seam the first and the last sample are one place: either may be the nearest.
    circle = shapes.circle(radius=2.0)
    low, high = circle.domain
    t = np.array([low + share * (high - low)])
    found, distance = CurveFeet(circle)(circle.evaluate(t))
    assert distance[0] < 1e-12
    assert found[0] == pytest.approx(t[0], abs=1e-9)


def test_few_samples_are_looked_at_as_a_tree_would_find_them(monkeypatch):
    arc = shapes.arc(radius=2.0)
    points = np.random.default_rng(1).normal(size=(300, 3)) * 3.0
    feet = CurveFeet(arc)
    own = feet(points)
    monkeypatch.setattr(curve_foot, "MIN_PAIRS_FOR_TREE", 0)
    for found, by_tree in zip(own, feet(points), strict=True):
        np.testing.assert_array_equal(found, by_tree)
