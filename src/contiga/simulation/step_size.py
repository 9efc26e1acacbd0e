"""Choose the length of the next step: a given one, or as long as named reasons allow.

An automatic step is proposed from the state before it: the critical step, the rate of change of
forces, rotations, rows of tables, and the step before. The step is then computed and judged: how
far points went, whether one passed in and out, whether a contact became stiffer, and its energy
balance error. A rejected step is repeated, shorter; for energy only if that helps, and never below
the shortest step. Every choice follows from the states alone.

*Change of forces.* In a step h the velocity of a leapfrog has an error of about h²/12 times the
rate of change of the acceleration. A body that swings at ω on a contact changes its acceleration
by ω² v. An error of ε times the largest velocity therefore allows h = √(12 ε)/ω in an impact, and
any stable length at rest, in steady sliding and in rolling, where the forces of single points
change and their sum does not. Elastic forces and friction count as far as they change smoothly;
damping counts as a swing at a fraction of its decay rate. Free nodes count all together and are
followed less closely: there may be many, and single ones are seldom of interest.

*Hand-over of a shared force.* The deepest points carry the force of a law that acts as one. Two
nodes change over while the difference of their depths passes through a small part of the depth.
Small errors of position therefore become large errors of the force on each node, and a node that
is released too early leaves with another velocity. Each hand-over multiplies the errors before it,
at any step. With a the acceleration of a node and d the speed at which depths part, a step h leaves
the bounds

    position  x ← x + h v + h² |Δa|/24        the error of a leapfrog itself: ω²h²/24 in phase
    time      τ = x/d                         by which the hand-over is early or late
    velocity  v ← v + |Δa| min(τ, h)          the wrong acceleration over that time

(small errors carried along; Hairer, Lubich, Wanner, Geometric Numerical Integration, ch. IX, has
the first).
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import count
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import length, product, row_products
from contiga.contact.foot_rows import closest
from contiga.contact.shape import shape_of
from contiga.contact.state import State
from contiga.dynamics.stepping import AutoSteps
from contiga.errors import RunError
from contiga.geometry.net import NetMotion
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IndexArray, IntArray, SurfacePlaces
from contiga.rigid.frames import cross, to_world, turn_to_world
from contiga.rigid.rigid_lanes import (
    AXES,
    CENTRE,
    FORCE,
    FREE_DIRECTIONS,
    FREE_ROTATIONS,
    MASS,
    MOMENTS,
    TORQUE,
)
from contiga.simulation.clock import Clock
from contiga.simulation.critical import Limit, Rates, check_stable, find_limit, limit_of
from contiga.simulation.load_forces import unrealised_load_work
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.reasons import Choice, Cut, Reason
from contiga.simulation.signals import longest_sample
from contiga.simulation.step import NodalForces, StepResult, add_forces, advance, nodal_force
from contiga.simulation.system_state import SystemState
from contiga.simulation.triggers import kinks_of_triggers

SWING_STEP = 0.018
"""Step times ω of a body's fastest vibration if that has all the energy: the error of its phase is
ω²h²/24 then, that of its amplitude ω²h²/8."""
NODE_WEIGHT = 0.0144
"""Weight of the force rate of free nodes: steps of 0.15/ω, eight times as long, follow them."""
DRAG_WEIGHT = 0.0162
"""Weight of the rate of viscous friction with a decay γ: steps of 0.14/γ follow it."""
DECAY_WEIGHT = 0.25
"""Frequency, as a fraction of a decay rate γ, as which damping counts: a decay has no phase."""
MAX_TURN, MAX_DRIVEN_TURN = 0.025, 0.1
"""Largest rotation in a step, radians, of a free body, and of one that a motion turns exactly."""
SHORTEST_SHARE = 0.002
"""Share of the critical step below which only stability, travel and kinks shorten a step: a fifth
of the step that follows a swing with all the energy."""
ELEMENT_SHORTEST_SHARE = 0.05
"""Value of `SHORTEST_SHARE` for models with elements, whose steps grow slowly from there."""
GROWTH = 1.5
ELEMENT_GROWTH, ELEMENT_ENERGY_GAIN = 1.1, 2e-6
"""A leapfrog conserves E − h² Σ F²/(8 m) of elements, so that a step which shrinks while a contact
pushes and grows while it does not adds energy every time. Steps therefore grow by at most this
factor, and change that term by at most this share of the largest energy."""
ENERGY_TOL = 4e-6
"""Energy balance error allowed in a step, as a share of the largest energy so far: a thousandth in
all if each of 250 steps has it, and hardly any does."""
ELEMENT_ENERGY_TOL = 2e-5
"""Value of `ENERGY_TOL` for models with elements: errors of many steps have both signs."""
LEAK_FACTOR = 2.0
"""Allowed error, as a multiple of the energy per time that shorter steps have not conserved."""
LEAK_GAIN = 0.25
"""Weight of one unsuccessful retry in the leak: a force that jumps looks the same once."""
JUMP_WEIGHT = 0.2
"""Weight of work whose error has a random sign."""
MAX_STEP_RATIO = 2.0
"""Largest ratio of a step to the one that its end state allows: beyond, something stiff was met."""
SHORTEST_MARGIN = 1.05
"""Multiple of the shortest step up to which a step is not repeated."""
MIN_STEP_SHARE = 1e-9
"""Share of the longest step below which nothing shortens a step."""
FORGETTING_RATE = 0.05
"""Decay rate of the memory of a swing, as a fraction of its ω."""
UNFOLLOWED_SWINGS = (0.5, 1e-4), (0.3, 1e-3)
"""Pairs of ω h above which swings of single points are not followed, and of the velocity change in
a step, over √(2 E_peak), from which it matters: a rebound has an error of (ω h)²/8."""
PHASE_LIMIT = 0.05
"""ω h up to which single points keep their phase for a while: fifteen swings lose 0.01 rad."""
SWING_SHARE = 1e-3
"""Velocity amplitude of single points, over √(2 E_peak), from which their phase counts."""
PARTING_SHARE = 1e-4
"""Speed at which depths of points that share a force part, over the same, from which it counts."""
HAND_OVER_SHARE = 1e-4
"""Minimum change of velocity in a step, as a fraction of √(2 E_peak), for the hand-over error to
count."""
PLACE_ERROR = 1.0 / 24.0
"""Error of the position of a node after a step, as a fraction of h² |Δa|."""
MAX_TRAVEL = 0.02
"""Largest travel of a slave in a step where it may touch, as a share of the master's size."""
RETRY_SAFETY = 0.9
"""Share of the allowed travel that the next trial uses."""
MIN_RETRY = 0.1
"""Shortest next trial, as a share of the rejected step."""
GRAZING_DEPTH = 0.01
"""Depth up to which a point only grazes a body, as a share of its travel in the step."""
STEEP_DEPTH = 0.05
"""Depth half way inside, as a share of the path inside, from which a point does not graze."""


