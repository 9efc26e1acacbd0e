"""Coordinates of joints that a case gives to an included file are those its joints then have."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.case.posture import Tie, postures
from contiga.dynamics.joint_laws import JointLaw
from contiga.dynamics.joints import KINDS, Joint
from contiga.rigid import pose

seeds = st.integers(0, 2**32 - 1)


def a_joint(rng: np.random.Generator, name: str, first: str, second: str) -> Joint:
    """A joint drawn with coordinates other than zero."""
    kind = str(rng.choice([*KINDS]))
    laws = {
        key: JointLaw(start=float(rng.uniform(-1.0, 1.0)))
        for key in KINDS[kind].coordinates
        if key != "cone" and rng.random() < 0.5
    }
    axis = rng.normal(size=(2, 3))
    if kind == "universal":
        axis[1] -= axis[0] * (axis[0] @ axis[1]) / (axis[0] @ axis[0])
    elif kind != "spherical":
        axis[1] = axis[0]
    return Joint(kind, first, second, at=rng.normal(size=3), axis=axis, name=name, **laws)  # type: ignore[arg-type]


def some_coordinates(rng: np.random.Generator, joint: Joint) -> dict[str, Any]:
    given: dict[str, Any] = {
        key: float(rng.uniform(0.05, 1.5) if key == "cone" else rng.uniform(-1.5, 1.5))
        for key in KINDS[joint.kind].coordinates
    }
    if "cone" in given and rng.random() < 0.5:
        given["about"] = rng.normal(size=3).tolist()
    return given


def measured(joint: Joint, X_1: Any, X_2: Any) -> dict[str, float]:
    """Coordinates of a joint whose bodies have been moved, by the definitions of its page."""
    one, two = joint.markers()
    p, q = (pose.apply(X, m.point[None])[0] for X, m in ((X_1, one), (X_2, two)))
    a, b = (m.axes @ X[:3, :3].T for X, m in ((X_1, one), (X_2, two)))
    way = q - p
    if "travel" in KINDS[joint.kind].coordinates:
        np.testing.assert_allclose(way - (way @ a[2]) * a[2], 0.0, atol=1e-12)
    else:
        np.testing.assert_allclose(way, 0.0, atol=1e-12)
    if joint.kind in ("revolute", "cylindrical", "translational"):
        np.testing.assert_allclose(a[2], b[2], atol=1e-12)
    if joint.kind == "universal":
        assert abs(a[2] @ b[0]) < 1e-12
    values = {
        "angle": math.atan2(b[0] @ a[1], b[0] @ a[0]),
        "angle_1": math.atan2(b[0] @ a[1], b[0] @ a[0]),
        "angle_2": math.atan2(a[2] @ b[1], a[2] @ b[2]),
        "travel": way @ a[2],
        "cone": math.atan2(float(np.linalg.norm(np.cross(a[2], b[2]))), a[2] @ b[2]),
        "twist": math.atan2(a[1] @ b[0] - a[0] @ b[1], a[0] @ b[0] + a[1] @ b[1]),
    }
    return {key: float(values[key]) for key in KINDS[joint.kind].coordinates}


@settings(deadline=None, max_examples=100)
@given(seed=seeds)
def test_joints_of_a_tree_have_the_coordinates_that_are_given(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints, ties = [], []
    for k in range(1, 6):
        ends = [f"b{rng.integers(k)}", f"b{k}"]
        rng.shuffle(ends)
        joints.append(a_joint(rng, f"j{k}", *ends))
        ties.append(Tie(joints[-1].between[0], joints[-1].between[1], joints[-1]))
    asked = {joint.name: some_coordinates(rng, joint) for joint in joints if rng.random() < 0.7}
    root = f"b{rng.integers(6)}"
    poses = postures(ties, root, asked)
    assert (poses[root] == np.eye(4)).all()
    for joint in joints:
        one, two = (poses[body] for body in joint.between)
        if joint.name in asked:
            values = measured(joint, one, two)
            for key, value in values.items():
                np.testing.assert_allclose(value, asked[joint.name][key], atol=1e-11)
        else:
            np.testing.assert_allclose(one, two, atol=1e-14)


@settings(deadline=None, max_examples=100)
@given(seed=seeds)
def test_joints_as_drawn_have_the_coordinates_of_their_laws(seed: int) -> None:
    joint = a_joint(np.random.default_rng(seed), "joint", "a", "b")
    for key, value in measured(joint, np.eye(4), np.eye(4)).items():
        if key != "cone":
            start = joint.laws[key].start if key in joint.laws else 0.0
            np.testing.assert_allclose(value, start, atol=1e-12)


@settings(deadline=None, max_examples=50)
@given(angles=st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=6), height=st.floats(-2.0, 2.0))
def test_a_plane_chain_is_where_its_angles_say(angles: list[float], height: float) -> None:
    links = [(f"link {k}", f"link {k + 1}") for k in range(-1, len(angles) - 1)]
    joints = [
        Joint("revolute", "ground" if k == 0 else first, second, at=[k, 0, 0], axis=[0, 0, 1])
        for k, (first, second) in enumerate(links)
    ]
    ties = [Tie(joint.between[0], joint.between[1], joint) for joint in joints]
    asked = {joint.name: {"angle": a} for joint, a in zip(joints, angles, strict=True)}
    poses = postures(ties, "ground", asked)
    sums = np.cumsum(angles)
    tip = np.cumsum(np.stack([np.cos(sums), np.sin(sums), np.zeros(len(sums))], axis=1), axis=0)
    for k, (_, second) in enumerate(links):
        end = pose.apply(poses[second], np.array([[k + 1.0, 0.0, height]]))[0]
        np.testing.assert_allclose(end, tip[k] + [0.0, 0.0, height], atol=1e-12)
