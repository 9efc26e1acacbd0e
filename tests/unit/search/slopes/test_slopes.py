"""Derivatives of depth and normal at feet, inside and outside, against differences of feet."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import box
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.records import FootSlopes

STEP = 1e-5


def slopes_of(master: object, points: np.ndarray, feet: cg.Projection) -> FootSlopes:
    out = FootSlopes(np.full((len(points), 3), np.nan), np.full((len(points), 3, 3), np.nan))
    master.surface.slopes(points, feet, out)
    return out


def differences(master: object, points: np.ndarray) -> FootSlopes:
    depth, normal = np.empty((len(points), 3)), np.empty((len(points), 3, 3))
    for j, way in enumerate(STEP * np.eye(3)):
        near, far = (
            (master.project(points + k * way), master.project(points - k * way)) for k in (1, 2)
        )
        depth[:, j] = -(8.0 * (near[0].gap - near[1].gap) - (far[0].gap - far[1].gap))
        normal[:, :, j] = 8.0 * (near[0].normal - near[1].normal) - (far[0].normal - far[1].normal)
    return FootSlopes(depth / (12.0 * STEP), normal / (12.0 * STEP))


def worst(master: object, points: np.ndarray, feature: cg.Feature) -> float:
    feet = master.project(points)
    rows = np.flatnonzero(feet.feature == feature)
    assert len(rows) > 0
    feet = cg.Projection(*(values[rows] for values in feet))
    found, wanted = slopes_of(master, points[rows], feet), differences(master, points[rows])
    turning = np.abs(wanted.normal).max(axis=(1, 2))
    turned = np.abs(found.normal - wanted.normal).max(axis=(1, 2)) / np.maximum(turning, 1.0)
    return max(float(np.abs(found.depth - wanted.depth).max()), float(turned.max()))


def beside_a_knot(master: cg.Body, feet: cg.Projection) -> np.ndarray:
    """Where derivatives of the surface jump, and differences miss; not on creases along knots."""
    beside = np.zeros(len(feet.patch), bool)
    for k, patch in enumerate(master.patches):
        for axis, knots in enumerate(patch.knots):
            inner = np.unique(knots)[1:-1]
            way = np.abs(feet.uv[:, axis, None] - inner).min(axis=1, initial=np.inf)
            beside |= (feet.patch == k) & (way > 0.0) & (way < 1e-3 * np.ptp(knots))
    return beside


SHAFT = cg.NurbsCurve(
    1,
    [0, 0, 1, 2, 3, 4, 5, 5],
    [[0, 0, 0], [2, 0, 0], [2, 0, 1], [1, 0, 1], [1, 0, 3], [0, 0, 3]],
)
MASTERS = {
    "torus": lambda: cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]),
    "egg": lambda: cg.Body([cg.shapes.ellipsoid(axes=(1.0, 2.0, 3.0))]),
    "waves": lambda: cg.Body([cg.shapes.bumpy_plate()]),
    "box": lambda: box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0)),
    "shaft": lambda: cg.Body([cg.shapes.revolved(SHAFT)]),
    "holed": holed_plate,
}


@pytest.mark.parametrize(
    ("name", "feature"),
    [
        ("torus", cg.Feature.FACE),
        ("egg", cg.Feature.FACE),
        ("waves", cg.Feature.FACE),
        ("box", cg.Feature.FACE),
        ("box", cg.Feature.EDGE),
        ("box", cg.Feature.VERTEX),
        ("shaft", cg.Feature.FACE),
        ("shaft", cg.Feature.EDGE),
        ("holed", cg.Feature.EDGE),
    ],
)
def test_against_differences_on_both_sides(name: str, feature: cg.Feature) -> None:
    master = MASTERS[name]()
    low, high = master.bounds()
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    rng = np.random.default_rng(1)
    points = middle + rng.uniform(-1.0, 1.0, (200, 3)) * (half + 0.15 * half.max())
    feet = master.project(points)
    # Off where feet change from piece to piece, and where the surface is centred.
    turning = slopes_of(master, points, feet).normal
    calm = (np.abs(turning).max(axis=(1, 2)) * half.max() < 60.0) & (np.abs(feet.gap) > 0.02)
    for way in 4.0 * STEP * np.vstack([np.eye(3), -np.eye(3)]):
        moved = master.project(points + way)
        calm &= (moved.feature == feet.feature) & (moved.patch == feet.patch)
        calm &= np.linalg.norm(moved.point - feet.point, axis=1) < 1e-2
    calm &= ~beside_a_knot(master, feet)
    assert worst(master, points[calm], feature) < 1e-7


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_at_a_pole_from_the_curvatures_of_three_ways(axis: int) -> None:
    """An egg of three half axes, whose poles are at the ends of z: 1/radius = c/a², c/b²."""
    axes = np.roll([1.0, 2.0, 3.0], axis)
    egg = cg.Body([cg.shapes.ellipsoid(axes=axes)])
    a, b, c = axes
    for depth in (-0.3, 0.2):
        points = np.array([[0.0, 0.0, c - depth], [0.0, 0.0, -c + depth]])
        feet = egg.project(points)
        if not np.allclose(np.abs(feet.point[:, 2]), c):  # another place is nearer
            continue
        found = slopes_of(egg, points, feet).normal
        bend = np.array([c / a**2, c / b**2])
        wanted = np.zeros((3, 3))
        wanted[[0, 1], [0, 1]] = bend / (1.0 - depth * bend)
        np.testing.assert_allclose(found, [wanted, wanted], rtol=0.0, atol=1e-12)


def test_each_row_alone_gives_the_same() -> None:
    body = MASTERS["holed"]()
    points = np.random.default_rng(2).uniform(-0.6, 0.6, (50, 3)) * [1.0, 1.0, 0.3]
    feet = body.project(points)
    whole = slopes_of(body, points, feet)
    for k in range(0, 50, 7):
        one = cg.Projection(*(values[k : k + 1] for values in feet))
        alone = slopes_of(body, points[k : k + 1], one)
        np.testing.assert_array_equal(alone.normal[0], whole.normal[k])
        np.testing.assert_array_equal(alone.depth[0], whole.depth[k])
