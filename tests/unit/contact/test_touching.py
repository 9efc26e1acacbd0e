"""Few points in contact at once, by one kernel: the bits of the questions one after the other."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.sample import FULL
from tests.scenes import box

import contiga as cg
from contiga.contact import at_once, closed_body
from contiga.contact.kernels import touching_nb
from contiga.contact.state import State
from contiga.contact.step_buffers import MOST
from contiga.jit.pinned import AT_ADDRESS
from contiga.search.exact_surface import ExactSurface

N = 70 if FULL else 50


def shell() -> cg.Body:
    """A ball with a hole in it: there are walls to go through, and rooms to come out in."""
    return cg.Body([cg.shapes.sphere(), cg.shapes.sphere(radius=0.7).flipped()])


BODIES: dict[str, Callable[[], cg.Body]] = {  # each with the search on it, built once
    "shell": cache(shell),
    "torus": cache(lambda: cg.Body([cg.shapes.torus()])),
    "slab": cache(lambda: box((-2.0, -2.0, -0.1), (2.0, 2.0, 0.1))),
}
HOW: dict[str, dict[str, Any]] = {
    "plain": {},
    "by penetration": {"search": "penetration", "depth": 0.3},
    "held": {"on_edge": "hold", "friction": cg.Coulomb(0.3)},
}


def shaken(body: cg.Body, way: float, turned: bool) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points about the bodies that go some way at every step, or lie still, or are not there."""
    rng = np.random.default_rng(11)
    points = 1.1 * rng.uniform(*body.bounds(), (N, 3))
    for k in range(14):
        points = points + way * rng.normal(size=points.shape) * (k % 4 > 0)
        now = points.copy()
        now[3 * k : 3 * k + 2] = np.nan
        yield now, cg.motion.pose.rotation("y", 0.1 * k if turned else 0.3)


def states(body: cg.Body, how: dict[str, Any], way: float, turned: bool) -> list[State]:
    (start, pose), *rest = shaken(body, way, turned)
    slave = cg.Slave(np.zeros((N, 3)), area=np.linspace(1.0, 2.0, N))
    contact = cg.Contact(body, slave, law=cg.PenaltyLaw(3.0, damping=0.1), **how)
    values = [contact.start(start, pose)]
    for points, pose in rest:
        values.append(contact.step(values[-1], points, pose, dt=0.1))
    return values


def bits(state: State) -> dict[str, bytes]:
    return {f.name: np.asarray(getattr(state, f.name)).tobytes() for f in fields(State)}


@pytest.fixture
def answers(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, ...]]:
    """What the kernels answer, as (touching, near, left, held), while a test runs."""
    told: list[tuple[int, ...]] = []

    def advance(*given: Any) -> Any:
        told.append(touching_nb.advance(*given))
        return told[-1]

    def touch(*given: Any) -> Any:
        told.append((len(given[0]), 0, touching_nb.touch(*given)[1], 0))
        return 0, told[-1][2]

    def stay_free(*given: Any) -> Any:
        told.append((0, len(given[0]), touching_nb.stay_free(*given), -1))
        return told[-1][2]

    for module in (at_once, closed_body):
        kernels = SimpleNamespace(**vars(touching_nb))
        kernels.advance, kernels.touch, kernels.stay_free = advance, touch, stay_free
        monkeypatch.setattr(module, "touching_nb", kernels)
    return told


@pytest.mark.parametrize(
    ("name", "how", "turned"),
    [
        (name, how, turned)
        for name in BODIES
        for how in HOW
        for turned in (False, True)
        if FULL or not turned or (name, how) == ("torus", "held")
    ],
)
def test_at_once_the_bits_are_those_of_one_by_one(
    monkeypatch: pytest.MonkeyPatch,
    answers: list[tuple[int, ...]],
    name: str,
    how: str,
    turned: bool,
) -> None:
    body, ways = BODIES[name](), (0.0005, 0.05, 0.3)
    now = [states(body, HOW[how], way, turned) for way in ways]
    assert sum(left == 0 and touching > 0 for touching, _, left, _ in answers) > 3
    free = [left for _, near, left, _ in answers if near > 0]
    assert min(free.count(0), sum(left > 0 for left in free)) > 3
    assert (touching_nb.TURNED in [left for _, _, left, _ in answers]) == turned
    assert max(state.n_contact for seen in now for state in seen) > 3
    monkeypatch.setattr(ExactSurface, "pinned_parts", lambda *_: None)
    asked = len(answers)
    for way, seen in zip(ways, now, strict=True):
        for k, (a, b) in enumerate(zip(seen, states(body, HOW[how], way, turned), strict=True)):
            assert bits(a) == bits(b), (way, k)
    assert len(answers) == asked


def test_balls_are_worked_out_when_a_point_first_needs_them(
    answers: list[tuple[int, ...]],
) -> None:
    points = np.array([[0.0, 0.0, 1.1]])
    contact = cg.Contact(
        cg.Body([cg.shapes.sphere()]), cg.Slave(points, area=[1.0]), law=cg.PenaltyLaw(1.0)
    )
    state = contact.step(contact.start(points), points - [0.0, 0.3, 0.2])
    assert state.n_contact == 1
    for k in range(1, 30):
        state = contact.step(state, points - [0.0, 0.3, 0.2 + 0.01 * k])
    assert sum(left == touching_nb.NO_BALLS for _, _, left, _ in answers) == 1
    assert answers[-1] == (1, 0, 0, 1)


def test_of_many_points_nothing_is_done_at_once(answers: list[tuple[int, ...]]) -> None:
    n = MOST + 1
    angle = np.linspace(0.0, 6.0, n)
    around = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    contact = cg.Contact(
        cg.Body([cg.shapes.sphere()]), cg.Slave(around, area=np.ones(n)), law=cg.PenaltyLaw(1.0)
    )
    state = contact.step(contact.start(1.1 * around), 0.99 * around)
    assert state.n_contact == n
    assert contact.step(state, 0.98 * around).n_contact == n
    assert answers[-1] == (n, 0, touching_nb.MANY, 0)


def test_a_body_that_is_gone_takes_what_was_laid_out_with_it() -> None:
    def stepped() -> list[Any]:
        points, body = np.array([[0.3, 0.2, 1.1]]), cg.Body([cg.shapes.sphere()])
        contact = cg.Contact(body, cg.Slave(points, area=[1.0]), law=cg.PenaltyLaw(1.0))
        state = contact.start(points)
        for k in range(1, 5):
            state = contact.step(state, points - [0.0, 0.0, 0.15 + 0.02 * k])
        assert state.n_contact == 1
        pinned = body.surface.pinned_parts(True)
        assert AT_ADDRESS[pinned[0].address] is pinned[0]
        return [part.address for part in pinned]

    places = stepped()
    gc.collect()
    assert not any(place in AT_ADDRESS for place in places)


def test_of_triangles_nothing_is_done_at_once() -> None:
    assert cg.Body([cg.shapes.sphere()]).tessellate(0.05).surface.pinned_parts(False) is None
