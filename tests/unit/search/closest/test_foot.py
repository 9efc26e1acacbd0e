"""From a foot to its record, on faces, edges and corners of a box."""

from __future__ import annotations

import numpy as np

import contiga as cg


def box():
    return cg.Body([cg.shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3), *-np.eye(3))])


def test_feet_of_a_box_and_what_they_lie_on():
    p = np.random.default_rng(0).uniform(-1.5, 1.5, (400, 3))
    outside = (np.abs(p) > 0.5).any(axis=1)
    feet = box().project(p[outside])
    np.testing.assert_allclose(feet.point, np.clip(p[outside], -0.5, 0.5), atol=1e-9)
    beyond = (np.abs(p[outside]) > 0.5).sum(axis=1)
    kinds = np.array([cg.Feature.NONE, cg.Feature.FACE, cg.Feature.EDGE, cg.Feature.VERTEX])
    np.testing.assert_array_equal(feet.feature, kinds[beyond])
    away = p[outside] - feet.point
    np.testing.assert_allclose(feet.gap, np.linalg.norm(away, axis=1), atol=1e-9)
    np.testing.assert_allclose(feet.normal * feet.gap[:, None], away, atol=1e-8)


def test_a_tracked_foot_goes_on_in_the_next_face():
    body = box()
    start = body.project([[0.4, 0.1, 0.6]])
    corner = body.project([[0.6, 0.1, 0.6]], start=start, mode="track")
    assert corner.feature[0] == cg.Feature.EDGE
    foot = body.project([[0.6, 0.1, 0.2]], start=corner, mode="track")
    assert foot.feature[0] == cg.Feature.FACE
    np.testing.assert_allclose(foot.point, [[0.5, 0.1, 0.2]], atol=1e-12)
    np.testing.assert_allclose(foot.normal, [[1.0, 0.0, 0.0]], atol=1e-12)
