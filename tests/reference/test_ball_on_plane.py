"""A ball pressed onto a plane of points at its pole: by symmetry nothing pushes sideways."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

RADIUS, DEPTH = 50.0, 0.5


def plane_of_points() -> np.ndarray:
    """Rings about the axis from a hair to beyond the edge of contact, and the point on it."""
    radii = np.concatenate([10.0 ** np.arange(-12.0, 1.0), [2.0, 5.0, 8.0]])
    angles = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    rings = np.multiply.outer(
        radii, np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    )
    return np.concatenate([[[0.0, 0.0, 0.0]], rings.reshape(-1, 3)])


@pytest.mark.parametrize("foot", ["nearest", "tracked"])
@pytest.mark.parametrize("tilt", [0.0, 0.5 * np.pi])
def test_no_force_is_lateral(foot, tilt):
    """The lower pole of the ball, or a point of its equator, is where it touches."""
    ball = cg.shapes.sphere(radius=RADIUS).rotated([1.0, 0.0, 0.0], tilt)
    body = cg.Body([ball.translated([0.0, 0.0, RADIUS])])
    points = plane_of_points()
    contact = cg.Contact(
        body, cg.Slave(points, area=np.ones(len(points))), law=cg.PenaltyLaw(2.0), foot=foot
    )
    state = contact.start(points - [0.0, 0.0, 1.0])
    for depth in (-0.2, 0.3 * DEPTH, 0.7 * DEPTH, DEPTH):
        state = contact.step(state, points + np.array([0.0, 0.0, depth]), dt=1.0)
    way = points + np.array([0.0, 0.0, DEPTH - RADIUS])
    distance = np.linalg.norm(way, axis=1)
    force = np.maximum(2.0 * (RADIUS - distance), 0.0)[:, None] * way / distance[:, None]
    np.testing.assert_allclose(state.force, force, atol=5e-12)
    total = state.force.sum(axis=0)
    assert np.abs(total[:2]).max() <= 1e-12 * abs(total[2])
    at_pole = state.force[0]
    assert np.abs(at_pole[:2]).max() <= 1e-12 * abs(at_pole[2])
