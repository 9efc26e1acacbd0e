"""A step is a pure function: of the same arguments the same bits, and nothing is changed."""

from __future__ import annotations

import copy
import dataclasses
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga.contact.search_records import WorkspacePool
from contiga.contact.state import State

N = 3000


def _bits(state: State) -> list[bytes]:
    return [np.asarray(getattr(state, field.name)).tobytes() for field in fields(State)]


def _run(order: np.ndarray, search: str = "intersection") -> list[State]:
    """Points falling on a torus, in the given order of rows."""
    rng = np.random.default_rng(4)
    points = rng.uniform([-2.7, -2.7, 0.3], [2.7, 2.7, 0.9], (N, 3))
    drift = rng.normal(scale=0.02, size=(N, 3)) - [0.0, 0.0, 0.05]
    ring = cg.Body([cg.shapes.torus()])
    cloud = cg.Slave(points[order], area=np.linspace(1.0, 2.0, N)[order])
    contact = cg.Contact(ring, cloud, law=cg.PenaltyLaw(3.0, per_area=True), search=search)
    states = [contact.start(points[order])]
    for k in range(1, 13):
        states.append(contact.step(states[-1], (points + k * drift)[order], dt=0.1))
    return states


@pytest.fixture(scope="module")
def states() -> list[State]:
    return _run(np.arange(N))


def test_a_state_takes_at_most_180_bytes_a_point(states: list[State]) -> None:
    whole = ("wrench", "energies", "pose")  # of all points together
    names = [field.name for field in fields(State) if field.name not in whole]
    assert sum(getattr(states[-1], name).nbytes for name in names) / N == 179


def test_the_same_arguments_give_the_same_bits(states: list[State]) -> None:
    assert states[-1].n_contact > 200
    for a, b in zip(states, _run(np.arange(N)), strict=True):
        assert _bits(a) == _bits(b)


def test_a_step_changes_neither_state_nor_points(states: list[State]) -> None:
    ring = cg.Body([cg.shapes.torus()])
    last = states[-1]
    contact = cg.Contact(ring, cg.Slave(last.points_B, area=np.ones(N)), law=cg.PenaltyLaw(1.0))
    points, X_WB = last.points_B - [0.0, 0.0, 0.02], np.eye(4)
    before = (_bits(last), points.tobytes(), X_WB.tobytes())
    first = contact.step(last, points, X_WB)
    again = contact.step(last, points, X_WB)
    assert before == (_bits(last), points.tobytes(), X_WB.tobytes())
    assert _bits(first) == _bits(again)


def test_a_state_shares_no_memory_with_the_points_or_the_last_state(states: list[State]) -> None:
    ring = cg.Body([cg.shapes.torus()])
    contact = cg.Contact(ring, cg.Slave(np.zeros((N, 3)), area=np.ones(N)), law=cg.PenaltyLaw(1.0))
    points = states[0].points_B.copy()
    first = contact.start(points)
    second = contact.step(first, points)
    for field in fields(State):
        own = getattr(second, field.name)
        assert not np.shares_memory(own, points)
        assert not np.shares_memory(own, getattr(first, field.name))


@pytest.mark.parametrize(
    ("through", "closed"),
    [("release", False), ("hold", True), *full(("release", True), ("hold", False))],
)
def test_later_steps_change_no_state_whatever_they_work_in(closed: bool, through: str) -> None:
    ring = cg.shapes.torus()
    body = cg.Body([ring if closed else ring.restricted(ring.domain[0], (0.0, 0.7))])
    points = np.random.default_rng(4).uniform([-2.7, -2.7, 0.3], [2.7, 2.7, 0.9], (N, 3))

    def contact() -> cg.Contact:
        slave = cg.Slave(points, area=np.ones(N))
        return cg.Contact(body, slave, law=cg.PenaltyLaw(3.0), through=through)

    def step(of: cg.Contact, state: State, k: int) -> State:
        turn = cg.motion.pose.rotation("z", 0.1 * k)
        return of.step(state, points - [0.0, 0.0, 0.05 * k], turn, dt=0.1)

    own, apart = contact(), contact()
    states = [own.start(points)]
    for k in range(1, 9):
        states.append(step(own, states[-1], k))
    seen = [_bits(step(contact(), state, k)) for k, state in enumerate(states[:-1], 1)]
    assert states[-1].n_contact > 200
    assert seen == [_bits(state) for state in states[1:]]
    # Steps of one contact on several threads at once work each in a room of their own.
    first = apart.start(points)
    with ThreadPoolExecutor(4) as pool:
        again = list(pool.map(lambda k: step(apart, first, k), [1, 2, 3, 4] * 3))
    alone = [_bits(step(contact(), first, k)) for k in (1, 2, 3, 4)]
    assert [_bits(state) for state in again] == alone * 3


