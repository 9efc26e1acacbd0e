"""Strips of splines: through their rows, and flat without changing their length."""

from __future__ import annotations

import numpy as np

from contiga.slaves.strip import Strip

STRIP = Strip(8, 2)


def rows() -> np.ndarray:
    """A quarter of a circle of radius 2, 1 wide."""
    angle = 0.5 * np.pi * STRIP.greville_u[:, None]
    arc = np.stack([2 * np.cos(angle), 0 * angle, 2 * np.sin(angle)], axis=2)
    return arc + (STRIP.greville_v[:, None] - 0.5) * np.array([0.0, 1.0, 0.0])


def test_the_patch_goes_through_its_rows() -> None:
    u, v = np.meshgrid(STRIP.greville_u, STRIP.greville_v, indexing="ij")
    points = STRIP.through(rows()).evaluate(np.stack([u.ravel(), v.ravel()], axis=1))
    np.testing.assert_allclose(points.reshape(rows().shape), rows(), atol=1e-12)


def test_the_flat_patch_is_as_long_as_the_laid_one() -> None:
    flat = STRIP.flat(rows(), 1.0, 0.9).reshape(rows().shape)
    assert not flat[..., 2].any()
    np.testing.assert_allclose(flat[-1, :, 0] - flat[0, :, 0], 0.9 * np.pi, rtol=1e-4)
    np.testing.assert_allclose(flat[:, -1, 1] - flat[:, 0, 1], 1.0, rtol=1e-12)
