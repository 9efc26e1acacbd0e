"""Choose how long the next step is: as given, or as long as named reasons allow.

An automatic step is proposed by what is known before it: the critical step, how fast
forces change, turns, rows of tables, the step before. Then it is worked out and judged by what
happened in it: how far points went, whether one went in and out, what is stiffer than foreseen, its
energy balance error. What objects has it taken again, shorter; for energy only where that helps,
and never below the shortest step. Every choice follows from the states alone.

*What changes.* In a step h a leapfrog's velocity is off by about h²/12 of the rate at which the
acceleration changes. A body that swings at ω on what it touches changes it by ω² v: so steps that
are to be right to a share ε of the largest velocity take h = √(12 ε)/ω in an impact, and any length
that is stable at rest, in steady sliding and in rolling, where the forces of single points change
and their sum does not. Elastic forces and friction count, as far as they change smoothly; how hard
damping pulls counts as a swing of a part of its decay. Free nodes count all together, and are
followed less closely: there may be many, and what each does is seldom asked for.

*What is handed over.* The deepest point carries the force of a law that acts as one; those nearly
as deep share it. Two nodes change over while the difference of their depths goes through a small
part of the depth: so small errors of place make large ones of what each carries, and a node that is
let go too early leaves with another velocity. Each hand-over multiplies what was wrong before it,
at any step. With a the acceleration of a node and d the speed at which depths part, a step h leaves
bounds of

    place     x ← x + h v + h² |Δa|/24        the error of a leapfrog itself: ω²h²/24 in phase
    time      τ = x/d                         by which the hand-over is early or late
    velocity  v ← v + |Δa| min(τ, h)          what was handed over, for so long

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
from contiga.rigid.rigid_lanes import AXES, CENTRE, FORCE, MASS, MOMENTS, SPINS, TORQUE, WAYS
from contiga.simulation.clock import Clock
from contiga.simulation.critical import Limit, Rates, check_stable, find_limit, limit_of
from contiga.simulation.load_forces import load_work_beyond_way
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.reasons import Choice, Cut, Reason
from contiga.simulation.signals import longest_sample
from contiga.simulation.step import ForcesOn, Stepped, add_forces, advance, nodal_force
from contiga.simulation.system_state import SystemState
from contiga.simulation.triggers import kinks_of_triggers

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
"""Minimum change of velocity in a step, as a fraction of that of all the energy, for the hand-over
error to count."""
OWN = 1.0 / 24.0
"""Of h² |Δa|: what the place of a node is off by after a step."""
SPAN = 0.02
"""Part of its master's size that a slave may go in a step, where it may touch."""
AIM = 0.9
"""Part of the way that was allowed which the next try takes."""
LEAST_PART = 0.1
"""Part of a step that the next try takes at least."""
CLIPPED = 0.01
"""Part of its way in the step: a point that grazes no deeper has felt nothing."""
STEEP = 0.05
"""Part of its way inside: one that is so deep half way does not graze, however short that is."""


NO_LIMIT = Limit(math.inf, "", Rates())
"""Of what no forces move."""


class HandOver(NamedTuple):
    """The motion in a step of points that share a force, and their error after it."""

    place: float = 0.0
    """Error of the depths of nodes, length."""
    speed: float = 0.0
    """And of how fast these change, length/time."""
    late: float = 0.0
    """Time by which a hand-over in this step is early or late; 0 where there is none."""
    parting: float = math.inf
    """√m times the speed at which depths of points that share a force part, m the mass of what they
    move; infinite where none share."""


class Start(NamedTuple):
    """The state where a step begins, and what is known of it."""

    state: SystemState
    most: float
    """The longest step there is."""
    limit: Limit
    """Of what lasts in it."""
    kicks: float
    """Σ F²/(8 m) over the nodes of elements."""


class Try(NamedTuple):
    """A step that was computed, and what it shows."""

    stepped: Stepped
    limit: Limit
    """Of what lasts at its end."""
    shaking: float = 0.0
    missing: float = 0.0
    """Its energy balance error."""
    bearable: float = math.inf
    """What that may be: as much as in those before it, however short."""
    least: float = 0.0
    """The shortest step that it may be cut to, but for stability."""
    single: float = 0.0
    """ω h of single points that swing in it, and that it does not follow."""
    lag: float = 0.0
    """Radians of phase by which those are off in it that swing and show."""
    handed: HandOver = HandOver()
    """How points that share a force hand it on."""
    late: float = 0.0
    """Time by which they hand it on early or late, where that shows."""


