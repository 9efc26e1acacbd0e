"""What weighs the force: fixed areas at rest, quadrature points, or measured areas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg
from contiga.errors import InputError

BALL = cg.Body([cg.shapes.sphere(radius=2.0)])
LAW = cg.StressLaw(3.0, thickness=0.5)


def _sheet(n: int = 13) -> cg.Slave:
    return cg.Slave(*square_sheet(3.0, n), mass=np.ones(n * n))


SHEET = _sheet()


def _pressed(slave: cg.Slave = SHEET, law: Any = LAW, **options: Any) -> cg.State:
    contact = cg.Contact(BALL, slave, law=law, search="penetration", **options)
    return contact.start(slave.points + np.array([0.01, 0.02, 1.8]))


def test_the_force_on_a_node_is_its_area_at_rest_times_the_pressure() -> None:
    state = _pressed()
    stress = 3.0 * state.penetration / 0.5
    np.testing.assert_allclose(state.normal_force, SHEET.area * stress, rtol=1e-14)
    np.testing.assert_allclose(state.pressure, stress, rtol=1e-13)
    # What is measured is the region's: a disc of radius √(2² − 1.8²).
    assert state.total_area == pytest.approx(np.pi * (4.0 - 1.8**2), rel=0.03)


def test_an_area_given_to_every_node_is_its_weight() -> None:
    state = _pressed(area=cg.NodalArea(0.25))
    np.testing.assert_allclose(state.normal_force, 1.5 * state.penetration, rtol=1e-14)
    assert state.total_area == 0.25 * state.n_contact


def test_measured_areas_weigh_the_force_where_they_are_asked_to() -> None:
    state = _pressed(weights="area")
    np.testing.assert_allclose(state.normal_force, state.area * 6.0 * state.penetration, rtol=1e-13)


def test_a_sheet_of_points_has_weights_and_a_cloud_needs_some() -> None:
    cloud = cg.Slave(SHEET.points)
    state = _pressed(cloud, area=cg.CloudArea())
    # The diagonals of its squares may lie the other way.
    assert state.total_force[2] == pytest.approx(_pressed().total_force[2], rel=0.02)
    for area in (cg.CloudArea(by="feet"), cg.HullArea()):
        with pytest.raises(InputError, match='weights="area"'):
            _pressed(cloud, area=area)
        assert _pressed(cloud, area=area, weights="area").total_force[2] > 0.0
        # A spring on every point needs none.
        spring = _pressed(cloud, cg.PenaltyLaw(6.0), area=area)
        np.testing.assert_allclose(spring.normal_force, 6.0 * spring.penetration, rtol=1e-14)
        assert spring.max_pressure > 0.0


@pytest.mark.parametrize("law", [LAW, cg.ForceLaw(7.0), cg.AdaptiveLaw(0.2)])
@pytest.mark.parametrize("quadrature", [1, 3, 6, 12])
def test_points_on_facets_give_their_forces_to_the_nodes(law: Any, quadrature: int) -> None:
    contact = cg.Contact(BALL, SHEET, law=law, quadrature=quadrature)
    state = contact.start(SHEET.points + np.array([0.0, 0.0, 2.1]))
    state = contact.step(state, SHEET.points + np.array([0.01, 0.02, 1.8]), dt=0.1)
    n, m = len(SHEET), len(SHEET) + quadrature * len(SHEET.facets)
    assert (state.force.shape, state.penetration.shape) == ((n, 3), (m,))
    assert (state.area.shape, state.pressure.shape, state.clusters.shape) == ((n,), (n,), (n,))
    np.testing.assert_array_equal(state.normal_force[:n], 0.0)
    whole = (state.normal_force[:, None] * state.normal).sum(axis=0)
    np.testing.assert_allclose(state.total_force, whole, rtol=1e-12, atol=1e-12 * whole[2])
    np.testing.assert_array_equal(state.wrench[:3], -state.total_force)
    moved = SHEET.points + np.array([0.01, 0.02, 1.8])
    moment = -np.cross(moved - BALL.reference_point, state.force).sum(axis=0)
    np.testing.assert_allclose(state.wrench[3:], moment, atol=1e-12 * whole[2])


def test_pressure_at_a_node_is_the_mean_of_the_points_round_it() -> None:
    nodes, points = _pressed(), _pressed(quadrature=12)
    assert points.max_pressure <= 6.0 * points.max_penetration
    # Nodes whose facets are all in contact.
    inner = nodes.penetration > 0.12
    np.testing.assert_allclose(points.pressure[inner], nodes.pressure[inner], rtol=0.1)
    np.testing.assert_allclose(points.area, nodes.area, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"quadrature": 2}, "quadrature: .*found 2; allowed: 'nodes', 1, 3, 6, 12"),
        ({"quadrature": True}, "quadrature"),
        ({"weights": "none"}, "weights: .*allowed: 'rest', 'area'"),
        ({"quadrature": 3, "weights": "area"}, "weights: quadrature points"),
        ({"quadrature": 3, "area": cg.NodalArea(1.0)}, "area: quadrature points"),
        ({"quadrature": 3, "law": cg.PenaltyLaw(1.0)}, "law: a stiffness per point"),
        ({"quadrature": 3, "slave": cg.Slave([[0.0, 0.0, 0.0]], area=[1.0])}, "quadrature"),
        ({"friction": cg.Coulomb}, "friction: .*Coulomb"),
        ({"friction": 0.3}, "friction: .*Coulomb"),
    ],
)
def test_what_does_not_go_together_is_one_message(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        _pressed(**options)


def test_a_state_of_another_quadrature_or_friction_is_refused() -> None:
    state = _pressed()
    other = cg.Contact(BALL, SHEET, law=LAW, quadrature=3)
    with pytest.raises(InputError, match="another slave or quadrature"):
        other.step(state, SHEET.points)
    rough = cg.Contact(BALL, SHEET, law=LAW, friction=cg.Coulomb(0.1))
    with pytest.raises(InputError, match="another friction"):
        rough.step(state, SHEET.points)


def test_rates_are_exact_where_velocities_are_given() -> None:
    law = cg.StressLaw(3.0, thickness=0.5, damping=2.0)
    contact = cg.Contact(BALL, SHEET, law=law)
    start = contact.start(SHEET.points + np.array([0.0, 0.0, 2.1]))
    moved = SHEET.points + np.array([0.0, 0.0, 1.8])
    v_W, twist = np.tile([0.3, 0.0, -1.0], (len(SHEET), 1)), ([0.1, 0.0, 0.2], [0.0, 0.4, 0.0])
    state = contact.step(start, moved, dt=0.1, velocity=v_W, twist=twist)
    on = state.in_contact
    body = np.array(twist[0]) + np.cross(twist[1], moved[on])
    rate = -((v_W[on] - body) * state.normal[on]).sum(axis=1)
    stress = 6.0 * state.penetration[on] + 2.0 * rate / 0.5
    np.testing.assert_allclose(state.normal_force[on], SHEET.area[on] * stress, rtol=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"twist": ([0, 0, 0], [0, 0, 0])}, "velocity of the slave is not"),
        ({"velocity": np.zeros((169, 3))}, "twist of the master, which moves"),
        ({"velocity": np.zeros((3, 3)), "twist": ([0, 0, 0], [0, 0, 0])}, "one row a slave point"),
        ({"velocity": np.zeros((169, 3)), "twist": ([0, 0], [0, 0, 0])}, "a velocity and a spin"),
        ({"velocity": np.zeros((169, 3)), "twist": 3.0}, "a velocity and a spin"),
        ({"velocity": np.zeros((169, 3)), "twist": ([0, 0, np.nan], [0, 0, 0])}, "and a spin"),
    ],
)
def test_velocities_that_do_not_fit_are_one_message(given: dict[str, Any], said: str) -> None:
    contact = cg.Contact(BALL, SHEET, law=LAW)
    state = contact.start(SHEET.points + np.array([0.0, 0.0, 2.1]))
    pose = cg.motion.pose.translation([0.0, 0.0, 0.1])
    with pytest.raises(InputError, match=said):
        contact.step(state, SHEET.points + np.array([0.0, 0.0, 2.0]), pose, 0.1, **given)
