"""Points that enter a closed body by one side and leave it by another are out of contact."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus as Is

UNIT = cg.PenaltyLaw(1.0)


def _disc(kind: str) -> cg.Body | cg.TriMesh:
    """A flat ellipsoid, half a unit thick in the middle, exact or of triangles."""
    body = cg.Body([cg.shapes.ellipsoid(axes=(2.0, 2.0, 0.25))])
    return body if kind == "exact" else body.tessellate(1e-3)


def _walk(master: cg.Body | cg.TriMesh, path: np.ndarray, **options: object) -> list[cg.State]:
    """One point along `path` (k, 3)."""
    slave = cg.Slave(path[:1], area=[1.0])
    contact = cg.Contact(master, slave, law=UNIT, **options)  # type: ignore[arg-type]
    states = [contact.start(path[:1])]
    for point in path[1:]:
        states.append(contact.step(states[-1], point[None, :]))
    return states


def _down(heights: list[float], x: float = 0.3) -> np.ndarray:
    return np.array([[x, 0.1, z] for z in heights])


@pytest.mark.parametrize("kind", ["exact", "mesh"])
def test_a_point_that_comes_out_below_is_released(kind: str) -> None:
    path = _down([0.4, 0.2, 0.0, -0.2, -0.3, -0.6, 0.0])
    states = _walk(_disc(kind), path)
    expected = [Is.FREE, Is.NEW, Is.OLD, Is.OLD, Is.RELEASED, Is.FREE, Is.NEW]
    assert [int(state.status[0]) for state in states] == expected
    # Inside, the foot stays with the side the point came in by; then with the other.
    assert [float(np.sign(state.normal[0, 2])) for state in states] == [0, 1, 1, 1, 0, 0, -1]
    assert not states[4].force.any()
    assert states[3].penetration[0] == pytest.approx(0.445, abs=5e-3)


@pytest.mark.parametrize("kind", ["exact", "mesh"])
def test_a_step_right_through_is_no_contact(kind: str) -> None:
    states = _walk(_disc(kind), _down([0.4, -0.4, 0.4, 0.1]))
    assert [int(state.status[0]) for state in states] == [Is.FREE, Is.FREE, Is.FREE, Is.NEW]


def test_a_point_that_starts_inside_is_released_below() -> None:
    states = _walk(_disc("exact"), _down([0.1, -0.1, -0.4]), search="penetration")
    assert [int(state.status[0]) for state in states] == [Is.NEW, Is.OLD, Is.RELEASED]


def test_a_step_across_a_dent_ends_inside_and_is_contact() -> None:
    """Round the hole of a ring: the straight way leaves the body and comes in again."""
    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.4)])
    turned = [np.array([0.65 * np.cos(a), 0.65 * np.sin(a), 0.0]) for a in (0.0, 0.9)]
    path = np.array([[0.5, 0.0, 0.0], *turned])
    assert ring.contains(path).tolist() == [False, True, True]
    assert not ring.contains(path[1:].mean(axis=0))[0]
    states = _walk(ring, path)
    assert [int(state.status[0]) for state in states] == [Is.FREE, Is.NEW, Is.OLD]
    assert states[2].penetration[0] == pytest.approx(0.05, abs=1e-12)


def test_small_steps_deep_inside_are_followed_to_the_other_side() -> None:
    heights = np.linspace(0.26, -0.26, 521).tolist()
    states = _walk(_disc("exact"), _down(heights, x=0.0))
    inside = [abs(z) < 0.2497 for z in heights]  # at x, y = 0, 0.1 the disc is 0.24969 thick
    np.testing.assert_array_equal([state.n_contact == 1 for state in states], inside)
    # Deep points have a way to go before they are looked at again.
    assert max(float(state.safe_distance[0]) for state in states if state.n_contact) > 0.1


@pytest.mark.full
def test_random_walks_are_in_contact_where_they_are_inside() -> None:
    """A thin body, often gone through; truth is the closest point."""
    blade = cg.Body([cg.shapes.ellipsoid(axes=(2.0, 1.0, 0.1))])
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-2.0, 2.0, (400, 2)), rng.uniform(0.15, 0.4, 400)])
    contact = cg.Contact(blade, cg.Slave(points, area=np.ones(400)), law=UNIT)
    state = contact.start(points)
    through = 0
    for _ in range(60):
        points = points + rng.normal(0.0, 0.06, points.shape) - 0.3 * points * [0.0, 0.0, 0.2]
        before = state
        state = contact.step(state, points)
        np.testing.assert_array_equal(state.in_contact, blade.contains(points))
        up, down = before.normal[:, 2] > 0.0, points[:, 2] < 0.0
        through += int((up & down & (state.status == Is.RELEASED)).sum())
    assert through > 50
