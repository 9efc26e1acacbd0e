"""The life of a point in contact, against closed forms at every step."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.records import ContactStatus as Is
from contiga.statuses import Feature

UNIT = cg.PenaltyLaw(1.0)


def _directions(n: int, seed: int = 0) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def _contact(master: cg.Body, points: np.ndarray, **options: object) -> cg.Contact:
    cloud = cg.Slave(points, area=np.ones(len(points)))
    return cg.Contact(master, cloud, law=UNIT, **options)  # type: ignore[arg-type]


def _walk(contact: cg.Contact, path: list[np.ndarray]) -> list[cg.State]:
    states = [contact.start(path[0])]
    for points in path[1:]:
        states.append(contact.step(states[-1], points, dt=0.5))
    return states


def test_in_and_out_and_in_again_through_a_plane() -> None:
    plane = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    heights = [0.3, 0.1, -0.1, -0.3, 0.0, -0.2, 0.2, 0.3, -0.05, -0.05]
    expected = [Is.FREE, Is.FREE, Is.NEW, Is.OLD, Is.OLD, Is.OLD, Is.RELEASED, Is.FREE, Is.NEW]
    expected += [Is.OLD]
    path = [np.array([[0.2, -0.1, h]]) for h in heights]
    for state, points, status in zip(
        _walk(_contact(plane, path[0]), path), path, expected, strict=True
    ):
        depth = max(-points[0, 2], 0.0) if status in (Is.NEW, Is.OLD) else 0.0
        assert state.status.tolist() == [status]
        assert state.penetration[0] == pytest.approx(depth, abs=1e-15)
        assert state.in_contact.tolist() == [status in (Is.NEW, Is.OLD)]
        if status in (Is.NEW, Is.OLD):
            assert state.normal.tolist() == [[0.0, 0.0, 1.0]]
            np.testing.assert_allclose(state.foot, [[0.2, -0.1, 0.0]], rtol=0, atol=1e-15)
            np.testing.assert_allclose(state.force, [[0.0, 0.0, depth]], rtol=0, atol=1e-15)
        else:
            assert (state.patch[0], state.feature[0], state.clusters[0]) == (-1, Feature.NONE, -1)
            np.testing.assert_array_equal(state.foot, points)
            assert not state.force.any()
            assert not state.area.any()


@pytest.mark.parametrize("radius", [1.0, 1e-3, 250.0])
def test_points_into_a_sphere_from_all_sides(radius: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=radius)])
    d = _directions(200)
    far = np.array([1.2, 1.05, 0.95, 0.8, 0.9, 0.99, 1.01, 1.1, 0.97]) * radius
    # A jitter of the start, so that points do not enter along the normal.
    path = [r * d for r in far]
    path[0] = path[0] + 0.05 * radius * _directions(200, 1)
    path[1] = path[1] + 0.02 * radius * _directions(200, 2)
    states = _walk(_contact(ball, path[0]), path)
    counts = [0, 0, 200, 200, 200, 200, 0, 0, 200]
    assert [state.n_contact for state in states] == counts
    for state, r in zip(states, far, strict=True):
        depth = max(radius - r, 0.0)
        np.testing.assert_allclose(state.penetration, depth, rtol=0, atol=1e-12 * radius)
        if depth > 0.0:
            np.testing.assert_allclose(state.normal, d, rtol=0, atol=1e-9)
            np.testing.assert_allclose(state.foot, radius * d, rtol=0, atol=1e-9 * radius)
    assert (states[6].status == Is.RELEASED).all()
    assert (states[7].status == Is.FREE).all()
    assert (states[8].status == Is.NEW).all()


def test_points_into_a_torus_have_the_tubes_depth_and_normal() -> None:
    major, minor = 2.0, 0.5
    ring = cg.Body([cg.shapes.torus(major=major, minor=minor)])
    rng = np.random.default_rng(5)
    around, tube = rng.uniform(0.0, 2.0 * np.pi, (2, 300))
    axis = np.stack([np.cos(around), np.sin(around), np.zeros(300)], axis=1)
    n = np.cos(tube)[:, None] * axis + np.sin(tube)[:, None] * np.array([0.0, 0.0, 1.0])
    radii = [0.7, 0.45, 0.2, 0.05, 0.3, 0.55]
    path = [major * axis + r * n for r in radii]
    states = _walk(_contact(ring, path[0]), path)
    assert [state.n_contact for state in states] == [0, 300, 300, 300, 300, 0]
    for state, r in list(zip(states, radii, strict=True))[1:5]:
        np.testing.assert_allclose(state.penetration, minor - r, rtol=0, atol=1e-11)
        np.testing.assert_allclose(state.normal, n, rtol=0, atol=1e-9)


def test_a_point_that_slides_along_keeps_its_contact_over_the_seam() -> None:
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    angles = np.linspace(-0.3, 4.0 * np.pi + 0.3, 140)
    path = [np.array([[1.1 * np.cos(angles[0]), 1.1 * np.sin(angles[0]), 0.0]])]
    path += [np.array([[0.9 * np.cos(a), 0.9 * np.sin(a), 0.3 * np.sin(a)]]) for a in angles]
    states = _walk(_contact(tube, path[0]), path)
    assert states[1].status[0] == Is.NEW
    for state, a in zip(states[2:], angles[1:], strict=True):
        assert state.status[0] == Is.OLD
        assert state.penetration[0] == pytest.approx(0.1, abs=1e-12)
        np.testing.assert_allclose(state.normal[0], [np.cos(a), np.sin(a), 0.0], atol=1e-11)


def test_a_step_that_only_touches_is_contact_without_depth() -> None:
    plane = cg.Body([cg.shapes.plane()])
    contact = _contact(plane, np.zeros((1, 3)))
    state = contact.step(contact.start([[0.1, 0.1, 0.5]]), [[0.1, 0.1, 0.0]])
    assert state.status[0] in (Is.NEW, Is.FREE)
    assert not state.force.any()
    deeper = contact.step(state, [[0.1, 0.1, -0.25]])
    assert deeper.in_contact.all()
    assert deeper.penetration[0] == pytest.approx(0.25, abs=1e-15)


def test_a_point_that_goes_through_and_back_in_one_step_is_not_in_contact() -> None:
    # Through a torus' tube: in at one side and out at the other, the path ends on the free side.
    ring = cg.Body([cg.shapes.torus(major=2.0, minor=0.5)])
    contact = _contact(ring, np.zeros((1, 3)))
    state = contact.step(contact.start([[2.1, 0.0, 0.6]]), [[2.1, 0.8, -3.0]])
    assert state.status[0] == Is.FREE
    assert not state.total_force.any()


def test_a_point_that_starts_inside_makes_no_force_under_intersection() -> None:
    ball = cg.Body([cg.shapes.sphere()])
    inside = 0.8 * _directions(50)
    contact = _contact(ball, inside)
    path = [inside, 0.7 * _directions(50), 0.9 * _directions(50), 1.2 * _directions(50)]
    path += [0.9 * _directions(50)]
    states = _walk(contact, path)
    for state in states[:-1]:
        assert (state.status == Is.FREE).all()
        assert not state.force.any()
        assert not state.wrench.any()
    # Once outside, it can come in.
    assert (states[-1].status == Is.NEW).all()


def test_the_same_start_is_contact_at_once_under_penetration() -> None:
    ball = cg.Body([cg.shapes.sphere()])
    d = _directions(50)
    radii = [0.8, 0.7, 1.2, 0.9]
    path = [r * d for r in radii]
    states = _walk(_contact(ball, path[0], search="penetration"), path)
    for state, r in zip(states, radii, strict=True):
        np.testing.assert_allclose(state.penetration, max(1.0 - r, 0.0), rtol=0, atol=1e-12)
    statuses = [int(np.unique(state.status)[0]) for state in states]
    assert statuses == [Is.NEW, Is.OLD, Is.RELEASED, Is.NEW]


def test_both_searches_agree_for_points_that_start_outside() -> None:
    ring = cg.Body([cg.shapes.torus()])
    rng = np.random.default_rng(11)
    start = 4.0 * _directions(400)
    path = [start + t * (2.2 * _directions(400, 3) - start) for t in np.linspace(0.0, 1.0, 21)]
    path = [p + 0.01 * rng.normal(size=p.shape) for p in path]
    first = _walk(_contact(ring, path[0]), path)
    second = _walk(_contact(ring, path[0], search="penetration"), path)
    assert max(state.n_contact for state in first) > 20
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.status, b.status)
        np.testing.assert_allclose(a.penetration, b.penetration, rtol=0, atol=1e-11)


def test_the_rate_of_penetration_is_that_of_the_path() -> None:
    # A damper alone: the force is the rate. New: the speed of approach; old: the change of λ.
    plane = cg.Body([cg.shapes.plane()])
    cloud = cg.Slave([[0.0, 0.0, 0.3]])
    damper = cg.PenaltyLaw(1e-300, damping=1.0)
    contact = cg.Contact(plane, cloud, law=damper, area=cg.NodalArea(1.0))
    heights = [0.3, -0.1, -0.15, -0.15, -0.05]
    states = _walk(contact, [np.array([[0.0, 0.0, h]]) for h in heights])
    rates = [state.total_force[2] for state in states]
    np.testing.assert_allclose(rates, [0.0, 0.8, 0.1, 0.0, 0.0], rtol=0, atol=1e-14)
