"""Feet continued by walking over adjoining triangles."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import Feature, Status, TriMesh

SHEET = TriMesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]])


@pytest.fixture(scope="module")
def torus() -> TriMesh:
    return cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.02)


def test_tracked_feet_of_small_steps_are_the_closest_ones_on_a_convex_mesh():
    ball = cg.shapes.ellipsoid(axes=(1.0, 0.8, 0.6)).tessellate(0.01)
    rng = np.random.default_rng(9)
    points = rng.normal(size=(500, 3))
    points *= rng.uniform(1.0, 1.6, (500, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    feet = ball.project(points)
    for k in range(20):
        points = points + 0.05 * np.cross([0.2, 0.5, 1.0], points)
        feet = ball.project(points, start=feet, mode="track")
        expected = ball.project(points)
        np.testing.assert_allclose(feet.gap, expected.gap, rtol=0, atol=1e-14, err_msg=str(k))


def test_tracked_feet_stay_on_their_branch_of_a_folded_sheet():
    # Two leaves 0.1 apart, joined by a fold far away: the closest leaf changes, the branch not.
    net = [[0, 0, 0], [1, 0, 0], [2, 0, 0.05], [1, 0, 0.1], [0, 0, 0.1]]
    fold = cg.NurbsCurve(2, [0, 0, 0, 0.5, 0.5, 1, 1, 1], net)
    sheet = cg.shapes.extruded(fold, [0, 1, 0]).tessellate(1e-3)
    start = np.stack([np.linspace(0.1, 0.6, 40), np.full(40, 0.5), np.full(40, 0.01)], axis=1)
    branch = sheet.project(start)
    whole = []
    for steps in (4, 64):
        feet = branch
        for k in range(1, steps + 1):
            moved = start + np.array([0.0, 0.0, 0.075 * k / steps])
            feet = sheet.project(moved, start=feet, mode="track")
        whole.append(feet)
        assert (feet.point[:, 2] < 0.06).all()
    assert (sheet.project(moved).point[:, 2] > 0.08).all()
    np.testing.assert_allclose(whole[0].gap, whole[1].gap, rtol=0, atol=1e-14)


def test_a_tracked_foot_past_a_border_keeps_its_triangles_normal():
    feet = SHEET.project([[1.0, 1.0, -0.2]])
    past = SHEET.project([[2.3, 1.0, -0.2]], start=feet, mode="track")
    assert past.status[0] == Status.BORDER
    assert past.feature[0] == Feature.EDGE
    np.testing.assert_array_equal(past.normal, [[0, 0, 1]])
    assert past.gap[0] == -0.2
    np.testing.assert_array_equal(past.point, [[2.0, 1.0, 0.0]])
    # The closest point's normal runs along the distance.
    whole = SHEET.project([[2.3, 1.0, -0.4]])
    assert whole.status[0] == Status.BORDER
    np.testing.assert_allclose(whole.gap, [-0.5], rtol=0, atol=1e-15)


def test_rows_without_a_foot_are_found_anew_and_bad_rows_marked(torus):
    points = np.random.default_rng(10).normal(size=(50, 3))
    feet = torus.project(points)
    points[3] = np.nan
    points[4, 1] = np.inf
    bad = torus.project(points)
    assert bad.status[3] == bad.status[4] == Status.NOT_FINITE
    assert bad.patch[3] == -1
    assert np.isnan(bad.gap[3])
    again = torus.project(np.nan_to_num(points, posinf=1.0), start=bad, mode="track")
    assert (again.status == Status.OK).all()
    assert torus.project(points, start=feet, mode="track").status[3] == Status.NOT_FINITE
