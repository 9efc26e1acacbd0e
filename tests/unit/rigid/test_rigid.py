"""Points and directions between body and world axes."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.layout import locked
from contiga.errors import InputError
from contiga.rigid import pose
from contiga.rigid.frames import checked_pose, to_body, to_world, turn_to_world
from contiga.rigid.kernels import rigid_nb

X_WB = pose.compose(pose.translation([1.0, -2.0, 3.0]), pose.rotation("z", 0.7))


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(0).normal(size=(50, 3))


@pytest.mark.interpreted
def test_world_points_are_the_homogeneous_product(points: np.ndarray) -> None:
    expected = (X_WB @ np.column_stack([points, np.ones(50)]).T).T[:, :3]
    np.testing.assert_allclose(to_world(X_WB, points), expected, rtol=0, atol=1e-14)


@pytest.mark.interpreted
def test_body_points_undo_world_points(points: np.ndarray) -> None:
    np.testing.assert_allclose(to_body(X_WB, to_world(X_WB, points)), points, rtol=0, atol=1e-14)


@pytest.mark.interpreted
def test_directions_turn_and_do_not_move(points: np.ndarray) -> None:
    turned = turn_to_world(X_WB, points)
    np.testing.assert_allclose(turned, points @ X_WB[:3, :3].T, rtol=0, atol=1e-15)
    lengths = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), lengths, rtol=1e-14)


@pytest.mark.interpreted
def test_every_row_is_treated_alone(points: np.ndarray) -> None:
    whole = to_body(X_WB, points)
    for k in range(len(points)):
        assert to_body(X_WB, points[k : k + 1]).tobytes() == whole[k].tobytes()


@pytest.mark.interpreted
def test_not_finite_rows_stay_alone(points: np.ndarray) -> None:
    points[3, 1] = np.nan
    moved = to_world(X_WB, points)
    assert np.flatnonzero(~np.isfinite(moved).all(axis=1)).tolist() == [3]


def test_points_that_may_be_written_to_and_those_that_may_not_are_one_version(
    points: np.ndarray,
) -> None:
    answers = [to_body(X_WB, locked(points)), to_world(X_WB, locked(points))]
    kernels = rigid_nb.to_body, rigid_nb.to_world
    before = [len(getattr(kernel, "overloads", ())) for kernel in kernels]
    np.testing.assert_array_equal(to_body(X_WB, points), answers[0])
    np.testing.assert_array_equal(to_world(X_WB, points), answers[1])
    assert [len(getattr(kernel, "overloads", ())) for kernel in kernels] == before
    points[0] = 1.0  # which is still the caller's to write to


@pytest.mark.interpreted
def test_columns_of_a_wider_array_are_turned(points: np.ndarray) -> None:
    wide = np.hstack([points, points])
    np.testing.assert_array_equal(turn_to_world(X_WB, wide[:, 3:]), turn_to_world(X_WB, points))


@pytest.mark.interpreted
def test_a_pose_is_taken_as_a_copy_of_its_own() -> None:
    given = np.asfortranarray(X_WB)
    given.flags.writeable = False
    taken = checked_pose(given)
    assert taken.flags.carray
    assert not np.shares_memory(taken, given)
    np.testing.assert_array_equal(taken, X_WB)
    np.testing.assert_array_equal(checked_pose(X_WB.tolist()), X_WB)
    assert checked_pose(np.eye(4, dtype=np.int64)).dtype == np.float64


def changed(*entries: tuple[int, int, float]) -> np.ndarray:
    wrong = X_WB.copy()
    for i, j, value in entries:
        wrong[i, j] = value
    return wrong


WRONG = {
    "far too long": 1.1 * X_WB,
    "mirrored": X_WB * [1.0, 1.0, -1.0, 1.0],
    "sheared": changed((0, 2, 1e-6)),
    "of another last row": changed((3, 0, 1e-3)),
    "of another last number": changed((3, 3, 2.0)),
    "not a number": changed((1, 1, np.nan)),
    "moved without end": changed((2, 3, np.inf)),
    "not square": X_WB[:3],
    "text": np.full((4, 4), "a"),
}


@pytest.mark.interpreted
@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_pose_is_refused_with_the_words_of_poses(name: str) -> None:
    with pytest.raises(InputError) as wanted:
        pose.as_pose(WRONG[name])
    with pytest.raises(InputError) as error:
        checked_pose(WRONG[name])
    assert str(error.value) == str(wanted.value)


@pytest.mark.interpreted
@pytest.mark.parametrize("off", [0.4e-9, 1.1e-9, -0.4e-9, -1.1e-9])
def test_a_pose_may_be_off_by_as_much_as_poses_may(off: float) -> None:
    matrix = np.eye(4)
    matrix[0, 1] = off
    assert rigid_nb.is_rigid(matrix, pose.RIGID) == (abs(off) <= pose.RIGID)


@pytest.mark.interpreted
def test_a_wrench_is_added_about_the_origin_of_the_frame() -> None:
    wrench, about_B, total = np.arange(1.0, 7.0), np.array([0.3, -2.0, 5.0]), np.full(6, 10.0)
    rigid_nb.add_wrench(wrench, about_B, X_WB, total)
    moment = np.cross(X_WB[:3, :3] @ about_B, wrench[:3]) + wrench[3:]
    np.testing.assert_allclose(total - 10.0, [*wrench[:3], *moment], rtol=0, atol=1e-13)
