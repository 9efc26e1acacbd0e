"""Far points are left alone and none is missed; points that are not finite or not active."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga.records import ContactStatus as Is
from contiga.search.exact_surface import ExactSurface

from .pointed import pointed_ball

NAN = float("nan")


def _contact(master: cg.Body, n: int, **options: object) -> cg.Contact:
    active = options.pop("active", None)
    cloud = cg.Slave(np.zeros((n, 3)), area=np.ones(n), active=active)  # type: ignore[arg-type]
    return cg.Contact(master, cloud, law=cg.PenaltyLaw(1.0), **options)  # type: ignore[arg-type]


class _Looked:
    """Counts the rows that are looked at closely."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
        self.rows = 0
        inner = getattr(ExactSurface, name)

        def counted(*args: object) -> object:
            self.rows += len(args[2])  # type: ignore[arg-type]
            return inner(*args)

        monkeypatch.setattr(ExactSurface, name, counted)


@pytest.mark.parametrize("search", ["intersection", *full("penetration")])
def test_far_points_are_not_looked_at(monkeypatch: pytest.MonkeyPatch, search: str) -> None:
    ball = pointed_ball()
    points = np.random.default_rng(0).uniform([-1.0, -1.0, 5.0], [1.0, 1.0, 7.0], (500, 3))
    contact = _contact(ball, 500, search=search)
    state = contact.start(points)
    looked = _Looked(monkeypatch, "closest")
    for k in range(1, 20):
        state = contact.step(state, points - [0.0, 0.0, 0.15 * k])
    assert looked.rows == 0
    for k in range(20, 40):
        state = contact.step(state, points - [0.0, 0.0, 0.15 * k])
    assert looked.rows > 0
    assert state.n_contact > 0


def test_going_round_is_looked_at_again_and_again_but_not_every_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # The way gone is what counts, not the distance: a circle far out uses it up.
    ball = cg.Body([cg.shapes.sphere()])
    contact = _contact(ball, 1, search="penetration")
    angle = np.linspace(0.0, 2.0 * np.pi, 101)
    circle = 3.0 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    state = contact.start(circle[:1])
    closest, looked = _Looked(monkeypatch, "closest"), 0
    for point in circle[1:]:
        last, state = state, contact.step(state, point[None])
        looked += state.safe_distance[0] > last.safe_distance[0]
    # From the box around the ball's cells it is less far than from the ball, 2.
    assert int(6.0 * np.pi / 2.0) <= looked <= int(6.0 * np.pi / 1.0)
    assert closest.rows == 0


@pytest.mark.parametrize("scale", [0.005, 0.05, 0.4])
@pytest.mark.parametrize("search", ["intersection", "penetration"])
def test_random_walks_round_a_ball_agree_with_its_radius_at_every_step(
    search: str, scale: float
) -> None:
    # For a ball both searches have a closed form: inside is |p| < 1, and a point that started
    # outside has come in through the surface.
    ball = cg.Body([cg.shapes.sphere()])
    rng = np.random.default_rng(6)
    d = rng.normal(size=(400, 3))
    points = d / np.linalg.norm(d, axis=1, keepdims=True) * rng.uniform(1.001, 1.6, (400, 1))
    contact = _contact(ball, 400, search=search)
    state = contact.start(points)
    changes = 0
    for _ in range(60):
        points = points + rng.normal(scale=scale, size=(400, 3))
        last, state = state, contact.step(state, points)
        distance = np.linalg.norm(points, axis=1)
        np.testing.assert_array_equal(state.in_contact, distance < 1.0)
        depth = np.maximum(1.0 - distance, 0.0)
        np.testing.assert_allclose(state.penetration, depth, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(state.status == Is.NEW, ~last.in_contact & state.in_contact)
        np.testing.assert_array_equal(
            state.status == Is.RELEASED, last.in_contact & ~state.in_contact
        )
        changes += int((state.in_contact != last.in_contact).sum())
    assert changes > 20


def test_random_walks_of_the_body_are_seen_too() -> None:
    ball = cg.Body([cg.shapes.sphere()])
    rng = np.random.default_rng(7)
    points = rng.uniform(-2.0, 2.0, (300, 3))
    points = points[np.linalg.norm(points, axis=1) > 1.0]
    contact = _contact(ball, len(points))
    X_WB = np.eye(4)
    state = contact.start(points, X_WB)
    for _ in range(60):
        X_WB = X_WB.copy()
        X_WB[:3, 3] += rng.normal(scale=0.05, size=3)
        state = contact.step(state, points, X_WB)
        distance = np.linalg.norm(points - X_WB[:3, 3], axis=1)
        np.testing.assert_array_equal(state.in_contact, distance < 1.0)


def test_a_point_that_is_not_finite_is_marked_and_comes_back() -> None:
    plane = cg.Body([cg.shapes.plane()])
    contact = _contact(plane, 3)
    steps = {
        0.1: [Is.FREE, Is.FREE, Is.FREE],
        -0.1: [Is.NEW, Is.NEW, Is.NEW],
        -0.2: [Is.OLD, Is.NOT_FINITE, Is.OLD],
        # Back inside: under intersection no path of it has entered.
        -0.15: [Is.OLD, Is.FREE, Is.OLD],
        0.2: [Is.RELEASED, Is.FREE, Is.RELEASED],
        -0.3: [Is.NEW, Is.NEW, Is.NEW],
    }
    state = contact.start([[0.0, 0.0, 0.3], [0.1, 0.0, 0.3], [0.2, 0.0, 0.3]])
    for height, expected in steps.items():
        points = np.array([[x, 0.0, height] for x in (0.0, 0.1, 0.2)])
        if height == -0.2:
            points[1] = [0.1, NAN, np.inf]
        state = contact.step(state, points)
        assert state.status.tolist() == expected
        assert np.isfinite(state.total_force).all()
        assert np.isfinite(state.wrench).all()
        assert np.isfinite(state.penetration).all()


def test_a_point_that_comes_back_inside_is_contact_under_penetration() -> None:
    ball = cg.Body([cg.shapes.sphere()])
    contact = _contact(ball, 1, search="penetration")
    state = contact.start([[NAN, 0.0, 0.0]])
    assert state.status[0] == Is.NOT_FINITE
    state = contact.step(state, [[0.9, 0.0, 0.0]])
    assert state.status[0] == Is.NEW
    state = contact.step(state, [[0.0, 0.0, np.inf]])
    assert state.status[0] == Is.NOT_FINITE
    state = contact.step(state, [[0.0, 0.8, 0.0]])
    assert state.status[0] == Is.NEW
    assert state.penetration[0] == pytest.approx(0.2, abs=1e-14)


@pytest.mark.parametrize("search", ["intersection", "penetration"])
def test_points_that_are_not_active_take_no_part(search: str) -> None:
    ball = cg.Body([cg.shapes.sphere()])
    active = np.array([True, False, True, False])
    contact = _contact(ball, 4, active=active, search=search)
    d = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    state = contact.start(1.1 * d)
    for r in (0.9, 0.8, 1.2, 0.7):
        state = contact.step(state, r * d)
        assert state.in_contact.tolist() == (active & (r < 1.0)).tolist()
    assert (
        contact.start(0.5 * d).in_contact.tolist() == (active & (search == "penetration")).tolist()
    )


def test_a_slave_without_active_points_runs() -> None:
    contact = _contact(cg.Body([cg.shapes.sphere()]), 2, active=np.zeros(2, bool))
    state = contact.step(contact.start([[2.0, 0, 0], [0, 2.0, 0]]), [[0.5, 0, 0], [0, 0.5, 0]])
    assert state.n_contact == 0
