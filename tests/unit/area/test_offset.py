"""Areas carried along the normal: offsets of surfaces whose curvatures are known."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area.offset import offset_ratio

RNG = np.random.default_rng(3)


def _directions(n: int) -> np.ndarray:
    d = RNG.normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("gap", [-0.6, -0.1, -1e-9, 0.0, 0.4])
@pytest.mark.parametrize("inward", [False, True])
def test_concentric_spheres(gap: float, inward: bool) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    ball = ball.flipped() if inward else ball
    side = -1.0 if inward else 1.0
    feet = ball.project((2.0 + side * gap) * _directions(40))
    np.testing.assert_allclose(feet.gap, gap, rtol=0, atol=1e-12)
    expected = ((2.0 + side * gap) / 2.0) ** 2
    np.testing.assert_allclose(offset_ratio(ball, feet), expected, rtol=1e-12)


@pytest.mark.parametrize("gap", [-0.9, -0.2, 0.7])
def test_parallel_cylinders(gap: float) -> None:
    tube = cg.Body([cg.shapes.cylinder(radius=1.5, height=4.0)])
    angle = RNG.uniform(0.0, 2.0 * np.pi, 40)
    r = 1.5 + gap
    points = np.stack([r * np.cos(angle), r * np.sin(angle), RNG.uniform(-1.5, 1.5, 40)], axis=1)
    ratio = offset_ratio(tube, tube.project(points))
    np.testing.assert_allclose(ratio, r / 1.5, rtol=1e-12)


def test_offset_torus() -> None:
    major, minor, gap = 3.0, 1.0, -0.25
    ring = cg.Body([cg.shapes.torus(major=major, minor=minor)])
    around, tube = RNG.uniform(0.0, 2.0 * np.pi, (2, 60))
    far = major + (minor + gap) * np.cos(tube)
    points = np.stack(
        [far * np.cos(around), far * np.sin(around), (minor + gap) * np.sin(tube)], axis=1
    )
    # Area elements (R + r cos θ) r of both tori.
    expected = (minor + gap) * far / (minor * (major + minor * np.cos(tube)))
    np.testing.assert_allclose(offset_ratio(ring, ring.project(points)), expected, rtol=1e-11)


def test_a_plane_keeps_areas() -> None:
    plane = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    feet = plane.project(RNG.uniform(-1.0, 1.0, (20, 3)))
    np.testing.assert_array_equal(offset_ratio(plane, feet), 1.0)


def test_feet_on_edges_and_poles_keep_areas() -> None:
    plane = cg.Body([cg.shapes.plane()])
    assert offset_ratio(plane, plane.project([[3.0, 0.0, -1.0]])).tolist() == [1.0]
    ball = cg.Body([cg.shapes.sphere()])
    ratio = offset_ratio(ball, ball.project([[0.0, 0.0, 0.5]]))
    assert ratio[0] in (pytest.approx(0.25), 1.0)


def test_beyond_the_focal_point_areas_are_kept() -> None:
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0)])
    feet = tube.project([[1.5, 0.0, 0.0]])
    # The point 1.2 inside that foot lies beyond the axis: its area element is turned over.
    feet = feet._replace(gap=np.array([-1.2]))
    assert offset_ratio(tube, feet).tolist() == [1.0]