NO_LIMIT = Limit(math.inf, "", Rates())
"""Limit of a model that no forces move."""


class HandOver(NamedTuple):
    """Errors of points that share a force after a step, and the timing of a hand-over in it."""

    place: float = 0.0
    """Error of the depths of nodes, length."""
    speed: float = 0.0
    """Error of the rate of these depths, length/time."""
    late: float = 0.0
    """Time by which a hand-over in this step is early or late; 0 without one."""
    parting: float = math.inf
    """√m times the speed at which depths of points that share a force part, with m the mass that
    they move; infinite if no points share a force."""


class Start(NamedTuple):
    """The state at the start of a step, with its limits."""

    state: SystemState
    most: float
    """The longest step allowed at all."""
    limit: Limit
    """Critical step of what does not depend on the step."""
    kicks: float
    """Σ F²/(8 m) over the nodes of elements."""


class Trial(NamedTuple):
    """A computed step with the quantities by which it is judged."""

    stepped: StepResult
    limit: Limit
    """Critical step at its end of what does not depend on the step."""
    shaking: float = 0.0
    """Rate of change of forces over √mass, see `shaking_of`."""
    missing: float = 0.0
    """Energy balance error of the step."""
    allowed: float = math.inf
    """Largest allowed energy balance error."""
    least: float = 0.0
    """The shortest step that it may be cut to, except for stability."""
    single: float = 0.0
    """ω h of single points whose swing the step does not follow."""
    lag: float = 0.0
    """Phase error, radians, of single points whose swing matters."""
    handed: HandOver = HandOver()
    """Hand-over between points that share a force."""
    late: float = 0.0
    """Time by which the hand-over is early or late, if that matters."""


def next_step(model: Model, last: SystemState, clock: Clock) -> StepResult:
    """Return the step after `last`.

    Raises
    ------
    RunError
        A given step is longer than the critical one, or every step is, unless the model has
        `allow_unstable`; elements are unstable or inside out.
    """
    stepping = model.stepping
    if isinstance(stepping, AutoSteps):
        stepped = _automatic_step(model, stepping, last, clock)
    else:
        time = stepping.after(last.time)
        if model.mechanism.has_dynamics and not model.allow_unstable:
            begin = perf_counter()
            limit, step = find_limit(model, last), time - last.time
            clock.add("motion", begin)
            if step > limit.critical:
                raise RunError(
                    f"t = {last.time:g}: the step of {step:.4g} is longer than the critical one of "
                    f"{limit.critical:.4g}, that of {limit.of}: its vibrations would grow without "
                    f"bound. Take a step below {0.9 * limit.critical:.3g}, or "
                    'step = "auto"; allow_unstable lets it pass'
                )
        stepped = advance(model, last, time, clock)
    if model.mechanism.deforms:
        check_stable(model, stepped.state)
    return stepped


