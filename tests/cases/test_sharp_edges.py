"""Sharp edges: what pushes a point is the nearest wall, whichever it came in by."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.sample import full
from tests.scenes import box, grid_quads

import contiga as cg

POSE = cg.motion.pose
HALF, HEIGHT = 20.0, 20.0
LAW = cg.PenaltyLaw(1.0, per_area=True)


def block() -> cg.Body:
    """40 × 40 × 20, its bottom in z = 0."""
    return box((-HALF, -HALF, 0.0), (HALF, HALF, HEIGHT))


def bed(spacing: float, reach: float = 45.0) -> cg.Slave:
    """A sheet in z = 0, its nodes beside the edges of the block and not under them."""
    n = int(2.0 * reach / spacing) + 1
    x, y = np.meshgrid(*2 * [spacing * (np.arange(n) - 0.5 * (n - 1)) + 0.137])
    return cg.Slave(np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)]), grid_quads(n))


def to_walls(p_B: np.ndarray) -> np.ndarray:
    """(n, 6) how far points lie behind the walls −x, −y, −z, x, y, z of the block."""
    low, high = np.array([-HALF, -HALF, 0.0]), np.array([HALF, HALF, HEIGHT])
    return np.concatenate([p_B - low, high - p_B], axis=1)


def slid(contact: cg.Contact, way: np.ndarray, turn: float = 0.0) -> list[cg.State]:
    """States of a contact whose block stands at the places `way` (n, 3), turned about z."""
    points = contact.slave.points
    poses = [POSE.compose(POSE.translation(at), POSE.rotation("z", turn)) for at in way]
    states = [contact.start(points, poses[0])]
    for X_WB in poses[1:]:
        states.append(contact.step(states[-1], points, X_WB))
    return states


def along(*corners: tuple[float, float, float], step: float) -> np.ndarray:
    """Places on straight ways from corner to corner, no farther apart than `step`."""
    places = [np.array(corners[:1])]
    for a, b in pairwise(np.array(corners)):
        n = max(int(np.ceil(np.linalg.norm(b - a) / step)), 1)
        places.append(a + np.linspace(0.0, 1.0, n + 1)[1:, None] * (b - a))
    return np.concatenate(places)


@pytest.mark.parametrize(
    ("depth", "angle", "turn", "spacing", "quadrature"),
    [
        (0.05, 0.0, 0.0, 2.0, "nodes"),
        (0.1, 0.3, -0.2, 2.0, 3),
        (0.5, 1.1, 0.0, 7.0, 1),
        (2.0, 3.9, 1.3, 3.0, "nodes"),
        *full(
            (0.05, 0.7, 0.4, 10.0, 6),
            (0.1, 0.0, 0.0, 0.5, "nodes"),
            (0.5, 2.5, 0.785, 1.5, "nodes"),
            (2.0, 0.0, 0.0, 4.0, 6),
        ),
    ],
)
def test_a_block_that_is_slid_over_points_is_pushed_up_and_by_its_front_edge_back(
    depth, angle, turn, spacing, quadrature
) -> None:
    """Up: its depth on all points but those that are nearer to a side. Back: of those only."""
    contact = cg.Contact(block(), bed(spacing), law=LAW, quadrature=quadrature)
    x, y = 20.0 * np.cos(angle), 20.0 * np.sin(angle)
    way = along((0.0, 0.0, 0.5), (0.0, 0.0, -depth), (x, y, -depth), step=1.3)
    states = slid(contact, way, turn)
    for state in states:
        held = state.in_contact
        behind = to_walls(state.points_B)
        least = behind.min(axis=1)
        clear = np.abs(least) > 1e-12
        np.testing.assert_array_equal(held[clear], least[clear] > 0.0)
        np.testing.assert_allclose(state.penetration[held], least[held], rtol=0, atol=1e-9)
        told = held & (np.sort(behind, axis=1)[:, 1] > least + 1e-9)
        wall = np.concatenate([-np.eye(3), np.eye(3)])[behind.argmin(axis=1)]
        np.testing.assert_allclose(state.normal_B[told], wall[told], rtol=0, atol=1e-12)
    under = held & (state.normal_B[:, 2] < -0.5)
    weight = state.normal_force[under] / state.penetration[under]
    assert -state.total_force[2] == pytest.approx(depth * weight.sum(), rel=1e-9)
    # What another wall pushes lies within its depth of that.
    beside = held & ~under
    assert (behind[beside].min(axis=1, initial=0.0) <= depth).all()
    assert np.hypot(*state.total_force[:2]) <= state.normal_force[beside].sum() + 1e-9


def test_pushed_sideways_a_block_that_has_run_over_points_feels_nothing() -> None:
    """0.1 deep, no point within that of an edge: up by 0.1 a point, back by rounding."""
    slave = cg.Slave(bed(2.0).points, area=np.ones(len(bed(2.0))))
    contact = cg.Contact(block(), slave, law=cg.PenaltyLaw(1.0))
    state = slid(contact, along((0, 0, 0.5), (0, 0, -0.1), (20, 0, -0.1), step=0.25))[-1]
    under = np.all(np.abs(slave.points[:, :2] - [20.0, 0.0]) < HALF, axis=1).sum()
    np.testing.assert_allclose(-state.total_force, [0.0, 0.0, 0.1 * under], rtol=0, atol=1e-9)


DEEP = 0.7
WAYS = {
    "dropped": [(3.0, -2.0, 0.5), (3.0, -2.0, -DEEP)],
    "dropped in one step": None,
    "slid": [(-9.0, 4.0, 0.5), (-9.0, 4.0, -DEEP), (3.0, -2.0, -DEEP)],
    "slid from afar": [(-90.0, 4.0, -DEEP), (3.0, 4.0, -DEEP), (3.0, -2.0, -DEEP)],
    "from deeper": [(3.0, -2.0, 0.5), (3.0, 9.0, -4.0), (3.0, -2.0, -4.0), (3.0, -2.0, -DEEP)],
    "round a loop": [
        (3.0, -2.0, 0.5), (3.0, -2.0, -2.0), (15.0, 8.0, -3.0), (-12.0, 8.0, -1.0),
        (-12.0, -9.0, -DEEP), (3.0, -2.0, -DEEP),
    ],
    "lifted round": [
        (3.0, -2.0, 0.5), (3.0, -2.0, -2.0), (3.0, -2.0, 1.0), (80.0, -2.0, 1.0),
        (80.0, -2.0, -2.0), (3.0, -2.0, -2.0), (3.0, -2.0, -DEEP),
    ],
}  # fmt: skip
"""To one place. None below goes past the middle of the block, where the far walls are as near."""


def _end_of(name: str, search: str) -> cg.State:
    contact = cg.Contact(block(), bed(2.3), law=LAW, search=search)
    way = np.array(WAYS["dropped"]) if WAYS[name] is None else along(*WAYS[name], step=0.9)
    return slid(contact, way)[-1]


@pytest.mark.parametrize(
    ("name", "search"),
    [
        ("dropped", "intersection"),
        ("dropped in one step", "intersection"),
        ("slid", "penetration"),
        ("round a loop", "intersection"),
        *full(
            *((name, "intersection") for name in ("slid", "slid from afar", "from deeper")),
            ("lifted round", "intersection"),
            ("round a loop", "penetration"),
        ),
    ],
)
def test_the_force_does_not_depend_on_the_way_taken(name, search) -> None:
    contact = cg.Contact(block(), bed(2.3), law=LAW, search="penetration")
    placed = contact.start(contact.slave.points, POSE.translation(WAYS["dropped"][-1]))
    state = _end_of(name, search)
    np.testing.assert_array_equal(state.in_contact, placed.in_contact)
    for name_of in ("penetration", "force", "wrench", "foot"):
        a, b = getattr(state, name_of), getattr(placed, name_of)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * max(np.abs(b).max(), 1.0))
    assert state.energy.stored == pytest.approx(placed.energy.stored, rel=1e-12)


# A plate of 1: a point held from above, whose far side is nearer.


@pytest.mark.parametrize(("steps", "angle"), [(50, 0.0), (50, 0.4), *full((1600, 0.4))])
def test_a_point_in_a_plate_goes_out_by_its_end_and_never_by_the_far_side(steps, angle) -> None:
    plate = box((-20.0, -20.0, 0.0), (20.0, 20.0, 1.0))
    below = np.linspace(0.1, 0.9, 9)
    start = np.column_stack([np.full(9, 15.03), 0.4 * np.arange(9), np.full(9, 1.5)])
    contact = cg.Contact(plate, cg.Slave(start, area=np.ones(9)), law=cg.PenaltyLaw(1.0))
    pressed = start - np.outer(0.5 + below, [0.0, 0.0, 1.0])
    state = contact.start(start)
    for share in np.linspace(0.0, 1.0, steps // 4 + 1)[1:]:
        state = contact.step(state, start + share * (pressed - start))
    np.testing.assert_allclose(state.penetration, below, rtol=0, atol=1e-12)
    way = 5.5 * np.array([1.0, np.tan(angle), 0.0])
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        last, state = state, contact.step(state, pressed + share * way)
        to_end = 20.0 - state.points_B[:, 0]
        expected = np.maximum(np.minimum(below, to_end), 0.0)
        np.testing.assert_allclose(state.penetration, expected, rtol=0, atol=1e-12)
        assert (state.normal_B[:, 2] > -0.5).all()
        change = np.abs(state.penetration - last.penetration)
        assert (change <= np.linalg.norm(way) / steps + 1e-12).all()
    assert state.n_contact == 0


@pytest.mark.parametrize("steps", [1, 7, 200])
def test_a_point_pressed_right_through_a_plate_is_pushed_back_until_it_is_out(steps) -> None:
    plate = box((-20.0, -20.0, 0.0), (20.0, 20.0, 1.0))
    start = np.array([[1.0, 2.0, 1.2]])
    contact = cg.Contact(plate, cg.Slave(start, area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start(start)
    for depth in 0.97 * np.linspace(0.0, 1.0, steps + 1)[1:]:
        state = contact.step(state, start - [0.0, 0.0, 0.2 + depth])
        assert state.penetration[0] == pytest.approx(depth, abs=1e-12)
        assert state.normal_B[0].tolist() == [0.0, 0.0, 1.0]
    assert contact.step(state, start - [0.0, 0.0, 1.3]).n_contact == 0
