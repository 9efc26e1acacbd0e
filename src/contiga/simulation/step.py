"""One step of a simulation: place what moves, then every contact in turn."""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.prescribed import BodyMotion
from contiga.errors import InputError
from contiga.num.ordered import length
from contiga.num.pose import as_pose
from contiga.num.twist import Twist
from contiga.records import ContactStatus
from contiga.simulation.clock import Clock
from contiga.simulation.model import ContactPart, Model, SlavePart
from contiga.simulation.system_state import BodyState, SlaveState, SystemState, energy_of

# Columns of the history that count points by what became of them in the step.
COUNTED = {
    "n_new": ContactStatus.NEW,
    "n_old": ContactStatus.OLD,
    "n_held": ContactStatus.HELD,
    "n_released": ContactStatus.RELEASED,
    "n_slid_off": ContactStatus.SLID_OFF,
    "n_lost": ContactStatus.LOST,
    "n_not_finite": ContactStatus.NOT_FINITE,
    "n_found": ContactStatus.FOUND,
    "n_reacquired": ContactStatus.REACQUIRED,
    "n_through": ContactStatus.THROUGH,
}


class Stepped(NamedTuple):
    """What a step has made."""

    state: SystemState
    walls: dict[str, float]
    """Seconds each contact took, by contact."""


def place(model: Model, time: float) -> tuple[dict[str, BodyState], dict[str, SlaveState]]:
    """Bodies and slaves at `time`, and how they move."""
    bodies = {name: _body_at(name, part.motion, time) for name, part in model.bodies.items()}
    slaves = {name: _slave_at(name, part, time) for name, part in model.slaves.items()}
    return bodies, slaves


def _body_at(name: str, motion: BodyMotion, time: float) -> BodyState:
    """A body at `time`; what its motion answers is checked, since it may be a user's."""
    where = f"bodies[{name!r}]: motion at t = {time:g}"
    pose, twist = as_pose(motion.pose(time), where), motion.twist(time)
    if not isinstance(twist, Twist) or not all(
        np.shape(part) == (3,) and np.isfinite(part).all() for part in twist
    ):
        raise InputError(
            "twist(t) must be a velocity and a spin",
            where=where,
            found=twist,
            allowed="contiga.motion.Twist of two arrays (3,), finite",
        )
    return BodyState(pose, twist)


def _slave_at(name: str, part: SlavePart, time: float) -> SlaveState:
    """A slave at `time`."""
    state = SlaveState(part.motion.points(time), part.motion.velocities(time))
    for what, rows in zip(state._fields, state, strict=True):
        if np.shape(rows) != part.slave.points.shape:
            raise InputError(
                f"{what}(t) must have one row a slave point",
                where=f"slaves[{name!r}]: motion at t = {time:g}",
                found=np.shape(rows),
                allowed=str(part.slave.points.shape),
            )
    return state


def advance(model: Model, last: SystemState | None, time: float, clock: Clock) -> Stepped:
    """The simulation at `time`, from the state `last` before it; None at the start."""
    with clock("motion"):
        bodies, slaves = place(model, time)
    contacts: dict[str, State] = {}
    walls: dict[str, float] = {}
    for part in model.contacts:
        begun = perf_counter()
        contacts[part.name] = _touch(
            part, last, (slaves[part.slave], bodies[part.master]), time, clock
        )
        walls[part.name] = perf_counter() - begun
    return Stepped(SystemState(time, bodies, slaves, contacts, energy_of(contacts)), walls)


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


def history_row(model: Model, stepped: Stepped, *, measured: bool) -> dict[str, float]:
    """One row of the history; columns carry the contact's name where there are several.

    Contact areas are measured where `measured` is said; else they are NaN.
    """
    row: dict[str, float] = {"time": stepped.state.time}
    for part in model.contacts:
        prefix = "" if len(model.contacts) == 1 else f"{part.name}."
        columns = _columns(
            stepped.state.contacts[part.name], stepped.walls[part.name], measured=measured
        )
        row |= {prefix + name: value for name, value in columns.items()}
    return row


def _columns(state: State, wall: float, *, measured: bool) -> dict[str, float]:
    """What the history says of one contact."""
    force, moment_about = state.total_force, state.wrench[3:]
    centre = state.centre_of_pressure
    measured = measured or state.contact.weights == "area"
    columns: dict[str, float] = {
        "n_contact": state.n_contact,
        "max_penetration": state.max_penetration,
        "force_x": force[0],
        "force_y": force[1],
        "force_z": force[2],
        "force": length(force),
        "moment_x": moment_about[0],
        "moment_y": moment_about[1],
        "moment_z": moment_about[2],
        **_friction_columns(state),
        "area": state.total_area if measured else np.nan,
        "n_clusters": state.n_clusters if measured else np.nan,
        "mean_pressure": state.mean_pressure if measured else np.nan,
        "max_pressure": state.max_pressure,
        "centre_x": centre[0],
        "centre_y": centre[1],
        "centre_z": centre[2],
        **_energy_columns(state),
        "wall_time": wall,
    }
    counts = np.bincount(state.status, minlength=len(ContactStatus))
    columns |= {name: int(counts[status]) for name, status in COUNTED.items()}
    columns["n_unproved"] = state.n_unproved
    return columns


def _friction_columns(state: State) -> dict[str, float]:
    """Force of friction on the slave, where there is friction."""
    if len(state.traction_B) == 0:
        return {}
    total = state.friction.sum(axis=0)
    return {f"friction_{axis}": float(value) for axis, value in zip("xyz", total, strict=True)}


def _energy_columns(state: State) -> dict[str, float]:
    """Where the work done on the contact went since the start."""
    energy = state.energy
    return {
        "work": energy.work,
        "energy_stored": energy.stored,
        "energy_hysteresis": energy.hysteresis,
        "energy_damping": energy.damping,
        "energy_friction": energy.friction,
        "energy_error": energy.error,
    }
