"""The posture of an included file: poses of its bodies from the coordinates of its joints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.dynamics.joints import KINDS, Joint
from contiga.errors import CaseError
from contiga.io.naming import closest
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.transform import rotation, translation

_MIN_SINE = 1e-6
"""Smallest sine of the angle between two directions that are not parallel."""
ABOUT = "about"
"""Key, beside coordinates, of the axis that a cone opens about."""
Coordinates = Mapping[str, float | Sequence[float]]
"""Coordinates of a joint by name; `about` is an axis (3,)."""


class Tie(NamedTuple):
    """Two bodies of a mechanism that move together, but for the coordinates of a joint."""

    first: str
    second: str
    joint: Joint | None
    """None if the second body is attached to the first."""


class _Link(NamedTuple):
    """A body of the kinematic tree, and the tie to its parent."""

    body: str
    tie: Tie
    parent: str


def postures(
    ties: Sequence[Tie], root: str, coordinates: Mapping[str, Coordinates]
) -> dict[str, FloatArray]:
    """Return the poses (4, 4) that bring the bodies of a mechanism into a posture.

    Forward kinematics from a root that stays: bodies move from where they are drawn to where joints
    have the given coordinates.

    Parameters
    ----------
    ties : joints and attachments
    root : name of the body that stays where it is drawn
    coordinates : by the names of joints and of coordinates; others stay as drawn

    Returns
    -------
    dict
        Poses by name, of the root (identity) and bodies that ties connect to it; a body moves with
        its whole branch of the tree.

    Raises
    ------
    CaseError
        There is no such joint, or no ties connect it to the root; it does not have the coordinate,
        or the coordinate is beyond its stops; it is in a closed loop; a cone opens in no direction.
    """
    joints = {tie.joint.name: tie.joint for tie in ties if tie.joint is not None}
    for name, values in coordinates.items():
        if name not in joints:
            raise CaseError(
                "the file has no joint of this name",
                where=f"joints.{name}",
                allowed=", ".join(f'"{joint}"' for joint in joints) or "none",
                remedy=closest(name, joints),
            )
        joint = joints[name]
        _check_coordinates(joint, values)
        first, second = joint.between
        other_ties = [tie for tie in ties if tie.joint is not joint]
        if any(link.body == second for link in _tree(other_ties, first)):
            raise CaseError(
                "is in a closed loop: other joints have a say in its coordinates",
                where=f"joints.{joint.name}",
                allowed="joints of a tree",
                remedy="Draw the loop in the posture that is wanted",
            )
    poses = {root: np.eye(4)}
    for link in _tree(ties, root):
        tie_joint, relative = link.tie.joint, np.eye(4)
        if tie_joint is not None and tie_joint.name in coordinates:
            relative = _relative_pose(tie_joint, coordinates[tie_joint.name])
            if link.body == link.tie.first:
                relative = pose.invert(relative)
        poses[link.body] = product(poses[link.parent], relative)
    for name in coordinates:
        if joints[name].between[0] not in poses:
            raise CaseError(
                f"no joints lead from the root {root!r} to this one: what it would move is unknown",
                where=f"joints.{name}",
                remedy='Name a body of its mechanism as root = "…"',
            )
    return poses


def _tree(ties: Sequence[Tie], root: str) -> list[_Link]:
    """Return links (body, tie, parent) to the bodies that ties connect to the root, parents first.

    Breadth first; of several ties to a body the first is taken.
    """
    links: list[_Link] = []
    reached = [root]
    for body in reached:
        for tie in ties:
            ends = (tie.first, tie.second)
            if body in ends:
                child = ends[1 - ends.index(body)]
                if child not in reached:
                    reached.append(child)
                    links.append(_Link(child, tie, body))
    return links


def _check_coordinates(joint: Joint, coordinates: Coordinates) -> None:
    """Refuse coordinates that the joint does not have, or that are beyond its stops.

    A cone must be in [0, π), and `about` needs one.
    """
    names = list(KINDS[joint.kind].coordinates)
    allowed = [*names, ABOUT] if "cone" in names else names
    for key, value in coordinates.items():
        place = f"joints.{joint.name}.{key}"
        if key not in allowed:
            raise CaseError(
                f"a {joint.kind} joint does not have this coordinate",
                where=place,
                allowed=", ".join(allowed) or "none: it is rigid",
            )
        law = joint.laws.get(key)
        if law is not None and key != ABOUT:
            low, high = law.stops
            assert isinstance(value, int | float)
            if not low <= value <= high:
                raise CaseError(
                    "is beyond a stop of the joint",
                    where=place,
                    found=value,
                    allowed=f"from {low:g} to {high:g}",
                )
        if key == "cone" and not 0.0 <= float(value) < math.pi:  # type: ignore[arg-type]
            raise CaseError("is no cone", where=place, found=value, allowed="0 ≤ cone < π")
    if ABOUT in coordinates and "cone" not in coordinates:
        raise CaseError(
            "is the axis that a cone opens about, and no cone is given",
            where=f"joints.{joint.name}.{ABOUT}",
        )


def _relative_pose(joint: Joint, coordinates: Coordinates) -> FloatArray:
    """Return the pose (4, 4) that moves the second body from where it is drawn.

    Its joint then has the coordinates, with the first body as drawn. Coordinates that are not given
    are where the laws start, else zero; a cone stays as drawn.
    """
    first, second = np.eye(4), np.eye(4)
    for matrix, marker in zip((first, second), joint.markers(), strict=True):
        matrix[:3, :3], matrix[:3, 3] = marker.axes.T, marker.point
    values: dict[str, Any] = {key: law.start for key, law in joint.laws.items()}
    values |= coordinates

    def turn(key: str, axis: str = "z") -> FloatArray:
        return rotation(axis, values.get(key, 0.0))

    if joint.kind == "spherical":
        drawn = pose.compose(pose.invert(first), second)
        motion = product(_swing(joint, first, drawn, coordinates), turn("twist"))
    elif joint.kind == "universal":
        motion = product(turn("angle_1"), turn("angle_2", "x"))
    else:
        motion = product(translation([0.0, 0.0, values.get("travel", 0.0)]), turn("angle"))
    return pose.compose(first, motion, pose.invert(second))


def _swing(
    joint: Joint, first: FloatArray, drawn: FloatArray, coordinates: Coordinates
) -> FloatArray:
    """Return the rotation (4, 4) by the cone of a spherical joint, in its first marker's frame.

    `drawn` is its second marker in that frame. The cone opens about `about`, else in the direction
    in which it is drawn; without a cone it is as drawn.

    Raises
    ------
    CaseError
        A cone is to open and the axes are on one line, or `about` is along the axis of the joint.
    """
    third = drawn[:3, 2]
    about = np.array([-third[1], third[0], 0.0])
    angle = math.atan2(length(about), third[2])
    if "cone" in coordinates:
        angle = float(coordinates["cone"])  # type: ignore[arg-type]
    if ABOUT in coordinates:
        about = product(first[:3, :3].T, np.array(coordinates[ABOUT], np.float64))
        if not math.hypot(about[0], about[1]) > _MIN_SINE * length(about):
            raise CaseError(
                "is along the axis of the joint, about which no cone opens, or has no length",
                where=f"joints.{joint.name}.{ABOUT}",
                found=coordinates[ABOUT],
                allowed="a direction across the axis of the joint on the first body",
            )
        about[2] = 0.0
    if angle == 0.0:
        return np.eye(4)
    if not length(about) > _MIN_SINE:
        raise CaseError(
            "opens in no direction: the axes are drawn on one line",
            where=f"joints.{joint.name}.cone",
            found=angle,
            remedy=f"Give {ABOUT} = [x, y, z] beside it, the axis that the second body turns about",
        )
    return rotation(about, angle)