def _automatic_step(
    model: Model, stepping: AutoSteps, last: SystemState, clock: Clock
) -> StepResult:
    """Return the next step, repeated with a shorter length until it is accepted.

    It goes past no known kink and not past the end of the run. `choice` says what set its length.

    Raises
    ------
    RunError
        No step is stable for a law whose stiffness follows the step, unless the model has
        `allow_unstable`.
    """
    begin = perf_counter()
    if model.mechanism.followers and model.mechanism.has_dynamics and not model.allow_unstable:
        limit = limit_of(model, last, "following")
        if last.step > limit.critical:
            raise RunError(
                f"t = {last.time:g}: no step is stable for {limit.of}, whose stiffness follows the "
                f"step: the critical one is {limit.critical / last.step:.3g} of any. Take a "
                "smaller scale of its law; allow_unstable lets it pass"
            )
    limit = limit_of(model, last, "lasting") if model.mechanism.has_dynamics else NO_LIMIT
    kicks = 0.0
    for name, nodes in model.mechanism.element_movers.items():
        acting = NodalForces(model, name, last.acting)
        kicks += nodes.kick_energy(last.slaves[name], acting, model.gravity)
    start = Start(last, stepping.most, limit, kicks)
    cut = propose_step(model, stepping, start)
    clock.add("motion", begin)
    rejected: Trial | None = None
    # The last two steps before a kink share the time left, so that none is tiny.
    kinks = [*model.kinks, *kinks_of_triggers(model, last)]
    next_end = min((time for time in kinks if time > last.time), default=stepping.end)
    at_end = not next_end < stepping.end
    next_end = min(next_end, stepping.end)
    time_left, reason = next_end - last.time, Reason.END if at_end else Reason.KINK
    for n_tries in count(1):
        time = last.time + cut.step
        if cut.step >= time_left:
            time, cut = next_end, Cut(time_left, reason) if cut.step > time_left else cut
        elif 2.0 * cut.step > time_left:
            time, cut = last.time + 0.5 * time_left, Cut(0.5 * time_left, reason)
        stepped = advance(model, last, time, clock)
        begin = perf_counter()
        trial = Trial(stepped, NO_LIMIT)
        if model.mechanism.has_dynamics:
            trial = judge_step(model, stepping, start, stepped)
        loses_energy = model.mechanism.keeps_energy and trial.missing > trial.allowed
        shorter = rejection(model, stepping, start, trial, loses_energy=loses_energy)
        clock.add("motion", begin)
        if shorter is None:
            accepted_error = 0.0
            is_judged = model.mechanism.keeps_energy and not loses_energy
            if is_judged and trial.missing > _energy_tolerance(model, stepped.state):
                accepted_error = trial.missing  # accepted: shorter steps have not reduced it
            state = replace(
                stepped.state,
                shaking=trial.shaking,
                leak=leak_of(last, trial, rejected),
                place_error=trial.handed.place,
                speed_error=trial.handed.speed,
            )
            choice = Choice(cut, n_tries, accepted_error, trial.single, trial.lag, trial.late)
            return stepped._replace(state=state, choice=choice)
        if loses_energy and shorter.reason in (Reason.ENERGY, Reason.SHORTEST):
            rejected = trial
        cut = shorter
    raise AssertionError("the loop always returns")


def propose_step(model: Model, stepping: AutoSteps, start: Start) -> Cut:
    """Return the longest step that is expected to be accepted, and why it is not longer.

    It is the least of the largest step, the samples of filters, the travel that driven points may
    have, the cuts of the state (`_cuts_in_state`), and the growth from the step before. The first
    step assumes that all the energy swings.
    """
    last, longest = start.state, start.most
    cuts = [Cut(longest, Reason.LARGEST)]
    if model.sensors or model.springs:
        cuts.append(Cut(longest_sample(model), Reason.SAMPLE))
    for part in model.contacts:
        # Points that a motion drives may go as far as allowed.
        if part.name in model.driven_contacts and (speed := _max_speed(model, part, last)) > 0.0:
            before = last.contacts[part.name]
            travel = np.full(len(before.patch), longest * speed / RETRY_SAFETY)
            allowed = _allowed_travel(model, part, before, travel)
            step = RETRY_SAFETY * float(allowed.min(initial=math.inf)) / speed
            cuts.append(Cut(step, Reason.WAY, f"contact {part.name!r}"))
    shaking = last.shaking
    if not last.step:  # no rates of change yet: assume that all the energy swings
        bodies = _highest_frequency(start.limit.bodies)
        nodes = _highest_frequency(start.limit.nodes)
        shaking = max(bodies**2, NODE_WEIGHT * nodes**2) * math.sqrt(2.0 * last.peak_energy)
    cut = min([*cuts, *_cuts_in_state(model, stepping, start, last, start.limit, shaking)])
    if not 0.0 < last.step < cut.step:
        return cut
    if not model.mechanism.deforms:
        grown = GROWTH * last.step
    else:
        square = last.step * last.step
        if start.kicks > 0.0:
            gained = square + ELEMENT_ENERGY_GAIN * last.peak_energy / start.kicks
            square = min(gained, ELEMENT_GROWTH**2 * square)
        grown = math.sqrt(square)
    return min(cut, Cut(grown, Reason.GROWTH))


def _cuts_in_state(
    model: Model,
    stepping: AutoSteps,
    start: Start,
    state: SystemState,
    limit: Limit,
    shaking: float,
) -> list[Cut]:
    """Return the longest steps by rotations, stability and swings in one state.

    Following a swing asks for no step below the shortest one.
    """
    cuts: list[Cut] = []
    system = model.mechanism
    for i in (*system.free.tolist(), *system.driven):
        spin = length(state.bodies.twists[i, 3:])
        if spin > 0.0:
            max_turn = MAX_TURN if i in system.row else MAX_DRIVEN_TURN
            cuts.append(Cut(max_turn / spin, Reason.TURN, f"body {list(model.bodies)[i]!r}"))
    if system.has_dynamics:
        cuts.append(Cut(stepping.safety * limit.critical, Reason.CRITICAL, limit.of))
        if shaking > 0.0:
            followed = SWING_STEP * math.sqrt(math.sqrt(2.0 * state.peak_energy) / shaking)
            least = _shortest_step(model, stepping, start.most, limit.critical)
            cuts.append(Cut(max(followed, least), Reason.SWING, limit.of))
    return cuts


