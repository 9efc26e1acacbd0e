"""On a closed body the side of every point is known at every step, whatever crossings were seen."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus as Is
from contiga.search.exact_surface import ExactSurface

BALL = cg.Body([cg.shapes.sphere()])


def _contact(points: np.ndarray, master: cg.Body = BALL, **options: object) -> cg.Contact:
    slave = cg.Slave(points, area=np.ones(len(points)))
    return cg.Contact(master, slave, law=cg.PenaltyLaw(1.0), **options)  # type: ignore[arg-type]


def _blind(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that sees no crossing at all."""
    inner = ExactSurface.last_crossings

    def none(self: ExactSurface, a: np.ndarray, b: np.ndarray, rows: np.ndarray) -> object:
        hits, sense = inner(self, a, b, rows)
        return hits, np.zeros_like(sense)

    monkeypatch.setattr(ExactSurface, "last_crossings", none)


@pytest.mark.parametrize("step", [1e-9, 1e-4, 0.1, 1.0])
def test_a_point_that_came_in_unseen_is_found(monkeypatch: pytest.MonkeyPatch, step: float) -> None:
    outside = np.array([[0.0, 0.6, 0.8]]) * (1.0 + 0.5 * step)
    contact = _contact(outside)
    state = contact.start(outside)
    _blind(monkeypatch)
    inside = np.array([[0.0, 0.6, 0.8]]) * (1.0 - 0.5 * step)
    state = contact.step(state, inside)
    assert state.status[0] == Is.FOUND
    assert state.penetration[0] == pytest.approx(0.5 * step, rel=1e-3)
    assert state.in_contact[0]
    assert contact.step(state, inside).status[0] == Is.OLD


def test_points_inside_at_the_start_wait_until_they_have_been_outside() -> None:
    heights = [0.5, 0.7, 0.95, 0.2, 1.2, 0.9]
    path = np.array([[[0.1, 0.0, z]] for z in heights])
    contact = _contact(path[0])
    states = [contact.start(path[0])]
    for points in path[1:]:
        states.append(contact.step(states[-1], points))
    assert [int(s.status[0]) for s in states] == [Is.FREE] * 5 + [Is.NEW]
    assert [bool(s.safe_distance[0] < 0.0) for s in states] == [True] * 4 + [False] * 2


def test_out_and_in_again_within_a_step_is_coming_in() -> None:
    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.3)])
    start, end = np.array([[1.0, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.2]])
    contact = _contact(start, ring)
    state = contact.step(contact.start(start), end)
    assert state.status[0] == Is.NEW
    assert state.penetration[0] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("outward", [True, False])
def test_the_side_at_the_start_is_that_of_the_closest_point(outward: bool) -> None:
    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.3)])
    ring = ring if outward else ring.flipped()
    points = np.random.default_rng(3).uniform(-1.6, 1.6, (3000, 3))
    points = points[np.abs(ring.project(points).gap) > 1e-6]
    state = _contact(points, ring).start(points)
    np.testing.assert_array_equal(state.safe_distance < 0.0, ring.contains(points))
    assert (np.abs(state.safe_distance) <= np.abs(ring.project(points).gap) + 1e-12).all()
    taken = _contact(points, ring, search="penetration").start(points)
    np.testing.assert_array_equal(taken.in_contact, ring.contains(points))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_free_points_are_proved_to_be_so_by_their_feet(
    monkeypatch: pytest.MonkeyPatch, side: float
) -> None:
    rng = np.random.default_rng(4)
    d = rng.normal(size=(200, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    contact = _contact(d)
    state = contact.step(contact.start((1.0 + 0.01 * side) * d), (1.0 + 0.005 * side) * d)
    asked = 0
    inner = ExactSurface.closest

    def counted(self: ExactSurface, p: np.ndarray, rows: np.ndarray, *rest: object) -> None:
        nonlocal asked
        asked += len(rows)
        inner(self, p, rows, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(ExactSurface, "closest", counted)
    for k in range(20):
        turned = cg.motion.pose.rotation("z", 0.05 * k)[:3, :3]
        height = side * (0.005 + 0.004 * np.sin(k))
        state = contact.step(state, (1.0 + height) * d @ turned.T)
        np.testing.assert_array_equal(state.status, Is.FREE)
    if side > 0.0:
        assert asked <= 0.03 * 20 * len(d)  # no ball is known in the last cells beside the poles