def test_rooms_are_taken_by_one_step_at_a_time_and_given_back() -> None:
    rooms = WorkspacePool()
    first, second = rooms.take(4), rooms.take(4)
    assert not any(np.shares_memory(a, b) for a in first for b in second)
    assert {len(array) for array in first} == {4, 2}
    rooms.give(first)
    assert rooms.take(4) is first
    rooms.give(first)
    assert copy.deepcopy(rooms).take(4) is not first


def test_a_step_that_fails_gives_its_room_back() -> None:
    points = np.array([[0.0, 0.0, 1.1]])
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(ball, cg.Slave(points, area=[1.0]), law=_Failing(1.0))
    state = contact.start(points)
    with pytest.raises(ZeroDivisionError):
        contact.step(state, points - [0.0, 0.0, 0.2])
    room = contact._workspaces.take(1)
    contact._workspaces.give(room)
    with pytest.raises(ZeroDivisionError):
        contact.step(state, points - [0.0, 0.0, 0.2])
    assert contact._workspaces.take(1) is room


class _Failing(cg.PenaltyLaw):
    """A law that cannot answer."""

    def respond(self, pressed: cg.LawInput) -> cg.LawOutput:
        raise ZeroDivisionError


@pytest.mark.parametrize("search", ["intersection", "penetration"])
def test_permuted_points_have_permuted_results(search: str) -> None:
    order = np.random.default_rng(9).permutation(N)
    plain, permuted = _run(np.arange(N), search), _run(order, search)
    for a, b in zip(plain, permuted, strict=True):
        for field in fields(State):
            if field.name == "wrench":
                scale = np.abs(a.force).sum() + 1e-300
                np.testing.assert_allclose(b.wrench, a.wrench, rtol=0, atol=1e-13 * scale)
            elif field.name == "energies":
                np.testing.assert_allclose(b.energies, a.energies, rtol=0, atol=1e-13)
            elif field.name == "pose":
                np.testing.assert_array_equal(a.pose, b.pose)
            else:
                whole = getattr(a, field.name)
                own = whole[order] if len(whole) else whole
                assert own.tobytes() == getattr(b, field.name).tobytes(), field.name


def test_points_do_not_feel_each_other(states: list[State]) -> None:
    # A part of the points alone has the same bits: blocks of lanes are filled differently.
    rows = np.random.default_rng(10).choice(N, 217, replace=False)
    contact = cg.Contact(
        cg.Body([cg.shapes.torus()]),
        cg.Slave(np.zeros((217, 3)), area=np.linspace(1.0, 2.0, N)[rows]),
        law=cg.PenaltyLaw(3.0, per_area=True),
    )
    part = contact.start(states[0].points_B[rows])
    for state in states[1:]:
        part = contact.step(part, state.points_B[rows], dt=0.1)
        for name in ("status", "uv", "penetration", "normal", "force", "safe_distance"):
            assert getattr(part, name).tobytes() == getattr(state, name)[rows].tobytes(), name


@pytest.mark.parametrize("name", ["patch", "uv", "last_patch", "safe_distance", "penetration"])
def test_states_made_by_hand_may_hold_parts_of_other_arrays(name: str) -> None:
    """Kernels that steps call all the time look at the types of what a state holds."""
    points = np.random.default_rng(3).uniform(-1.1, 1.1, (200, 3))
    ball = cg.Body([cg.shapes.sphere()])
    slave, law = cg.Slave(points, area=np.ones(200)), cg.PenaltyLaw(1.0)
    contact = cg.Contact(ball, slave, law=law, search="penetration")
    state = contact.step(contact.start(points + 0.05), points + 0.01, dt=1.0)
    part = np.repeat(getattr(state, name), 2, axis=0)[::2]
    by_hand = dataclasses.replace(state, **{name: part})
    actual, expected = (contact.step(s, points, dt=1.0) for s in (by_hand, state))
    assert expected.n_contact > 20
    np.testing.assert_array_equal(actual.penetration, expected.penetration)
    np.testing.assert_array_equal(actual.status, expected.status)