def following(model: Model, last: SystemState, clock: Clock) -> Stepped:
    """Return the step after `last`.

    Raises
    ------
    RunError
        A given step is longer than the critical one, or every step is; elements are unstable or
        inside out.
    """
    stepping = model.stepping
    if isinstance(stepping, AutoSteps):
        stepped = _chosen(model, stepping, last, clock)
    else:
        time = stepping.after(last.time)
        if model.mechanism.moved and not model.allow_unstable:
            begun = perf_counter()
            limit, step = find_limit(model, last), time - last.time
            clock.add("motion", begun)
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


def _chosen(model: Model, stepping: AutoSteps, last: SystemState, clock: Clock) -> Stepped:
    """Return a step as long as it may be."""
    begun = perf_counter()
    if model.mechanism.followers and model.mechanism.moved and not model.allow_unstable:
        limit = limit_of(model, last, "following")
        if last.step > limit.critical:
            raise RunError(
                f"t = {last.time:g}: no step is stable for {limit.of}, whose stiffness follows the "
                f"step: the critical one is {limit.critical / last.step:.3g} of any. Take a "
                "smaller scale of its law; allow_unstable lets it pass"
            )
    limit = limit_of(model, last, "lasting") if model.mechanism.moved else NO_LIMIT
    kicks = 0.0
    for name, nodes in model.mechanism.joined.items():
        acting = ForcesOn(model, name, last.acting)
        kicks += nodes.kick_energy(last.slaves[name], acting, model.gravity)
    start = Start(last, stepping.most, limit, kicks)
    cut = proposed(model, stepping, start)
    clock.add("motion", begun)
    longer: Try | None = None
    # The last two steps before a kink share what is left, so that none is tiny.
    kinks = [*model.kinks, *kinks_of_triggers(model, last)]
    until = min((time for time in kinks if time > last.time), default=stepping.end)
    at_end = not until < stepping.end
    until = min(until, stepping.end)
    left, reason = until - last.time, Reason.END if at_end else Reason.KINK
    for tries in count(1):
        time = last.time + cut.step
        if cut.step >= left:
            time, cut = until, Cut(left, reason) if cut.step > left else cut
        elif 2.0 * cut.step > left:
            time, cut = last.time + 0.5 * left, Cut(0.5 * left, reason)
        stepped = advance(model, last, time, clock)
        begun = perf_counter()
        now = Try(stepped, NO_LIMIT)
        if model.mechanism.moved:
            now = tried(model, stepping, start, stepped)
        loses = model.mechanism.keeps_energy and now.missing > now.bearable
        shorter = objection(model, stepping, start, now, loses=loses)
        clock.add("motion", begun)
        if shorter is None:
            handed, missed = now.handed, 0.0
            judged = model.mechanism.keeps_energy and not loses
            if judged and now.missing > _lost(model, stepped.state):
                missed = now.missing  # let pass: shorter steps have not reduced it
            state = replace(
                stepped.state,
                shaking=now.shaking,
                leak=leak_of(last, now, longer),
                place_error=handed.place,
                speed_error=handed.speed,
            )
            choice = Choice(cut, tries, missed, now.single, now.lag, now.late)
            return stepped._replace(state=state, choice=choice)
        if loses and shorter.reason in (Reason.ENERGY, Reason.SHORTEST):
            longer = now
        cut = shorter
    raise AssertionError("there is always another step")


