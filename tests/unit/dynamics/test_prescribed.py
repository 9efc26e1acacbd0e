"""Prescribed motions: between the rows of a table, at its ends, outside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.dynamics import Combine, Fixed, Moved, Poses, Rotate, Translate, Twist
from contiga.dynamics.prescribed import is_known_ahead, pose_at
from contiga.errors import FileError, InputError, UnitError
from contiga.rigid import pose
from contiga.rigid.transform import PoseLike

HALF = np.sqrt(0.5)


def test_a_fixed_body_stays() -> None:
    np.testing.assert_array_equal(Fixed().pose(3.0), np.eye(4))


def test_translation_is_linear_between_rows_and_held_outside() -> None:
    motion = Translate([[0, 0, 0, 0], [10, 0, 0, -2], [20, 5, 0, -2]])
    for t, expected in (
        (-1, [0, 0, 0]),
        (0, [0, 0, 0]),
        (5, [0, 0, -1]),
        (10, [0, 0, -2]),
        (15, [2.5, 0, -2]),
        (99, [5, 0, -2]),
    ):
        np.testing.assert_array_equal(motion.pose(t)[:3, 3], expected)


def test_rotation_turns_about_its_centre_and_counts_whole_turns() -> None:
    motion = Rotate([[0, 0], [8, 720]], axis="z", centre=[1, 0, 0])
    np.testing.assert_allclose(pose.apply(motion.pose(1.0), [[2, 0, 0]]), [[1, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(pose.apply(motion.pose(5.0), [[2, 0, 0]]), [[1, 1, 0]], atol=1e-15)
    np.testing.assert_array_equal(motion.pose(9.0), motion.pose(8.0))


def test_poses_are_slerped_between_and_held_outside() -> None:
    motion = Poses.from_table([[0, 0, 0, 0, 1, 0, 0, 0], [2, 4, 0, 0, HALF, 0, 0, HALF]])
    middle = motion.pose(1.0)
    np.testing.assert_allclose(middle[:3, 3], [2, 0, 0])
    np.testing.assert_allclose(middle[:3, :3], pose.rotation("z", np.pi / 4)[:3, :3], atol=1e-15)
    np.testing.assert_array_equal(motion.pose(-5.0), motion.pose(0.0))
    np.testing.assert_array_equal(motion.pose(7.0), motion.pose(2.0))


def test_one_pose_is_a_motion_that_stands_still() -> None:
    motion = Poses([1.0], [pose.translation([1, 2, 3])])
    for t in (0.0, 1.0, 2.0):
        np.testing.assert_array_equal(motion.pose(t)[:3, 3], [1, 2, 3])


def test_a_pose_handed_out_can_be_changed_without_harm() -> None:
    motion = Poses([0.0, 1.0], [np.eye(4), np.eye(4)])
    for t in (-1.0, 0.5, 2.0):
        motion.pose(t)[0, 3] = 7.0
        assert motion.pose(t)[0, 3] == 0.0


def test_combined_motions_are_applied_in_their_order() -> None:
    turn = Rotate([[0, 90]], axis="z")
    move = Translate([[0, 1, 0, 0]])
    first_turn = pose.apply(Combine([turn, move]).pose(0), [[1, 0, 0]])
    first_move = pose.apply(Combine([move, turn]).pose(0), [[1, 0, 0]])
    np.testing.assert_allclose(first_turn, [[1, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(first_move, [[0, 2, 0]], atol=1e-15)
    np.testing.assert_array_equal(Combine([]).pose(0), np.eye(4))


def test_moved_points_follow_points_or_a_series() -> None:
    class Series:
        def points(self, t: float) -> np.ndarray:
            return np.array([[t, 0.0, 0.0]])

    motion = Translate([[0, 0, 0, 0], [1, 0, 0, 1]])
    np.testing.assert_array_equal(Moved([[1, 1, 1]], motion).points(1.0), [[1, 1, 2]])
    np.testing.assert_array_equal(Moved(Series(), motion).points(0.5), [[0.5, 0, 0.5]])


def test_poses_come_from_a_csv_with_its_columns_in_any_order(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(
        f"t, qw,qx,qy,qz,x,y,z,note\n0,1,0,0,0,1,2,3,a\n\n1,{HALF},0,0,{HALF},4,5,6,b\n"
    )
    motion = Poses.from_csv(path)
    np.testing.assert_array_equal(motion.pose(0.0), pose.translation([1, 2, 3]))
    np.testing.assert_allclose(motion.pose(1.0)[:3, 0], [0, 1, 0], atol=1e-15)


def test_poses_come_in_the_units_that_are_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(
        '"t [s]";"x [m]";"y [mm]";"z";"qw";"qx [1]";"qy";"qz"\n'
        "0;0;0;0;1;0;0;0\n0,5;0,1;2;3;1;0;0;0\n"
    )
    motion = Poses.from_csv(path, units=("mm", "ms"))
    assert motion.times.tolist() == [0.0, 500.0]
    np.testing.assert_allclose(motion.pose(500.0), pose.translation([100, 2, 3]), rtol=1e-15)
    with pytest.raises(UnitError, match=r"poses\.csv:1: t \[s\]: .*units = …"):
        Poses.from_csv(path)
    with pytest.raises(UnitError, match="units: not a unit of time"):
        Poses.from_csv(path, units=("mm", "kg"))


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("t,x,y,z,qw,qx,qy\n", FileError, r"poses\.csv:1: the column 'qz' is missing"),
        ("", FileError, "the first line must name the columns"),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0\n", FileError, r"poses\.csv:2: a row does not"),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,zero,1,0,0,0\n", FileError, r"poses\.csv:2: a row does not"),
        ("t,x,y,z,qw,qx,qy,qz\n", InputError, r"poses\.csv: .*at least one row"),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,2,0,0,0\n", InputError, "must have length 1"),
        ("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,nan,0,0,0\n", FileError, r"poses\.csv:2: a number is not"),
        (
            "t,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n",
            InputError,
            "times go back or repeat at row 1",
        ),
    ],
)
def test_a_wrong_pose_file_is_refused_with_its_place(tmp_path: Path, text, kind, message) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(text)
    with pytest.raises(kind, match=message):
        Poses.from_csv(path)


def test_a_missing_pose_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.csv: the file cannot be read"):
        Poses.from_csv(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Translate([[0, 0, 0]]), "4 columns"),
        (lambda: Translate([]), "4 columns and at least one row"),
        (lambda: Translate([[0, 0, 0, 0], [1, 0, 0]]), "all of the same length"),
        (lambda: Translate([[1, 0, 0, 0], [0, 0, 0, 0]]), r"go back .*found \[1.0, 0.0\]"),
        (lambda: Translate([[0, 0, 0, np.inf]]), "row 0 is not finite"),
        (lambda: Rotate([[0, 0], [0, 1]]), "go back or repeat at row 1"),
        (lambda: Rotate([[0, 0]], axis="w"), "not an axis"),
        (lambda: Rotate([[0, 0]], axis=[0, 0, 0]), "zero vector"),
        (lambda: Rotate([[0, 0]], centre=[0, 0]), "centre: must be three finite numbers"),
        (lambda: Poses([0.0, 1.0], [np.eye(4)]), "one finite time for each row"),
        (lambda: Poses([0.0], [2.0 * np.eye(4)]), r"poses\[0\]: .*rotation and a translation"),
    ],
)
def test_a_wrong_table_is_refused_with_its_rule(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


class Turning:
    """A motion of a user's own that gives rotations and pairs."""

    def __init__(self, position: list[float] | None = None) -> None:
        self.position = position

    def pose(self, t: float) -> PoseLike:
        turn = Rotation.from_euler("z", 90.0 * t, degrees=True)
        return turn if self.position is None else (turn, self.position)

    def twist(self, t: float) -> Twist:
        return Twist(np.zeros(3), np.array([0.0, 0.0, 0.5 * np.pi]))


