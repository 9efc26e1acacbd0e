"""One step of a simulation: place what moves, then every contact, then what their forces do."""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple

from contiga.contact.state import State
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.rigid_bodies import kicked
from contiga.simulation.clock import Clock
from contiga.simulation.forces import spring_states, wrenches
from contiga.simulation.ledger import contact_energy, energy_of, external_work
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.place import Placement, frames, kicked_nodes, place
from contiga.simulation.reasons import Choice
from contiga.simulation.system_state import BodyState, SystemState


class Stepped(NamedTuple):
    """What a step has made."""

    state: SystemState
    walls: dict[str, float]
    """Seconds each contact took, by contact."""
    choice: Choice | None = None
    """How its length was chosen; None where it was given."""


def advance(model: Model, last: SystemState | None, time: float, clock: Clock) -> Stepped:
    """The simulation at `time`, from the state `last` before it; None at the start."""
    with clock("motion"):
        standing = place(model, last, time)
    contacts: dict[str, State] = {}
    walls: dict[str, float] = {}
    for part in model.contacts:
        begun = perf_counter()
        pair = standing.slaves[part.slave], standing.bodies[part.master]
        contacts[part.name] = _touch(part, last, pair, time, clock)
        walls[part.name] = perf_counter() - begun
    if not (model.mechanism.moved or model.sensors):
        dt = 0.0 if last is None else time - last.time
        energy = contact_energy(contacts)
        state = SystemState(time, standing.bodies, standing.slaves, contacts, energy, dt)
        return Stepped(state, walls)
    with clock("motion"):
        return Stepped(_moved(model, last, standing, contacts, time), walls)


def _moved(
    model: Model,
    last: SystemState | None,
    standing: Placement,
    contacts: dict[str, State],
    time: float,
) -> SystemState:
    """The end of a step in which forces move bodies: the other half of their kick, and energies."""
    system, dt = model.mechanism, standing.now.dt
    springs = spring_states(model, last, standing)
    if last is not None:
        standing = standing._replace(slaves=kicked_nodes(model, last, standing, contacts))
    acting = wrenches(model, contacts, springs, standing, time)
    kinetic = kicked(standing.free, system.fixed, acting[system.free], dt)
    external, initial = 0.0, None
    if last is not None:
        work = external_work(model, last, standing, contacts, acting, time)
        external, initial = last.energy.external + work, last.energy.initial
    inside = [nodes.energy(standing.slaves[name]) for name, nodes in system.nodes.items()]
    energy = energy_of(contacts, springs, inside, kinetic, external, initial)
    bodies = frames(system, standing)
    now = standing.now._replace(twists=bodies.twists)
    return SystemState(
        time,
        bodies,
        {name: nodes.carried(standing.slaves[name], now) for name, nodes in system.nodes.items()},
        contacts,
        energy,
        step=dt,
        rigid=standing.free.rows,
        wrenches=acting,
        springs=springs,
        rest=None if last is None else last.rest,
        peak_energy=max(0.0 if last is None else last.peak_energy, energy.total + energy.lost),
    )


def _touch(
    part: ContactPart,
    last: SystemState | None,
    pair: tuple[SlaveState, BodyState],
    time: float,
    clock: Clock,
) -> State:
    """One contact at `time`."""
    p_W, X_WB = pair[0].points, pair[1].pose
    if last is None:
        return part.contact.start(p_W, X_WB, clock=clock)
    return part.contact.step(
        last.contacts[part.name],
        p_W,
        X_WB,
        time - last.time,
        velocity=pair[0].velocities,
        twist=pair[1].twist,
        clock=clock,
    )