def proposed(model: Model, stepping: AutoSteps, start: Start) -> Cut:
    """Return the longest step that is foreseen to be right, and why it is not longer."""
    last, most = start.state, start.most
    cuts = [Cut(most, Reason.LARGEST)]
    if model.sensors or model.springs:
        cuts.append(Cut(longest_sample(model), Reason.SAMPLE))
    for part in model.contacts:
        # Points that a motion drives go as far as they may.
        if part.name in model.driven_contacts and (speed := _speed(model, part, last)) > 0.0:
            before = last.contacts[part.name]
            room = _room(model, part, before, np.full(len(before.patch), most * speed / AIM))
            step = AIM * float(room.min(initial=math.inf)) / speed
            cuts.append(Cut(step, Reason.WAY, f"contact {part.name!r}"))
    shaking = last.shaking
    if not last.step:  # nothing is known of changes: as if all there is swung
        bodies, nodes = _fastest(start.limit.bodies), _fastest(start.limit.nodes)
        shaking = max(bodies**2, OF_NODES * nodes**2) * math.sqrt(2.0 * last.peak_energy)
    cut = min([*cuts, *_met(model, stepping, start, last, start.limit, shaking)])
    if not 0.0 < last.step < cut.step:  # of others nothing grows
        return cut
    if not model.mechanism.deforms:
        grown = GROWTH * last.step
    else:
        square = last.step * last.step
        if start.kicks > 0.0:
            gained = square + GAINED * last.peak_energy / start.kicks
            square = min(gained, GROWTH_OF_ELEMENTS**2 * square)
        grown = math.sqrt(square)
    return min(cut, Cut(grown, Reason.GROWTH))


def _met(
    model: Model,
    stepping: AutoSteps,
    start: Start,
    state: SystemState,
    limit: Limit,
    shaking: float,
) -> list[Cut]:
    """Limit steps by what may be met without being foreseen at their start: turns and stiffness."""
    cuts: list[Cut] = []
    system = model.mechanism
    for i in (*system.free.tolist(), *system.driven):
        spin = length(state.bodies.twists[i, 3:])
        if spin > 0.0:
            part = TURNED if i in system.row else DRIVEN
            cuts.append(Cut(part / spin, Reason.TURN, f"body {list(model.bodies)[i]!r}"))
    if system.moved:
        cuts.append(Cut(stepping.safety * limit.critical, Reason.CRITICAL, limit.of))
        if shaking > 0.0:
            followed = RESOLVED * math.sqrt(math.sqrt(2.0 * state.peak_energy) / shaking)
            least = _shortest(model, stepping, start.most, limit.critical)
            cuts.append(Cut(max(followed, least), Reason.SWING, limit.of))
    return cuts


def _shortest(model: Model, stepping: AutoSteps, most: float, critical: float) -> float:
    """Return the step that only stability, ways and kinks go below."""
    part = SHORTEST_OF_ELEMENTS if model.mechanism.deforms else SHORTEST
    return stepping.shortest or part * min(critical, most)


def _fastest(rates: Rates) -> float:
    """Return the highest ω of any vibration, 1/time."""
    return max(math.sqrt(rates.square), DAMPED * rates.decay)


def tried(model: Model, stepping: AutoSteps, start: Start, stepped: Stepped) -> Try:
    """Return a step with what it shows."""
    last, state = start.state, stepped.state
    limit = limit_of(model, state, "lasting")
    energetic = math.sqrt(2.0 * state.peak_energy)
    shaking = shaking_of(model, last, state, limit)
    least = _shortest(model, stepping, start.most, min(limit.critical, start.limit.critical))
    missing = missing_of(model, start, state)
    bearable = _lost(model, state) + LEAKED * last.leak * state.step
    handed = hand_over(model, last, state)
    now = Try(stepped, limit, shaking, missing, bearable, least, handed=handed)
    swings = math.sqrt(limit.points) * state.step
    if swings <= PHASED and not handed.late:
        return now
    # What single points are off by, as far as that shows.
    kick = changes_of_points(model, last, state) * state.step
    shown = kick / energetic if kick > 0.0 else 0.0
    followed = all(swings <= most or shown <= share for most, share in UNFOLLOWED)
    lags = swings > PHASED and shown > SWUNG * swings * swings  # a kick is v (ω h)² at most
    # What shares a force swings by itself only where its depths part.
    lags = lags and handed.parting > PARTED * energetic
    return now._replace(
        single=0.0 if followed else swings,
        lag=swings**3 / 24.0 if lags else 0.0,
        late=handed.late if shown > HANDED else 0.0,
    )


