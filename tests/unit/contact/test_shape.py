"""Contact with masters whose control points another solver moves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.geometry.test_net import bent

import contiga as cg
from contiga.contact.shape import shape_of
from contiga.errors import InputError

HALF = 0.1


def plate(knots: int = 4) -> cg.Body:
    """A plate of 4 by 4 at z = 0, of degree 2, free side up."""
    inner = list(np.linspace(0.0, 1.0, knots + 2)[1:-1])
    return cg.Body([cg.shapes.plane(width=4.0, length=4.0).k_refined((1, 1), inner, inner)])


def cloud(n: int = 60, height: float = 0.05) -> np.ndarray:
    rng = np.random.default_rng(6)
    return np.column_stack([rng.uniform(-1.5, 1.5, (n, 2)), rng.uniform(0.0, 2.0 * height, n)])


def contact_of(master: Any, points: np.ndarray, **options: Any) -> cg.Contact:
    slave = cg.Slave(points, area=np.full(len(points), 0.5))
    options = {"law": cg.PenaltyLaw(100.0), "shell_thickness": 2.0 * HALF} | options
    return cg.Contact(master, slave, **options)


def up(height: float) -> np.ndarray:
    return np.array([0.0, 0.0, height])


def turn(angle: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(angle).as_matrix()


FRICTION = {"none": None, "coulomb": cg.Coulomb(0.3), "viscous": cg.ViscousFriction(0.5, 0.1)}


@pytest.mark.parametrize("friction", FRICTION)
def test_control_points_that_move_as_a_whole_are_a_body_that_moves(friction: str) -> None:
    """The points stand; the plate comes up, turning. Damping and friction see its velocities."""
    body, points = plate(), cloud()
    options = {"law": cg.PenaltyLaw(100.0, damping=2.0), "friction": FRICTION[friction]}
    rigid, shaped = contact_of(body, points, **options), contact_of(body, points, **options)
    one, other = rigid.start(points + up(0.2)), shaped.start(points + up(0.2))
    for k in range(1, 7):
        R, t = turn(np.array([0.002, 0.001, 0.02]) * k), np.array([0.02 * k, 0.0, 0.05 * k])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = R, t
        here = points + up(0.2)
        one = rigid.step(one, here, pose, dt=0.1)
        other = shaped.step(other, here, dt=0.1, control_points=body.net.points @ R.T + t)
        np.testing.assert_array_equal(one.status, other.status)
        np.testing.assert_allclose(other.penetration, one.penetration, rtol=0, atol=1e-13)
        # Paths are straight in the axes of each, so ways along the surface differ by the turn.
        scale = np.abs(one.force).max()
        loose = 1e-3 if friction == "none" else 0.03
        np.testing.assert_allclose(other.force, one.force, rtol=0, atol=loose * scale)
    assert one.n_contact > 20
    assert other.energy.work == pytest.approx(one.energy.work, rel=5e-3)


@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("quadrature", ["nodes", 3])
def test_forces_and_moments_balance_and_the_ledger_is_what_both_sides_do(
    friction: str, quadrature: str | int
) -> None:
    body, points = plate(), cg.clouds.sample(cg.shapes.plane(width=3.0, length=3.0), 9, 9)
    i = np.arange(81).reshape(9, 9)
    corners = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    slave = cg.Slave(points, np.stack(corners, axis=-1).reshape(-1, 4))
    contact = cg.Contact(
        body,
        slave,
        law=cg.StressLaw(100.0, thickness=1.0),
        shell_thickness=2.0 * HALF,
        friction=FRICTION[friction],
        quadrature=quadrature,
    )
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = turn(np.array([0.1, 0.2, 0.3])), [5.0, 1.0, -2.0]

    def world(p: np.ndarray) -> np.ndarray:
        return p @ X[:3, :3].T + X[:3, 3]

    high = world(points + up(0.2))
    last = contact.start(high, X, control_points=body.net.points)
    rest, net = body.net.points, body.net.points.copy()
    x, work = high, 0.0
    for k in range(1, 13):
        net = rest.copy()
        net[:, 2] += 0.02 * k * np.cos(rest[:, 0]) * np.cos(0.7 * rest[:, 1])
        net[:, 0] += 0.01 * k * (1.0 + 0.2 * rest[:, 1])
        there = world(points + up(0.2 - 0.005 * k) + [[0.0, 0.004 * k, 0.0]])
        state = contact.step(last, there, X, dt=0.1, control_points=net)
        both = state.force.sum(axis=0) + state.control_force.sum(axis=0)
        scale = np.abs(state.force).sum() + 1e-300
        assert np.abs(both).max() <= 1e-13 * scale
        arms = np.cross(there, state.force).sum(axis=0)
        arms += np.cross(world(net), state.control_force).sum(axis=0)
        assert np.abs(arms).max() <= 1e-12 * scale
        work -= 0.5 * ((last.force + state.force) * (there - x)).sum()
        moved = (net - (last.control_points)) @ X[:3, :3].T
        work -= 0.5 * ((last.control_force + state.control_force) * moved).sum()
        assert state.energy.work == pytest.approx(work, rel=1e-12, abs=1e-14)
        x, last = there, state
    assert state.n_contact > 10
    if friction != "none":
        assert np.abs(state.traction_B).max() > 1e-3
        assert state.energy.friction + state.energy.stored > 0.0


def test_energy_is_what_went_in_to_second_order() -> None:
    """A plate that is driven against points that stand: what it does is stored or rubbed off."""
    body, points = plate(), cloud()
    errors = []
    for n in (20, 40, 80):
        contact = contact_of(body, points, friction=cg.ViscousFriction(0.3, 0.1))
        here = points + up(0.2)
        state = contact.start(here, control_points=body.net.points)
        for k in range(1, n + 1):
            net, t = body.net.points.copy(), k / n
            net[:, 2] += 0.4 * t * t * np.cos(0.5 * net[:, 0] + t)
            net[:, :2] *= 1.0 + 0.05 * t
            state = contact.step(state, here, dt=1.0 / n, control_points=net)
        errors.append(abs(state.energy.error) / state.energy.work)
    assert errors[0] < 0.02
    assert errors[2] < errors[0] / 8.0


def test_points_that_stand_are_met_by_a_shape_that_comes_from_afar() -> None:
    """Safe distances shrink by how far the shape comes, or points would be missed."""
    body, points = plate(), cloud()
    here = points + up(1.0)
    contact = contact_of(body, points)
    state = contact.start(here, control_points=body.net.points)
    for k in range(1, 201):
        net = body.net.points.copy()
        net[:, 2] += 0.005 * k + 0.002 * k * np.cos(net[:, 0])
        state = contact.step(state, here, dt=1.0, control_points=net)
    cold = contact_of(body, points, search="penetration").start(here, control_points=net)
    assert cold.n_contact == len(points)
    np.testing.assert_allclose(state.penetration, cold.penetration, rtol=0, atol=1e-12)
    assert state.n_unproved == 0


def test_a_shape_that_is_not_told_again_stays() -> None:
    body, points = plate(), cloud()
    contact = contact_of(body, points, search="penetration")
    net = bent(body, by=0.01)
    first = contact.start(points, control_points=net)
    told = contact.step(first, points, dt=1.0, control_points=net)
    untold = contact.step(first, points, dt=1.0)
    for name, array in told.arrays.items():
        np.testing.assert_array_equal(array, untold.arrays[name], err_msg=name)
    np.testing.assert_array_equal(untold.control_points, net)
    net += 1.0  # whose array it was does not matter
    assert not np.array_equal(untold.control_points, net)


def test_a_body_that_keeps_its_shape_has_no_control_forces() -> None:
    body, points = plate(), cloud()
    contact = contact_of(body, points, search="penetration")
    state = contact.step(contact.start(points), points, dt=1.0)
    assert state.control_points.shape == state.control_force.shape == (0, 3)


def test_the_first_shape_told_is_compared_with_that_at_rest() -> None:
    body, points = plate(), cloud()
    here = points + up(1.0)
    contact = contact_of(body, points)
    state = contact.start(here)
    state = contact.step(state, here, dt=1.0, control_points=body.net.points + up(0.5))
    state = contact.step(state, here, dt=1.0, control_points=body.net.points + up(1.0))
    assert state.n_contact == len(points)


def test_a_state_of_arrays_goes_on_with_the_same_bits_and_takes_no_harm() -> None:
    body, points = plate(), cloud()
    contact = contact_of(body, points, search="penetration", friction=cg.Coulomb(0.2))
    state = contact.start(points, control_points=bent(body, 1, 0.002))
    state = contact.step(state, points, dt=0.1, control_points=bent(body, 2, 0.002))
    before = {name: array.copy() for name, array in state.arrays.items()}
    again = cg.State(**before, of=contact)
    spare = contact.start(points, control_points=body.net.points)
    net = bent(body, 3, 0.002)
    one = contact.step(state, points, dt=0.1, control_points=net)
    other = contact.step(again, points, dt=0.1, control_points=net, out=spare)
    for name, array in one.arrays.items():
        np.testing.assert_array_equal(array, other.arrays[name], err_msg=name)
    for name, array in state.arrays.items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


def test_velocities_that_are_given_are_those_against_the_surface() -> None:
    """Points that ride along with a plate feel no damping and no friction."""
    body, points = plate(), cloud()
    law = cg.PenaltyLaw(100.0, damping=5.0)
    contact = contact_of(
        body, points, law=law, friction=cg.ViscousFriction(1.0, 0.1), search="penetration"
    )
    spin, speed = np.array([0.1, 0.2, -0.3]), np.array([1.0, 2.0, 3.0])
    net = body.net.points
    state = contact.start(points, control_points=net)
    there = {
        "velocity": np.cross(spin, points) + speed,
        "twist": (np.zeros(3), np.zeros(3)),
        "control_velocity": np.cross(spin, net) + speed,
    }
    rides = contact.step(state, points, dt=0.1, control_points=net, **there)
    stands = contact.step(state, points, dt=0.1)
    assert rides.n_contact == len(points)
    np.testing.assert_allclose(rides.force, stands.force, rtol=0, atol=1e-10)
    pulled = there | {"control_velocity": np.cross(spin, net)}
    pulled = contact.step(state, points, dt=0.1, control_points=net, **pulled)
    assert np.abs(pulled.force - stands.force).max() > 1.0


def test_the_tangent_is_that_of_the_shape() -> None:
    body, points = plate(), cloud()
    contact = contact_of(body, points, search="penetration")
    net = bent(body, 4, 0.01)
    start = contact.start(points, control_points=net)
    state = contact.step(start, points, dt=0)
    matrix, h = contact.tangent(state).toarray(), 1e-6
    push = np.random.default_rng(0).standard_normal(points.shape)
    ahead, behind = (contact.step(start, points + s * h * push, dt=0).force for s in (1.0, -1.0))
    central = ((ahead - behind) / (2.0 * h)).ravel()
    np.testing.assert_allclose(matrix @ push.ravel(), central, rtol=0, atol=1e-4)


def test_a_closed_shape_that_breathes_pushes_out_what_it_takes_in() -> None:
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    rng = np.random.default_rng(2)
    way = rng.standard_normal((200, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    points = way * rng.uniform(1.15, 1.6, (200, 1))
    contact = contact_of(body, points)
    state = contact.start(points, control_points=body.net.points)
    for size in (1.05, 1.2, 1.3, 1.45, 1.3, 1.1, 1.0):
        state = contact.step(state, points, dt=1.0, control_points=body.net.points * size)
        depth = np.maximum(HALF - (np.linalg.norm(points, axis=1) - size), 0.0)
        np.testing.assert_allclose(state.penetration, depth, rtol=0, atol=1e-12)
    assert state.n_contact == 0


@pytest.mark.parametrize(
    ("master", "options", "told"),
    [
        (plate(), {"foot": "tracked"}, "feet are not followed over a surface that changes"),
        (plate(), {"through": "hold"}, 'allowed: foot="nearest" and through="release"'),
        (plate().tessellate(0.1), {}, "a mesh has no control points"),
    ],
)
def test_masters_that_cannot_change_their_shape_are_refused(
    master: Any, options: dict[str, Any], told: str
) -> None:
    points = cloud()
    contact = contact_of(master, points, shell_thickness=None, **options)
    with pytest.raises(InputError, match=told):
        contact.start(points, control_points=np.zeros((4, 3)))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"control_points": np.zeros((5, 3))}, "one row a control point.*body.net.control"),
        ({"control_points": np.full((49, 3), np.inf)}, r"control_points\[0\].*finite"),
        ({"control_velocity": np.zeros((36, 3))}, "control_points: the velocity of control"),
        (
            {"control_points": plate().net.points, "velocity": np.zeros((60, 3))},
            "control_velocity: goes with the velocity",
        ),
        (
            {
                "control_points": plate().net.points,
                "velocity": np.zeros((60, 3)),
                "control_velocity": np.zeros((4, 3)),
            },
            "control_velocity: must have one row a control point",
        ),
    ],
)
def test_arrays_that_do_not_fit_are_refused(options: dict[str, Any], told: str) -> None:
    points = cloud()
    contact = contact_of(plate(), points)
    with pytest.raises(InputError, match=told):
        contact.step(contact.start(points), points, dt=1.0, **options)


def test_a_state_of_another_shape_is_refused() -> None:
    points = cloud()
    one, other = contact_of(plate(3), points), contact_of(plate(4), points)
    state = one.start(points, control_points=plate(3).net.points)
    with pytest.raises(InputError, match="belongs to another master"):
        other.step(cg.State(**state.arrays), points, dt=1.0, control_points=plate(4).net.points)


def test_safe_distances_do_not_shrink_with_a_rigid_motion() -> None:
    """The shell flies, turns and is bent, the points fly and turn with it."""
    body, rng = plate(), np.random.default_rng(8)
    points = rng.uniform([-3.0, -3.0, -1.5], [3.0, 3.0, 1.5], (80, 3))
    contact = contact_of(body, points, search="penetration", on_edge="hold", depth=HALF)
    shape = body.net.points
    state = contact.start(points, control_points=shape)
    for _ in range(10):
        last, before, held = state, shape, state.in_contact
        R, t = turn(rng.normal(scale=0.02, size=3)), rng.normal(size=3)
        bump = 1e-3 * rng.normal(size=shape.shape)
        points, shape = points @ R.T + t, (before + bump) @ R.T + t
        state = contact.step(state, points, dt=0.1, control_points=shape)
        free = ~held & ~state.in_contact
        assert (state.safe_distance[free] > last.safe_distance[free] - 0.02).all()
        surface = cg.NurbsSurface(
            body.patches[0].degrees, body.patches[0].knots, shape[body.net.control[0]]
        )
        true = np.abs(cg.Body([surface]).project(points).gap)
        assert (state.safe_distance[free] <= np.abs(true[free] - HALF) + 1e-9).all()
    assert free.sum() > 40


def test_no_point_of_a_surface_leaves_its_rigid_motion_by_more_than_is_said() -> None:
    body, rng = cg.Body([cg.shapes.sphere(radius=1.0)]), np.random.default_rng(9)
    patch, rest, uv = body.patches[0], body.net.points, rng.random((400, 2))
    low, high = np.transpose(patch.domain)
    uv = low + uv * (high - low)
    for angle, by in ((0.0, 0.1), (1e-3, 0.0), (0.3, 0.0), (0.3, 0.1), (2.8, 0.3)):
        before = bent(body, 3, by)
        now = bent(body, 4, by) @ turn(angle * np.array([0.6, 0.0, 0.8])).T + up(3.0)
        shape = shape_of(body, False, now, before)
        R = shape.rigid[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-14)
        assert np.trace(R) >= 1.0 - 1e-12  # by 90° at most
        places = [
            cg.NurbsSurface(
                patch.degrees, patch.knots, net[body.net.control[0]], patch.weights
            ).evaluate(uv)
            for net in (before, now)
        ]
        off = places[1] - cg.motion.pose.apply(shape.rigid, places[0])
        assert np.linalg.norm(off, axis=1).max() <= shape.travel
        bend = np.linalg.norm(bent(body, 4, by) - before, axis=1).max()
        if angle < np.pi / 2.0:
            assert shape.travel <= 1.2 * bend + 0.5 * angle**2
    assert shape_of(body, False, rest, rest).travel == 0.0
