"""What a state keeps of the points in contact, and the arrays that are made of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.contact.loads import Loads
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of

N = 40


def states(**options: Any) -> list[State]:
    """A state of points on a ball that a contact has made, and one of its arrays."""
    rng = np.random.default_rng(3)
    on = rng.normal(size=(N, 3))
    on /= np.linalg.norm(on, axis=1)[:, None]
    law = cg.PenaltyLaw(5.0, damping=options.pop("damping", 0.0))
    slave = cg.Slave(on, area=np.ones(N))
    contact = cg.Contact(cg.Body([cg.shapes.sphere()]), slave, law=law, **options)
    state = contact.step(contact.start(1.1 * on), (0.99 + 0.02 * rng.random((N, 1))) * on, dt=0.1)
    assert 5 < state.n_contact < N
    return [state, State(**contact.step(contact.start(1.1 * on), state.points_B, dt=0.1).arrays)]


def as_whole(column: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    rows, values = column
    whole = np.zeros((N, *values.shape[1:]))
    whole[rows] = values
    return whole


@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("friction", [None, cg.Coulomb(0.3)])
def test_what_the_next_step_asks_is_the_same_of_whole_arrays(
    damping: float, friction: cg.Coulomb | None
) -> None:
    kept, whole = states(damping=damping, friction=friction)
    rows, same = kept_of(kept), kept_of(whole)
    for one, other in zip((rows.deep, *rows.carried), (same.deep, *same.carried), strict=True):
        np.testing.assert_array_equal(as_whole(one), as_whole(other))
    made = {"penetration", "normal_force", "normal_B", "damping", "traction_B"} & vars(kept).keys()
    assert not made, made  # no whole array for that
    width = friction.n_memory if friction else 0
    for name, columns in (("memory", 0), ("friction_memory", width)):
        assert rows.shape(name) == same.shape(name) == (N, columns)


def test_of_what_there_is_not_the_arrays_are_empty() -> None:
    kept, _ = states()
    for name, shape in (
        ("damping", (0,)), ("viscosity", (0,)), ("friction_memory", (N, 0)),
        ("traction_B", (0, 3)), ("tangential", (0,)),
    ):  # fmt: skip
        assert kept_of(kept).shape(name) == getattr(kept, name).shape == shape


def test_forces_may_be_those_of_other_points() -> None:
    rows, one, three = np.array([2], np.int32), np.ones(1), np.ones((1, 3))
    loads = Loads(rows, one, three, three, rows, one, one, np.zeros((1, 0)), None)
    assert loads.column("force", np.zeros((N, 3))) is None
    own = loads._replace(world=three).column("force", np.zeros((N, 3)))
    assert own is not None
    assert own.whole().sum() == 3.0
