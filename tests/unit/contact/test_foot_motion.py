"""The spin of a surface by the gradient of its displacement, and couples on that gradient."""

from __future__ import annotations

import numpy as np

from contiga.contact.foot_motion import cross, lever, spin

RNG = np.random.default_rng(0)


def test_a_surface_that_moves_rigidly_spins_as_it_turns() -> None:
    turn, normals = RNG.normal(size=(2, 5, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    along = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    gradients = np.cross(turn[:, :, None], along, axis=1)  # of ω × x, along the surface
    found = spin(gradients[..., None], normals[:, :, None], normals[:, :, None])
    np.testing.assert_allclose(found[..., 0], turn, rtol=0.0, atol=1e-14)


def test_a_couple_does_on_the_gradient_the_work_that_it_does_on_the_spin() -> None:
    gradients = RNG.normal(size=(5, 3, 3, 2))
    couple, a, b = RNG.normal(size=(3, 5, 3, 2))
    work = (lever(couple, a, b) * gradients).sum(axis=(1, 2))
    np.testing.assert_allclose(work, (couple * spin(gradients, a, b)).sum(axis=1), rtol=1e-12)


def test_cross_products_are_along_the_second_axis() -> None:
    a, b = RNG.normal(size=(2, 4, 3, 7))
    np.testing.assert_array_equal(cross(a, b)[1, :, 2], np.cross(a[1, :, 2], b[1, :, 2]))