def _shortest_step(model: Model, stepping: AutoSteps, most: float, critical: float) -> float:
    """Return the length below which only stability, travel and kinks shorten a step."""
    share = ELEMENT_SHORTEST_SHARE if model.mechanism.deforms else SHORTEST_SHARE
    return stepping.shortest or share * min(critical, most)


def _highest_frequency(rates: Rates) -> float:
    """Return the highest ω of any vibration, 1/time; a decay counts by `DECAY_WEIGHT`."""
    return max(math.sqrt(rates.square), DECAY_WEIGHT * rates.decay)


def judge_step(model: Model, stepping: AutoSteps, start: Start, stepped: StepResult) -> Trial:
    """Return a computed step with the quantities by which it is judged.

    Errors of single points are zero unless they matter, with w the largest change of their velocity
    in the step over √(2 E_peak): `single` counts if ω h and w both exceed a pair of
    `UNFOLLOWED_SWINGS`; `lag` if ω h > `PHASE_LIMIT`, w > `SWING_SHARE` (ω h)² and depths part
    faster than `PARTING_SHARE` √(2 E_peak); `late` if w > `HAND_OVER_SHARE`.
    """
    last, state = start.state, stepped.state
    limit = limit_of(model, state, "lasting")
    energetic = math.sqrt(2.0 * state.peak_energy)
    shaking = shaking_of(model, last, state, limit)
    least = _shortest_step(model, stepping, start.most, min(limit.critical, start.limit.critical))
    missing = missing_energy(model, start, state)
    allowed = _energy_tolerance(model, state) + LEAK_FACTOR * last.leak * state.step
    handing = hand_over(model, last, state)
    trial = Trial(stepped, limit, shaking, missing, allowed, least, handed=handing)
    swing = math.sqrt(limit.points) * state.step
    if swing <= PHASE_LIMIT and not handing.late:
        return trial
    # Errors of single points, as far as they matter.
    kick = changes_of_points(model, last, state) * state.step
    kick_share = kick / energetic if kick > 0.0 else 0.0
    is_followed = all(swing <= most or kick_share <= share for most, share in UNFOLLOWED_SWINGS)
    # A kick is at most v (ω h)². Points that share a force swing only where their depths part.
    is_lagging = swing > PHASE_LIMIT and kick_share > SWING_SHARE * swing * swing
    is_lagging = is_lagging and handing.parting > PARTING_SHARE * energetic
    return trial._replace(
        single=0.0 if is_followed else swing,
        lag=swing**3 / 24.0 if is_lagging else 0.0,
        late=handing.late if kick_share > HAND_OVER_SHARE else 0.0,
    )


def rejection(
    model: Model, stepping: AutoSteps, start: Start, trial: Trial, *, loses_energy: bool
) -> Cut | None:
    """Return the step to take instead of the trial, and why; None if it is accepted.

    It is rejected if points may have passed a wall unnoticed (looked at only in steps above
    `MIN_STEP_SHARE` of the largest), or, where forces move anything, if it is longer than
    `MAX_STEP_RATIO` times what its end state allows, or if it `loses_energy`: its energy balance
    error is larger than allowed. Only stability and travel ask for less than the shortest step.
    """
    last, state, step = start.state, trial.stepped.state, trial.stepped.state.step
    if step > MIN_STEP_SHARE * start.most:
        passage = unnoticed_passage(model, last, state)
        if passage is not None:
            return passage
    if not model.mechanism.has_dynamics:
        return None
    cuts_at_end = _cuts_in_state(model, stepping, start, state, trial.limit, trial.shaking)
    next_cut = min(cuts_at_end, default=Cut(math.inf, Reason.END))
    if step > MAX_STEP_RATIO * next_cut.step:
        shorter = Cut(min(0.5 * step, MAX_STEP_RATIO * next_cut.step), Reason.STIFFER, next_cut.of)
        if next_cut.reason == Reason.CRITICAL:
            return shorter
    elif loses_energy:
        # The contact whose own balance has changed most.
        error_of_contact = {
            name: abs(at.energy.error - last.contacts[name].energy.error)
            for name, at in state.contacts.items()
        }
        name = max(error_of_contact, key=lambda key: error_of_contact[key], default="")
        loser = f"contact {name!r}" if name and error_of_contact[name] > 0.0 else ""
        share = min(0.5, max(0.05, 0.7 * math.sqrt(trial.allowed / trial.missing)))
        shorter = Cut(share * step, Reason.ENERGY, loser)
    else:
        return None
    if step <= SHORTEST_MARGIN * trial.least:  # already about as short as allowed
        return None
    return Cut(trial.least, Reason.SHORTEST, shorter.of) if trial.least > shorter.step else shorter