def objection(
    model: Model, stepping: AutoSteps, start: Start, now: Try, *, loses: bool
) -> Cut | None:
    """Return the step to take in place of one, and why; None where it may pass.

    It `loses` where its energy balance error is larger than allowed.
    """
    last, state, step = start.state, now.stepped.state, now.stepped.state.step
    if step > LEAST * start.most:
        further = gone_too_far(model, last, state)
        if further is not None:
            return further
    if not model.mechanism.moved:
        return None
    foreseen = _met(model, stepping, start, state, now.limit, now.shaking)
    next_cut = min(foreseen, default=Cut(math.inf, Reason.END))
    if step > COARSER * next_cut.step:
        shorter = Cut(min(0.5 * step, COARSER * next_cut.step), Reason.STIFFER, next_cut.of)
        if next_cut.reason == Reason.CRITICAL:
            return shorter
    elif loses:
        # The contact whose own balance has changed most.
        off = {
            name: abs(at.energy.error - last.contacts[name].energy.error)
            for name, at in state.contacts.items()
        }
        name = max(off, key=lambda key: off[key], default="")
        loser = f"contact {name!r}" if name and off[name] > 0.0 else ""
        part = min(0.5, max(0.05, 0.7 * math.sqrt(now.bearable / now.missing)))
        shorter = Cut(part * step, Reason.ENERGY, loser)
    else:
        return None
    if step <= SAME * now.least:  # about as short already as it may be
        return None
    return Cut(now.least, Reason.SHORTEST, shorter.of) if now.least > shorter.step else shorter


def _lost(model: Model, state: SystemState) -> float:
    """Return the energy that a step may miss in the balance, if shorter ones keep it."""
    return (LOST_OF_ELEMENTS if model.mechanism.deforms else LOST) * state.peak_energy


def leak_of(last: SystemState, now: Try, longer: Try | None) -> float:
    """Return the energy balance error per time that steps have however short they are.

    Of what points leave that come in, half as long a step leaves half the energy a time, or less;
    of forces that are the gradient of none all. Between the two lies 1/√2. `longer` is a step that
    was too long by its energy, from the same start.
    """
    step = now.stepped.state.step
    rate = now.missing / step
    if longer is not None:
        before = longer.stepped.state.step
        if rate > math.sqrt(step / before) * (longer.missing / before):
            return last.leak + LEARNT * (rate - last.leak)
    return max(0.5 * last.leak, min(rate, last.leak))


def missing_of(model: Model, start: Start, state: SystemState) -> float:
    """Return the energy balance error of a step, but for what a leapfrog owes until the next one.

    The kinetic energy of bodies stands h² F²/(8 m) above what the work of its forces has made it,
    but for the loads', which is told as it is; that of elements does as far as h has changed.
    """
    last, owed = start.state, 0.0
    if model.mechanism.loads:
        owed = -load_work_beyond_way(model, last, state.rigid, state.bodies.poses, state.time)
    for k, one in enumerate(model.mechanism.fixed):
        a, b = last.rigid[k, FORCE : FORCE + 3], state.rigid[k, FORCE : FORCE + 3]
        owed += float((b * b - a * a).sum()) * state.step * state.step / (8.0 * one[MASS])
    if state.step != last.step:
        owed += (last.step * last.step - state.step * state.step) * start.kicks
    # Work that may or may not have been done by damping that set in within the step: a damping
    # force is there at once when a point comes in at a speed. The step counts half of its work over
    # the whole step, wherever in it that was; of many points the errors are independent.
    squares = 0.0
    for part in model.contacts:
        now = state.contacts[part.name]
        if now.kept.damping is None:
            continue
        rows, damping = now.kept.damping.nonzero()
        new = now.status[rows] == ContactStatus.NEW
        rows, damping = rows[new], damping[new]
        way = _ways(part, last.contacts[part.name], now, rows)
        work = 0.5 * damping * row_products(way, now.kept.normal_B.at(rows))
        squares += float((work * work).sum())
    return abs(state.energy.error - last.energy.error + owed) + JUMPS * math.sqrt(squares)


class _Felt(NamedTuple):
    """Forces, or their rates, at some points of a contact."""

    rows: IndexArray
    """(k,) points of contact."""
    forces: FloatArray
    """(k, 3) on the slave, world axes."""


