"""What derivatives of contact forces obey whatever the scene: moved together nothing changes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import contiga as cg

SETTINGS = settings(max_examples=25, deadline=None, derandomize=True)
EGG = cg.Body([cg.shapes.ellipsoid(axes=(1.0, 2.0, 3.0))]).with_reference_point([0.2, -0.3, 0.1])
TABLE = [[0.0, 0.0], [0.15, 1.0], [0.5, 4.0]]
LAWS = st.sampled_from(
    [
        cg.PenaltyLaw(7.0, damping=0.1),
        cg.StressLaw(TABLE, 0.7),
        cg.ForceLaw(TABLE),
        cg.ForceLaw(TABLE, share="penetration"),
    ]
)
CONSERVING = st.sampled_from([cg.PenaltyLaw(7.0), cg.StressLaw(TABLE, 0.7), cg.ForceLaw(TABLE)])
FRICTIONS = st.sampled_from([None, cg.Coulomb(0.3), cg.ViscousFriction(0.3, speed=0.1)])
SEEDS = st.integers(0, 10**6)


def scene(law: object, friction: object, seed: int) -> tuple:
    """A contact, a state of it, and where points and pose go from there."""
    rng = np.random.default_rng(seed)
    feet = EGG.project(rng.normal(size=(5, 3)) * [1.0, 2.0, 3.0])
    points = feet.point - rng.uniform(0.05, 0.3, 5)[:, None] * feet.normal
    slave = cg.Slave(points, area=rng.uniform(0.5, 1.0, 5))
    contact = cg.Contact(EGG, slave, law=law, friction=friction, search="penetration")
    state = contact.step(contact.start(points), points, dt=0.1)
    return contact, state, points + 0.01 * rng.normal(size=(5, 3))


def about(points: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """θ × x of each point for each axis of θ: (3 n, 3)."""
    return np.stack([np.cross(axis, points).ravel() for axis in turn], axis=1)


@given(law=LAWS, friction=FRICTIONS, seed=SEEDS)
@SETTINGS
def test_both_sides_moved_together_turn_the_forces_along(
    law: object, friction: object, seed: int
) -> None:
    contact, state, points = scene(law, friction, seed)
    after = contact.step(state, points, dt=0.1)
    whole = contact.linearise(after)
    shift = np.tile(np.eye(3), (5, 1))
    force, scale = after.force, 1.0 + np.abs(whole.force_by_points.data).max(initial=0.0)
    together = np.hstack([shift, about(points, np.eye(3))])
    change = whole.force_by_points @ together + whole.force_by_pose
    wanted = np.hstack([np.zeros((15, 3)), about(force, np.eye(3))])
    np.testing.assert_allclose(change, wanted, rtol=0.0, atol=1e-9 * scale)
    change = whole.wrench_by_points @ together + whole.wrench_by_pose
    wrench = after.wrench.reshape(2, 3)
    wanted = np.hstack([np.zeros((6, 3)), about(wrench, np.eye(3))])
    np.testing.assert_allclose(change, wanted, rtol=0.0, atol=1e-8 * scale)


@given(law=LAWS, friction=FRICTIONS, seed=SEEDS)
@SETTINGS
def test_the_same_scene_elsewhere_has_the_same_tangent_turned(
    law: object, friction: object, seed: int
) -> None:
    contact, state, points = scene(law, friction, seed)
    here = contact.tangent(contact.step(state, points, dt=0.1)).toarray()
    turn = Rotation.random(random_state=seed).as_matrix()
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turn, [3.0, -2.0, 5.0]

    def moved(x: np.ndarray) -> np.ndarray:
        return x @ turn.T + place[:3, 3]

    before = moved(state.points_B)
    start = contact.step(contact.start(before, place), before, pose=place, dt=0.1)
    there = contact.tangent(contact.step(start, moved(points), pose=place, dt=0.1)).toarray()
    every = np.kron(np.eye(5), turn)
    scale = 1.0 + np.abs(here).max()
    np.testing.assert_allclose(there, every @ here @ every.T, rtol=0.0, atol=1e-7 * scale)


@given(law=CONSERVING, seed=SEEDS)
@SETTINGS
def test_forces_of_an_energy_have_a_symmetric_tangent(law: object, seed: int) -> None:
    contact, state, points = scene(law, None, seed)
    tangent = contact.tangent(contact.step(state, points, dt=0.1)).toarray()
    scale = 1.0 + np.abs(tangent).max()
    np.testing.assert_allclose(tangent, tangent.T, rtol=0.0, atol=1e-11 * scale)
