"""Bring a simulation to rest before a run: dynamic relaxation with kinetic damping.

Prescribed motions are stopped. Deforming slaves, and free bodies that are named, move by the forces
on them in steps near the critical one. Their velocities are set to zero whenever the kinetic energy
has passed a peak, which is where forces balance (P. A. Cundall, 1976; M. R. Barnes, Int. J. Space
Struct. 14, 1999), so that nothing swings far beyond equilibrium, which materials would remember.
Between stops the velocities are steered towards the forces, a little less each step; otherwise fast
vibrations that every stop meets at their turning point would remain (E. Bitzek et al., Phys. Rev.
Lett. 97, 2006). This takes a quarter of the steps of stops alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from contiga.arrays.ordered import length, row_lengths
from contiga.contact.state import ContactEnergy, State
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.free import Attached, Dependent, Free
from contiga.dynamics.nodes import Imbalance
from contiga.dynamics.prescribed import Fixed, Moved, Stopped
from contiga.dynamics.rigid_bodies import Placed, kick_bodies
from contiga.dynamics.shapes import ControlPoints, ControlPointsOf
from contiga.dynamics.springs import GROUND, Spring
from contiga.dynamics.stepping import GivenTimes
from contiga.errors import InputError, RunError
from contiga.rigid.rigid_lanes import (
    FORCE,
    FREE_DIRECTIONS,
    FREE_ROTATIONS,
    MASS,
    MOMENTUM,
    TORQUE,
    VELOCITY,
)
from contiga.rigid.twist import still
from contiga.simulation.clock import Clock
from contiga.simulation.critical import check_stable, limit_of
from contiga.simulation.joints import joint_states, react_joints
from contiga.simulation.model import BodyPart, Model, SlavePart
from contiga.simulation.settle import Rest, Settle
from contiga.simulation.step import (
    NodalForces,
    StepResult,
    advance,
    energy_of,
    kicked_bodies,
    place,
    wrenches,
)
from contiga.simulation.step_size import unnoticed_passage
from contiga.simulation.system_state import Acting, BodyStates, SystemState
from contiga.simulation.triggers import trigger_states

SAFETY = 0.7
"""Step as a share of the critical one: near 1 the fastest vibrations outlast the stops, and nodes
that begin far from equilibrium go astray."""
STEERING_SHARE, STEERING_DECAY = 0.1, 0.99
"""Share of the velocities that is turned towards the forces in the step after a stop, and the
factor on that share from step to step."""
JOINT_SAFETY = 0.2
"""Share of the critical step with joints: a mechanism has few modes, and each must be stopped close
to its peak of kinetic energy."""
MAX_ROTATION = 0.2
"""Largest rotation in a step with joints, radians: beyond it the joints may not close."""
STEPS_PER_RUN = 200
"""Number of steps in the duration of the run if nothing bounds the step."""

OnSettle = Callable[[int, float], Any]
"""Called with the number of each step and the residual after it."""


def come_to_rest(model: Model, clock: Clock, on_settle: OnSettle | None = None) -> StepResult:
    """Return the state at the start of `model` after it has come to rest by `model.settling`.

    `on_settle` is called with the number of steps and the residual after each step. The time of
    steps is not that of the run.

    Raises
    ------
    InputError
        The model has nothing that could come to rest.
    RunError
        The model is not at rest after the largest number of steps, or elements are unstable or
        inside out.
    """
    options = model.settling or Settle()
    resting = _resting_model(model, options)
    if not (resting.mechanism.deforms or len(resting.mechanism.free)):
        raise InputError(
            "nothing can come to rest: no slave deforms",
            where="settle",
            remedy="Name the free bodies that are to come to rest as its `bodies`",
        )
    state = advance(resting, None, model.stepping.start, clock).state
    longest = (model.stepping.end - model.stepping.start) / STEPS_PER_RUN
    first = imbalance = _imbalance(resting, state)
    residual = _residual(imbalance, first)
    swing, share = 0.0, STEERING_SHARE
    for step in range(options.steps):
        if residual <= options.tolerance:
            return _first_state(model, resting, state, Rest(step, residual), clock)
        before = state
        # A step near the critical one, shorter where points go too far.
        critical = limit_of(resting, before).critical
        safety = JOINT_SAFETY if resting.joints else SAFETY
        length_of_step = safety * critical if math.isfinite(critical) else longest
        if resting.joints and (spin := float(row_lengths(before.bodies.twists[:, 3:]).max())) > 0.0:
            length_of_step = min(length_of_step, MAX_ROTATION / spin)
        while True:
            state = advance(resting, before, before.time + length_of_step, clock).state
            shorter = unnoticed_passage(resting, before, state)
            if shorter is None:
                break
            length_of_step = shorter.step
        check_stable(resting, state)
        imbalance = _imbalance(resting, state)
        residual = _residual(imbalance, first)
        if on_settle is not None:
            on_settle(step + 1, residual)
        # The kinetic energy in the middle of the step: at the ends of a step it is wrong for the
        # fastest vibrations, whose period is two steps.
        kinetic = state.energy.kinetic
        for name in resting.mechanism.masses:
            nodes, now = resting.mechanism.nodes[name], state.slaves[name]
            mid_kinetic = nodes.kinetic_between(before.slaves[name], now, state.step)
            kinetic += mid_kinetic - nodes.energy(now).kinetic
        last_swing, swing = swing, kinetic
        if swing < last_swing:
            state, swing, share = _stopped(resting, state), 0.0, STEERING_SHARE
        else:
            # A share of the velocities of nodes is turned towards the forces.
            slaves = {}
            for name, nodes in resting.mechanism.nodes.items():
                acting = NodalForces(resting, name, state.acting)
                slaves[name] = nodes.with_mixed_velocities(
                    state.slaves[name], acting, resting.gravity, share
                )
            state, share = replace(state, slaves=slaves), STEERING_DECAY * share
    raise RunError(
        f"it has not come to rest: after {options.steps} steps the unbalanced forces are "
        f"{residual:.3g} of the loads, and {options.tolerance:g} were asked for. Is something held "
        "by nothing? Else allow more steps, or a larger tolerance"
    )


def _resting_model(model: Model, settle: Settle) -> Model:
    """Return the model in which only deforming slaves, and the bodies named by `settle`, move.

    All other motions are stopped as they are at the start, and loads and devices held there. It has
    the joints of bodies that come to rest, and neither sensors nor output.
    """
    start = model.stepping.start
    bodies, slaves = {}, {}
    resting: Any
    for name, (body, motion) in model.bodies.items():
        resting = motion
        if isinstance(motion, Free):
            resting = motion.resting(start) if name in settle.bodies else Fixed()
        elif isinstance(motion, ControlPoints):
            resting = ControlPoints([start], [motion.control_points(start)])
        elif not isinstance(motion, Attached | ControlPointsOf):
            assert not isinstance(motion, Dependent)
            resting = Stopped(motion, start)
        bodies[name] = BodyPart(body, resting)
    for name, (slave, slave_motion) in model.slaves.items():
        resting = slave_motion
        if isinstance(slave_motion, Deforming):
            resting = slave_motion.resting(start)
        elif not isinstance(slave_motion, Dependent):
            resting = Moved(slave_motion.points(start), Fixed())
        elif isinstance(slave_motion, Free):
            resting = Moved(slave.points, Fixed())
        slaves[name] = SlavePart(slave, resting)
    names, system = list(model.bodies), model.mechanism

    def settles(end: str) -> bool:
        return end != GROUND and names[system.root_of(end)] in settle.bodies

    joints = {
        name: joint for name, joint in model.joints.items() if any(map(settles, joint.between))
    }
    return Model(
        bodies=bodies,
        slaves=slaves,
        contacts=model.contacts,
        stepping=GivenTimes([start]),
        gravity=model.gravity,
        springs={name: spring.resting() for name, spring in model.springs.items()},
        slip_rings=model.slip_rings,
        joints=joints,
        loads=tuple(load.at_time(start) for load in model.loads),
        units=model.units,
        gas={name: chamber.resting() for name, chamber in model.gas.items()},
    )


def _stopped(model: Model, state: SystemState) -> SystemState:
    """Return a copy of the state with all velocities and the kinetic energy zero."""
    nodes = model.mechanism.nodes
    slaves = {name: nodes[name].without_velocities(slave) for name, slave in state.slaves.items()}
    rows, twists = state.rigid.copy(), state.bodies.twists.copy()
    rows[:, VELOCITY : VELOCITY + 3] = 0.0
    rows[:, MOMENTUM : MOMENTUM + 3] = 0.0
    twists[:] = 0.0
    bodies = BodyStates(model.mechanism.index, state.bodies.poses, twists)
    energy = state.energy._replace(kinetic=0.0)
    return replace(state, slaves=slaves, rigid=rows, bodies=bodies, energy=energy)


def _imbalance(model: Model, state: SystemState) -> Imbalance:
    """Return unbalanced forces, loads, reactions and rounding, summed over nodes and free bodies.

    They are sums of magnitudes; free bodies add to forces and loads alone.

    The moment on a body counts as a force at the distance of its size.
    """
    system = model.mechanism
    force = load = reaction = rounding = 0.0
    for name, nodes in system.nodes.items():
        acting = NodalForces(model, name, state.acting)
        of_slave = nodes.imbalance(state.slaves[name], acting, model.gravity)
        force, load = force + of_slave.force, load + of_slave.load
        reaction, rounding = reaction + of_slave.reaction, rounding + of_slave.rounding
    weight = math.sqrt(float((model.gravity**2).sum()))
    names = list(model.bodies)
    for row, fixed, i in zip(state.rigid, system.fixed, system.free, strict=True):
        pull = row[FORCE : FORCE + 3] * fixed[FREE_DIRECTIONS : FREE_DIRECTIONS + 3]
        turn = row[TORQUE : TORQUE + 3] * fixed[FREE_ROTATIONS : FREE_ROTATIONS + 3]
        size = model.bodies[names[i]].body.size
        force += length(pull) + length(turn) / size
        load += float(fixed[MASS]) * weight
    return Imbalance(force, load, reaction, rounding)


def _residual(now: Imbalance, first: Imbalance) -> float:
    """Return the unbalanced forces over the loads; 0 if they are below rounding.

    Without loads they are divided by the reactions; without these too, by their own initial value.
    """
    scale = now.load or now.reaction or first.force
    return now.force / scale if now.force > now.rounding else 0.0


def _first_state(
    model: Model, resting: Model, state: SystemState, rest: Rest, clock: Clock
) -> StepResult:
    """Return the first state of a run of `model` that starts from `state` of the resting model.

    Nodes, and bodies that came to rest, keep their places; other motions have the velocities of the
    run's start. Stored energies stay; losses and works begin from zero, rates at standstill.
    """
    system, start = model.mechanism, model.stepping.start
    at_rest = _stopped(resting, state)
    placement = place(model, None, start)
    placed = Placed(*(array.copy() for array in placement.free))
    for k, i in enumerate(system.free):
        at = resting.mechanism.row.get(int(i))
        if at is not None:
            placed.rows[k], placed.twists[k] = at_rest.rigid[at], 0.0
            placed.poses[k] = at_rest.bodies.poses[i]
    poses, twists = placement.bodies.poses.copy(), placement.bodies.twists.copy()
    poses[system.free], twists[system.free] = placed.poses, placed.twists
    poses, twists = poses[system.root], twists[system.root]
    now = placement.now._replace(poses=poses, twists=twists)
    slaves = {
        name: nodes.restarted(at_rest.slaves[name], now) for name, nodes in system.nodes.items()
    }
    bodies = BodyStates(system.index, poses, twists)
    placement = placement._replace(bodies=bodies, slaves=slaves, free=placed, now=now)
    contacts = {}
    for part in model.contacts:  # at rest: without rates, and without losses so far
        points = at_rest.slaves[part.slave].points
        touched = part.contact.step(
            at_rest.contacts[part.name],
            points,
            at_rest.bodies[part.master].pose,
            at_rest.step or 1.0,
            velocity=np.zeros_like(points),
            twist=still(),
            clock=clock,
        )
        stored = touched.energy.stored
        energies = np.array(ContactEnergy(stored, stored, 0.0, 0.0, 0.0))
        contacts[part.name] = State(**(touched.arrays | {"energies": energies}), of=part.contact)
    springs = {
        name: Spring.begun(spring._replace(force=spring.force - spring.damper, damper=0.0))
        for name, spring in at_rest.springs.items()
    }
    rings = {name: ring._replace(friction=0.0) for name, ring in at_rest.slip_rings.items()}
    gas = model.chambers.first_states(at_rest.gas)
    joints = None
    if model.joints:
        joints = joint_states(model, None, bodies)
        settled_laws = {}  # hysteresis and friction continue from these
        if at_rest.joints is not None:
            for k, entry in enumerate(resting.linkage.laws):
                settled_laws[entry.joint, entry.coordinate] = at_rest.joints.law(k)
        for k, entry in enumerate(model.linkage.laws):
            if (law := settled_laws.get((entry.joint, entry.coordinate))) is not None:
                at_standstill = law._replace(force=law.force - law.damper, damper=0.0)
                joints.laws[k] = entry.law.begun(at_standstill)
    forces = Acting(contacts, springs, gas, rings, joints)
    acting = wrenches(model, forces, placement)
    kinetic = kick_bodies(placed, system.fixed, acting[system.free], 0.0)
    if joints is not None:
        kinetic, joints = react_joints(model, None, joints, placed, bodies, start, acting)
        forces = forces._replace(joints=joints)
    inside = [nodes.energy(slaves[name]) for name, nodes in system.nodes.items()]
    energy = energy_of(forces, inside, kinetic, 0.0, None)
    first_state = SystemState(
        start,
        kicked_bodies(system, placement),
        slaves,
        contacts,
        energy,
        rigid=placed.rows,
        wrenches=acting,
        springs=springs,
        slip_rings=rings,
        joints=joints,
        gas=gas,
        peak_energy=energy.total,
        rest=rest,
    )
    first_state = replace(first_state, triggers=trigger_states(model, None, first_state))
    return StepResult(first_state, dict.fromkeys(contacts, 0.0))
