"""Derivatives over the control points of masters that deform, against differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.differences import jacobian
from tests.unit.contact.test_linearise import turned
from tests.unit.contact.test_shape import bent, plate

import contiga as cg

SAME = 1e-7
"""Relative difference: rounding of the differences."""
N_DIRECTIONS = 4
"""Ways along which differences are taken."""
TABLE = [[0.0, 0.0], [0.1, 1.0], [1.0, 30.0]]
POSE = np.eye(4)
POSE[:3, :3] = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
POSE[:3, 3] = 1.0, 2.0, 3.0


def pressed(
    body: cg.Body,
    points: np.ndarray,
    quads: Any = None,
    shape: np.ndarray | None = None,
    **how: Any,
) -> tuple[cg.Contact, cg.State, np.ndarray, np.ndarray]:
    """A contact, the state at rest, the control points and the points that a step then has."""
    options: dict[str, Any] = {"law": cg.PenaltyLaw(7.0), "search": "penetration", "depth": 0.3}
    options |= {"shell_thickness": 0.4} | how
    area = None if quads is not None else np.linspace(0.5, 1.0, len(points))
    slave = cg.Slave(points, quads, area=area, thickness=np.full(len(points), 0.5))
    contact = cg.Contact(body, slave, **options)
    shape = bent(body, 3, 0.02) if shape is None else shape
    world = points @ POSE[:3, :3].T + POSE[:3, 3]
    state = contact.start(world, POSE, control_points=body.net.points)
    return contact, state, shape, world + 0.002 * np.random.default_rng(2).normal(size=world.shape)


def misses(
    contact: cg.Contact,
    state: cg.State,
    shape: np.ndarray,
    points: np.ndarray,
    dt: float = 0.0,
    step: float = 1e-5,
    **how: Any,
) -> dict[str, float]:
    """How far each derivative is off differences, relative to the largest of its kind."""

    def after(x: np.ndarray, control: np.ndarray) -> cg.State:
        return contact.step(state, x, POSE, dt=dt, control_points=control, **how)

    found = after(points, shape)
    assert found.in_contact.all()
    ways = np.random.default_rng(5).normal(size=(N_DIRECTIONS, points.size))
    bends = np.random.default_rng(6).normal(size=(N_DIRECTIONS, shape.size))

    def over_points(a: np.ndarray) -> cg.State:
        return after(points + (a @ ways).reshape(points.shape), shape)

    def over_control(a: np.ndarray) -> cg.State:
        return after(points, shape + (a @ bends).reshape(shape.shape))

    actual, still, off = contact.linearise(found), np.zeros(N_DIRECTIONS), {}
    for by, moved, along in (("points", over_points, ways), ("control", over_control, bends)):
        for of, name in (("force", "force"), ("control_force", "control")):
            wanted = jacobian(lambda a, of=of, moved=moved: getattr(moved(a), of), still, step)
            ours = getattr(actual, f"{name}_by_{by}") @ along.T
            off[f"{name}_by_{by}"] = float(np.abs(ours - wanted).max() / np.abs(wanted).max())
    return off


def over_plate() -> np.ndarray:
    xy = np.array([[0.13, 0.21], [-0.83, 0.4], [1.27, -1.31], [0.02, -0.6]])
    return np.column_stack([xy, [0.11, 0.08, 0.13, -0.05]])


LAWS = [
    cg.PenaltyLaw(7.0),
    cg.StressLaw(TABLE, damping=0.1),
    cg.StressLaw(TABLE, unloading=0.1, hysteresis_slope=80.0),
    cg.ForceLaw(TABLE, share="penetration"),
]


@pytest.mark.parametrize("law", LAWS)
def test_of_points_on_a_sheet(law: object) -> None:
    given = pressed(plate(), over_plate(), law=law)
    contact, state, shape, points = given
    found = misses(contact, contact.step(state, points, POSE, dt=0.1), shape, points, dt=0.1)
    assert max(found.values()) < SAME, found


def test_without_friction_it_is_that_of_an_energy() -> None:
    contact, state, shape, points = pressed(plate(), over_plate())
    one = contact.linearise(contact.step(state, points, POSE, dt=0, control_points=shape))
    over = one.force_by_control.toarray().reshape(len(points), 3, -1, 3)
    back = one.control_by_points.toarray().reshape(-1, 3, len(points), 3)
    R = POSE[:3, :3]  # forces are in world axes, control points in the body's
    np.testing.assert_allclose(
        np.einsum("iajb,cb->iajc", over, R), back.transpose(2, 3, 0, 1), atol=1e-12
    )


def test_of_points_beside_edges_of_a_solid_and_held_on_a_border() -> None:
    """Feet on rational patches, at a crease and on the border of a sheet."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    ways = np.array([[0.3, 0.2, 0.9], [-0.5, 0.6, 0.1], [0.2, -0.7, -0.4]])
    points = 1.1 * ways / np.linalg.norm(ways, axis=1)[:, None]
    found = misses(*pressed(ball, points))
    assert max(found.values()) < SAME, found
    beside = np.array([[2.06, 0.31, 0.05], [0.4, -2.05, 0.06], [2.05, 2.04, 0.07]])
    held = pressed(plate(), beside, shape=bent(plate(), 3, 0.003), on_edge="hold")
    assert (held[0].step(held[1], held[3], POSE, dt=0, control_points=held[2]).feature > 0).all()
    found = misses(*held)
    assert max(found.values()) < SAME, found


