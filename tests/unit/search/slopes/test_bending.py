"""The second fundamental form, against that of closed forms in any parameters."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.elements.kernels import element_nb
from contiga.search.slopes.kernels import bending_nb


@njit
def _bent(elements, grid, uv, normal):
    h = np.empty((4, 6))
    foot = element_nb.locate(grid, 0, uv[0], uv[1])
    return bending_nb.bending(elements, foot, (normal[0], normal[1], normal[2]), h)


def form_of(patch: cg.NurbsSurface, uv: np.ndarray) -> np.ndarray:
    """(3, 3) of the second fundamental form at a place, in space."""
    tables = cg.Body([patch]).surface.tables
    normal = patch.normal(uv[None])[0]
    q, p, b11, b12, b22 = _bent(tables.elements, tables.grid, uv, normal)
    frame = np.array([q, p])
    np.testing.assert_allclose(frame @ frame.T, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(frame @ normal, 0.0, atol=1e-12)
    return frame.T @ np.array([[b11, b12], [b12, b22]]) @ frame


def test_a_cylinder_bends_around_its_axis_alone() -> None:
    tube = cg.shapes.cylinder(radius=2.0, height=5.0)
    domain = np.array(tube.domain)
    uv = domain[:, 0] + np.array([0.3, 0.6]) * (domain[:, 1] - domain[:, 0])
    x, y, _ = tube.evaluate(uv[None])[0]
    around = np.array([-y, x, 0.0]) / 2.0
    np.testing.assert_allclose(form_of(tube, uv), -np.outer(around, around) / 2.0, atol=1e-12)


@pytest.mark.parametrize("shear", [0.0, 0.7])
def test_slanting_parameters_make_no_difference(shear: float) -> None:
    """A ball under a net whose lines are not square to each other."""
    ball = cg.shapes.sphere(radius=2.0)
    domain = np.array(ball.domain)
    share = np.array([0.3, 0.6 + 0.1 * shear])
    uv = domain[:, 0] + share * (domain[:, 1] - domain[:, 0])
    n = ball.normal(uv[None])[0]
    np.testing.assert_allclose(form_of(ball, uv), -(np.eye(3) - np.outer(n, n)) / 2.0, atol=1e-12)


def test_a_plane_has_none_and_a_saddle_both_signs() -> None:
    plane = cg.shapes.bilinear((0, 0, 0), (2, 0, 0), (1, 1, 0), (3, 1, 0))
    np.testing.assert_allclose(form_of(plane, np.array([0.4, 0.6])), 0.0, atol=1e-14)
    saddle = cg.shapes.saddle()
    middle = np.array(saddle.domain).mean(axis=1)
    bends = np.linalg.eigvalsh(form_of(saddle, middle))
    assert bends[0] < -0.1
    assert bends[2] > 0.1
