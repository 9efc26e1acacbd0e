"""A state keeps of many arrays only the rows in contact, and nobody can tell."""

from __future__ import annotations

import copy
import pickle
from dataclasses import fields

import numpy as np
import pytest

import contiga as cg
from contiga.contact.loads import Column, Guards, KeptColumns, guard_states_of
from contiga.contact.state import State

N = 400


def _contact(**options: object) -> cg.Contact:
    slave = cg.Slave(np.zeros((N, 3)), area=np.linspace(1.0, 2.0, N))
    law = cg.PenaltyLaw(5.0, per_area=True, damping=0.3)
    return cg.Contact(cg.Body([cg.shapes.sphere()]), slave, law=law, **options)  # type: ignore[arg-type]


def _places() -> list[np.ndarray]:
    rng = np.random.default_rng(12)
    on = rng.normal(size=(N, 3))
    on /= np.linalg.norm(on, axis=1)[:, None]
    deep = rng.uniform(-0.02, 0.02, (N, 1))
    ways = (1.05, 1.0 + deep, 0.99 + deep, 1.002 + deep)
    return [np.ascontiguousarray(way * on) for way in ways]


def _run(contact: cg.Contact, *, dense: bool) -> list[State]:
    start, *places = _places()
    states = [contact.start(start)]
    for points in places:
        last = State(**states[-1].arrays, of=contact) if dense else states[-1]
        states.append(contact.step(last, points, dt=0.1))
    return states


@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.3)])
def test_steps_from_whole_arrays_have_the_same_bits(friction: cg.Coulomb | None) -> None:
    contact = _contact(friction=friction)
    assert 50 < _run(contact, dense=False)[-1].n_contact < N
    for a, b in zip(_run(contact, dense=False), _run(contact, dense=True), strict=True):
        for field in fields(State):
            x, y = getattr(a, field.name), getattr(b, field.name)
            assert x.shape == y.shape, field.name
            assert x.dtype == y.dtype
            assert x.tobytes() == y.tobytes(), field.name


def test_parts_and_rows_that_are_not_zero_are_those_of_the_whole_array() -> None:
    contact = _contact()
    state = _run(contact, dense=False)[-1]
    whole = State(**copy.copy(state).arrays, of=contact)
    rows = np.arange(0, N, 3)
    for name in ("penetration", "normal_force", "stiffness", "damping", "memory"):
        for one in (state, whole):
            part = getattr(one.kept, name).at(rows)
            np.testing.assert_array_equal(part, getattr(whole, name)[rows])
    for name in ("penetration", "normal_force", "damping"):
        for one in (state, whole):
            own, values = getattr(one.kept, name).nonzero()
            np.testing.assert_array_equal(own, np.flatnonzero(getattr(whole, name)))
            np.testing.assert_array_equal(values, getattr(whole, name)[own])
    assert state.max_penetration == whole.penetration.max()


def test_arrays_without_contact_are_not_made_until_they_are_asked_for() -> None:
    state = _run(_contact(), dense=False)[-1]
    held = {name for name, value in vars(state).items() if isinstance(value, np.ndarray)}
    assert not held & {"penetration", "normal_force", "force", "foot_B", "stiffness"}
    assert state.force is state.force
    np.testing.assert_array_equal(state.foot_B[state.patch < 0], state.points_B[state.patch < 0])
    assert not np.shares_memory(state.foot_B, state.points_B)


def test_states_are_copied_and_pickled_and_have_no_other_names() -> None:
    state = _run(_contact(), dense=False)[-1]
    for other in (copy.deepcopy(state), pickle.loads(pickle.dumps(state))):
        np.testing.assert_array_equal(other.force, state.force)
    with pytest.raises(AttributeError, match="forces"):
        state.forces  # type: ignore[attr-defined]  # noqa: B018


