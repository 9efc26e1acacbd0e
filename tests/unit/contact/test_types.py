"""Contact types slave, master and combined, and what laws make of them."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

PLATE = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])


def _pressed(contact: cg.Contact, points: np.ndarray, depth: np.ndarray) -> cg.State:
    state = contact.start(points + depth)
    return contact.step(state, points, dt=1.0)


def _shell(radius: float, n: int = 60) -> np.ndarray:
    d = np.random.default_rng(0).normal(size=(n, 3))
    return radius * d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("depth", [1e-6, 0.1, 0.6])
def test_type_master_carries_areas_to_the_master_on_concentric_spheres(depth: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    inner = _shell(2.0 - depth)
    areas = np.linspace(0.1, 0.3, len(inner))
    cloud = cg.Slave(inner, area=areas)
    law = cg.StressLaw(3.0, thickness=0.5)
    actual = {}
    for kind in ("slave", "master"):
        contact = cg.Contact(ball, cloud, law=law, contact_type=kind, weights="area")
        actual[kind] = contact.step(contact.start(1.1 * 2.0 / (2.0 - depth) * inner), inner)
    stress = 3.0 * depth / 0.5
    ratio = (2.0 / (2.0 - depth)) ** 2
    np.testing.assert_allclose(actual["slave"].area, areas, rtol=1e-15)
    np.testing.assert_allclose(actual["master"].area, areas * ratio, rtol=1e-10)
    for kind, state in actual.items():
        force = np.linalg.norm(state.force, axis=1)
        np.testing.assert_allclose(force, stress * state.area, rtol=1e-8, err_msg=kind)
        np.testing.assert_allclose(state.pressure, stress, rtol=1e-8)
    at_rest = cg.Contact(ball, cloud, law=law, contact_type="master")
    state = at_rest.step(at_rest.start(1.1 * 2.0 / (2.0 - depth) * inner), inner)
    np.testing.assert_allclose(np.linalg.norm(state.force, axis=1), stress * areas, rtol=1e-8)
    np.testing.assert_allclose(state.area, areas * ratio, rtol=1e-10)
    np.testing.assert_allclose(state.pressure, stress, rtol=1e-8)


def test_type_master_carries_areas_to_the_master_on_parallel_cylinders() -> None:
    tube = cg.Body([cg.shapes.cylinder(radius=1.5, height=4.0)])
    angle = np.linspace(0.1, 6.0, 30)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(30)], axis=1)
    cloud = cg.Slave(1.2 * ring, area=np.full(30, 0.2))
    contact = cg.Contact(tube, cloud, law=cg.PenaltyLaw(1.0), contact_type="master")
    state = contact.step(contact.start(1.6 * ring), 1.2 * ring)
    np.testing.assert_allclose(state.area, 0.2 * 1.5 / 1.2, rtol=1e-12)


def test_type_combined_is_two_springs_in_series() -> None:
    points = np.array([[0.0, 0.0, -0.1], [0.5, 0.5, -0.3], [-1.0, 0.2, -0.2]])
    area = np.array([0.5, 1.0, 2.0])
    cloud = cg.Slave(points, area=area, thickness=[0.2, 0.2, 0.2])
    law, master_law = cg.StressLaw(4.0), cg.StressLaw(1.0, thickness=0.4)
    contact = cg.Contact(PLATE, cloud, law=law, master_law=master_law, contact_type="combined")
    state = _pressed(contact, points, np.array([0.0, 0.0, 1.0]))
    stiffness = 1.0 / (0.2 / 4.0 + 0.4 / 1.0)
    expected = stiffness * area * np.array([0.1, 0.3, 0.2])
    np.testing.assert_allclose(state.force[:, 2], expected, rtol=1e-12)


def test_a_combined_contact_with_a_rigid_like_master_is_one_of_the_slave() -> None:
    points = np.array([[0.0, 0.0, -0.1]])
    cloud = cg.Slave(points, area=[1.0])
    law = cg.StressLaw([[0, 0], [0.1, 1.0], [1.0, 2.0]], thickness=0.5)
    stiff = cg.StressLaw(1e12, thickness=0.5)
    both = cg.Contact(PLATE, cloud, law=law, master_law=stiff, contact_type="combined")
    alone = cg.Contact(PLATE, cloud, law=law)
    up = np.array([0.0, 0.0, 1.0])
    expected = _pressed(alone, points, up).total_force
    np.testing.assert_allclose(_pressed(both, points, up).total_force, expected, rtol=1e-9)


def test_the_force_law_shares_its_total_by_penetration_and_area() -> None:
    points = np.array([[0.0, 0.0, -0.1], [0.5, 0.5, -0.3], [-1.0, 0.2, 0.2]])
    area = np.array([0.5, 1.0, 2.0])
    law = cg.ForceLaw(2.0, share="penetration")
    contact = cg.Contact(PLATE, cg.Slave(points, area=area), law=law)
    state = _pressed(contact, points, np.array([0.0, 0.0, 1.0]))
    expected = 2.0 * 0.3 * np.array([0.05, 0.3, 0.0]) / 0.35
    np.testing.assert_allclose(state.force[:, 2], expected, rtol=1e-13)


@pytest.mark.parametrize("law", [cg.ForceLaw(2.0), cg.PenaltyLaw(2.0), cg.StressLaw(2.0, 0.1)])
def test_no_one_and_flat_contacts_are_defined(law: object) -> None:
    points = np.array([[0.0, 0.0, 0.1], [0.5, 0.5, 0.1]])
    contact = cg.Contact(PLATE, cg.Slave(points, area=[1.0, 1.0]), law=law)  # type: ignore[arg-type]
    state = contact.start(points)
    assert state.n_contact == 0
    assert not state.total_force.any()
    assert state.n_clusters == 0
    one = contact.step(state, [[0.0, 0.0, -0.1], [0.5, 0.5, 0.1]])
    assert one.n_contact == one.n_clusters == 1
    scale = 20.0 if isinstance(law, cg.StressLaw) else 2.0
    np.testing.assert_allclose(one.total_force, [0.0, 0.0, scale * 0.1], rtol=1e-12, atol=1e-15)
    flat = contact.step(one, [[0.0, 0.0, 0.0], [0.5, 0.5, 0.1]])
    assert flat.n_contact == 1
    assert flat.max_penetration == 0.0
    assert not flat.total_force.any()


def test_no_areas_at_all_still_share_a_total_force() -> None:
    points = np.array([[0.0, 0.0, -0.1], [0.5, 0.5, -0.3]])
    law = cg.ForceLaw(2.0, share="penetration")
    contact = cg.Contact(PLATE, cg.Slave(points, area=[0.0, 0.0]), law=law)
    state = _pressed(contact, points, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(state.force[:, 2], 0.6 * np.array([0.25, 0.75]), rtol=1e-13)
    assert not state.pressure.any()


def test_adaptive_stiffness_follows_mass_and_step() -> None:
    points = np.array([[0.0, 0.0, -0.1], [0.5, 0.5, -0.1]])
    cloud = cg.Slave(points, area=[1.0, 1.0], mass=[2.0, 6.0])
    contact = cg.Contact(PLATE, cloud, law=cg.AdaptiveLaw(0.5))
    state = contact.start(points + np.array([0.0, 0.0, 1.0]))
    state = contact.step(state, points, dt=0.1)
    np.testing.assert_allclose(state.force[:, 2], 0.5 * np.array([2.0, 6.0]) / 0.01 * 0.1)


def test_nodal_values_follow_their_points() -> None:
    # Only one of three points is in contact, with its own area, thickness and mass.
    points = np.array([[0.0, 0.0, 0.5], [0.5, 0.5, -0.2], [1.0, 1.0, 0.5]])
    cloud = cg.Slave(points, area=[1.0, 3.0, 5.0], thickness=[0.1, 0.4, 0.2])
    contact = cg.Contact(PLATE, cloud, law=cg.StressLaw(2.0))
    state = _pressed(contact, points, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(state.force[:, 2], [0.0, 3.0 * 2.0 * 0.5, 0.0], rtol=1e-13)
