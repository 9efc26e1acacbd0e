"""Frames of the two faces at a crease."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.unit.search import plain
from tests.unit.search.sheets import SHEETS

import contiga as cg
from contiga.search.certify.kernels import fold_nb
from contiga.search.certify.kernels.bend_nb import bend_bounds, bend_work

pytestmark = pytest.mark.interpreted


@njit
def side_frame(elements, e, side, x, h):
    return fold_nb.side_frame(elements, e, side, x, h)


@pytest.mark.parametrize("side", range(4))
def test_a_frame_is_orthonormal_and_looks_into_its_face(side):
    patch = cg.shapes.bumpy_plate(waves=1)
    elements = plain.elements(cg.Body([patch]))
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
    elements = plain.elements(cg.Body([cg.shapes.cylinder(radius=2.0, height=1.0)]))
    h = np.empty((4, 6))
    for side in range(4):
        bent = np.linalg.norm(side_frame(elements, 0, side, 0.1, h)[4])
        assert bent == pytest.approx(0.5, rel=1e-9) or bent == pytest.approx(0.0, abs=1e-12)


@njit
def side_bend(bend, work, cell, side):
    return fold_nb.side_bend(bend, work, cell, side)


@pytest.mark.parametrize("name", SHEETS)
def test_a_side_bends_and_runs_within_what_is_told(name):
    """C(y) of the side of a cell that is one of its element's, |y| ≤ 1."""
    rng = np.random.default_rng(0)
    y = np.linspace(-1.0, 1.0, 33)
    told, bend, work = 0, np.empty(6), bend_work()
    for _ in range(few(8, 2)):
        patch = SHEETS[name](rng)
        elements = plain.elements(cg.Body([patch]))
        for side in range(4):
            size = rng.uniform(0.05, 0.6, 2)
            low = rng.uniform(-0.5, 0.5 - size)
            low[side // 2] = 0.5 - size[side // 2] if side % 2 else -0.5
            cell = (low[0], low[0] + size[0], low[1], low[1] + size[1])
            if not bend_bounds(elements, 0, cell, bend, work):
                continue
            told += 1
            k = 1 - side // 2
            uv = np.zeros((33, 2)) + (side % 2)
            uv[:, k] = low[k] + 0.5 + 0.5 * (1.0 + y) * size[k]
            D = patch.derivatives(uv, order=2)
            first, second = (D[:, n, 0] if k == 0 else D[:, 0, n] for n in (1, 2))
            first, second = 0.5 * size[k] * first, 0.25 * size[k] ** 2 * second
            speed = np.linalg.norm(first, axis=1)
            bent = np.linalg.norm(np.cross(first, second), axis=1) / speed**3
            c, change, least, most = side_bend(bend, work, cell, side)
            assert change >= np.linalg.norm(second - c, axis=1).max() - 1e-12
            assert least <= speed.min() * (1 + 1e-9)
            assert most >= bent.max() * (1 - 1e-9) - 1e-9
    assert told > few(10, 2)
