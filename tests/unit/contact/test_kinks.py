"""Which points another piece of the master pushes than before: Newton's method may go astray."""

from __future__ import annotations

import numpy as np
import pytest
from tests.scenes import box

import contiga as cg
from contiga.errors import InputError

BOX = box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
FLAT = cg.Body([cg.shapes.ellipsoid(axes=(3.0, 2.0, 1.0))])


def contact_of(master: object, n: int, **options: object) -> cg.Contact:
    slave = cg.Slave(np.zeros((n, 3)), area=np.ones(n))
    return cg.Contact(master, slave, law=cg.PenaltyLaw(1.0), search="penetration", **options)


def test_a_point_that_passes_to_another_face() -> None:
    contact = contact_of(BOX, 3)
    start = np.array([[1.0, 1.7, 1.72], [1.0, 1.0, 1.7], [1.0, 1.2, 2.5]])
    state = contact.start(start)
    assert len(state.kinks) == 0
    after = contact.step(state, start + np.array([0.0, 0.05, -0.02]))
    assert after.n_contact == 2
    assert after.kinks.tolist() == [0]
    assert contact.step(after, start + np.array([0.0, 0.06, -0.02])).kinks.tolist() == []


def test_points_that_come_in_are_told_by_their_status() -> None:
    contact = contact_of(BOX, 1)
    state = contact.start(np.array([[1.0, 1.0, 2.5]]))
    after = contact.step(state, np.array([[1.0, 1.0, 1.9]]))
    assert after.status.tolist() == [cg.ContactStatus.NEW]
    assert len(after.kinks) == 0


def test_a_foot_that_jumps_to_another_wall_of_the_same_face() -> None:
    """The middle of a flat ellipsoid: above it the upper side is nearest, below it the lower."""
    contact = contact_of(FLAT, 1)
    state = contact.start(np.array([[2.2, 0.0, 0.02]]))
    assert state.normal[0, 2] > 0.0
    passed = contact.step(state, np.array([[2.2, 0.0, -0.02]]))
    assert (passed.patch == state.patch).all()
    assert passed.normal[0, 2] < 0.0
    assert passed.kinks.tolist() == [0]
    beside = contact.step(state, np.array([[2.2, 0.0, 0.03]]))
    assert len(beside.kinks) == 0


def test_to_an_edge_and_along_it() -> None:
    contact = contact_of(BOX, 1, shell_thickness=0.4)
    state = contact.start(np.array([[1.0, 1.95, 2.1]]))
    assert state.feature.tolist() == [cg.Feature.FACE]
    over = contact.step(state, np.array([[1.0, 2.05, 2.1]]))
    assert over.feature.tolist() == [cg.Feature.EDGE]
    assert over.kinks.tolist() == [0]
    assert len(contact.step(over, np.array([[1.1, 2.06, 2.1]])).kinks) == 0


@pytest.mark.parametrize("way", [0.02, 0.2])
def test_a_smooth_way_has_none(way: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = contact_of(ball, 40)
    points = np.random.default_rng(0).normal(size=(40, 3))
    points *= 0.7 / np.linalg.norm(points, axis=1)[:, None]
    state = contact.start(points)
    moved = points + way * np.random.default_rng(1).normal(size=points.shape) / np.sqrt(3.0)
    after = contact.step(state, moved)
    assert after.n_contact > 30
    assert len(after.kinks) == 0


def test_a_state_made_by_hand_does_not_know() -> None:
    contact = contact_of(BOX, 1)
    state = contact.start(np.array([[1.0, 1.0, 1.9]]))
    with pytest.raises(InputError, match="step that made it"):
        _ = cg.State(**state.arrays, of=contact).kinks
