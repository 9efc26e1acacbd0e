"""The closest point of a body, against dense samples of it."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg


def rough(seed, rows=6):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(-1, 1, rows)], indexing="ij")
    net = np.stack([x, y, 0.6 * rng.normal(size=(rows, rows))], axis=-1)
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, rows - 2), np.ones(3)])
    return cg.NurbsSurface((3, 3), (knots, knots), net, rng.uniform(0.5, 2.0, (rows, rows)))


@pytest.mark.parametrize("seed", range(4))
def test_no_sample_of_the_surface_is_closer(seed):
    patch = rough(seed)
    u = np.linspace(0.0, 1.0, 160)
    samples = patch.evaluate(np.stack(np.meshgrid(u, u), -1).reshape(-1, 2))
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (80, 3))
    feet = cg.Body([patch]).project(points)
    found = np.linalg.norm(points - feet.point, axis=1)
    nearest = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert (found <= nearest + 1e-12).all()
    assert (found >= nearest - 0.06).all()
    assert feet.certified[feet.feature == cg.Feature.FACE].all()
