"""Derivatives over the master's pose and over velocities, and of friction, against differences."""

from __future__ import annotations

import weakref

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.differences import jacobian
from tests.unit.contact.test_tangent import EGG, SAME, TABLE, contact_of, misses, pressed, soft

import contiga as cg
from contiga.errors import InputError

DEPTHS = np.array([0.11, 0.14, 0.17, 0.19])
SHARED = 0.2 * (1.0 - 0.0008 * np.arange(4))
DEEPER = 0.201 * (1.0 - 0.0005 * np.arange(4))
FRICTIONS = [
    cg.Coulomb(0.4),
    cg.Coulomb(0.4, stiffness=20.0),
    cg.Coulomb(0.4, 0.2, decay=2.0),
    cg.ViscousFriction(0.3, speed=0.1),
]


def slid(contact: cg.Contact, depths: np.ndarray, way: float, **how: object) -> tuple:
    """A state after steps of so much sliding, and where the points go next."""
    points, normals = pressed(depths)
    along = np.cross(normals, [0.1, 0.3, 1.0])
    along /= np.linalg.norm(along, axis=1)[:, None]
    state = contact.start(points)
    for _ in range(2):
        points = points + way * along - 0.004 * normals
        state = contact.step(state, points, **how)
    rough = way * np.random.default_rng(4).normal(size=points.shape)
    deeper = 0.01 + 0.002 * np.arange(len(points))[:, None]
    return state, points + way * along - deeper * normals + 0.1 * rough


@pytest.mark.parametrize("dt", [0.1, 0.0])
@pytest.mark.parametrize("way", [0.002, 0.06], ids=["sticks", "slips"])
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize(
    "law",
    [
        cg.PenaltyLaw(7.0),
        cg.StressLaw(soft, damping=0.1),
        cg.ForceLaw(TABLE),
        cg.ForceLaw(soft, share="penetration"),
    ],
)
def test_friction_sticks_and_slips(law: object, friction: object, way: float, dt: float) -> None:
    contact = contact_of(EGG, 4, law=law, friction=friction)
    state, points = slid(contact, DEPTHS, way, dt=dt)
    after = contact.step(state, points, dt=dt)
    if isinstance(friction, cg.Coulomb):
        pull = np.linalg.norm(after.friction, axis=1) / np.maximum(after.normal_force, 1e-9)
        assert (pull.max() > 0.19) == (way > 0.01) or friction.stiffness > 0.0
        assert after.friction.any()
    assert misses(contact, state, points, dt=dt) < SAME


@pytest.mark.parametrize("way", [0.0002, 0.06], ids=["sticks", "slips"])
@pytest.mark.parametrize("friction", FRICTIONS)
def test_points_that_share_a_force_slide_as_one(friction: object, way: float) -> None:
    contact = contact_of(EGG, 4, law=cg.ForceLaw(TABLE), friction=friction)
    points, normals = pressed(SHARED)
    along = np.cross(normals, [0.1, 0.3, 1.0])
    state = contact.start(points)
    state = contact.step(state, points + way * along, dt=0.1)
    points = EGG.project(points + 2.0 * way * along)
    points = points.point - DEEPER[:, None] * points.normal
    assert np.count_nonzero(contact.step(state, points, dt=0.1).normal_force) > 1
    assert misses(contact, state, points, dt=0.1, step=1e-6) < SAME