def test_of_points_inside_a_solid_without_a_thickness() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    ways = np.array([[0.3, 0.2, 0.9], [-0.5, 0.6, 0.1], [0.2, -0.7, -0.4]])
    points = 0.9 * ways / np.linalg.norm(ways, axis=1)[:, None]
    found = misses(*pressed(ball, points, shell_thickness=None))
    assert max(found.values()) < SAME, found


def test_of_points_between_nodes() -> None:
    rows = np.array([[-0.3, -0.2, 0.1], [0.4, -0.3, 0.09], [0.5, 0.5, 0.12], [-0.4, 0.3, 0.06]])
    law = cg.PenaltyLaw(7.0, per_area=True)
    found = misses(*pressed(plate(), rows, [[0, 1, 2, 3]], quadrature=3, law=law))
    assert max(found.values()) < SAME, found


STICKS, SLIPS = cg.Coulomb(20.0, stiffness=20.0), cg.Coulomb(0.4)
FRICTIONS = [STICKS, SLIPS, cg.Coulomb(0.4, 0.2, decay=2.0), cg.ViscousFriction(0.3, speed=0.1)]
THICK: dict[str, Any] = {"points": over_plate()}
THIN: dict[str, Any] = {"points": over_plate() - [0.0, 0.0, 0.25], "shell_thickness": None}


def rubbed(
    body: cg.Body, points: np.ndarray, quads: Any = None, **how: Any
) -> tuple[cg.Contact, cg.State, np.ndarray, np.ndarray]:
    """`pressed` after a step that leaves tractions, and points that slide in the next."""
    contact, state, shape, points = pressed(body, points, quads, **how)
    half_way = 0.5 * (body.net.points + shape)
    state = contact.step(state, points, POSE, dt=0.1, control_points=half_way)
    along = np.array([0.04, 0.07, 0.0]) @ POSE[:3, :3].T
    return contact, state, shape, points + along


@pytest.mark.parametrize("dt", [0.1, 0.0])
@pytest.mark.parametrize("where", [THICK, THIN], ids=["thick", "thin"])
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("law", LAWS)
def test_friction_on_a_sheet(law: object, friction: object, where: dict, dt: float) -> None:
    contact, state, shape, points = rubbed(plate(), law=law, friction=friction, **where)
    after = contact.step(state, points, POSE, dt=dt, control_points=shape)
    pull = np.linalg.norm(after.friction, axis=1) / after.normal_force
    if friction is STICKS:
        assert ((pull > 0.01) & (pull < 10.0)).all()
    if friction is SLIPS:
        assert np.count_nonzero(pull > 0.4 - 1e-9) > 1
    found = misses(contact, state, shape, points, dt)
    assert max(found.values()) < SAME, found


