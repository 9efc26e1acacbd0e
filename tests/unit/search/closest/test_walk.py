"""The local foot from a start that may be far away, over many elements."""

from __future__ import annotations

import numpy as np
import pytest

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
