"""The critical step of a state is worked out once, and anew for another state."""

from __future__ import annotations

import gc
from dataclasses import replace

import pytest

import contiga as cg
from contiga.simulation import critical
from contiga.simulation.critical import limit_of


def falling() -> cg.Simulation:
    """A ball on a node that stands still."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    node = cg.Slave([[0.0, 0.0, -1.001]], area=[1.0])
    return cg.Simulation(
        bodies={"ball": (ball, cg.motion.Free(ball.mass_properties(1.0), velocity=(0, 0, -1.0)))},
        slaves={"node": node},
        contacts=[cg.Contact(ball, node, law=cg.PenaltyLaw(50.0))],
        end=0.05,
        step="auto",
    )


def touching(simulation: cg.Simulation) -> cg.SystemState:
    """After a few steps."""
    state = simulation.start()
    while not state.n_contact:
        state = simulation.step(state)
    return state


def test_a_state_keeps_its_limit_and_another_has_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = falling()
    free, state = simulation.start(), touching(simulation)
    limit, asked = limit_of(simulation, state), []
    monkeypatch.setattr(critical, "find_limit", lambda *what: asked.append(what) or limit)
    assert limit.critical < 1.0
    assert limit_of(simulation, replace(state, shaking=3.0, leak=1.0)) is limit
    assert asked == []
    for other in (free, replace(state, contacts=free.contacts)):
        limit_of(simulation, other)
    limit_of(simulation, state, "following")
    limit_of(falling(), state)
    assert len(asked) == 4


def test_limits_go_with_their_states() -> None:
    gc.collect()
    before = len(critical._LIMITS)
    state = touching(falling())
    limit_of(falling(), state)
    gc.collect()
    assert before < len(critical._LIMITS) <= before + 2
    del state
    gc.collect()
    assert len(critical._LIMITS) == before
