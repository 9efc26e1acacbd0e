"""What is moved by a matrix can be moved, turned and scaled."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import GeometryError
from contiga.rigid import transform
from contiga.rigid.movable import Movable

MATRICES = [
    ("translated", ([1.0, 2.0, 3.0],), transform.translation([1.0, 2.0, 3.0])),
    ("rotated", ("z", 0.3, [1.0, 0.0, 0.0]), transform.rotation("z", 0.3, [1.0, 0.0, 0.0])),
    ("scaled", ([1.0, 2.0, 3.0],), transform.scaling([1.0, 2.0, 3.0])),
    ("transformed", (np.diag([1.0, -1.0, 1.0, 1.0]),), np.diag([1.0, -1.0, 1.0, 1.0])),
]


class Frame(Movable):
    """The matrix it was moved by."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix = matrix

    def _moved(self, matrix: np.ndarray) -> Frame:
        return Frame(matrix @ self.matrix)


@pytest.mark.parametrize(("how", "given", "matrix"), MATRICES)
def test_every_way_is_a_matrix(how, given, matrix) -> None:
    np.testing.assert_array_equal(getattr(Frame(np.eye(4)), how)(*given).matrix, matrix)


def test_a_matrix_that_flattens_is_refused() -> None:
    with pytest.raises(GeometryError, match="singular"):
        Frame(np.eye(4)).transformed(np.diag([1.0, 1.0, 0.0, 1.0]))


@pytest.mark.parametrize(
    "thing",
    [
        cg.shapes.circle(),
        cg.shapes.sphere(),
        cg.Body(cg.shapes.sphere(), name="ball"),
        cg.Body(cg.shapes.sphere()).tessellate(0.1),
    ],
)
def test_what_is_moved_stays_of_its_kind(thing) -> None:
    moved = thing.rotated("x", 0.2).translated([0.0, 0.0, 2.0]).scaled(2.0)
    assert type(moved) is type(thing)
    np.testing.assert_allclose(moved.bounds().mean(axis=0), [0.0, 0.0, 4.0], atol=0.1)