def _energy_tolerance(model: Model, state: SystemState) -> float:
    """Return the energy balance error that a step may have if shorter ones have less."""
    return (ELEMENT_ENERGY_TOL if model.mechanism.deforms else ENERGY_TOL) * state.peak_energy


def leak_of(last: SystemState, now: Trial, rejected: Trial | None) -> float:
    """Return the energy balance error per time that steps have at any length.

    If points come into contact, half the step has half the error per time, or less; forces that
    are no gradient of an energy have the same. Between the two lies 1/√2: above it the leak goes
    towards the rate of this step by `LEAK_GAIN`, else it falls to that rate, by half at most.
    `rejected` is a longer step from the same start that was rejected for its energy.
    """
    step = now.stepped.state.step
    rate = now.missing / step
    if rejected is not None:
        before = rejected.stepped.state.step
        if rate > math.sqrt(step / before) * (rejected.missing / before):
            return last.leak + LEAK_GAIN * (rate - last.leak)
    return max(0.5 * last.leak, min(rate, last.leak))


def missing_energy(model: Model, start: Start, state: SystemState) -> float:
    """Return the size of the energy balance error of a step that a leapfrog does not recover later.

    The kinetic energy of bodies is h² F²/(8 m) above the work of their forces, except for that of
    loads, which is exact; for elements the same holds for the change of h. An allowance for the
    damping at new points in contact is added.
    """
    last, recovered = start.state, 0.0
    if model.mechanism.loads:
        recovered = -unrealised_load_work(model, last, state.rigid, state.bodies.poses, state.time)
    for k, fixed in enumerate(model.mechanism.fixed):
        a, b = last.rigid[k, FORCE : FORCE + 3], state.rigid[k, FORCE : FORCE + 3]
        recovered += float((b * b - a * a).sum()) * state.step * state.step / (8.0 * fixed[MASS])
    if state.step != last.step:
        recovered += (last.step * last.step - state.step * state.step) * start.kicks
    # Damping acts at once when a point comes into contact at a speed. The step counts half of its
    # work over the whole step, whenever contact began; errors of many points are independent.
    squares = 0.0
    for part in model.contacts:
        now = state.contacts[part.name]
        if now.kept.damping is None:
            continue
        rows, damping = now.kept.damping.nonzero()
        is_new = now.status[rows] == ContactStatus.NEW
        rows, damping = rows[is_new], damping[is_new]
        path = _relative_paths(part, last.contacts[part.name], now, rows)
        work = 0.5 * damping * row_products(path, now.kept.normal_B.at(rows))
        squares += float((work * work).sum())
    return abs(state.energy.error - last.energy.error + recovered) + JUMP_WEIGHT * math.sqrt(
        squares
    )


class _PointForces(NamedTuple):
    """Forces, or their rates, at points of a contact."""

    rows: IndexArray
    """(k,) points of contact."""
    forces: FloatArray
    """(k, 3) on the slave, world axes."""


def shaking_of(model: Model, last: SystemState, state: SystemState, limit: Limit) -> float:
    """Return how fast the forces on bodies and nodes change in the step from `last`, over √mass.

    The largest of three counts: that of bodies, of nodes by `NODE_WEIGHT`, and of viscous friction
    by `DRAG_WEIGHT`. At the turning point of a swing at ω, where forces do not change, the rate of
    bodies is ω F, but no more than before: so a constant force, as in steady sliding, is forgotten.
    Contacts whose stiffness follows the step do not count.
    """
    system, turning = model.mechanism, 0.0
    # Moments count by their effect on the kinetic energy, as forces do.
    decay = DECAY_WEIGHT * DECAY_WEIGHT * limit.bodies.decay
    rates = np.zeros((len(system.free), 6))
    for part in model.contacts:
        if part.name not in model.mechanism.followers and model.mechanism.sides[part.name].free:
            for point_rates in _force_rates(part, last, state, decay):
                places = state.contacts[part.name].held_W.points.at(point_rates.rows)
                _add_forces(rates, model, part, places, point_rates.forces, state)
    for name in state.springs:
        both = (last.springs[name], -1.0, last), (state.springs[name], 1.0, state)
        for end, k in system.free_ends(name):
            for spring, sign, at in both:
                if spring.length == 0.0:
                    continue
                axis = (spring.ends[1 - end] - spring.ends[end]) / spring.length
                size = sign * (spring.force - spring.damper) / state.step
                if sign > 0.0:
                    size += decay * spring.damper
                place, force = spring.ends[end : end + 1], (size * axis)[None]
                add_forces(rates[k], place, force, at.rigid[k, CENTRE : CENTRE + 3])
    if model.joints:
        changes = np.zeros((2, len(system.index), 6))
        for change, at in zip(changes, (last, state), strict=True):
            assert at.joints is not None
            model.linkage.add_reactions(at.joints, at.bodies.poses, change)
            model.linkage.add_laws(at.joints, at.bodies.poses, change)
        of_joints = (changes[1] - changes[0])[system.free] / state.step
        about = state.rigid[:, CENTRE : CENTRE + 3] - state.bodies.poses[system.free, :3, 3]
        rates[:, :3] += of_joints[:, :3]
        rates[:, 3:] += of_joints[:, 3:] - cross(about, of_joints[:, :3])
    of_bodies = max(
        [0.0, *(_over_root_mass(system, k, rate, state) for k, rate in enumerate(rates))]
    )
    fastest = _highest_frequency(limit.bodies)
    if fastest > 0.0:
        turning = last.shaking * math.exp(-FORGETTING_RATE * fastest * state.step)
        forces = state.rigid[:, FORCE : FORCE + 6]
        pulls = [_over_root_mass(system, k, force, state) for k, force in enumerate(forces)]
        turning = min(turning, fastest * max(pulls, default=0.0))
    of_nodes = dragged = 0.0
    for name, mass in system.loose.items():  # all nodes of a slave together
        rates = np.zeros((len(mass), 3))
        for part in model.contacts:
            if part.slave != name or part.name in model.mechanism.followers:
                continue
            decay = DECAY_WEIGHT * DECAY_WEIGHT * limit.nodes.decay
            for point_rates in _force_rates(part, last, state, decay):
                for k, values in enumerate(point_rates.forces.T):
                    nodes, sums = part.contact.nodal_sum(
                        point_rates.rows, np.ascontiguousarray(values)
                    )
                    rates[nodes, k] += sums
        root = math.sqrt(float((np.square(rates).sum(axis=1) / mass).sum()))
        of_nodes = max(of_nodes, root)
    for part in model.contacts:
        # The rate at which viscous friction changes, over its largest value.
        friction: Any = part.contact.friction
        now = state.contacts[part.name]
        if getattr(friction, "viscosity", None) is not None:
            rate = _friction_rates(last.contacts[part.name], now, state.step).forces
            bound = friction.coefficient * float(now.normal_force.sum())
            if bound > 0.0:
                total_rate = float(np.sqrt(np.square(rate).sum(axis=1)).sum())
                dragged = max(dragged, total_rate / bound)
    decay = max(limit.bodies.decay, limit.nodes.decay)
    dragged = decay * dragged * math.sqrt(2.0 * state.peak_energy)
    return max(math.hypot(of_bodies, turning), NODE_WEIGHT * of_nodes, DRAG_WEIGHT * dragged)


