"""What is held against a step once it is worked out: how far points went, what it met, energy."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import row_products
from contiga.contact.state_rows import kept_of
from contiga.dynamics.stepping import AutoSteps
from contiga.records import ContactStatus
from contiga.rigid.rigid_lanes import FORCE, MASS
from contiga.simulation.critical import has_energy, limit_of
from contiga.simulation.hand_over import HandOver, hand_over
from contiga.simulation.ledger import load_work_beyond_way
from contiga.simulation.model import Model
from contiga.simulation.reasons import Cut, Reason
from contiga.simulation.shaking import (
    changes_of_points,
    dragging_of,
    shaking_of,
    shaking_of_nodes,
    unbalanced,
)
from contiga.simulation.step import Stepped
from contiga.simulation.step_proposals import (
    DAMPED,
    OF_DRAG,
    OF_NODES,
    fastest_of,
    kicks_of_elements,
    met,
    shortest_step,
)
from contiga.simulation.system_state import SystemState
from contiga.simulation.way_limits import crossed, too_far

LOST = 4e-6
"""Part of the largest energy so far that a step may miss in the balance: a thousandth in all where
each of 250 steps leaves so much, and hardly any does."""
LOST_OF_ELEMENTS = 2e-5
"""The same where elements ring: what many steps miss has both signs, and is a thousandth in all."""
LEAKED = 2.0
"""So many times the energy a time that shorter steps have not kept is let pass."""
LEARNT = 0.25
"""Part by which one step that does not help is believed: a force that jumps looks the same once."""
JUMPS = 0.2
"""Weight of work that may be missing, or too much, as chance has it."""
COARSER = 2.0
"""A step that ends where one so much shorter would be taken is too long: it met something stiff."""
SAME = 1.05
"""Times the shortest step that a step may be and need not be taken again."""
LEAST = 1e-9
"""Part of the longest step below which nothing shortens one."""
FORGOTTEN = 0.05
"""Part of ω that a swing is forgotten by."""
UNFOLLOWED = (0.5, 1e-4), (0.3, 1e-3)
"""ω h from which on single points that swing are not followed, and the part of the velocity of all
the energy that the kick of a step must change by for that to show: a rebound is off by (ω h)²/8."""
PHASED = 0.05
"""ω h up to which single points are right to phase for a while: fifteen swings take 0.01 rad."""
SWUNG = 1e-3
"""Part of the velocity of all the energy that single points swing with where their phase counts."""
PARTED = 1e-4
"""And with which depths of points that share a force part; less where they turn round."""
HANDED = 1e-4
"""Part of that velocity that a step changes by where what is handed on counts."""


class Try(NamedTuple):
    """A step that was worked out, and what it shows."""

    stepped: Stepped
    cut: Cut
    """Why it was no longer."""
    shaking: float
    missing: float
    """Its energy balance error."""
    least: float
    """The shortest step that it may be cut to, but for stability."""
    single: float = 0.0
    """ω h of single points that swing in it, and that it does not follow."""
    lag: float = 0.0
    """Radians of phase by which those are off in it that swing and show."""
    handed: HandOver = HandOver()
    """How points that share a force hand it on."""
    late: float = 0.0
    """Time by which they hand it on early or late, where that shows."""

    @property
    def rate(self) -> float:
        """Energy balance error a time."""
        return self.missing / self.stepped.state.step


def tried(model: Model, stepping: AutoSteps, last: SystemState, stepped: Stepped, cut: Cut) -> Try:
    """A step with what it shows."""
    state = stepped.state
    if not model.mechanism.moved:
        return Try(stepped, cut, 0.0, 0.0, 0.0)
    limit = limit_of(model, state, "lasting")
    before = limit_of(model, last, "lasting")
    rate = shaking_of(model, last, state, DAMPED * DAMPED * limit.bodies.decay)
    shaking = math.hypot(rate, _turning(model, last, state, fastest_of(limit.bodies)))
    nodes = shaking_of_nodes(model, last, state, DAMPED * DAMPED * limit.nodes.decay)
    decay = max(limit.bodies.decay, limit.nodes.decay)
    dragged = decay * dragging_of(model, last, state) * math.sqrt(2.0 * state.peak_energy)
    shaking = max(shaking, OF_NODES * nodes, OF_DRAG * dragged)
    least = shortest_step(model, stepping, min(limit.critical, before.critical))
    missing = missing_of(model, last, state)
    now = Try(stepped, cut, shaking, missing, least, handed=hand_over(model, last, state))
    return _single(model, last, now, math.sqrt(limit.points) * state.step)


def _single(model: Model, last: SystemState, now: Try, swings: float) -> Try:
    """With what single points are off by, whose ω h is `swings` at most, as far as that shows."""
    if swings <= PHASED and not now.handed.late:
        return now
    state = now.stepped.state
    kick = changes_of_points(model, last, state) * state.step
    shown = kick / math.sqrt(2.0 * state.peak_energy) if kick > 0.0 else 0.0
    followed = all(swings <= least or shown <= share for least, share in UNFOLLOWED)
    lags = swings > PHASED and shown > SWUNG * swings * swings  # a kick is v (ω h)² at most
    # What shares a force swings by itself only where its depths part.
    lags = lags and now.handed.parting > PARTED * math.sqrt(2.0 * state.peak_energy)
    return now._replace(
        single=0.0 if followed else swings,
        lag=swings**3 / 24.0 if lags else 0.0,
        late=now.handed.late if shown > HANDED else 0.0,
    )


def _turning(model: Model, last: SystemState, state: SystemState, fastest: float) -> float:
    """What a swing at ω shakes where it turns round, and forces do not change: ω F.

    No more than before, so that a force which stays, as in steady sliding, is forgotten.
    """
    if fastest == 0.0:
        return 0.0
    before = last.shaking * math.exp(-FORGOTTEN * fastest * state.step)
    return min(before, fastest * unbalanced(model, state))


def objection(model: Model, stepping: AutoSteps, last: SystemState, now: Try) -> Cut | None:
    """The step to take in place of one, and why; None where it may pass."""
    state, step = now.stepped.state, now.stepped.state.step
    if step > LEAST * stepping.most:
        further = too_far(model, last, state) or crossed(model, last, state)
        if further is not None:
            return further
    if not model.mechanism.moved:
        return None
    foreseen = met(model, stepping, replace(state, shaking=now.shaking))
    next_cut = min(foreseen, default=Cut(math.inf, Reason.END))
    if step > COARSER * next_cut.step:
        shorter = Cut(min(0.5 * step, COARSER * next_cut.step), Reason.STIFFER, next_cut.of)
        if next_cut.reason == Reason.CRITICAL:
            return shorter
        return _above(now.least, shorter, step)
    if not loses(model, last, now):
        return None
    part = min(0.5, max(0.05, 0.7 * math.sqrt(_bearable(model, last, now) / now.missing)))
    return _above(now.least, Cut(part * step, Reason.ENERGY, _loser(last, state)), step)


def _bearable(model: Model, last: SystemState, now: Try) -> float:
    """The energy balance error a step may have: as much as those before it, however short."""
    state = now.stepped.state
    return _lost(model) * state.peak_energy + LEAKED * last.leak * state.step


def _lost(model: Model) -> float:
    return LOST_OF_ELEMENTS if model.mechanism.deforms else LOST


def loses(model: Model, last: SystemState, now: Try) -> bool:
    """Whether a step has a larger energy balance error than it may."""
    return _by_energy(model) and now.missing > _bearable(model, last, now)


def let_pass(model: Model, last: SystemState, now: Try) -> float:
    """The error of a step that is let pass, since shorter ones have not reduced it; else zero."""
    if not _by_energy(model) or loses(model, last, now):
        return 0.0
    return now.missing if now.missing > _lost(model) * now.stepped.state.peak_energy else 0.0


def leak_of(last: SystemState, now: Try, longer: Try | None) -> float:
    """Energy balance error a time of steps however short, as it is known after a step.

    Of what points leave that come in, half as long a step leaves half the energy a time, or less;
    of forces that are the gradient of none all. Between the two lies 1/√2. `longer` is a step that
    was too long by its energy, from the same start.
    """
    if longer is not None:
        share = now.stepped.state.step / longer.stepped.state.step
        if now.rate > math.sqrt(share) * longer.rate:
            return last.leak + LEARNT * (now.rate - last.leak)
    return max(0.5 * last.leak, min(now.rate, last.leak))


def _above(least: float, cut: Cut, step: float) -> Cut | None:
    """A cut to no less than the shortest step; None where it is about as short already."""
    if step <= SAME * least:
        return None
    return Cut(least, Reason.SHORTEST, cut.of) if least > cut.step else cut


def _by_energy(model: Model) -> bool:
    """Whether energy judges steps: forces that are the gradient of none leave some at any step."""
    return all(
        part.contact.weights != "area" and has_energy(part.contact.law) for part in model.contacts
    )


def _loser(last: SystemState, state: SystemState) -> str:
    """The contact whose own balance has changed most."""
    off = {
        name: abs(now.energy.error - last.contacts[name].energy.error)
        for name, now in state.contacts.items()
    }
    name = max(off, key=lambda key: off[key], default="")
    return f"contact {name!r}" if name and off[name] > 0.0 else ""


def missing_of(model: Model, last: SystemState, state: SystemState) -> float:
    """Energy balance error of a step, but for what a leapfrog owes until the next one.

    The kinetic energy of bodies stands h² F²/(8 m) above what the work of its forces has made it,
    but for the loads', which is told as it is; that of elements does as far as h has changed.
    """
    owed = -load_work_beyond_way(model, last, state.rigid, state.bodies.poses, state.time)
    for k, one in enumerate(model.mechanism.fixed):
        a, b = (rows[k, FORCE : FORCE + 3] for rows in (last.rigid, state.rigid))
        owed += float((b * b - a * a).sum()) * state.step * state.step / (8.0 * one[MASS])
    if state.step != last.step:
        shorter = last.step * last.step - state.step * state.step
        owed += shorter * kicks_of_elements(model, last)
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
        work = 0.5 * now.damping[rows] * row_products(way, kept_of(now).part("normal_B", rows))
        squares += float((work * work).sum())
    return math.sqrt(squares)