def shaking_of(model: Model, last: SystemState, state: SystemState, limit: Limit) -> float:
    """Return how fast the forces on bodies and nodes change in the step from `last`, over √mass.

    Where a body turns round, and forces do not change, a swing at ω shakes it by ω F; by no more
    than before, so that a force which stays, as in steady sliding, is forgotten.
    """
    system, turning = model.mechanism, 0.0
    # Rates of turning count by what they would do to the kinetic energy alike.
    decay = DAMPED * DAMPED * limit.bodies.decay
    rates = np.zeros((len(system.free), 6))
    for part in model.contacts:
        if part.name not in model.mechanism.followers and model.mechanism.sides[part.name].free:
            for felt in _rates(part, last, state, decay):
                places = state.contacts[part.name].held_W.points.at(felt.rows)
                _add_felt(rates, model, part, places, felt.forces, state)
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
    of_bodies = max([0.0, *(_over_mass(system, k, rate, state) for k, rate in enumerate(rates))])
    fastest = _fastest(limit.bodies)
    if fastest > 0.0:
        turning = last.shaking * math.exp(-FORGOTTEN * fastest * state.step)
        forces = state.rigid[:, FORCE : FORCE + 6]
        pulls = [_over_mass(system, k, force, state) for k, force in enumerate(forces)]
        turning = min(turning, fastest * max(pulls, default=0.0))
    of_nodes = dragged = 0.0
    for name, mass in system.loose.items():  # of a slave all together
        rates = np.zeros((len(mass), 3))
        for part in model.contacts:
            if part.slave != name or part.name in model.mechanism.followers:
                continue
            decay = DAMPED * DAMPED * limit.nodes.decay
            for felt in _rates(part, last, state, decay):
                for k, values in enumerate(felt.forces.T):
                    nodes, sums = part.contact.nodal_sum(felt.rows, np.ascontiguousarray(values))
                    rates[nodes, k] += sums
        root = math.sqrt(float((np.square(rates).sum(axis=1) / mass).sum()))
        of_nodes = max(of_nodes, root)
    for part in model.contacts:
        # The rate at which viscous friction changes, over what it can be at most.
        friction: Any = part.contact.friction
        now = state.contacts[part.name]
        if getattr(friction, "viscosity", None) is not None:
            rate = _gripped(last.contacts[part.name], now, state.step).forces
            bound = friction.coefficient * float(now.normal_force.sum())
            if bound > 0.0:
                whole = float(np.sqrt(np.square(rate).sum(axis=1)).sum())
                dragged = max(dragged, whole / bound)
    decay = max(limit.bodies.decay, limit.nodes.decay)
    dragged = decay * dragged * math.sqrt(2.0 * state.peak_energy)
    return max(math.hypot(of_bodies, turning), OF_NODES * of_nodes, OF_DRAG * dragged)


def _over_mass(system: Mechanism, k: int, rate: FloatArray, state: SystemState) -> float:
    """Return √(ṗᵀ M⁻¹ ṗ) for the rate (6,) of force and moment about the centre of a body."""
    one, turn = system.fixed[k], state.bodies.poses[int(system.free[k]), :3, :3]
    torque = product(turn.T, rate[3:] * one[SPINS : SPINS + 3])
    moment = product(one[AXES : AXES + 9].reshape(3, 3).T, torque)
    square = np.square(rate[:3] * one[WAYS : WAYS + 3]).sum() / one[MASS]
    return math.sqrt(float(square + (moment * moment / one[MOMENTS : MOMENTS + 3]).sum()))


def _rates(
    part: ContactPart, last: SystemState, state: SystemState, decay: float
) -> tuple[_Felt, ...]:
    """Return the rates of a contact's forces on its slave: normal ones by stiffness, and friction.

    What sets in at once has no stiffness.
    """
    before, now = last.contacts[part.name], state.contacts[part.name]
    rows, stiffness = now.kept.stiffness.nonzero()
    if len(rows) == 0 and now.kept.traction_B is None:
        return ()
    normals = now.kept.normal_B.at(rows)
    inward = -row_products(_ways(part, before, now, rows), normals) / state.step
    rate = stiffness * np.where(np.isfinite(inward), inward, 0.0)
    if now.kept.damping is not None:
        rate = rate + decay * now.kept.damping.at(rows)
    elastic = _Felt(rows, turn_to_world(now.pose, rate[:, None] * normals))
    if now.kept.traction_B is None:
        return (elastic,)
    return elastic, _gripped(before, now, state.step)


def _gripped(before: State, now: State, step: float) -> _Felt:
    """Return the rates of friction at points that carried in the last step, too."""
    kept, last = now.kept, before.kept
    if kept.traction_B is None or last.traction_B is None:
        return _Felt(kept.normal_force.rows[:0], np.zeros((0, 3)))
    rows, traction = kept.traction_B
    carried = (kept.normal_force.at(rows) > 0.0) & (last.normal_force.at(rows) > 0.0)
    rows, traction = rows[carried], traction[carried]
    rate = (traction - last.traction_B.at(rows)) / step
    return _Felt(rows, turn_to_world(now.pose, rate))


