"""Derivatives of depth and normal at feet on triangles, against differences of feet."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import box
from tests.unit.search.slopes.test_slopes import STEP, slopes_of, worst

import contiga as cg


@pytest.mark.parametrize("kind", ["facet", "vertex"])
@pytest.mark.parametrize("feature", [cg.Feature.FACE, cg.Feature.EDGE, cg.Feature.VERTEX])
def test_against_differences_on_both_sides(feature: cg.Feature, kind: str) -> None:
    coarse = box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0)).tessellate(0.1, size=0.8)
    mesh = cg.TriMesh(coarse.vertices, coarse.triangles, normals=kind)
    points = np.random.default_rng(1).uniform(-0.4, 1.4, (300, 3)) * [1.4, 1.0, 1.0]
    feet = mesh.project(points)
    calm = np.abs(feet.gap) > 0.02
    for way in 4.0 * STEP * np.vstack([np.eye(3), -np.eye(3)]):
        moved = mesh.project(points + way)
        calm &= (moved.feature == feet.feature) & (moved.patch == feet.patch)
    assert worst(mesh, points[calm], feature) < 1e-7


def test_beside_a_border_a_held_foot_keeps_the_normal_of_its_triangle() -> None:
    sheet = cg.TriMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    start = sheet.project([[0.9, 0.5, -0.1]])
    points = np.array([[1.2, 0.5, -0.1]])
    feet = sheet.project(points, start=start, mode="track")
    assert feet.feature.tolist() == [cg.Feature.EDGE]
    found = slopes_of(sheet, points, feet)
    np.testing.assert_array_equal(found.depth, [[0.0, 0.0, -1.0]])
    np.testing.assert_array_equal(found.normal, np.zeros((1, 3, 3)))