@pytest.mark.parametrize("friction", [STICKS, SLIPS], ids=["sticks", "slips"])
def test_friction_beside_edges_inside_solids_and_between_nodes(friction: object) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    ways = np.array([[0.3, 0.2, 0.9], [-0.5, 0.6, 0.1], [0.2, -0.7, -0.4]])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    beside = np.array([[2.06, 0.31, 0.05], [0.4, -2.12, 0.06], [2.05, 2.0, 0.07]])
    rows = np.array([[-0.3, -0.2, 0.1], [0.4, -0.3, 0.09], [0.5, 0.5, 0.12], [-0.4, 0.3, 0.06]])
    border = {"shape": bent(plate(), 3, 0.003), "on_edge": "hold"}
    between = {"quadrature": 3, "law": cg.PenaltyLaw(7.0, per_area=True)}
    for given in (
        rubbed(ball, 1.1 * ways, friction=friction),
        rubbed(ball, 0.9 * ways, friction=friction, shell_thickness=None),
        rubbed(plate(), beside, friction=friction, **border),
        rubbed(plate(), rows, [[0, 1, 2, 3]], friction=friction, **between),
    ):
        found = misses(*given)
        assert max(found.values()) < SAME, found
    held = rubbed(plate(), beside, friction=friction, **border)
    assert (held[0].step(held[1], held[3], POSE, dt=0, control_points=held[2]).feature > 0).all()


def test_friction_of_points_that_share_a_force_and_slide_as_one() -> None:
    level = over_plate()
    level[:, 2] = 0.05 - 1e-5 * np.arange(4)
    shape = np.add(plate().net.points, [1e-3, 2e-3, 1e-3])
    shape += 1e-6 * np.random.default_rng(8).normal(size=shape.shape)
    how = {"law": cg.ForceLaw(TABLE), "shape": shape}
    for friction in (cg.Coulomb(0.02, stiffness=5.0), cg.Coulomb(20.0, stiffness=5.0)):
        contact, state, shape, _ = pressed(plate(), level, friction=friction, **how)
        points = np.add(level, [0.01, 0.02, 0.0]) @ POSE[:3, :3].T + POSE[:3, 3]
        after = contact.step(state, points, POSE, dt=0, control_points=shape)
        assert (after.normal_force > 0.0).all()
        assert after.friction.any()
        found = misses(contact, state, shape, points, step=1e-6)
        assert max(found.values()) < SAME, found


@pytest.mark.parametrize("friction", FRICTIONS)
def test_friction_and_dampers_of_points_that_come_in(friction: object) -> None:
    law = cg.PenaltyLaw(7.0, damping=0.2)
    far = np.add(over_plate(), [0.0, 0.0, 0.5])
    contact, state, shape, _ = pressed(
        plate(), far, law=law, friction=friction, search="intersection"
    )
    points = np.add(over_plate(), [0.1, 0.2, 0.0]) @ POSE[:3, :3].T + POSE[:3, 3]
    assert state.n_contact == 0
    found = misses(contact, state, shape, points, dt=0.1)
    assert max(found.values()) < SAME, found


@pytest.mark.parametrize("friction", FRICTIONS)
def test_velocities_that_are_given_stay_while_all_else_moves(friction: object) -> None:
    """Over the pose as well: the surface below a point turns it, and itself turns with the pose."""
    law = cg.StressLaw(TABLE, damping=0.1)
    contact, state, shape, points = rubbed(plate(), over_plate(), law=law, friction=friction)
    rng = np.random.default_rng(7)
    given: dict[str, Any] = {
        "velocity": rng.normal(size=points.shape),
        "twist": ([0.1, 0.2, -0.1], [0.5, -0.3, 0.4]),
        "control_velocity": rng.normal(size=shape.shape),
    }
    found = misses(contact, state, shape, points, 0.1, **given)
    assert max(found.values()) < SAME, found

    def both(pose: np.ndarray) -> np.ndarray:
        after = contact.step(state, points, pose, dt=0.1, control_points=shape, **given)
        return np.concatenate([after.force.ravel(), after.wrench])

    after = contact.step(state, points, POSE, dt=0.1, control_points=shape, **given)
    actual = contact.linearise(after)
    wanted = jacobian(lambda q: both(turned(POSE, q)), np.zeros(6))
    ours = np.concatenate([actual.force_by_pose, actual.wrench_by_pose])
    np.testing.assert_allclose(ours, wanted, rtol=0.0, atol=SAME * np.abs(wanted).max())