def _add_felt(
    rates: FloatArray,
    model: Model,
    part: ContactPart,
    places: FloatArray,
    forces: FloatArray,
    state: SystemState,
) -> None:
    """Add what acts on the slave at places (k, 3), and the reverse on the master, where free."""
    sides = model.mechanism.sides[part.name]
    for k, sign in zip(sides.free, sides.signs, strict=True):
        add_forces(rates[k], places, sign * forces, state.rigid[k, CENTRE : CENTRE + 3])


def changes_of_points(model: Model, last: SystemState, state: SystemState) -> float:
    """Return the largest change of forces on single points in a step, over √mass.

    These are nodes of a free slave, or points that share a force on the body they stand on.
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
            _add_felt(changes, model, part, places, shared, state)
    return max([most, *(_over_mass(system, k, own, state) for k, own in enumerate(changes))])


def _change_of_nodes(model: Model, name: str, last: SystemState, state: SystemState) -> FloatArray:
    """Return the change (n, 3) of the forces on the nodes of a slave."""
    return nodal_force(model, name, last.acting) - nodal_force(model, name, state.acting)


def _sharing(before: State, now: State) -> IndexArray:
    """Return the points with a normal force in either state."""
    both = before.kept.normal_force.nonzero(), now.kept.normal_force.nonzero()
    return np.union1d(both[0].rows, both[1].rows)


def hand_over(model: Model, last: SystemState, state: SystemState) -> HandOver:
    """Return the errors after a step from `last`, which holds those before it."""
    system, step = model.mechanism, state.step
    place = last.place_error + step * last.speed_error
    speed, late, parts = last.speed_error, 0.0, []
    for part in model.contacts:
        if not getattr(part.contact.law, "acts_as_one", False):
            continue
        before, now = last.contacts[part.name], state.contacts[part.name]
        bodies = model.mechanism.sides[part.name].free
        # How fast the depths of points part that share a force, or hand it on.
        parting, rows = math.inf, _sharing(before, now)
        rows = rows[now.in_contact[rows]]
        if len(rows) > 1:  # else one has it alone
            way = _ways(part, before, now, rows)
            parting = float(np.ptp(row_products(way, now.kept.normal_B.at(rows)) / step))
        if math.isfinite(parting):
            # The least mass that the contact moves at either side; 0 where it moves none.
            masses = [float(system.fixed[row, MASS]) for row in bodies]
            if part.slave in system.masses:
                masses.append(float(system.masses[part.slave].sum()))
            parts.append(parting * math.sqrt(min(masses, default=0.0)))
        if not (before.n_contact or now.n_contact):
            continue
        # The largest change in the step of the acceleration of a point, by what is free at either
        # side of the contact: of a body by its force, and by its torque.
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
        place += OWN * step * step * change_of_all
        if 0.0 < parting < math.inf:
            late = max(late, place / parting)
            speed += change_of_all * min(late, step)
    return HandOver(place, speed, late, max(parts, default=math.inf))


def gone_too_far(model: Model, last: SystemState, state: SystemState) -> Cut | None:
    """Return the step to take in place of one in which points pass through a wall unnoticed.

    They go past a wall that never pushed them, or in and out; None where they do not.

    They may go a small part of the master's size, or as far as they cannot touch it.
    """
    worst, of = 1.0, ""
    gone: dict[str, FloatArray] = {}
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        gone[part.name] = ways = _lengths(now.points_B - before.points_B)
        if part.name in model.driven_contacts:
            # What a table drives may turn round, or whole turns, between the ends of a step; and
            # a surface that changes its shape goes past points that stand.
            fastest = max(_speed(model, part, last), _speed(model, part, state))
            ways = np.maximum(ways, fastest * state.step)
        room = _room(model, part, before, ways)
        if (far := float(np.max(ways / room, initial=0.0))) > worst:
            worst, of = far, f"contact {part.name!r}"
    if worst > 1.0:
        return Cut(state.step * max(LEAST_PART, AIM / worst), Reason.WAY, of)
    least = 1.0
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        if len(now.control_points):
            continue  # `_room` alone keeps the ways short of points beside it
        free = (before.patch < 0) & (now.patch < 0) & (before.safe_distance >= 0.0)
        way = gone[part.name]
        rows = np.flatnonzero(free & (way > before.safe_distance)).astype(np.int32)
        if len(rows):
            surface = model.bodies[part.master].body.surface
            share = _first_inside(surface, before.points_B, now.points_B, way, rows)
            if share < least:
                least, of = share, f"contact {part.name!r}"
    if not of:
        return None
    return Cut(state.step * max(LEAST_PART, least), Reason.CROSSING, of)


def _room(model: Model, part: ContactPart, before: State, wanted: FloatArray) -> FloatArray:
    """Return how far (m,) each point may go; those that want to go farther are measured."""
    known = np.where(before.patch >= 0, 0.0, before.safe_distance)
    # Points that lie inside since the start touch nothing.
    half = part.contact.half_thickness
    span = np.full(len(known), SPAN * model.mechanism.sides[part.name].size)
    if len(before.control_points) and half is not None:
        # A point that half a thickness did not reach cannot pass the wall within that length.
        span = np.where(half > 0.0, np.minimum(half, span), span)
    room = np.where(known < 0.0, math.inf, np.maximum(span, known))
    rows = np.flatnonzero((wanted > room) & (before.patch < 0)).astype(np.int32)
    if len(rows):
        # What is left of a distance known once lessens on any way, also on one that leads away.
        clear = np.zeros(len(room))
        surface = model.bodies[part.master].body.surface
        if len(before.control_points):
            follows, net = part.contact.follows_feet, before.control_points
            surface = shape_of(part.contact.master, follows, net).surface
        surface.safe_distance(before.points_B, rows, clear)
        if half is not None:
            clear -= half
        room = np.maximum(room, clear)
    return room


def _speed(model: Model, part: ContactPart, at: SystemState) -> float:
    """Return an upper bound of the speed of all nodes relative to the master."""
    slave, body = at.slaves[part.slave], at.bodies[part.master]
    against = slave.velocities - body.twist.at(body.pose[:3, 3], slave.points)
    shape = model.shapes.velocity(part.master, at.time, at.slaves)
    fastest = 0.0 if shape is None else float(_lengths(shape).max(initial=0.0))
    return fastest + float(np.max(_lengths(against), initial=0.0))


def _ways(part: ContactPart, before: State, now: State, rows: IndexArray) -> FloatArray:
    """Return displacements (k, 3) of points in contact relative to the surface, body axes."""
    points = now.points_B[rows]
    ways = points - before.points_B[rows]
    if len(now.control_points):
        body, change = part.contact.master.faces, now.control_points - before.control_points
        assert body is not None
        feet = SurfacePlaces(now.patch[rows], now.uv[rows])
        ways = ways - NetMotion(body, now.control_points, change).carry(feet, points)
    return ways


def _lengths(ways: FloatArray) -> FloatArray:
    """Return the lengths (n,) of the rows, zero for those that are not finite."""
    square = row_products(ways, ways)
    return np.asarray(np.sqrt(np.where(np.isfinite(square), square, 0.0)))


def _first_inside(
    surface: Surface, a: FloatArray, b: FloatArray, way: FloatArray, rows: IntArray
) -> float:
    """Return the first part of its way, from a to b (n, 3), at which a point is inside.

    Only points count that are outside at both ends.
    """
    entry = surface.entries(a, b, rows)
    rows, start = rows[entry.patch >= 0], entry.point[entry.patch >= 0]
    if len(rows) == 0:
        return 1.0
    leaving, sense = surface.last_crossings(a, b, rows)
    out = sense < 0
    rows, start, end = rows[out], start[out], leaving.point[out]
    if len(rows) == 0:
        return 1.0
    middle = 0.5 * (start + end)
    depth = -closest(surface, middle, np.arange(len(rows), dtype=np.int32)).gap
    aim = np.where((depth > 0.0)[:, None], middle, start + CLIPPED * (end - start))
    gone = _lengths(aim - a[rows]) / way[rows]
    # As deep as its way inside is long, or outside again between two walls: through one.
    least = np.minimum(CLIPPED * way[rows], STEEP * _lengths(end - start))
    return float(np.min(gone, initial=1.0, where=(depth > least) | (depth <= 0.0)))
