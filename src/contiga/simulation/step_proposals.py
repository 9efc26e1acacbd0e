"""What a step is proposed by, from the state it begins at: the longest that each reason allows."""

from __future__ import annotations

import math
from collections.abc import Iterator

from contiga.arrays.ordered import length
from contiga.dynamics.stepping import AutoSteps
from contiga.simulation.critical import Limit, Rates, limit_of
from contiga.simulation.model import Model
from contiga.simulation.place import forces_on
from contiga.simulation.reasons import Cut, Reason
from contiga.simulation.signals import longest_sample
from contiga.simulation.system_state import SystemState
from contiga.simulation.way_limits import driven_ways

RESOLVED = 0.018
"""Part of 1/ω of a body's fastest vibration that a step takes where that has all the energy: its
phase is right to ω²h²/24 then, its amplitude to ω²h²/8."""
OF_NODES = 0.0144
"""What the shaking of free nodes counts for: steps of 0.15/ω, eight times as long, follow them."""
OF_DRAG = 0.0162
"""The same of a decay γ by viscous friction that changes as fast: steps of 0.14/γ follow it."""
DAMPED = 0.25
"""A decay γ counts as a vibration of so much of it: it has no phase to be right."""
TURNED, DRIVEN = 0.025, 0.1
"""Of a radian, that a free body turns in a step, and one whose turns a motion says exactly."""
SHORTEST = 0.002
"""Part of the critical step below which nothing but stability, ways and kinks shortens one: a fifth
of what follows a swing that has all the energy."""
SHORTEST_OF_ELEMENTS = 0.05
"""The same where elements ring: from there steps grow slowly."""
GROWTH = 1.5
GROWTH_OF_ELEMENTS, GAINED = 1.1, 2e-6
"""What a leapfrog keeps of elements is E − h² Σ F²/(8 m), so that a step which is cut while a
contact pushes and grows while it does not adds energy every time. It grows by so little, and
changes that by no more than a part of the largest energy."""


def proposals(model: Model, stepping: AutoSteps, state: SystemState) -> Iterator[Cut]:
    """All of them, for the step after `state`, which says how forces have changed before."""
    others = [
        Cut(stepping.most, Reason.LARGEST),
        Cut(longest_sample(model), Reason.SAMPLE),
        *driven_ways(model, stepping.most, state),
        *met(model, stepping, state),
    ]
    yield from others
    if 0.0 < state.step < min(others).step:  # of others nothing grows, and elements cost a pass
        yield Cut(_grown(model, state), Reason.GROWTH)


def met(model: Model, stepping: AutoSteps, state: SystemState) -> Iterator[Cut]:
    """Those of what a step may meet that was not foreseen at its start: turns and stiffness."""
    yield from _turns(model, state)
    if not model.mechanism.moved:
        return
    limit = limit_of(model, state, "lasting")
    yield Cut(stepping.safety * limit.critical, Reason.CRITICAL, limit.of)
    energetic = math.sqrt(2.0 * state.peak_energy)
    # Of the start nothing is known: as if all there is swung.
    shaking = state.shaking if state.step else _at_start(limit) * energetic
    if shaking > 0.0:
        followed = RESOLVED * math.sqrt(energetic / shaking)
        least = shortest_step(model, stepping, limit.critical)
        yield Cut(max(followed, least), Reason.SWING, limit.of)


def _grown(model: Model, state: SystemState) -> float:
    """A step that is longer than the one before it."""
    if not model.mechanism.deforms:
        return GROWTH * state.step
    square, kicks = state.step * state.step, kicks_of_elements(model, state)
    if kicks > 0.0:
        square = min(square + GAINED * state.peak_energy / kicks, GROWTH_OF_ELEMENTS**2 * square)
    return math.sqrt(square)


def kicks_of_elements(model: Model, state: SystemState) -> float:
    """Σ F²/(8 m) over the nodes of elements."""
    return sum(
        nodes.kick_energy(state.slaves[name], forces_on(model, name, state.contacts), model.gravity)
        for name, nodes in model.mechanism.nodes.items()
    )


def shortest_step(model: Model, stepping: AutoSteps, critical: float) -> float:
    """The step that nothing but stability, ways and kinks goes below."""
    part = SHORTEST_OF_ELEMENTS if model.mechanism.deforms else SHORTEST
    return stepping.shortest or part * min(critical, stepping.most)


def fastest_of(rates: Rates) -> float:
    """The ω that things swing with at most, 1/time."""
    return max(math.sqrt(rates.square), DAMPED * rates.decay)


def _at_start(limit: Limit) -> float:
    """ω² as the shaking of all there is counts it."""
    return max(fastest_of(limit.bodies) ** 2, OF_NODES * fastest_of(limit.nodes) ** 2)


def _turns(model: Model, state: SystemState) -> Iterator[Cut]:
    """By how far bodies turn."""
    names, system = list(model.bodies), model.mechanism
    for i in (*system.free.tolist(), *system.driven):
        spin = length(state.bodies.twists[i, 3:])
        if spin > 0.0:
            part = TURNED if i in system.row else DRIVEN
            yield Cut(part / spin, Reason.TURN, f"body {names[i]!r}")
