"""The local foot from a start that may be far away, over many elements."""

from __future__ import annotations

import numpy as np
import pytest
from tests import ellipsoids

import contiga as cg


def on_torus(p, major=3.0, minor=1.0):
    """The foot of a point outside the axis on a torus about z."""
    ring = p * [1.0, 1.0, 0.0]
    ring *= major / np.linalg.norm(ring, axis=1)[:, None]
    off = p - ring
    return ring + minor * off / np.linalg.norm(off, axis=1)[:, None]


@pytest.mark.parametrize("angle", [0.1, 1.0, 2.5])
def test_a_foot_walks_over_elements_to_the_foot_of_its_point(angle):
    body = cg.Body([cg.shapes.torus(major=3.0, minor=1.0)])
    rng = np.random.default_rng(0)
    a = on_torus(rng.normal(size=(100, 3)) * 3.0)
    a += 0.2 * (a - a * [1.0, 1.0, 0.0])
    c, s = np.cos(angle), np.sin(angle)
    b = a @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    feet = body.project(b, start=body.project(a), mode="track")
    assert (feet.status == cg.Status.OK).all()
    np.testing.assert_allclose(feet.point, on_torus(b), atol=1e-9)


def test_a_foot_ends_at_the_border_that_the_point_went_beyond():
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    start = body.project([[0.0, 0.3, 0.1]])
    foot = body.project([[5.0, 0.3, 0.1]], start=start, mode="track")
    assert foot.status[0] == cg.Status.BORDER
    np.testing.assert_allclose(foot.point, [[1.0, 0.3, 0.0]], atol=1e-12)


OFFSETS = (0.0, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3, 1e-2)
"""From the axis through the poles, in the size."""


def about_poles(axes, size):
    """Points near the axis of an ellipsoid at either pole, within it, on it and outside."""
    angle = np.linspace(0.0, 2.0 * np.pi, 13)[:-1] + 0.01 * (np.arange(12) % 3)
    off = np.multiply.outer(OFFSETS, np.column_stack([np.cos(angle), np.sin(angle)]))
    narrowest = min(axes[:2]) ** 2 / axes[2]  # radius of curvature at the pole
    heights = axes[2] + np.array([-0.5 * narrowest, -1e-3, 1e-8, 0.1, 10.0])
    shape = (2, len(heights), *off.shape[:2], 3)
    points = np.empty(shape)
    points[..., :2] = off
    points[0, ..., 2], points[1, ..., 2] = heights[:, None, None], -heights[:, None, None]
    return size * points.reshape(-1, 3)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e3])
@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (1.0, 1.0, 0.4), (1.0, 0.7, 0.8)])
def test_feet_beside_a_pole_are_as_exact_as_elsewhere(axes, size):
    axes = tuple(size * a for a in axes)
    body = cg.Body([ellipsoids.ellipsoid(axes)])
    points = about_poles([a / size for a in axes], size)
    point, normal = ellipsoids.feet(points, axes)
    rng = np.random.default_rng(0)
    way = size * 10.0 ** rng.uniform(-12.0, -1.5, len(points))
    before = points + way[:, None] * rng.normal(size=points.shape) * [1.0, 1.0, 0.0]
    for feet in (
        body.project(points),
        body.project(points, start=body.project(before), mode="track"),
    ):
        assert (feet.status == cg.Status.OK).all()
        # A miss of 1e-12 of the size is as far as twice that where points are half as deep as the
        # surface is curved.
        off = np.linalg.norm(feet.point - point, axis=1)
        assert off.max() <= 2.5e-12 * body.size
        turn = np.linalg.norm(feet.normal - normal, axis=1)
        assert turn.max() <= 2.5e-12 * body.size / (min(axes) ** 2 / max(axes))
        assert (
            np.abs(feet.gap) - np.linalg.norm(points - point, axis=1)
        ).max() <= 1e-14 * size * 12


def test_an_apex_stays_one():
    body = cg.Body([cg.shapes.cone()])
    tip = body.patches[0].control_points.reshape(-1, 3)
    tip = tip[np.argmax(tip[:, 2])]
    points = tip + np.array([[0.0, 0.0, 0.2], [1e-9, 0.0, 0.2], [0.02, -0.01, 0.2]])
    feet = body.project(points)
    assert (feet.feature == cg.Feature.VERTEX).all()
    np.testing.assert_allclose(feet.point, np.tile(tip, (3, 1)), atol=1e-12)
    way = points - tip
    np.testing.assert_allclose(feet.normal, way / np.linalg.norm(way, axis=1)[:, None], atol=1e-11)
