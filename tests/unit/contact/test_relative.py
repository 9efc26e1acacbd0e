"""How fast points move against a body that flies and turns."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.contact.kernels import relative_nb
from contiga.rigid import pose as poses

RNG = np.random.default_rng(3)
N = 50
POSE = poses.translation([3.0, -2.0, 0.5]) @ poses.rotation("y", 0.7) @ poses.rotation("x", -1.1)
TWIST = np.array([[1.0, -2.0, 0.3], [0.4, 5.0, -0.6]])


@pytest.mark.interpreted
def test_it_is_the_change_of_the_place_in_the_axes_of_the_body() -> None:
    p, v = RNG.normal(size=(2, N, 3))
    out = np.full((N, 3), 7.0)
    relative_nb.relative(v, p, POSE, TWIST, out, 2, N - 3)
    assert (out[:2] == 7.0).all()
    assert (out[N - 3 :] == 7.0).all()
    # d/dt Rᵀ(p − t), by central differences of a body that turns about its own origin.
    rates = []
    for h in (-1e-6, 1e-6):
        X = np.eye(4)
        X[:3, :3] = turned(TWIST[1], h) @ POSE[:3, :3]
        X[:3, 3] = POSE[:3, 3] + h * TWIST[0]
        rates.append((p + h * v - X[:3, 3]) @ X[:3, :3])
    expected = (rates[1] - rates[0]) / 2e-6
    np.testing.assert_allclose(out[2 : N - 3], expected[2 : N - 3], rtol=0, atol=1e-8)


def turned(spin: np.ndarray, time: float) -> np.ndarray:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(spin)) * time
    x, y, z = spin / np.linalg.norm(spin)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)


@pytest.mark.interpreted
def test_the_first_point_with_a_place_and_no_velocity_is_told() -> None:
    points, velocity = np.zeros((6, 3)), np.zeros((5, 3))  # quadrature points follow the nodes
    assert relative_nb.first_without_velocity(velocity, points) == -1
    points[1], velocity[1] = np.nan, np.nan
    assert relative_nb.first_without_velocity(velocity, points) == -1
    velocity[3, 2], velocity[4, 0] = np.inf, np.nan
    assert relative_nb.first_without_velocity(velocity, points) == 3
