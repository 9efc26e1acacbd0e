"""Branches followed part by part, where one step is too long to be proved."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg


@pytest.mark.parametrize("angle", [0.2, 0.8, 1.5])
def test_long_steps_about_a_sphere_are_followed_to_their_feet(angle):
    body = cg.Body([cg.shapes.sphere()])
    way = np.random.default_rng(0).normal(size=(200, 3))
    a = 0.6 * way / np.linalg.norm(way, axis=1)[:, None]
    side = np.cross(a, [0.3, 0.5, 0.8])
    side *= 0.6 / np.linalg.norm(side, axis=1)[:, None]
    b = np.cos(angle) * a + np.sin(angle) * side
    feet = body.project(b, start=body.project(a), mode="track")
    np.testing.assert_allclose(feet.point, b / 0.6, atol=1e-9)
    # the straight way between them comes no nearer to the centre than 0.6 cos(angle/2)
    assert feet.certified.mean() > 0.9


def test_a_minimum_that_vanishes_on_the_way_is_an_event():
    """Past the centre of a cylinder's cross-section the near side is a maximum of its own."""
    body = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    z = body.bounds()[:, 2].mean()
    start = body.project([[0.5, 0.01, z]])
    feet = body.project([[-0.5, 0.01, z]], start=start, mode="track")
    assert feet.point[0, 0] < 0.0 or feet.status[0] == cg.Status.BRANCH_EVENT
    np.testing.assert_allclose(np.hypot(*feet.point[0, :2]), 1.0, atol=1e-9)