def _over_root_mass(system: Mechanism, k: int, rate: FloatArray, state: SystemState) -> float:
    """Return √(ṗᵀ M⁻¹ ṗ) for the rate (6,) of force and moment about the centre of a body."""
    fixed, turn = system.fixed[k], state.bodies.poses[int(system.free[k]), :3, :3]
    torque = product(turn.T, rate[3:] * fixed[FREE_ROTATIONS : FREE_ROTATIONS + 3])
    moment = product(fixed[AXES : AXES + 9].reshape(3, 3).T, torque)
    square = np.square(rate[:3] * fixed[FREE_DIRECTIONS : FREE_DIRECTIONS + 3]).sum() / fixed[MASS]
    return math.sqrt(float(square + (moment * moment / fixed[MOMENTS : MOMENTS + 3]).sum()))


def _force_rates(
    part: ContactPart, last: SystemState, state: SystemState, decay: float
) -> tuple[_PointForces, ...]:
    """Return the rates of a contact's forces on its slave: normal forces, then friction if any.

    Damping counts as elastic with the rate `decay`. The result is empty without stiffness
    and friction.
    """
    before, now = last.contacts[part.name], state.contacts[part.name]
    rows, stiffness = now.kept.stiffness.nonzero()
    if len(rows) == 0 and now.kept.traction_B is None:
        return ()
    normals = now.kept.normal_B.at(rows)
    inward = -row_products(_relative_paths(part, before, now, rows), normals) / state.step
    rate = stiffness * np.where(np.isfinite(inward), inward, 0.0)
    if now.kept.damping is not None:
        rate = rate + decay * now.kept.damping.at(rows)
    elastic = _PointForces(rows, turn_to_world(now.pose, rate[:, None] * normals))
    if now.kept.traction_B is None:
        return (elastic,)
    return elastic, _friction_rates(before, now, state.step)


def _friction_rates(before: State, now: State, step: float) -> _PointForces:
    """Return the rates of friction at points that carry force at both ends of the step, world axes.

    There are no points if either state has no friction.
    """
    kept, last = now.kept, before.kept
    if kept.traction_B is None or last.traction_B is None:
        return _PointForces(kept.normal_force.rows[:0], np.zeros((0, 3)))
    rows, traction = kept.traction_B
    is_pressed = (kept.normal_force.at(rows) > 0.0) & (last.normal_force.at(rows) > 0.0)
    rows, traction = rows[is_pressed], traction[is_pressed]
    rate = (traction - last.traction_B.at(rows)) / step
    return _PointForces(rows, turn_to_world(now.pose, rate))


def _add_forces(
    rates: FloatArray,
    model: Model,
    part: ContactPart,
    places: FloatArray,
    forces: FloatArray,
    state: SystemState,
) -> None:
    """Add forces on the slave at places (k, 3), and the opposite ones on the master, if free.

    `rates` (b, 6) of free bodies, about their centres, are changed in place.
    """
    sides = model.mechanism.sides[part.name]
    for k, sign in zip(sides.free, sides.signs, strict=True):
        add_forces(rates[k], places, sign * forces, state.rigid[k, CENTRE : CENTRE + 3])


