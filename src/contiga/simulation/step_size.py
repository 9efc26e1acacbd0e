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
from contiga.dynamics.stepping import AutoSteps
from contiga.errors import RunError
from contiga.num.ordered import length
from contiga.num.rigid_lanes import FORCE, MASS
from contiga.records import ContactStatus
from contiga.simulation.clock import Clock
from contiga.simulation.critical import Limit, limit_of
from contiga.simulation.model import Model
from contiga.simulation.signals import longest_sample
from contiga.simulation.step import Stepped, advance
from contiga.simulation.system_state import SystemState

RESOLVED = 0.025
"""Part of 1/ω of a body's fastest vibration, and of a radian of its turn, that a step takes: its
phase is right to ω²h²/24 then, its amplitude to ω²h²/8."""
DAMPED = 0.25
"""A decay γ counts as a vibration of so much of it: it has no phase to be right."""
LOST = 2e-6
"""Part of the largest energy so far that a step may leave nowhere."""
JUMPS = 0.2
"""Weight of work that may be missing, or too much, as chance has it."""
GROWTH = 1.5
COARSER = 2.0
"""A step that ends where one so much shorter would be taken is too long: it met something stiff."""
SPAN = 0.02
"""Part of its master's size that a slave may go in a step, where it may touch."""
SHORTEST = 0.01
"""Part of the step that stiffness and turns allow below which energy shortens no step."""
LEAST = 1e-9
"""Part of the longest step below which nothing shortens one."""
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
    # Forces that are the gradient of no energy leave some nowhere at any step.
    bearable = math.inf if any(p.contact.weights == "area" for p in model.contacts) else LOST
    stepped, before = None, math.inf
    while True:
        tried = advance(model, last, _until(last.time, step, stepping.end), clock)
        if not model.mechanism.moved:
            return tried
        step, missing = tried.state.step, _missing(model, last, tried.state)
        with clock("motion"):
            longest = COARSER * _allowed(model, stepping, tried.state)
        far = _too_far(model, last, tried.state)
        if far > 1.0 and step > LEAST * stepping.most:
            step *= max(0.1, 0.9 / far)
        elif step > longest:
            step = min(0.5 * step, longest)
        elif missing <= bearable * tried.state.most or step <= SHORTEST * min(longest, allowed):
            return tried
        elif stepped is not None and missing > BETTER * before:
            # What is nowhere does not come from the length of the step.
            return stepped
        else:
            stepped, before = tried, missing
            # What a point that comes in leaves nowhere falls with the square of the step.
            step *= min(0.5, max(0.05, 0.7 * math.sqrt(LOST * tried.state.most / missing)))


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
    fastest = max(math.sqrt(limit.bodies.square), DAMPED * limit.bodies.decay)
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
    return abs(state.energy.error - last.energy.error + owed) + JUMPS * _jumped(last, state)


def _jumped(last: SystemState, state: SystemState) -> float:
    """Work that may or may not have been done by damping that set in within the step.

    A damping force is there at once when a point comes in at a speed. The step counts half of its
    work over the whole step, wherever in it that was; of many points the errors are independent.
    """
    squares = 0.0
    for name, now in state.contacts.items():
        if len(now.damping) == 0:
            continue
        rows = np.flatnonzero((now.status == ContactStatus.NEW) & (now.damping != 0.0))
        way = now.points_B[rows] - last.contacts[name].points_B[rows]
        work = 0.5 * now.damping[rows] * (way * now.part("normal_B", rows)).sum(axis=1)
        squares += float((work * work).sum())
    return math.sqrt(squares)
