"""The posture of an included file: poses of its bodies where joints have given coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.dynamics.joints import KINDS, Joint, Marker
from contiga.errors import CaseError
from contiga.io.naming import closest
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.transform import rotation, translation

_ACROSS = 1e-6
"""Sine of the angle from which on a direction is across another."""
ABOUT = "about"
"""Key, beside coordinates, of the axis that a cone opens about."""
Coordinates = Mapping[str, float | Sequence[float]]
"""Coordinates of a joint by name; `about` is an axis (3,)."""


class Tie(NamedTuple):
    """Two bodies of a mechanism that move together, but for the coordinates of a joint."""

    first: str
    second: str
    joint: Joint | None
    """None where the second body is attached to the first."""


class _Step(NamedTuple):
    """A body that has been reached, and from where."""

    body: str
    tie: Tie
    before: str


def postures(
    ties: Sequence[Tie], root: str, given: Mapping[str, Coordinates]
) -> dict[str, FloatArray]:
    """Return the poses (4, 4) that bring the bodies of a mechanism into a posture.

    Forward kinematics from a root that stays: bodies move from where they are drawn to where joints
    have the coordinates given.

    Parameters
    ----------
    ties : joints and attachments
    root : name of the body that stays where it is drawn
    given : coordinates by the names of joints and of coordinates; others stay as drawn

    Returns
    -------
    dict
        Poses by name, of bodies that ties connect to the root; a body moves with all that hangs
        beyond it.

    Raises
    ------
    CaseError
        A joint that is not there or hangs on no tie to the root, a coordinate that it does not have
        or that is beyond its stops, a joint in a closed loop, a cone that opens in no direction.
    """
    joints = {tie.joint.name: tie.joint for tie in ties if tie.joint is not None}
    for name, coordinates in given.items():
        if name not in joints:
            raise CaseError(
                "the file has no joint of this name",
                where=f"joints.{name}",
                allowed=", ".join(f'"{known}"' for known in joints) or "none",
                remedy=closest(name, joints),
            )
        _check_coordinates(joints[name], coordinates)
        _check_tree(ties, joints[name])
    poses = {root: np.eye(4)}
    for step in _outwards(ties, root):
        joint, relative = step.tie.joint, np.eye(4)
        if joint is not None and joint.name in given:
            relative = _relative(joint, given[joint.name])
            if step.body == step.tie.first:
                relative = pose.invert(relative)
        poses[step.body] = product(poses[step.before], relative)
    for name in given:
        if joints[name].between[0] not in poses:
            raise CaseError(
                f"no joints lead from the root {root!r} to this one: what it would move is unknown",
                where=f"joints.{name}",
                remedy='Name a body of its mechanism as root = "…"',
            )
    return poses


def _outwards(ties: Sequence[Tie], root: str) -> list[_Step]:
    """Return the bodies that ties connect to the root, each after one it is tied to."""
    steps: list[_Step] = []
    reached = [root]
    for body in reached:
        for tie in ties:
            ends = (tie.first, tie.second)
            if body in ends:
                other = ends[1 - ends.index(body)]
                if other not in reached:
                    reached.append(other)
                    steps.append(_Step(other, tie, body))
    return steps


def _check_tree(ties: Sequence[Tie], joint: Joint) -> None:
    """Refuse a joint whose bodies other ties connect, too."""
    first, second = joint.between
    others = [tie for tie in ties if tie.joint is not joint]
    if any(step.body == second for step in _outwards(others, first)):
        raise CaseError(
            "is in a closed loop: other joints have a say in its coordinates",
            where=f"joints.{joint.name}",
            allowed="joints of a tree",
            remedy="Draw the loop in the posture that is wanted",
        )


def _check_coordinates(joint: Joint, coordinates: Coordinates) -> None:
    known = list(KINDS[joint.kind].coordinates)
    allowed = [*known, ABOUT] if "cone" in known else known
    for key, value in coordinates.items():
        where = f"joints.{joint.name}.{key}"
        if key not in allowed:
            raise CaseError(
                f"a {joint.kind} joint does not have this coordinate",
                where=where,
                allowed=", ".join(allowed) or "none: it is rigid",
            )
        law = joint.laws.get(key)
        if law is not None and key != ABOUT:
            low, high = law.stops
            assert isinstance(value, int | float)
            if not low <= value <= high:
                raise CaseError(
                    "is beyond a stop of the joint",
                    where=where,
                    found=value,
                    allowed=f"from {low:g} to {high:g}",
                )
        if key == "cone" and not 0.0 <= float(value) < math.pi:  # type: ignore[arg-type]
            raise CaseError("is no cone", where=where, found=value, allowed="0 ≤ cone < π")
    if ABOUT in coordinates and "cone" not in coordinates:
        raise CaseError(
            "is the axis that a cone opens about, and no cone is given",
            where=f"joints.{joint.name}.{ABOUT}",
        )


def _relative(joint: Joint, given: Coordinates) -> FloatArray:
    """Return the pose (4, 4) that moves the second body from where it is drawn.

    Its joint then has the coordinates `given`, with the first body as drawn.
    """
    first, second = (_frame(marker) for marker in joint.markers())
    drawn = pose.compose(pose.invert(first), second)
    values = {key: law.start for key, law in joint.laws.items()} | dict(given)
    if joint.kind == "spherical":
        there = product(_swing(joint, first, drawn, given), _turn(values, "twist"))
    elif joint.kind == "universal":
        there = product(_turn(values, "angle_1"), _turn(values, "angle_2", "x"))
    else:
        there = product(_travel(values), _turn(values, "angle"))
    return pose.compose(first, there, pose.invert(second))


def _frame(marker: Marker) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = marker.axes.T, marker.point
    return matrix


def _turn(values: Coordinates, key: str, axis: str = "z") -> FloatArray:
    angle = values.get(key, 0.0)
    assert isinstance(angle, int | float)
    return rotation(axis, angle)


def _travel(values: Coordinates) -> FloatArray:
    return translation([0.0, 0.0, values.get("travel", 0.0)])


def _swing(joint: Joint, first: FloatArray, drawn: FloatArray, given: Coordinates) -> FloatArray:
    """Return the rotation (4, 4) by the cone of a spherical joint, in its first marker's frame.

    `drawn` is its second marker there.
    """
    third = drawn[:3, 2]
    about = np.array([-third[1], third[0], 0.0])
    angle = math.atan2(length(about), third[2])
    if "cone" in given:
        angle = float(given["cone"])  # type: ignore[arg-type]
    if ABOUT in given:
        about = product(first[:3, :3].T, np.array(given[ABOUT], np.float64))
        if not math.hypot(about[0], about[1]) > _ACROSS * length(about):
            raise CaseError(
                "is along the axis of the joint, about which no cone opens, or has no length",
                where=f"joints.{joint.name}.{ABOUT}",
                found=given[ABOUT],
                allowed="a direction across the axis of the joint on the first body",
            )
        about[2] = 0.0
    if angle == 0.0:
        return np.eye(4)
    if not length(about) > _ACROSS:
        raise CaseError(
            "opens in no direction: the axes are drawn on one line",
            where=f"joints.{joint.name}.cone",
            found=angle,
            remedy=f"Give {ABOUT} = [x, y, z] beside it, the axis that the second body turns about",
        )
    return rotation(about, angle)