def test_motions_of_ones_own_may_give_rotations_or_pairs() -> None:
    turn, lift = pose.rotation("z", np.pi / 2), Translate([[0, 0, 0, 0], [1, 0, 0, 2]])
    points = [[1.0, 0.0, 0.0]]
    moved, velocity = Moved(points, Turning()), [[-0.5 * np.pi, 0.0, 0.0]]
    np.testing.assert_allclose(moved.points(1.0), [[0, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(moved.velocities(1.0), velocity, atol=1e-15)
    expected = pose.compose(pose.translation([0, 0, 2]), turn)
    np.testing.assert_allclose(Combine([Turning(), lift]).pose(1.0), expected, atol=1e-15)
    np.testing.assert_allclose(pose_at(Turning([0, 0, 2]), 1.0), expected, atol=1e-15)


def test_a_motion_of_ones_own_that_gives_no_pose_is_named() -> None:
    motion = Turning([0.0, 0.0, np.nan])
    with pytest.raises(InputError, match=r"Turning.pose\(2\).*three finite numbers"):
        Moved([[1.0, 0.0, 0.0]], motion).points(2.0)


def test_poses_may_be_rotations_or_pairs() -> None:
    turns = Rotation.from_rotvec([[0, 0, 0], [0, 0, 90]], degrees=True)
    np.testing.assert_allclose(
        Poses([0.0, 2.0], turns).pose(1.0), pose.rotation("z", np.pi / 4), atol=1e-15
    )
    motion = Poses([0.0, 2.0], [(turns[0], [0, 0, 0]), (turns[1], [4, 0, 0])])
    np.testing.assert_allclose(motion.pose(1.0)[:3, 3], [2, 0, 0])
    with pytest.raises(InputError, match=r"poses\[1\].*rotation and a translation"):
        Poses([0.0, 2.0], [turns[0], (np.diag([1.0, -1.0, 1.0]), [0, 0, 0])])


def test_built_in_motions_are_known_ahead_and_others_if_they_say_so() -> None:
    table = [[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]]
    moved = Translate(table)
    known = [moved, Fixed(), Combine([moved, moved]), Poses([0.0], [np.eye(4)])]
    assert all(is_known_ahead(motion) for motion in known)

    class Live:
        """Poses that come from a solver."""

        known_ahead = False

    assert not is_known_ahead(Live())
    assert not is_known_ahead(object())
