"""Derivatives over the control points of masters that deform, against differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.differences import jacobian
from tests.unit.contact.test_shape import bent, plate

import contiga as cg

SAME = 1e-7
"""Relative difference: rounding of the differences."""
WAYS = 4
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
    contact: cg.Contact, state: cg.State, shape: np.ndarray, points: np.ndarray, dt: float = 0.0
) -> dict[str, float]:
    """How far each derivative is off differences, relative to the largest of its kind."""

    def after(x: np.ndarray, control: np.ndarray) -> cg.State:
        return contact.step(state, x, POSE, dt=dt, control_points=control)

    found = after(points, shape)
    assert found.in_contact.all()
    ways = np.random.default_rng(5).normal(size=(WAYS, points.size))
    bends = np.random.default_rng(6).normal(size=(WAYS, shape.size))

    def over_points(a: np.ndarray) -> cg.State:
        return after(points + (a @ ways).reshape(points.shape), shape)

    def over_control(a: np.ndarray) -> cg.State:
        return after(points, shape + (a @ bends).reshape(shape.shape))

    actual, still, off = contact.linearise(found), np.zeros(WAYS), {}
    for by, moved, along in (("points", over_points, ways), ("control", over_control, bends)):
        for of, name in (("force", "force"), ("control_force", "control")):
            wanted = jacobian(lambda a, of=of, moved=moved: getattr(moved(a), of), still)
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


def test_friction_is_off_by_what_the_surface_does_within_the_step() -> None:
    """The less it turns and stretches the better."""
    off = []
    for by in (0.02, 0.002):
        body = plate()
        shape = body.net.points + by * (bent(body, 3, 0.1) - body.net.points)
        given = pressed(body, over_plate(), shape=shape, friction=cg.Coulomb(0.4, stiffness=20.0))
        contact, state, shape, points = given
        state = contact.step(state, points, POSE, dt=0)
        found = misses(contact, state, shape, points + 0.003 * np.array([1.0, 2.0, 0.0]))
        off.append(max(found.values()))
    assert off[0] < 0.05
    assert off[1] < 0.2 * off[0]


def test_of_a_master_that_keeps_its_shape_there_are_none() -> None:
    slave = cg.Slave([[0.0, 0.0, 0.1]], area=[1.0])
    contact = cg.Contact(plate(), slave, law=cg.PenaltyLaw(1.0), shell_thickness=0.4)
    one = contact.linearise(contact.start(slave.points))
    shapes = one.force_by_control.shape, one.control_by_points.shape, one.control_by_control.shape
    assert shapes == ((3, 0), (0, 3), (0, 0))
