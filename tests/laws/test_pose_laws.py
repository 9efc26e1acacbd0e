"""Properties of quaternions and poses, against scipy's Rotation."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from contiga.rigid import pose, quaternion

numbers = st.floats(-1.0, 1.0, allow_subnormal=False)
quaternions = (
    st.lists(numbers, min_size=4, max_size=4)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
    .map(lambda q: quaternion.as_unit(np.array(q)))
)
positions = st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3)
poses = st.builds(pose.from_quaternion, quaternions, positions)


def scipy_rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1))


@given(quaternions)
def test_the_matrix_is_that_of_scipy_and_comes_back(q) -> None:
    R = quaternion.to_matrix(q)
    np.testing.assert_allclose(R, scipy_rotation(q).as_matrix(), atol=1e-15)
    back = quaternion.from_matrix(R)
    np.testing.assert_allclose(back * np.sign(back @ q), q, atol=1e-14)


@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_slerp_is_that_of_scipy(p, q, s) -> None:
    mixed = quaternion.to_matrix(quaternion.slerp(p, q, s))
    # Half a turn apart both ways are as good, and scipy may take the other.
    if abs(p @ q) > 1e-6:
        both = Rotation.concatenate([scipy_rotation(p), scipy_rotation(q)])
        np.testing.assert_allclose(mixed, Slerp([0, 1], both)(s).as_matrix(), atol=1e-9)
    np.testing.assert_allclose(mixed @ mixed.T, np.eye(3), atol=1e-14)


@given(quaternions, quaternions)
def test_slerp_starts_and_ends_at_its_ends(p, q) -> None:
    for s, end in ((0.0, p), (1.0, q)):
        np.testing.assert_allclose(abs(quaternion.slerp(p, q, s) @ end), 1.0, atol=1e-14)


@given(poses, poses)
def test_inverse_and_relative_poses_undo_each_other(X, Y) -> None:
    np.testing.assert_allclose(pose.compose(X, pose.invert(X)), np.eye(4), atol=1e-11)
    np.testing.assert_allclose(pose.compose(X, pose.relative(X, Y)), Y, atol=1e-11)


@given(poses, positions, positions)
def test_a_pose_keeps_distances(X, a, b) -> None:
    moved = pose.apply(X, np.array([a, b]))
    before, after = np.linalg.norm(np.subtract(a, b)), np.linalg.norm(moved[0] - moved[1])
    np.testing.assert_allclose(after, before, rtol=1e-12, atol=1e-11)


@given(poses, poses, st.floats(0.0, 1.0))
def test_interpolation_does_not_depend_on_its_direction(X, Y, s) -> None:
    there = pose.interpolate(X, Y, s)
    pose.as_pose(there)
    if abs(pose.to_quaternion(X) @ pose.to_quaternion(Y)) > 1e-6:
        np.testing.assert_allclose(there, pose.interpolate(Y, X, 1.0 - s), atol=1e-8)