def changes_of_points(model: Model, last: SystemState, state: SystemState) -> float:
    """Return the largest change of point forces of one slave or body in a step, over √mass.

    Nodes of a free slave count together, as the root of Σ |Δf|²/m; on a body only the normal forces
    of contacts whose points share a force count.
    """
    system, most = model.mechanism, 0.0
    for name, mass in system.loose.items():
        change = _change_of_nodes(model, name, last, state)
        most = max(most, math.sqrt(float((np.square(change).sum(axis=1) / mass).sum())))
    changes = np.zeros((len(system.free), 6))
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        if now.kept.stiffness_bound is not None:
            forces, rows = [], _sharing(before, now)
            for kept in (before.kept, now.kept):
                forces.append(kept.normal_force.at(rows)[:, None] * kept.normal_B.at(rows))
            shared = turn_to_world(now.pose, forces[1] - forces[0])
            places = to_world(now.pose, now.points_B[rows])
            _add_forces(changes, model, part, places, shared, state)
    of_bodies = (_over_root_mass(system, k, change, state) for k, change in enumerate(changes))
    return max([most, *of_bodies])


def _change_of_nodes(model: Model, name: str, last: SystemState, state: SystemState) -> FloatArray:
    """Return the forces (n, 3) on the nodes of a slave in `last`, less those in `state`."""
    return nodal_force(model, name, last.acting) - nodal_force(model, name, state.acting)


def _sharing(before: State, now: State) -> IndexArray:
    """Return the points with a normal force in either state."""
    both = before.kept.normal_force.nonzero(), now.kept.normal_force.nonzero()
    return np.union1d(both[0].rows, both[1].rows)


def hand_over(model: Model, last: SystemState, state: SystemState) -> HandOver:
    """Return errors of depths and their rates, lateness and parting of points that share a force.

    Errors are those after the step; `last` has those before it. Only contacts whose law acts as one
    count; the bounds are those at the head of the module.
    """
    system, step = model.mechanism, state.step
    place = last.place_error + step * last.speed_error
    speed, late, parts = last.speed_error, 0.0, []
    for part in model.contacts:
        if not getattr(part.contact.law, "acts_as_one", False):
            continue
        before, now = last.contacts[part.name], state.contacts[part.name]
        bodies = model.mechanism.sides[part.name].free
        # The speed at which depths of points that share a force part.
        parting, rows = math.inf, _sharing(before, now)
        rows = rows[now.in_contact[rows]]
        if len(rows) > 1:
            paths = _relative_paths(part, before, now, rows)
            parting = float(np.ptp(row_products(paths, now.kept.normal_B.at(rows)) / step))
        if math.isfinite(parting):
            # The smaller mass that the contact moves; 0 if it moves none.
            masses = [float(system.fixed[row, MASS]) for row in bodies]
            if part.slave in system.masses:
                masses.append(float(system.masses[part.slave].sum()))
            parts.append(parting * math.sqrt(min(masses, default=0.0)))
        if not (before.n_contact or now.n_contact):
            continue
        # The largest change of the acceleration of a point in the step, by the forces and torques
        # on the free bodies and nodes at both sides of the contact.
        changes = [0.0]
        for row in bodies:
            fixed, lanes = system.fixed[row], state.rigid[row]
            change = lanes - last.rigid[row]
            places = now.held_W.points.values
            arm = length(np.abs(places - lanes[CENTRE : CENTRE + 3]).max(axis=0, initial=0.0))
            turns = length(change[TORQUE : TORQUE + 3]) * arm / fixed[MOMENTS]
            changes.append(float(length(change[FORCE : FORCE + 3]) / fixed[MASS] + turns))
        if part.slave in system.loose:
            square = np.square(_change_of_nodes(model, part.slave, last, state)).sum(axis=1)
            changes.append(float((np.sqrt(square) / system.loose[part.slave]).max()))
        change_of_all = sum(changes)
        if change_of_all == 0.0:
            continue
        place += PLACE_ERROR * step * step * change_of_all
        if 0.0 < parting < math.inf:
            late = max(late, place / parting)
            speed += change_of_all * min(late, step)
    return HandOver(place, speed, late, max(parts, default=math.inf))


