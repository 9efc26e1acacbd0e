"""Steps into states that are handed back: the bits of steps into new ones, and what is refused."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg
from contiga.contact.state import State
from contiga.errors import InputError

N = 1200


def bits(state: State) -> dict[str, bytes]:
    return {f.name: np.asarray(getattr(state, f.name)).tobytes() for f in fields(State)}


def torus() -> cg.Body:
    return cg.Body([cg.shapes.torus()])


def bowl() -> cg.Body:
    """An open body."""
    whole = cg.shapes.torus()
    (u0, u1), v = whole.domain
    return cg.Body([whole.restricted((u0, u0 + 0.7 * (u1 - u0)), v)])


def falling(turning: bool = False) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points that fall through a torus and are lifted again, some of them not there at times."""
    rng = np.random.default_rng(4)
    points = rng.uniform([-2.7, -2.7, 0.3], [2.7, 2.7, 0.9], (N, 3))
    drift = rng.normal(scale=0.02, size=(N, 3)) - [0.0, 0.0, 0.07]
    for k in range(14):
        now = points + min(k, 20 - 2 * k) * drift
        now[k * 10 : k * 10 + 30 * (k > 0)] = np.nan
        angle = 0.05 * k if turning else 0.0
        yield now, cg.motion.pose.rotation([0.0, 1.0, 0.0], angle)


CONTACTS: dict[str, Callable[[cg.Slave], cg.Contact]] = {
    "closed": lambda slave: cg.Contact(torus(), slave, law=cg.PenaltyLaw(3.0)),
    "open": lambda slave: cg.Contact(bowl(), slave, law=cg.PenaltyLaw(3.0), on_edge="hold"),
    "by penetration": lambda slave: cg.Contact(
        torus(), slave, law=cg.PenaltyLaw(3.0), search="penetration"
    ),
    "held through": lambda slave: cg.Contact(
        torus(), slave, law=cg.PenaltyLaw(3.0), through="hold"
    ),
    "damped, with friction": lambda slave: cg.Contact(
        torus(), slave, law=cg.PenaltyLaw(3.0, damping=0.2), friction=cg.Coulomb(0.3)
    ),
    "measured": lambda slave: cg.Contact(
        torus(), slave, law=cg.PenaltyLaw(3.0, per_area=True), area=cg.CloudArea(), weights="area"
    ),
}


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("name", CONTACTS)
def test_states_handed_back_get_the_bits_of_new_ones(name: str, turning: bool) -> None:
    way = list(falling(turning))
    contact = CONTACTS[name](cg.Slave(way[0][0], area=np.linspace(1.0, 2.0, N)))
    plain = [contact.start(way[0][0], way[0][1])]
    for points, pose in way[1:]:
        plain.append(contact.step(plain[-1], points, pose, dt=0.1))
    assert max(state.n_contact for state in plain) > 50
    wanted = [bits(state) for state in plain]

    state, spare = contact.start(way[0][0], way[0][1]), plain[7]
    for k, (points, pose) in enumerate(way[1:], start=1):
        before = bits(state)
        new = contact.step(state, points, pose, dt=0.1, out=spare)
        assert new is spare
        assert bits(state) == before
        assert bits(new) == wanted[k]
        state, spare = new, state


def test_quadrature_points_are_reused_too() -> None:
    sheet = cg.Slave(*square_sheet(4.0, 12))
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(ball, sheet, law=cg.PenaltyLaw(5.0, per_area=True), quadrature=3)
    up = [[0.0, 0.0, z] for z in (1.05, 0.98, 0.96, 0.99, 1.02)]
    plain = [contact.start(sheet.points + up[0])]
    for z in up[1:]:
        plain.append(contact.step(plain[-1], sheet.points + z))
    assert plain[2].n_contact > 0
    wanted = [bits(state) for state in plain]
    state, spare = contact.start(sheet.points + up[0]), plain[2]
    for k, z in enumerate(up[1:], start=1):
        state, spare = contact.step(state, sheet.points + z, out=spare), state
        assert bits(state) == wanted[k]


@pytest.fixture
def fallen() -> tuple[cg.Contact, State, State, np.ndarray]:
    """A contact, two states of it, and where its points are next."""
    way = list(falling())
    contact = CONTACTS["closed"](cg.Slave(way[0][0], area=np.ones(N)))
    first = contact.step(contact.start(way[0][0]), way[1][0])
    return contact, first, contact.step(first, way[2][0]), way[3][0]


Fallen = tuple[cg.Contact, State, State, np.ndarray]


def refused(contact: cg.Contact, state: State, points: np.ndarray, out: Any, match: str) -> None:
    kept = bits(out) if isinstance(out, State) and out.__dict__ else None
    with pytest.raises(InputError, match=match) as error:
        contact.step(state, points, out=out)
    assert str(error.value.where).startswith("out")
    assert kept is None or bits(out) == kept


def test_a_state_that_is_needed_or_of_others_is_refused(fallen: Fallen) -> None:
    contact, old, state, points = fallen
    start = next(falling())[0]
    other = CONTACTS["closed"](cg.Slave(start, area=np.ones(N)))
    refused(contact, state, points, state, "must not be the state that the step goes on from")
    refused(contact, state, points, other.start(start), "a state of this contact")
    refused(contact, state, points, State(**old.arrays), "a state of this contact")
    refused(contact, state, points, old.arrays, "State")
    refused(contact, state, points, [old], "State")


def test_a_state_whose_arrays_others_need_is_refused(fallen: Fallen) -> None:
    contact, old, state, points = fallen
    refused(contact, state, points, copy.copy(state), "shares memory")
    shared = State(**(old.arrays | {"safe_distance": state.safe_distance}), of=contact)
    refused(contact, state, points, shared, "shares memory")
    refused(contact, state, old.points_B, old, "shares memory")
    refused(contact, state, old.points_B[::-1][::-1], old, "shares memory")


def test_arrays_that_cannot_be_written_to_are_refused(fallen: Fallen) -> None:
    contact, old, state, points = fallen
    read_only = old.uv.copy()
    read_only.flags.writeable = False
    for name, wrong in (
        ("uv", read_only),
        ("last_patch", old.last_patch.astype(np.int64)),
        ("status", old.status[:-1]),
        ("points_B", np.asfortranarray(old.points_B)),
        ("patch", old.patch.tolist()),
    ):
        made = State(**(old.arrays | {name: wrong}), of=contact)
        with pytest.raises(InputError, match="that can be written to") as error:
            contact.step(state, points, out=made)
        assert error.value.where == f"out.{name}"


class Failing(cg.PenaltyLaw):
    """A law that cannot answer."""

    def respond(self, pressed: cg.LawInput) -> cg.LawOutput:
        raise ZeroDivisionError


def test_a_step_that_fails_leaves_nothing_half_written(fallen: Fallen) -> None:
    contact, old, state, points = fallen
    before = bits(state)
    with pytest.raises(InputError):
        contact.step(state, points, dt=-1.0, out=old)
    assert old.n_contact >= 0  # refused before anything was written
    law, contact.law = contact.law, Failing(3.0)
    with pytest.raises(ZeroDivisionError):
        contact.step(state, points, out=old)
    contact.law = law
    with pytest.raises(AttributeError, match="the out of a step that failed"):
        _ = old.status
    with pytest.raises(AttributeError, match="the out of a step that failed"):
        _ = old.penetration
    assert bits(state) == before
    with pytest.raises(InputError, match="a state of this contact"):
        contact.step(state, points, out=old)