def test_a_law_may_go_on_with_the_arrays_it_answered() -> None:
    class Reusing:
        """Answers the same arrays, written anew, at every step."""

        n_memory = 0
        needs_mass = needs_thickness = False
        force = np.zeros(0)

        def respond(self, inp: cg.LawInput) -> cg.LawOutput:
            if len(self.force) != len(inp.penetration):
                self.force = np.empty(len(inp.penetration))
            self.force[:] = 3.0 * inp.penetration
            ones = np.ones(len(self.force))
            return cg.LawOutput(self.force, 3.0 * ones, ones, np.zeros((len(ones), 0)))

    slave = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    contact = cg.Contact(cg.Body([cg.shapes.sphere()]), slave, law=Reusing())
    first = contact.step(contact.start(slave.points), [[0.0, 0.0, 0.9]])
    contact.step(first, [[0.0, 0.0, 0.8]])
    assert first.normal_force[0] == pytest.approx(0.3)


def test_no_rows_at_all() -> None:
    none = Column(np.zeros(0, np.int32), np.zeros((0, 2)))
    np.testing.assert_array_equal(none.at(np.array([0, 2])), np.zeros((2, 2)))


@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.3)])
def test_what_the_next_step_asks_is_the_same_of_whole_arrays(friction: cg.Coulomb | None) -> None:
    state = _run(_contact(friction=friction), dense=False)[-1]
    kept, same = state.kept, State(**copy.copy(state).arrays).kept
    for name, one, other in zip(KeptColumns._fields, kept, same, strict=True):
        assert (one is None) == (other is None), name
        for a, b in zip(one or (), other or (), strict=True):
            np.testing.assert_array_equal(a, b, name)
            assert a.dtype == b.dtype, name


def test_points_in_contact_stand_in_the_world_as_all_do() -> None:
    contact, points = _contact(), _places()
    pose = cg.motion.pose.rotation([1.0, 2.0, 3.0], 0.7, centre=(0.1, 0.2, 0.3))
    placed = [cg.motion.pose.apply(pose, place) for place in points]
    state = contact.step(contact.start(placed[0], pose), placed[2], pose, dt=0.1)
    assert state.n_contact > 5
    rows, places = state.held_W.points
    np.testing.assert_array_equal(rows, np.flatnonzero(state.in_contact))
    np.testing.assert_allclose(places, placed[2][rows], atol=1e-13)
    np.testing.assert_array_equal(state.held_W.normals.values, state.normal[rows])


def test_of_what_there_is_not_the_arrays_are_empty() -> None:
    law = cg.PenaltyLaw(5.0)
    slave = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    state = cg.Contact(cg.Body([cg.shapes.sphere()]), slave, law=law).start(slave.points)
    for name, shape in (
        ("damping", (0,)), ("viscosity", (0,)), ("friction_memory", (1, 0)),
        ("stiffness_bound", (0,)), ("traction_B", (0, 3)), ("tangential", (0,)),
    ):  # fmt: skip
        assert getattr(state.kept, name) is None
        assert getattr(state, name).shape == shape


def test_what_holds_points_is_told_of_other_points_too_and_zero_of_those_not_held():
    held = Column(np.array([1, 4, 6]), np.array([0.1, 0.2, 0.3]))
    normal, guard = np.eye(3), np.array([[0.0, 0.6, 0.8]])
    holds = guard_states_of(held, normal, Guards(np.array([4]), guard))
    guards, depth, opposed = holds.at(np.array([0, 1, 4, 7, 6]))
    none = np.zeros(3)
    np.testing.assert_array_equal(guards, [none, normal[0], guard[0], none, normal[2]])
    np.testing.assert_array_equal(depth, [0.0, 0.1, 0.2, 0.0, 0.3])
    assert opposed.dtype == np.bool_
    assert opposed.tolist() == [False, False, True, False, False]
    assert [len(each) for each in holds.at(np.zeros(0, np.int64))] == [0, 0, 0]