def unnoticed_passage(model: Model, last: SystemState, state: SystemState) -> Cut | None:
    """Return the step to take instead of one in which points may pass a wall unnoticed.

    Points may travel `MAX_TRAVEL` of the master's size, or as far as they cannot touch it, and must
    not go in and out within the step, unless they only graze. None if both hold. The retry is at
    least `MIN_RETRY` of the step; travel is looked at first.
    """
    worst_ratio, contact_text = 1.0, ""
    travels: dict[str, FloatArray] = {}
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        travels[part.name] = travel_of_points = _lengths(now.points_B - before.points_B)
        if part.name in model.driven_contacts:
            # A driven body may reverse, or turn by whole turns, between the ends of a step, and a
            # surface that changes its shape passes points at rest.
            fastest = max(_max_speed(model, part, last), _max_speed(model, part, state))
            travel_of_points = np.maximum(travel_of_points, fastest * state.step)
        allowed = _allowed_travel(model, part, before, travel_of_points)
        if (ratio := float(np.max(travel_of_points / allowed, initial=0.0))) > worst_ratio:
            worst_ratio, contact_text = ratio, f"contact {part.name!r}"
    if worst_ratio > 1.0:
        return Cut(
            state.step * max(MIN_RETRY, RETRY_SAFETY / worst_ratio), Reason.WAY, contact_text
        )
    first_share = 1.0
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        if len(now.control_points):
            continue  # `_allowed_travel` alone limits the paths of points beside a changing surface
        free = (before.patch < 0) & (now.patch < 0) & (before.safe_distance >= 0.0)
        travel = travels[part.name]
        rows = np.flatnonzero(free & (travel > before.safe_distance)).astype(np.int32)
        if len(rows):
            surface = model.bodies[part.master].body.surface
            share = _first_inside_share(surface, before.points_B, now.points_B, travel, rows)
            if share < first_share:
                first_share, contact_text = share, f"contact {part.name!r}"
    if not contact_text:
        return None
    return Cut(state.step * max(MIN_RETRY, first_share), Reason.CROSSING, contact_text)


def _allowed_travel(
    model: Model, part: ContactPart, before: State, travel: FloatArray
) -> FloatArray:
    """Return how far (m,) each point may travel, infinitely far if it is inside from the start.

    Distances from the master are measured only for points that `travel` farther than known to be
    safe.
    """
    safe_distance = np.where(before.patch >= 0, 0.0, before.safe_distance)
    # Points that are inside from the start touch nothing: their safe distance is negative.
    half = part.contact.half_thickness
    span = np.full(len(safe_distance), MAX_TRAVEL * model.mechanism.sides[part.name].size)
    if len(before.control_points) and half is not None:
        # A point farther off than half a thickness cannot pass the wall within that length.
        span = np.where(half > 0.0, np.minimum(half, span), span)
    allowed = np.where(safe_distance < 0.0, math.inf, np.maximum(span, safe_distance))
    rows = np.flatnonzero((travel > allowed) & (before.patch < 0)).astype(np.int32)
    if len(rows):
        # The safe distance shrinks with any travel, also with one that leads away.
        distance = np.zeros(len(allowed))
        surface = model.bodies[part.master].body.surface
        if len(before.control_points):
            follows, net = part.contact.follows_feet, before.control_points
            surface = shape_of(part.contact.master, follows, net).surface
        surface.safe_distance(before.points_B, rows, distance)
        if half is not None:
            distance -= half
        allowed = np.maximum(allowed, distance)
    return allowed


def _max_speed(model: Model, part: ContactPart, at: SystemState) -> float:
    """Return an upper bound of the speed of all nodes relative to the master's surface."""
    slave, body = at.slaves[part.slave], at.bodies[part.master]
    against = slave.velocities - body.twist.at(body.pose[:3, 3], slave.points)
    shape = model.shapes.velocity(part.master, at.time, at.slaves)
    fastest = 0.0 if shape is None else float(_lengths(shape).max(initial=0.0))
    return fastest + float(np.max(_lengths(against), initial=0.0))


def _relative_paths(part: ContactPart, before: State, now: State, rows: IndexArray) -> FloatArray:
    """Return displacements (k, 3) of points `rows` in a step relative to the surface, body axes."""
    points = now.points_B[rows]
    paths = points - before.points_B[rows]
    if len(now.control_points):
        body, change = part.contact.master.faces, now.control_points - before.control_points
        assert body is not None
        feet = SurfacePlaces(now.patch[rows], now.uv[rows])
        paths = paths - NetMotion(body, now.control_points, change).carry(feet, points)
    return paths


def _lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths (n,) of the rows, zero for those that are not finite."""
    square = row_products(vectors, vectors)
    return np.asarray(np.sqrt(np.where(np.isfinite(square), square, 0.0)))


def _first_inside_share(
    surface: Surface, a: FloatArray, b: FloatArray, travel: FloatArray, rows: IntArray
) -> float:
    """Return the first share of the paths of `rows` from a to b (n, 3) at which a point is inside.

    All points are outside at both ends. The share is that of the middle of the path inside; 1 if no
    path leads in and out, or all only graze the surface. `travel` (n,) are lengths of the paths.
    """
    entry = surface.entries(a, b, rows)
    rows, start = rows[entry.patch >= 0], entry.point[entry.patch >= 0]
    if len(rows) == 0:
        return 1.0
    leaving, sense = surface.last_crossings(a, b, rows)
    is_leaving = sense < 0
    rows, start, end = rows[is_leaving], start[is_leaving], leaving.point[is_leaving]
    if len(rows) == 0:
        return 1.0
    middle = 0.5 * (start + end)
    depth = -closest(surface, middle, np.arange(len(rows), dtype=np.int32)).gap
    target = np.where((depth > 0.0)[:, None], middle, start + GRAZING_DEPTH * (end - start))
    share = _lengths(target - a[rows]) / travel[rows]
    # The point is deep for the length of its path inside, or outside half way: it passed a wall.
    grazing = np.minimum(GRAZING_DEPTH * travel[rows], STEEP_DEPTH * _lengths(end - start))
    return float(np.min(share, initial=1.0, where=(depth > grazing) | (depth <= 0.0)))
