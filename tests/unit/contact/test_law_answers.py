"""What a law answers beside its force: stiffness, stored energy, and what it remembers."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest

import contiga as cg
from contiga.contact.respond import checked_output
from contiga.errors import InputError

PLANE = cg.Body([cg.shapes.plane()])
CLOUD = cg.Slave([[x, y, 0.0] for x in (-0.3, 0.2) for y in (-0.2, 0.3)], area=[0.5, 1.0, 2.0, 4.0])


class Deepest:
    """Answers how deep each point has ever been, and how many steps it has been in contact."""

    needs_mass = needs_thickness = False
    n_memory = 2

    def respond(self, inp: cg.LawInput) -> cg.LawOutput:
        deepest = np.maximum(inp.penetration, inp.memory[:, 0])
        none = np.zeros(len(deepest))
        return cg.LawOutput(deepest, none, none, np.column_stack([deepest, inp.memory[:, 1] + 1]))


def heights(*z: float) -> np.ndarray:
    return np.asarray(CLOUD.points + np.array(z)[:, None] * [0.0, 0.0, 1.0])


def test_memory_is_each_points_own_and_is_lost_where_it_leaves() -> None:
    contact = cg.Contact(PLANE, CLOUD, law=Deepest())
    state = contact.start(heights(0.1, 0.1, 0.1, 0.1))
    np.testing.assert_array_equal(state.memory, np.zeros((4, 2)))
    state = contact.step(state, heights(-0.01, -0.02, 0.1, 0.1))
    state = contact.step(state, heights(-0.03, -0.01, -0.04, 0.1))
    np.testing.assert_allclose(state.memory[:, 0], [0.03, 0.02, 0.04, 0.0], rtol=1e-12)
    np.testing.assert_array_equal(state.memory[:, 1], [2, 2, 1, 0])
    state = contact.step(state, heights(0.1, -0.005, -0.01, 0.1))
    state = contact.step(state, heights(-0.01, -0.005, -0.01, -0.02))
    np.testing.assert_allclose(state.memory[:, 0], [0.01, 0.02, 0.04, 0.02], rtol=1e-12)
    np.testing.assert_array_equal(state.memory[:, 1], [1, 4, 3, 1])
    np.testing.assert_allclose(state.force[:, 2], state.memory[:, 0], rtol=1e-12)


def test_a_state_of_another_law_is_refused() -> None:
    state = cg.Contact(PLANE, CLOUD, law=Deepest()).start(heights(0.1, 0.1, 0.1, 0.1))
    other = cg.Contact(PLANE, CLOUD, law=cg.PenaltyLaw(1.0))
    with pytest.raises(InputError, match=r"state belongs to another law.*\(4, 2\).*\(4, 0\)"):
        other.step(state, heights(0.0, 0.0, 0.0, 0.0))
    other.step(replace(state, memory=np.zeros((4, 0))), heights(0.0, 0.0, 0.0, 0.0))


def test_stiffness_and_energy_of_a_state_are_those_of_its_law() -> None:
    contact = cg.Contact(PLANE, CLOUD, law=cg.PenaltyLaw(8.0, per_area=True))
    state = contact.start(heights(0.1, 0.1, 0.1, 0.1))
    state = contact.step(state, heights(-0.5, 0.1, -0.25, -1.0))
    np.testing.assert_allclose(state.stiffness, [4.0, 0.0, 16.0, 32.0], rtol=1e-12)
    assert state.energy.stored == pytest.approx(0.5 + 0.5 + 16.0)


def test_plain_laws_answer_arrays_of_their_own() -> None:
    seen = cg.LawInput(*np.full((3, 4), 0.25), None, np.ones(4), 0.0, np.zeros((4, 0)))
    for law in (cg.AdaptiveLaw(), cg.PenaltyLaw(2.0), cg.PenaltyLaw(2.0, per_area=True)):
        for inp in (seen, seen._replace(dt=0.5)):
            answer = checked_output(law, inp)
            kept = [answer.force, answer.stiffness, answer.stored, answer.memory]
            assert all(array.flags.carray for array in kept)
            assert [array.shape for array in kept] == [(4,), (4,), (4,), (4, 0)]
            given = [inp.penetration, inp.rate, inp.area, inp.mass]
            pairs = [*combinations(kept, 2), *product(kept, given)]
            assert not any(np.shares_memory(one, other) for one, other in pairs)


class TooFew(cg.PenaltyLaw):
    """A law derived from a plain one, that answers a row too few."""

    def respond(self, inp: cg.LawInput) -> cg.LawOutput:
        return super().respond(inp)._replace(force=np.ones(len(inp.penetration) - 1))


def test_laws_derived_from_plain_ones_are_looked_at() -> None:
    contact = cg.Contact(PLANE, CLOUD, law=TooFew(1.0))
    state = contact.start(heights(0.1, 0.1, 0.1, 0.1))
    with pytest.raises(InputError, match="one row a point in contact"):
        contact.step(state, heights(-0.1, -0.1, 0.1, 0.1))
