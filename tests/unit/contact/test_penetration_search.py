"""Search by penetration: depth, open bodies, points from behind."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus as Is


def _contact(master: cg.Body, n: int = 1, **options: object) -> cg.Contact:
    cloud = cg.Slave(np.zeros((n, 3)), area=np.ones(n))
    law = cg.PenaltyLaw(1.0)
    return cg.Contact(master, cloud, law=law, search="penetration", **options)  # type: ignore[arg-type]


def test_closed_bodies_are_known_from_open_ones() -> None:
    shapes = cg.shapes
    box = cg.Body([shapes.plane()])
    closed = [shapes.sphere(), shapes.torus(), shapes.ellipsoid()]
    opened = [shapes.cylinder(), shapes.disc(), shapes.saddle(), shapes.cone()]
    assert all(cg.Body([patch]).surface.closed for patch in closed)
    assert not any(cg.Body([patch]).surface.closed for patch in opened)
    assert not box.surface.closed


def test_a_closed_body_takes_points_of_any_depth() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    state = _contact(ball).start([[0.0, 1e-3, 0.0]])
    assert state.penetration[0] == pytest.approx(2.0 - 1e-3, abs=1e-12)


def test_an_open_body_reaches_a_tenth_of_its_size() -> None:
    plane = cg.Body([cg.shapes.plane(width=3.0, length=4.0)])
    contact = _contact(plane, 2)
    state = contact.start([[0.0, 0.0, -0.499], [0.0, 0.0, -0.501]])
    assert state.in_contact.tolist() == [True, False]


def test_the_depth_can_be_said() -> None:
    plane = cg.Body([cg.shapes.plane(width=3.0, length=4.0)])
    contact = _contact(plane, 2, depth=1.5)
    state = contact.start([[0.0, 0.0, -1.49], [0.0, 0.0, -1.51]])
    assert state.in_contact.tolist() == [True, False]
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    assert not _contact(ball, depth=0.5).start([[1.0, 0.0, 0.0]]).in_contact[0]


def test_a_point_too_deep_is_taken_as_soon_as_it_is_not() -> None:
    plane = cg.Body([cg.shapes.plane(width=3.0, length=4.0)])
    contact = _contact(plane)
    state = contact.start([[0.0, 0.0, -2.0]])
    for height, status in ((-1.0, Is.FREE), (-0.51, Is.FREE), (-0.49, Is.NEW), (-0.3, Is.OLD)):
        state = contact.step(state, [[0.0, 0.0, height]])
        assert state.status[0] == status


def test_a_point_beside_the_border_is_taken_as_soon_as_it_is_behind_the_face() -> None:
    plane = cg.Body([cg.shapes.plane(width=3.0, length=4.0)])
    contact = _contact(plane)
    state = contact.start([[1.502, 0.0, -0.3]])
    assert state.status[0] == Is.FREE
    state = contact.step(state, [[1.499, 0.0, -0.3]])
    assert state.status[0] == Is.NEW
    assert state.penetration[0] == pytest.approx(0.3, abs=1e-13)


def test_an_old_contact_may_go_deeper_than_a_new_one() -> None:
    plane = cg.Body([cg.shapes.plane(width=3.0, length=4.0)])
    contact = _contact(plane)
    state = contact.start([[0.0, 0.0, -0.4]])
    state = contact.step(state, [[0.0, 0.0, -0.9]])
    assert state.status[0] == Is.OLD
    assert state.penetration[0] == pytest.approx(0.9, abs=1e-13)


@pytest.mark.parametrize("master", ["sphere", "torus", "plane", "saddle"])
def test_random_walks_agree_with_a_fresh_look_at_every_step(master: str) -> None:
    # Convex bodies or shallow points: the followed foot is the closest one.
    body = cg.Body([getattr(cg.shapes, master)()])
    rng = np.random.default_rng(2)
    n = 300
    contact = _contact(body, n, depth=0.2)
    points = rng.uniform(-1.0, 1.0, (n, 3)) * (1.5 if master != "torus" else 2.6)
    state = contact.start(points)
    for _ in range(40):
        points = points + rng.normal(scale=0.03, size=(n, 3))
        state = contact.step(state, points)
        fresh = contact.start(points)
        # A contact once made is kept beyond the depth and over the medial surface.
        missed = fresh.in_contact & ~state.in_contact
        slid = (state.status == Is.SLID_OFF) | (state.status == Is.RELEASED)
        assert not (missed & ~slid).any()
        new = state.status == Is.NEW
        assert fresh.in_contact[new].all()
        np.testing.assert_array_equal(state.penetration[new], fresh.penetration[new])
