"""Frames of the two faces at a crease."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import contiga as cg
from contiga.search.kernels import fold_nb
from contiga.search.tables import tables_of

pytestmark = pytest.mark.interpreted


@njit
def side_frame(elements, e, side, x, h):
    return fold_nb.side_frame(elements, e, side, x, h)


@pytest.mark.parametrize("side", range(4))
def test_a_frame_is_orthonormal_and_looks_into_its_face(side):
    patch = cg.shapes.bumpy_plate(waves=1)
    elements = tables_of(cg.Body([patch])).elements
    h = np.empty((4, 6))
    row = elements.table[0]
    kinds = ((-0.5, None), (0.5, None), (None, -0.5), (None, 0.5))
    for x in (-0.4, 0.0, 0.3):
        point, tangent, b, normal, bent, _ = side_frame(elements, 0, side, x, h)
        frame = np.array([tangent, b, normal])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert abs(np.dot(bent, tangent)) < 1e-9
        s, t = (x if k is None else k for k in kinds[side])
        box = row["box"]
        uv = [box[0] + (s + 0.5) * (box[1] - box[0]), box[2] + (t + 0.5) * (box[3] - box[2])]
        np.testing.assert_allclose(point, patch.evaluate(np.array([uv]))[0], atol=1e-12)
        middle = 0.5 * np.array([box[0] + box[1], box[2] + box[3]])
        inward = patch.evaluate(np.array([0.99 * np.array(uv) + 0.01 * middle]))[0] - point
        assert np.dot(inward, b) > 0.0


def test_the_curvature_of_a_circular_side_is_that_of_its_circle():
    elements = tables_of(cg.Body([cg.shapes.cylinder(radius=2.0, height=1.0)])).elements
    h = np.empty((4, 6))
    for side in range(4):
        bent = np.linalg.norm(side_frame(elements, 0, side, 0.1, h)[4])
        assert bent == pytest.approx(0.5, rel=1e-9) or bent == pytest.approx(0.0, abs=1e-12)
