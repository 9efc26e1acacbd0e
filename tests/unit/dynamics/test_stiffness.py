"""The fastest vibration of a body on springs, against the eigenvalues of M⁻¹ K."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.dynamics.free import Free
from contiga.dynamics.kernels.stiffness_nb import fastest
from contiga.dynamics.rigid_bodies import fixed_of, row_of
from contiga.records import FloatArray

pytestmark = pytest.mark.interpreted

INERTIA = np.array([[1.0, 0.2, 0.1], [0.2, 2.0, 0.3], [0.1, 0.3, 2.5]])


def stiffness(
    points: FloatArray, normals: FloatArray, along: FloatArray, across: FloatArray
) -> FloatArray:
    """K of springs at points, about the origin."""
    K = np.zeros((6, 6))
    for p, n, k, t in zip(points, normals, along, across, strict=True):
        tensor = k * np.outer(n, n) + t * (np.eye(3) - np.outer(n, n))
        arm = np.array([[0, p[2], -p[1]], [-p[2], 0, p[0]], [p[1], -p[0], 0]])
        G = np.hstack([np.eye(3), arm])
        K += G.T @ tensor @ G
    return K


def test_it_is_the_largest_eigenvalue() -> None:
    rng = np.random.default_rng(5)
    for count in (1, 2, 9):
        points, normals = rng.normal(size=(count, 3)), rng.normal(size=(count, 3))
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        along, across = rng.uniform(1.0, 9.0, count), rng.uniform(0.0, 4.0, count)
        centre = np.array([0.3, -1.0, 0.2])
        motion = Free(3.0, inertia=INERTIA, centre=centre)
        one = fixed_of("body", motion)
        M = np.zeros((6, 6))
        M[:3, :3], M[3:, 3:] = 3.0 * np.eye(3), INERTIA
        K = stiffness(points - centre, normals, along, across)
        expected = np.linalg.eigvals(np.linalg.solve(M, K)).real.max()
        actual = fastest(points, normals, along, across, row_of(motion, one), one)
        assert actual == pytest.approx(expected, rel=1e-12)


def test_what_is_held_does_not_vibrate() -> None:
    motion = Free(2.0, hold=["x", "y", "rx", "ry", "rz"])
    one = fixed_of("body", motion)
    normals = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    args = np.array([[0.0, 5.0, 0.0], [7.0, 0.0, 0.0]]), normals, np.array([100.0, 8.0])
    assert fastest(*args, np.zeros(2), row_of(motion, one), one) == pytest.approx(4.0, rel=1e-14)
    assert fastest(*args, np.zeros(2), row_of(motion, one), one) > 0.0
