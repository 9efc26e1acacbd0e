"""How long the next step is: as given, or as long as contacts, springs and turns allow.

A step that chooses itself is at most a share of the critical one, short enough to follow whole
bodies on their contacts and springs and in their turns, and at most half as long again as the one
before. If it then leaves more energy nowhere than it may, or meets what is stiffer than it was
made for, it is taken again with half its length: so points come in and go out in short steps.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.lanes import FORCE, MASS
from contiga.dynamics.stepping import AutoSteps
from contiga.errors import RunError
from contiga.num.ordered import length
from contiga.simulation.clock import Clock
from contiga.simulation.critical import Limit, limit_of
from contiga.simulation.model import Model
from contiga.simulation.signals import longest_sample
from contiga.simulation.step import Stepped, advance
from contiga.simulation.system_state import SystemState

RESOLVED = 0.025
"""Part of 1/ω of a body's fastest vibration, and of a radian of its turn, that a step takes: its
phase is right to ω²h²/24 then, its amplitude to ω²h²/8."""
LOST = 2e-6
"""Part of the largest energy so far that a step may leave nowhere."""
GROWTH = 1.5
SPAN = 0.02
"""Part of its master's size that a slave may go in a step, where it may touch."""
SHORTEST = 1e-6
"""Of the step that stiffness and turns allow: shorter ones are not tried."""
BETTER = 0.6
"""Half a step that leaves more than this part of the energy of a whole one is no cure."""


def following(model: Model, last: SystemState, clock: Clock) -> Stepped:
    """The step after `last`.

    Raises
    ------
    RunError
        A given step is longer than the critical one.
    """
    stepping = model.stepping
    if isinstance(stepping, AutoSteps):
        return _chosen(model, stepping, last, clock)
    time = stepping.after(last.time)
    if model.mechanism.moved and not model.allow_unstable:
        with clock("motion"):
            _check(limit_of(model, last), time - last.time, last.time)
    return advance(model, last, time, clock)


def _check(limit: Limit, step: float, time: float) -> None:
    if step > limit.critical:
        raise RunError(
            f"t = {time:g}: the step of {step:.4g} is longer than the critical one of "
            f"{limit.critical:.4g}, that of {limit.of}: its vibrations would grow without bound. "
            f'Take a step below {0.9 * limit.critical:.3g}, or step = "auto"; '
            "allow_unstable lets it pass"
        )


def _chosen(model: Model, stepping: AutoSteps, last: SystemState, clock: Clock) -> Stepped:
    """A step as long as it may be."""
    with clock("motion"):
        allowed = _allowed(model, stepping, last)
    step = allowed if last.step == 0.0 else min(allowed, GROWTH * last.step)
    shortest = SHORTEST * allowed
    stepped, before = None, math.inf
    while True:
        tried = advance(model, last, _until(last.time, step, stepping.end), clock)
        missing = _missing(model, last, tried.state)
        if stepped is not None and missing > BETTER * before:
            # What is nowhere does not come from the length of the step.
            return stepped
        with clock("motion"):
            critical = limit_of(model, tried.state).critical
        step = tried.state.step
        far = _too_far(model, last, tried.state)
        fits = far <= 1.0 and step <= critical and missing <= LOST * tried.state.most
        if fits or step <= shortest or not model.mechanism.moved:
            return tried
        if far > 1.0:
            step *= max(0.1, 0.9 / far)
        elif step <= critical:
            stepped, before = tried, missing
            # What a point that comes in leaves nowhere falls with the square of the step.
            step *= min(0.5, max(0.05, 0.7 * math.sqrt(LOST * tried.state.most / missing)))
        else:
            step = min(0.5 * step, stepping.safety * critical)


def _too_far(model: Model, last: SystemState, state: SystemState) -> float:
    """How many times as far as it may go in a step a slave has gone against its master.

    It may go a small part of the master's size; or, of a slave that is clear of it, as far as no
    point of it can touch.
    """
    worst = 0.0
    for part in model.contacts:
        body, before = model.bodies[part.master].body, last.contacts[part.name]
        allowed = max(SPAN * body.size, _clear(before))
        if not math.isfinite(allowed):
            continue
        way = state.contacts[part.name].points_B - before.points_B
        square = (way * way).sum(axis=1).max(initial=0.0, where=np.isfinite(way).all(axis=1))
        worst = max(worst, math.sqrt(square) / allowed)
    return worst


def _clear(state: State) -> float:
    """How far all points can go before the first can touch; 0 where one is in contact."""
    if state.n_contact:
        return 0.0
    return float(state.safe_distance.min(initial=math.inf, where=state.safe_distance >= 0.0))


def _until(time: float, step: float, end: float) -> float:
    """When a step ends: the last two share what is left, so that none is tiny."""
    left = end - time
    if step >= left:
        return end
    return time + (step if 2.0 * step <= left else 0.5 * left)


def _allowed(model: Model, stepping: AutoSteps, last: SystemState) -> float:
    """What stiffness and turns allow."""
    if not model.mechanism.moved:
        return min(stepping.most, longest_sample(model))
    limit = limit_of(model, last)
    fastest = math.sqrt(limit.bodies.square)
    for i in model.mechanism.free:
        fastest = max(fastest, length(last.bodies.twists[i, 3:]))
    followed = RESOLVED / fastest if fastest > 0.0 else math.inf
    return min(stepping.most, longest_sample(model), stepping.safety * limit.critical, followed)


def _missing(model: Model, last: SystemState, state: SystemState) -> float:
    """Energy that a step leaves nowhere, but for what a leapfrog owes until the next one.

    Its kinetic energy stands h² F²/(8 m) above what the work of its forces has made it.
    """
    owed = 0.0
    for k, one in enumerate(model.mechanism.fixed):
        a, b = (rows[k, FORCE : FORCE + 3] for rows in (last.rigid, state.rigid))
        owed += float((b * b - a * a).sum()) * state.step * state.step / (8.0 * one[MASS])
    return abs(state.energy.error - last.energy.error + owed)
