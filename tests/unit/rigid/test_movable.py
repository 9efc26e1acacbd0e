"""What is moved by a matrix can be moved, turned and scaled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg
from contiga.errors import GeometryError, InputError
from contiga.rigid import pose, transform
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


def test_rotations_and_pairs_move_as_their_matrix_does() -> None:
    turn, position = Rotation.from_rotvec([0.3, -1.1, 0.7]), [1.0, 2.0, 3.0]
    matrix = pose.as_pose((turn, position))
    slave = cg.Slave([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]], name="pad")
    curve = cg.NurbsCurve(1, [0, 0, 1, 1], [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    for moved, plain in ((slave.transformed, "points"), (curve.transformed, "control_points")):
        expected = getattr(moved(matrix), plain)
        np.testing.assert_array_equal(getattr(moved((turn, position)), plain), expected)
        by_turn = getattr(moved(turn), plain) + position
        np.testing.assert_allclose(by_turn, expected, atol=1e-15)
    with pytest.raises(InputError, match=r"pad, transform.*one \(3, 3\) matrix"):
        slave.transformed(Rotation.from_rotvec(np.eye(3)))
