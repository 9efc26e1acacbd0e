"""The elements that meet at a foot."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.codes import POLE
from contiga.elements.kernels import sides_nb
from contiga.search.closest.kernels import around_nb
from contiga.search.tables import tables_of


def test_all_elements_around_a_corner_and_a_pole_are_listed():
    list_e, list_st = np.empty(64, np.int64), np.empty((64, 2))
    elements = tables_of(cg.Body([cg.shapes.bumpy_plate()])).elements
    inner = next(
        e for e in range(len(elements.table)) if (elements.table[e]["neighbour"] >= 0).all()
    )
    assert around_nb.around(elements, (inner, 0.5, 0.5), list_e, list_st) == 4
    assert around_nb.around(elements, (inner, 0.5, 0.1), list_e, list_st) == 2
    assert around_nb.around(elements, (inner, 0.2, 0.1), list_e, list_st) == 1
    ball = tables_of(cg.Body([cg.shapes.sphere()])).elements
    e, side = np.argwhere(ball.table["kind"] == POLE)[0]
    s, t = sides_nb.side_point(side, 0.3)
    assert around_nb.around(ball, (e, s, t), list_e, list_st) == 4


@pytest.mark.interpreted
def test_closest_points_about_a_pole_without_compilation():
    """An eighth of a ball, by points over it and one beside it."""
    ball = cg.shapes.sphere()
    body = cg.Body([ball.restricted((0.0, 0.25), (0.0, 0.5))])
    far = np.array([[0.01, 0.02, -1.2], [0.0, 0.0, -1.3], [0.6, 0.3, -0.9], [0.3, -0.1, -0.9]])
    expected = far / np.linalg.norm(far, axis=1)[:, None]
    expected[3] = np.array([0.3, 0.0, -0.9]) / np.sqrt(0.9)
    np.testing.assert_allclose(body.project(far).point, expected, rtol=0, atol=1e-12)
