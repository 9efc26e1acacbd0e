"""Bézier extraction reproduces the spline on every element."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import NurbsCurve, NurbsSurface, shapes
from contiga.geometry.bezier import extract, extract_curve

S = np.linspace(0.0, 1.0, 7)


def bernstein(degree: int, s: np.ndarray) -> np.ndarray:
    """(k, degree + 1) by the de Casteljau recursion, which the package does not use."""
    out = np.ones((s.size, 1))
    for _ in range(degree):
        zero = np.zeros((s.size, 1))
        out = np.hstack([out, zero]) * (1 - s)[:, None] + np.hstack([zero, out]) * s[:, None]
    return out


@pytest.mark.interpreted
@pytest.mark.parametrize(("p", "q"), [(1, 3), (2, 2), (4, 9), (15, 1)])
def test_every_element_is_the_surface(p, q):
    rng = np.random.default_rng(p)
    U, V = (np.r_[np.zeros(d + 1), 0.2, 0.55, np.ones(d + 1)] for d in (p, q))
    shape = (p + 3, q + 3)
    surface = NurbsSurface((p, q), (U, V), rng.normal(size=(*shape, 3)), rng.uniform(0.5, 2, shape))
    grid = extract(surface)
    assert grid.coefs.shape == (3, 3, p + 1, q + 1, 4)
    for i in range(3):
        for j in range(3):
            value = np.einsum("ka,lb,abd->kld", bernstein(p, S), bernstein(q, S), grid.coefs[i, j])
            u = grid.u_breaks[i] + (grid.u_breaks[i + 1] - grid.u_breaks[i]) * S
            v = grid.v_breaks[j] + (grid.v_breaks[j + 1] - grid.v_breaks[j]) * S
            uv = np.stack(np.meshgrid(u, v, indexing="ij"), -1)
            expected = surface.evaluate(uv.reshape(-1, 2)).reshape(*uv.shape[:2], 3)
            np.testing.assert_allclose(
                value[..., :3] / value[..., 3:], expected, rtol=0, atol=1e-13
            )


def test_neighbours_share_their_border_bit_for_bit():
    grid = extract(shapes.torus())
    np.testing.assert_array_equal(grid.coefs[:-1, :, -1], grid.coefs[1:, :, 0])
    np.testing.assert_array_equal(grid.coefs[:, :-1, :, -1], grid.coefs[:, 1:, :, 0])


def test_a_sphere_has_four_by_two_elements_with_positive_weights():
    grid = extract(shapes.sphere())
    assert grid.coefs.shape[:2] == (4, 2)
    assert (grid.coefs[..., 3] > 0.0).all()
    np.testing.assert_array_equal(grid.u_breaks, [0, 0.25, 0.5, 0.75, 1])


def test_extra_cuts_become_borders():
    grid = extract(shapes.plane(), np.array([0.25]), np.array([0.5, 0.75]))
    assert grid.coefs.shape[:2] == (2, 3)
    np.testing.assert_array_equal(grid.v_breaks, [0, 0.5, 0.75, 1])
    np.testing.assert_array_equal(grid.coefs[1, 1, :, :, 0], [[-0.25, -0.25], [0.5, 0.5]])


def test_every_piece_is_the_curve():
    rng = np.random.default_rng(2)
    knots = [0, 0, 0, 0, 0.3, 0.3, 0.8, 2, 2, 2, 2]
    curve = NurbsCurve(3, knots, rng.normal(size=(7, 3)), rng.uniform(0.5, 2, 7))
    pieces = extract_curve(curve)
    np.testing.assert_array_equal(pieces.breaks, [0, 0.3, 0.8, 2])
    for coefs, low, high in zip(pieces.coefs, pieces.breaks[:-1], pieces.breaks[1:], strict=True):
        value = bernstein(3, S) @ coefs
        expected = curve.evaluate(low + (high - low) * S)
        np.testing.assert_allclose(value[:, :3] / value[:, 3:], expected, rtol=0, atol=1e-14)
