"""Points, derivatives and normals, and normals as limits where a side is one point."""

from __future__ import annotations

import numpy as np

import contiga as cg


def test_derivatives_are_differences_of_the_surface():
    patch, h = cg.shapes.torus(), 1e-4
    for u, v in np.random.default_rng(0).uniform(0.1, 0.9, (20, 2)):
        D = patch.derivatives(np.array([[u, v]]), 2)[0]

        def at(du, dv, u=u, v=v):
            return patch.evaluate(np.array([[u + du * h, v + dv * h]]))[0]

        np.testing.assert_allclose(D[1, 0], (at(1, 0) - at(-1, 0)) / (2 * h), atol=1e-4)
        np.testing.assert_allclose(D[0, 1], (at(0, 1) - at(0, -1)) / (2 * h), atol=1e-4)
        mixed = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * h * h)
        np.testing.assert_allclose(D[1, 1], mixed, atol=2e-2)


def test_normals_at_the_poles_of_a_sphere_are_limits():
    patch = cg.shapes.sphere()
    (u0, u1), (v0, v1) = patch.domain
    corners = np.array([[u, v] for u in (u0, 0.3 * u0 + 0.7 * u1, u1) for v in (v0, v1)])
    np.testing.assert_allclose(patch.normal(corners), patch.evaluate(corners), atol=1e-8)


def test_a_surface_far_from_the_origin_loses_no_digits():
    near = cg.shapes.sphere(radius=1.0)
    far = near.transformed(
        np.array([[1, 0, 0, 2.0**40], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    )
    uv = np.random.default_rng(1).uniform(0.05, 0.95, (50, 2)) * [u[1] for u in near.domain]
    np.testing.assert_allclose(
        far.derivatives(uv, 1)[:, 1, 0], near.derivatives(uv, 1)[:, 1, 0], atol=2e-3
    )
    np.testing.assert_allclose(far.evaluate(uv)[:, 1:], near.evaluate(uv)[:, 1:], atol=1e-14)


def test_a_surface_without_area_has_no_normal():
    line = cg.NurbsSurface(
        (1, 1), [[0, 0, 1, 1]] * 2, np.repeat([[[0.0, 0, 0]], [[1.0, 0, 0]]], 2, 1)
    )
    assert np.isnan(line.normal(np.array([[0.5, 0.5]]))).all()