def test_equal_shares_of_two_points_pass_on_half_of_what_they_change() -> None:
    """Each way counts by the present share and the last one, and both are a half."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = contact_of(ball, 2, law=cg.ForceLaw(TABLE), friction=cg.Coulomb(0.4))
    points = np.array([[0.2, 0.0, 0.8], [-0.2, 0.0, 0.8]])
    state = contact.start(points)
    moved = points + np.array([[0.0, 0.002, -0.001], [0.0, 0.001, -0.001]])
    moved *= 0.82 / np.linalg.norm(moved, axis=1)[:, None]
    assert misses(contact, state, moved, step=1e-6) < SAME


@pytest.mark.parametrize("friction", FRICTIONS)
def test_points_that_come_in_slide_from_where_they_did(friction: object) -> None:
    inside, normals = pressed(DEPTHS)
    contact = contact_of(EGG, 4, friction=friction, search="intersection")
    state = contact.start(inside + 0.3 * normals + [0.1, 0.0, 0.0])
    assert contact.step(state, inside, dt=0.1).n_contact == 4
    assert misses(contact, state, inside, dt=0.1) < SAME


def test_friction_on_a_plateau_of_the_law() -> None:
    flat = cg.StressLaw([[0.0, 0.0], [0.1, 1.0], [1.0, 1.0]], 1.0)
    contact = contact_of(EGG, 4, law=flat, friction=cg.Coulomb(0.4))
    state, points = slid(contact, DEPTHS, 0.002)
    assert misses(contact, state, points) < SAME


def turned(pose: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """The pose after a small motion: of its origin, and by an angle about it."""
    out = pose.copy()
    out[:3, 3] += motion[:3]
    out[:3, :3] = Rotation.from_rotvec(motion[3:]).as_matrix() @ pose[:3, :3]
    return out


POSE = cg.motion.pose.translation([1.0, 2.0, 3.0]) @ cg.motion.pose.rotation([1, 2, 3], 0.7)


@pytest.mark.parametrize("exact", [False, True], ids=["paths", "velocities"])
@pytest.mark.parametrize(
    ("law", "friction"),
    [
        (cg.PenaltyLaw(7.0), None),
        (cg.StressLaw(TABLE, damping=0.1), cg.Coulomb(0.4, 0.2, decay=2.0)),
        (cg.StressLaw(TABLE, damping=0.1), cg.ViscousFriction(0.3, speed=0.1)),
        (cg.ForceLaw(TABLE, share="penetration"), cg.Coulomb(0.4)),
        (cg.ForceLaw(TABLE), cg.Coulomb(0.4, 0.2, decay=2.0)),
    ],
)
def test_of_a_master_that_moves_and_of_its_wrench(
    law: object, friction: object, exact: bool
) -> None:
    master = EGG.with_reference_point([0.3, -0.2, 0.4])
    contact = contact_of(master, 4, law=law, friction=friction)
    place = turned(POSE, np.array([0.002, 0.001, 0.003, 0.001, -0.002, 0.001]))
    inside, _ = pressed(SHARED if isinstance(law, cg.ForceLaw) else DEPTHS)
    before = inside @ POSE[:3, :3].T + POSE[:3, 3]
    now = inside @ place[:3, :3].T + place[:3, 3]
    now = now + 0.00001 * np.random.default_rng(5).normal(size=now.shape)
    state = contact.step(contact.start(before, POSE), before, pose=POSE, dt=0.1)
    how: dict = {"dt": 0.1}
    velocity = np.random.default_rng(6).normal(size=now.shape)
    if exact:
        how |= {"velocity": velocity, "twist": ([0.1, 0.2, -0.1], [0.5, -0.3, 0.4])}

    def both(points: np.ndarray, pose: np.ndarray, **other: object) -> np.ndarray:
        after = contact.step(state, points, pose=pose, **(how | other))
        return np.concatenate([after.force.ravel(), after.wrench])

    actual = contact.linearise(contact.step(state, now, pose=place, **how))
    step = 1e-6 if isinstance(law, cg.ForceLaw) else 1e-5
    over_points = jacobian(lambda x: both(x, place), now, step)
    over_pose = jacobian(lambda q: both(now, turned(place, q)), np.zeros(6), step)
    for found, wanted in (
        (actual.force_by_points.toarray(), over_points[:12]),
        (actual.wrench_by_points, over_points[12:]),
        (actual.force_by_pose, over_pose[:12]),
        (actual.wrench_by_pose, over_pose[12:]),
    ):
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=SAME * np.abs(wanted).max())
    by_velocity = actual.force_by_velocity.toarray()
    if not exact:
        assert actual.force_by_velocity.nnz == 0
        return
    wanted = jacobian(lambda v: both(now, place, velocity=v), velocity)[:12]
    largest = max(np.abs(wanted).max(), 1e-3)
    np.testing.assert_allclose(by_velocity, wanted, rtol=0.0, atol=SAME * largest)


def test_the_wrench_of_points_between_nodes() -> None:
    mesh = cg.Body([cg.shapes.plane(width=1.2, length=1.2)]).tessellate(0.1, size=0.6)
    nodes = mesh.vertices + np.array([0.3, 0.2, 2.9])
    nodes[:, 2] -= 0.2 * np.random.default_rng(3).random(len(nodes))
    slave = cg.Slave(nodes, mesh.triangles)
    law, friction = cg.StressLaw(TABLE, 0.7), cg.Coulomb(0.3)
    how = {"law": law, "friction": friction, "quadrature": 3, "search": "penetration"}
    contact = cg.Contact(EGG, slave, **how)
    state, now = contact.start(nodes), nodes + np.array([0.01, 0.02, -0.01])
    actual = contact.linearise(contact.step(state, now))
    wanted = jacobian(lambda x: contact.step(state, x).wrench, now)
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(actual.wrench_by_points, wanted, rtol=0.0, atol=SAME * scale)
    assert misses(contact, state, now) < SAME


def test_friction_without_derivatives_is_told_what_to_add() -> None:
    class Dry:
        n_memory = 0

        def respond(self, inp: object) -> object:
            none = np.zeros(len(inp.force))
            return cg.laws.friction.FrictionOutput(
                0.0 * inp.normal, none, none, none, np.zeros((len(none), 0))
            )

        def slid(self, memory: np.ndarray) -> np.ndarray:
            return np.zeros((len(memory), 3))

    class Short(cg.Coulomb):
        def changes(self, inp: object, change: object) -> np.ndarray:
            return super().changes(inp, change)[:, :2]

    points, _ = pressed(DEPTHS)
    contact = contact_of(EGG, 4, friction=Dry())
    with pytest.raises(InputError, match=r"friction.*no derivatives.*Dry.*changes"):
        contact.tangent(contact.start(points))
    contact = contact_of(EGG, 4, friction=Short(0.3))
    with pytest.raises(InputError, match=r"friction: changes.*a vector a point and direction"):
        contact.tangent(contact.start(points))


def test_velocities_change_only_for_friction_that_has_a_rate() -> None:
    """`Contact.step` and `Contact.tangent` take a friction without `has_rate` alike."""
    changes = []

    class Silent:
        n_memory = cg.Coulomb.n_memory
        respond, slid = cg.Coulomb(0.3).respond, cg.Coulomb(0.3).slid

        def changes(self, inp: object, change: object) -> np.ndarray:
            changes.append(change)
            return cg.Coulomb(0.3).changes(inp, change)

    class WithRate(Silent):
        has_rate = True

    points, _ = pressed(DEPTHS)
    for friction in (Silent(), WithRate()):
        contact = contact_of(EGG, 4, friction=friction)
        state = contact.step(contact.start(points), points + 0.01, dt=0.1)
        contact.tangent(state)
    assert [len(change.velocity) > 0 for change in changes] == [False, True]


def test_a_state_is_stepped_from_again_and_again_and_history_is_that_of_the_one_kept() -> None:
    contact = contact_of(EGG, 4, friction=cg.Coulomb(0.4))
    state, points = slid(contact, DEPTHS, 0.01, dt=0.0)
    before = {name: array.copy() for name, array in state.arrays.items()}
    first = contact.step(state, points, dt=0.0)
    contact.step(state, points + 0.03, dt=0.0)  # an iterate that was given up
    contact.linearise(first)
    again = contact.step(state, points, dt=0.0)
    for name, array in first.arrays.items():
        np.testing.assert_array_equal(array, again.arrays[name], err_msg=name)
    for name, array in state.arrays.items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


def test_a_state_does_not_keep_the_one_it_was_stepped_from() -> None:
    contact = contact_of(EGG, 4, law=cg.StressLaw(soft, damping=0.1), friction=cg.Coulomb(0.4))
    state, points = slid(contact, DEPTHS, 0.01, dt=0.1)
    last = weakref.ref(state)
    state = contact.step(state, points, dt=0.1)
    assert last() is None
    assert len(state.kinks) == 0


def test_a_step_without_time_has_no_rates_and_remembers() -> None:
    unloading = {"unloading": lambda x: 5.0 * x, "hysteresis_slope": 60.0}
    law = cg.StressLaw(soft, damping=50.0, **unloading)
    still = cg.StressLaw(soft, **unloading)
    friction = cg.Coulomb(0.4, 0.2, decay=9.0)
    states = []
    for which, dt in ((law, 0.0), (still, 1e9)):
        contact = contact_of(EGG, 4, law=which, friction=friction)
        state, points = slid(contact, DEPTHS, 0.01, dt=dt)
        states.append(contact.step(state, points, dt=dt))
    statics, slow = states
    np.testing.assert_array_equal(statics.memory, slow.memory)
    np.testing.assert_allclose(statics.force, slow.force, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(statics.slip, slow.slip, rtol=0.0, atol=1e-12)
    assert statics.slip.any()
    assert not statics.damping.any()
    assert statics.energy.damping == 0.0


def test_what_follows_the_step_needs_one() -> None:
    points, _ = pressed(DEPTHS)
    contact = contact_of(EGG, 4, law=cg.AdaptiveLaw())
    with pytest.raises(InputError, match="dt"):
        contact.step(contact.start(points), points, dt=0.0)