def test_central_differences_come_nearer_with_the_square_of_their_step() -> None:
    contact, state, shape, points = rubbed(plate(), over_plate(), friction=SLIPS)
    step = {"dt": 0.0, "pose": POSE}
    way = np.random.default_rng(5).normal(size=shape.shape)
    slopes = contact.linearise(contact.step(state, points, control_points=shape, **step))
    ours = slopes.control_by_control @ way.ravel(), slopes.force_by_control @ way.ravel()
    off = []
    for h in (1e-3, 5e-4):
        low, high = (
            contact.step(state, points, control_points=shape + end * way, **step) for end in (-h, h)
        )
        pairs = (low.control_force, high.control_force), (low.force, high.force)
        off.append(
            [
                np.abs((b - a).ravel() / (2.0 * h) - c).max() / np.abs(c).max()
                for (a, b), c in zip(pairs, ours, strict=True)
            ]
        )
    assert np.max(off) < 1e-2
    np.testing.assert_allclose(np.divide(*off), 4.0, rtol=0.05)


@pytest.mark.parametrize("friction", [None, STICKS, SLIPS], ids=["smooth", "sticks", "slips"])
@pytest.mark.parametrize("where", [THICK, THIN], ids=["thick", "thin"])
def test_changes_of_forces_balance_with_their_moments(where: dict, friction: object) -> None:
    contact, state, shape, points = rubbed(plate(), friction=friction, **where)
    after = contact.step(state, points, POSE, dt=0, control_points=shape)
    slopes, R = contact.linearise(after), POSE[:3, :3]
    n, m = len(points), len(shape)
    way, bend = np.random.default_rng(9).normal(size=(2, 3 * max(n, m)))
    way, bend = way[: 3 * n], bend[: 3 * m]
    on_points = slopes.force_by_points @ way + slopes.force_by_control @ bend
    on_control = slopes.control_by_points @ way + slopes.control_by_control @ bend
    on_points, on_control = on_points.reshape(n, 3), on_control.reshape(m, 3)
    scale = np.abs(on_points).max()
    total = on_points.sum(axis=0) + on_control.sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-12 * scale)
    moment = np.cross(points, on_points) + np.cross(way.reshape(n, 3), after.force)
    control, moved = shape @ R.T + POSE[:3, 3], bend.reshape(m, 3) @ R.T
    other = np.cross(control, on_control) + np.cross(moved, after.control_force)
    total = moment.sum(axis=0) + other.sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-11 * scale)


def test_of_a_master_that_keeps_its_shape_there_are_none() -> None:
    slave = cg.Slave([[0.0, 0.0, 0.1]], area=[1.0])
    contact = cg.Contact(plate(), slave, law=cg.PenaltyLaw(1.0), shell_thickness=0.4)
    one = contact.linearise(contact.start(slave.points))
    shapes = one.force_by_control.shape, one.control_by_points.shape, one.control_by_control.shape
    assert shapes == ((3, 0), (0, 3), (0, 0))


def test_without_contact_they_are_zero() -> None:
    body, slave = plate(), cg.Slave([[0.0, 0.0, 0.5]], area=[1.0])
    how = {"law": cg.PenaltyLaw(1.0), "friction": SLIPS, "shell_thickness": 0.4}
    contact, m = cg.Contact(body, slave, **how), len(body.net.points)
    one = contact.linearise(contact.start(slave.points, control_points=body.net.points))
    assert one.force_by_control.shape == (3, 3 * m)
    assert one.control_by_points.shape == (3 * m, 3)
    assert one.control_by_control.shape == (3 * m, 3 * m)
    for matrix in one[5:]:
        assert matrix.nnz == 0
