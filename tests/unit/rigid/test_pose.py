"""Poses against scipy's Rotation and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.errors import InputError
from contiga.rigid import pose, transform
from contiga.rigid.frames import checked_pose


def test_a_quarter_turn_about_z_is_exact() -> None:
    X = pose.rotation("z", np.pi / 2, centre=(1.0, 0.0, 0.0))
    np.testing.assert_array_equal(pose.apply(X, [[2.0, 0.0, 5.0]]), [[1.0, 1.0, 5.0]])


def test_apply_moves_points_and_only_turns_vectors() -> None:
    X = pose.compose(pose.translation([1, 2, 3]), pose.rotation("z", np.pi / 2))
    np.testing.assert_allclose(pose.apply(X, [[1, 0, 0]]), [[1, 3, 3]])
    np.testing.assert_allclose(pose.apply_vectors(X, [[1, 0, 0]]), [[0, 1, 0]])


@pytest.mark.parametrize("order", ["xyz", "zyx", "XYZ", "ZXZ", "yzy", "x", "ZY"])
def test_euler_angles_are_those_of_scipy(order: str) -> None:
    angles = [0.3, -1.1, 2.5][: len(order)]
    expected = Rotation.from_euler(order, angles if len(angles) > 1 else angles[0]).as_matrix()
    X = pose.from_euler(angles, order, position=[1, 2, 3])
    np.testing.assert_allclose(X[:3, :3], expected, atol=1e-15)
    np.testing.assert_array_equal(X[:3, 3], [1, 2, 3])


def test_a_relative_pose_takes_points_from_one_body_to_the_other() -> None:
    X_WA = pose.from_euler([0.1, 0.2, 0.3], position=[1, 0, 0])
    X_WB = pose.from_euler([-0.4, 0.9, 0.0], position=[0, 5, 0])
    p_B = np.array([[0.3, 0.4, 0.5]])
    p_A = pose.apply(pose.relative(X_WA, X_WB), p_B)
    np.testing.assert_allclose(pose.apply(X_WA, p_A), pose.apply(X_WB, p_B), atol=1e-15)


def test_interpolation_is_even_and_exact_at_the_ends() -> None:
    X0 = pose.translation([1, 0, 0])
    X1 = pose.compose(pose.translation([3, 4, 0]), pose.rotation([1, 1, 0], 1.2))
    np.testing.assert_array_equal(pose.interpolate(X0, X1, 0.0), X0)
    np.testing.assert_array_equal(pose.interpolate(X0, X1, 1.0), X1)
    third = pose.interpolate(X0, X1, 0.25)
    np.testing.assert_allclose(third[:3, 3], [1.5, 1.0, 0.0])
    np.testing.assert_allclose(third[:3, :3], pose.rotation([1, 1, 0], 0.3)[:3, :3], atol=1e-15)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pose.as_pose(np.diag([1.0, 1.0, 2.0, 1.0])), "rotation and a translation"),
        (lambda: pose.as_pose(np.diag([1.0, 1.0, -1.0, 1.0])), "rotation and a translation"),
        (lambda: pose.as_pose(np.eye(3)), r"\(4, 4\)"),
        (lambda: pose.as_pose(np.full((4, 4), np.nan)), "finite"),
        (lambda: pose.from_quaternion([0, 0, 0, 0]), "must not be all zero"),
        (lambda: pose.from_quaternion([1, 0, 0]), "four finite numbers"),
        (lambda: pose.from_euler([1, 2, 3], "xyw"), "order of Euler angles"),
        (lambda: pose.from_euler([1, 2, 3], "xYz"), "order of Euler angles"),
        (lambda: pose.from_euler([1, 2], "xyz"), "one angle for each axis"),
        (lambda: pose.rotation([0, 0, 0], 1.0), "must not be the zero vector"),
    ],
)
def test_what_is_no_pose_is_refused(call, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_a_pose_in_columns_is_read_as_kernels_read_it() -> None:
    turn = np.array([[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    in_columns = pose.as_pose(np.asfortranarray(turn))
    assert in_columns.flags.c_contiguous
    np.testing.assert_array_equal(in_columns, turn)


TURN = Rotation.from_rotvec([0.3, -1.1, 0.7])
POSITION = [1.0, 2.0, 3.0]


class RigidTransform:
    """Turn and translation in one, as scipy has from 1.16 on."""

    def __init__(self, matrices: np.ndarray) -> None:
        self._matrices = matrices

    def as_matrix(self) -> np.ndarray:
        return self._matrices


def matrix(t: object = (0.0, 0.0, 0.0)) -> np.ndarray:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = TURN.as_matrix(), t
    return X


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (TURN, matrix()),
        (RigidTransform(matrix(POSITION)), matrix(POSITION)),
        ((TURN, POSITION), matrix(POSITION)),
        ([TURN.as_matrix(), np.array(POSITION)], matrix(POSITION)),
        ((TURN.as_matrix().tolist(), (1, 2, 3)), matrix(POSITION)),
        (matrix(POSITION).tolist(), matrix(POSITION)),
    ],
)
def test_a_pose_may_be_a_rotation_or_a_pair(given: object, expected: np.ndarray) -> None:
    np.testing.assert_allclose(pose.as_pose(given), expected, rtol=0, atol=1e-15)  # type: ignore[arg-type]
    np.testing.assert_array_equal(checked_pose(given), pose.as_pose(given))  # type: ignore[arg-type]
    np.testing.assert_array_equal(transform.affine(given), pose.as_pose(given))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((np.diag([1.0, 1.0, -1.0]), POSITION), "must be a rotation and a translation.*det R = 1"),
        ((np.diag([1.0, 1.0, 1.0 + 1e-6]), POSITION), "must be a rotation and a translation"),
        ((np.full((3, 3), np.nan), POSITION), "finite"),
        ((TURN, [1.0, 2.0, np.nan]), "translation: must be three finite numbers"),
        ((TURN, [1.0, 2.0]), "translation: must be three finite numbers"),
        ((np.eye(3) * 1j, POSITION), "complex"),
        (("up", POSITION), "array of numbers"),
        ((np.eye(4), POSITION), r"one \(3, 3\) matrix.*found \(4, 4\)"),
        (Rotation.from_rotvec([[0, 0, 1], [0, 1, 0]]), r"one \(3, 3\).*rotations\[0\]"),
        ((Rotation.from_rotvec([[0, 0, 1]]), POSITION), r"one \(3, 3\).*rotations\[0\]"),
        (RigidTransform(np.stack([np.eye(4)] * 2)), r"one \(3, 3\)"),
        ("up", "array of numbers"),
        (np.eye(3), r"\(4, 4\)"),
    ],
)
def test_what_is_no_rotation_or_pair_is_refused_with_its_name(given: object, message: str) -> None:
    with pytest.raises(InputError, match=message) as raised:
        pose.as_pose(given, "bodies['ball']")  # type: ignore[arg-type]
    assert "bodies['ball']" in str(raised.value)
    with pytest.raises(InputError, match=message):
        checked_pose(given)  # type: ignore[arg-type]
