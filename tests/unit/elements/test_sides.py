"""Points and normals along the sides of elements, poles too."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search import plain

import contiga as cg
from contiga.elements.kernels import sides_nb

pytestmark = pytest.mark.interpreted


def test_samples_lie_on_their_sides_with_the_normals_of_the_surface():
    elements = plain.elements(cg.Body([cg.shapes.sphere(radius=2.0)]))
    points, normals = sides_nb.sample(elements)
    assert points.shape == normals.shape == (len(elements.table), 4, 5, 3)
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 2.0, atol=1e-12)
    # at the poles S_u × S_v vanishes: there it is the limit from inside
    np.testing.assert_allclose(normals, points / 2.0, atol=1e-14)


def test_sides_run_along_the_square():
    square = [sides_nb.side_point(side, 0.25) for side in range(4)]
    assert square == [(-0.5, 0.25), (0.5, 0.25), (0.25, -0.5), (0.25, 0.5)]


def test_the_tip_of_a_cone_has_no_normal_of_its_own():
    patch = cg.shapes.cone()
    elements = plain.elements(cg.Body([patch]))
    points, normals = sides_nb.sample(elements)
    length = np.linalg.norm(normals, axis=-1)
    np.testing.assert_allclose(length, 1.0, atol=1e-12)
    tip = np.ptp(points, axis=2).max(axis=-1) < 1e-12
    assert tip.any()
    assert np.ptp(normals[tip], axis=1).max() > 0.1
