"""Moving bodies, reference points, action and reaction."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg
from contiga.errors import InputError
from contiga.records import ContactStatus as Is
from contiga.rigid import pose

RNG = np.random.default_rng(8)
RING = cg.Body([cg.shapes.torus()], reference_point=(0.3, -0.2, 0.1))
CLOUD = np.random.default_rng(1).uniform([-2.6, -2.6, 0.55], [2.6, 2.6, 0.75], (800, 3))


def _contact(**options: object) -> cg.Contact:
    slave = cg.Slave(CLOUD, area=np.linspace(0.5, 1.5, len(CLOUD)))
    law = cg.PenaltyLaw(7.0, per_area=True)
    return cg.Contact(RING, slave, law=law, **options)  # type: ignore[arg-type]


def _pose(t: float) -> np.ndarray:
    turn = pose.rotation([0.2, -0.5, 1.0], 0.4 * t, [0.1, 0.0, 0.0])
    return pose.compose(pose.translation([0.02 * t, -0.01 * t, 0.5 * t]), turn)


def test_action_is_reaction_to_the_last_bit() -> None:
    contact = _contact()
    state = contact.start(CLOUD)
    for t in np.linspace(0.1, 1.0, 10):
        state = contact.step(state, CLOUD, _pose(t))
        np.testing.assert_array_equal(state.wrench[:3], -state.total_force)
    assert state.n_contact > 50


def test_the_moment_is_that_of_the_feet_too() -> None:
    contact = _contact()
    state = contact.step(contact.start(CLOUD), CLOUD, _pose(0.8))
    reference = (_pose(0.8) @ np.append(RING.reference_point, 1.0))[:3]
    moment = np.zeros(3)
    # A force along the line from point to foot has one moment, wherever on it it acts.
    for foot, force in zip(state.foot, state.force, strict=True):
        moment -= np.cross(foot - reference, force)
    scale = np.abs(state.force).sum()
    np.testing.assert_allclose(state.wrench[3:], moment, rtol=0, atol=1e-9 * scale)


def test_the_wrench_is_the_sum_over_the_points() -> None:
    contact = _contact()
    state = contact.step(contact.start(CLOUD), CLOUD, _pose(0.8))
    reference = (_pose(0.8) @ np.append(RING.reference_point, 1.0))[:3]
    moment = -np.cross(CLOUD - reference, state.force).sum(axis=0)
    scale = np.abs(state.force).sum()
    np.testing.assert_allclose(state.wrench[3:], moment, rtol=0, atol=1e-13 * scale)


def test_a_moving_body_and_moving_points_are_the_same() -> None:
    contact = _contact()
    moved = still = contact.start(CLOUD, _pose(0.0))
    for t in np.linspace(0.05, 1.2, 24):
        X_WB = _pose(t)
        moved = contact.step(moved, CLOUD, X_WB, dt=0.05)
        inverse = np.linalg.inv(X_WB)
        still = contact.step(still, pose.apply(inverse, CLOUD), dt=0.05)
        np.testing.assert_array_equal(moved.status, still.status)
        np.testing.assert_allclose(moved.penetration, still.penetration, rtol=0, atol=1e-12)
        turned = still.force @ X_WB[:3, :3].T
        np.testing.assert_allclose(moved.force, turned, rtol=0, atol=1e-10)
        foot = pose.apply(X_WB, still.foot)
        np.testing.assert_allclose(moved.foot, foot, rtol=0, atol=1e-10)
        for part in (slice(0, 3), slice(3, 6)):
            turned = X_WB[:3, :3] @ still.wrench[part]
            np.testing.assert_allclose(moved.wrench[part], turned, rtol=0, atol=1e-9)
    assert moved.n_contact > 50


def test_a_turning_body_has_normals_in_world_axes() -> None:
    plane = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    contact = cg.Contact(plane, cg.Slave([[0.2, 0.0, 0.1]], area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start([[0.2, 0.0, 0.1]])
    angle = -0.9
    # The plane turns about y: its point above the slave rises.
    state = contact.step(state, [[0.2, 0.0, 0.1]], pose.rotation("y", angle))
    n = np.array([np.sin(angle), 0.0, np.cos(angle)])
    assert state.status[0] == Is.NEW
    np.testing.assert_allclose(state.normal[0], n, rtol=0, atol=1e-15)
    assert state.penetration[0] == pytest.approx(-float(n @ [0.2, 0.0, 0.1]), abs=1e-15)


def test_shared_rigid_motion_changes_nothing() -> None:
    contact = _contact()
    state = contact.start(CLOUD, _pose(1.0))
    state = contact.step(state, CLOUD, _pose(1.3))
    for t in (3.0, 17.0):
        X = _pose(t)
        moved = pose.compose(X, _pose(1.3))
        after = contact.step(state, pose.apply(X, CLOUD), moved)
        assert (after.status[state.in_contact] == Is.OLD).all()
        np.testing.assert_allclose(after.penetration, state.penetration, rtol=0, atol=1e-12)


def test_a_pose_may_be_spelt_in_any_way_with_the_same_bits() -> None:
    contact, X_WB = _contact(), _pose(0.8)
    turn = Rotation.from_matrix(X_WB[:3, :3])
    X_WB[:3, :3] = turn.as_matrix()
    expected = contact.step(contact.start(CLOUD), CLOUD, X_WB)
    assert expected.n_contact > 50
    for spelt in ((turn, X_WB[:3, 3]), (X_WB[:3, :3], X_WB[:3, 3].tolist()), X_WB.tolist()):
        state = contact.step(contact.start(CLOUD), CLOUD, spelt)
        np.testing.assert_array_equal(state.force, expected.force)
        np.testing.assert_array_equal(state.pose, X_WB)
    np.testing.assert_array_equal(contact.start(CLOUD, turn).pose[:3, :3], X_WB[:3, :3])
    (run,) = contact.dry_run([(CLOUD, turn)])
    np.testing.assert_array_equal(run.pose[:3, :3], X_WB[:3, :3])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ((np.diag([1.0, 1.0, -1.0]), [0.0, 0.0, 1.0]), "must be a rotation"),
        (Rotation.from_rotvec(np.eye(3)), "one .3, 3. matrix"),
    ],
)
def test_a_reflection_or_several_rotations_are_no_pose(wrong: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        _contact().start(CLOUD, wrong)  # type: ignore[arg-type]
