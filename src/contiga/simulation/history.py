"""Make the rows of the history of a run: one row per step, one column per quantity."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length
from contiga.contact.state import State
from contiga.dynamics.stepping import AutoSteps
from contiga.records import IN_CONTACT, ContactStatus
from contiga.rigid import rigid_lanes as lanes
from contiga.rigid.frames import turn_to_world
from contiga.simulation.joints import joint_columns
from contiga.simulation.model import Model, column_prefixes
from contiga.simulation.relative_sensors import relative_columns
from contiga.simulation.sensors import (
    centre_acceleration,
    sensor_columns,
    slave_columns,
    vector_columns,
)
from contiga.simulation.springs import spring_columns
from contiga.simulation.step import StepResult
from contiga.simulation.step_columns import step_columns
from contiga.simulation.system_state import Energy, SystemState
from contiga.simulation.triggers import trigger_columns

# Columns of the history that count the points of each status after the step.
STATUS_OF_COLUMN = {
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

_AREA_COLUMNS = ("area", "n_clusters", "mean_pressure")
_OF_SYSTEM = (
    *("kinetic", "strain", "contact", "friction", "damping", "hysteresis"),
    *("external", "total", "error"),
)
"""Energies of a system, in the order of their columns."""
_OF_CONTACT = ("stored", "hysteresis", "damping", "friction", "error")
"""Energies of a contact, in the order of their columns."""
BODY_COLUMNS = (
    *("x", "y", "z", "vx", "vy", "vz", "ax", "ay", "az"),
    *("qw", "qx", "qy", "qz", "wx", "wy", "wz"),
)
"""Columns of a body: centre of mass, its velocity and acceleration, orientation, spin."""


def history_row(
    model: Model, stepped: StepResult, last: SystemState | None, *, measured: bool
) -> dict[str, float]:
    """Return one row of the history; columns have the contact's name if there are several.

    `last` is the state before the step, None at the start. Contact areas are NaN unless `measured`,
    or needed for the forces.
    """
    row: dict[str, float] = {"time": stepped.state.time}
    for contact, prefix in column_prefixes(model).items():
        contact_state = stepped.state.contacts[contact]
        before = None if last is None else last.contacts[contact]
        columns = contact_columns(
            contact_state, before, stepped.wall_times[contact], measured=measured
        )
        row |= {prefix + name: value for name, value in columns.items()}
    row |= sensor_columns(model, stepped.state, last)
    row |= relative_columns(model, stepped.state, last)
    row |= slave_columns(model, stepped.state)
    row |= trigger_columns(stepped.state)
    row |= spring_columns(model, stepped.state)
    row |= joint_columns(model, stepped.state)
    row |= model.chambers.columns(stepped.state.gas)
    if isinstance(model.stepping, AutoSteps):
        row |= step_columns(model, stepped.choice)
    if model.mechanism.has_dynamics:
        # Centre of mass, velocity, acceleration, orientation and spin of each free body.
        system, names = model.mechanism, list(model.bodies)
        for k, i in enumerate(system.free):
            rigid, fixed = stepped.state.rigid[k], system.fixed[k]
            values = (
                *rigid[lanes.CENTRE : lanes.CENTRE + 3],
                *rigid[lanes.VELOCITY : lanes.VELOCITY + 3],
                *centre_acceleration(rigid, fixed),
                *rigid[lanes.TURN : lanes.TURN + 4],
                *stepped.state.bodies[names[i]].twist.spin,
            )
            row |= {f"{names[i]}.{c}": float(v) for c, v in zip(BODY_COLUMNS, values, strict=True)}
        row |= energy_columns(stepped.state.energy)
        if model.gas:
            row["energy.gas"] = stepped.state.energy.gas
    if model.mechanism.deforms:
        row |= element_columns(stepped.state.energy)
    return row


def measured_columns(model: Model, state: SystemState) -> dict[str, float]:
    """Return the columns of contact areas, which `history_row` leaves NaN if not measured."""
    return {
        prefix + name: value
        for contact, prefix in column_prefixes(model).items()
        for name, value in _area_columns(state.contacts[contact]).items()
    }


def unmeasured_names(model: Model) -> list[str]:
    """Return the names of the columns that are NaN in a row that was not measured.

    Contacts that weigh forces by areas measure them in every step, and have none.
    """
    prefixes = column_prefixes(model)
    return [
        prefixes[part.name] + name
        for part in model.contacts
        if part.contact.weights != "area"
        for name in _AREA_COLUMNS
    ]


def total_force(model: Model, row: dict[str, float]) -> float:
    """Return the sum of the magnitudes of all contacts' forces in a row."""
    return sum(row[prefix + "force"] for prefix in column_prefixes(model).values())


def energy_columns(energy: Energy) -> dict[str, float]:
    """Return the history columns of the energies of a whole system, with the prefix "energy."."""
    return {f"energy.{name}": getattr(energy, name) for name in _OF_SYSTEM}


def element_columns(energy: Energy) -> dict[str, float]:
    """Return the history columns of the energies that only models with elements have."""
    return {"energy.hourglass": energy.hourglass, "energy.viscosity": energy.viscosity}


def contact_columns(
    state: State, last: State | None, wall: float, *, measured: bool
) -> dict[str, float]:
    """Return the history columns of one contact, without the prefix of its name.

    `last` is its state before the step, None at the start; `wall` is the wall-clock time of the
    step, seconds; contact areas are NaN unless `measured`, or needed for the forces. Points that
    are not proved count only while any point is in contact.
    """
    # The same bits as the sum of whole arrays: rows are added one by one, and others are zero.
    force = state.kept.force.values.sum(axis=0) + 0.0
    friction = {}
    if state.kept.traction_B is not None:
        friction_force = turn_to_world(state.pose, state.kept.traction_B.values).sum(axis=0)
        friction = vector_columns("friction_", friction_force + 0.0)
    measured = measured or state.contact.weights == "area"
    counts = np.bincount(state.status, minlength=len(ContactStatus)).tolist()
    n_touching = sum(counts[status] for status in IN_CONTACT)
    columns: dict[str, float] = {
        "n_contact": n_touching,
        "max_penetration": state.max_penetration,
        **vector_columns("force_", force),
        "force": length(force),
        **vector_columns("moment_", state.wrench[3:]),
        **friction,
        **(_area_columns(state) if measured else dict.fromkeys(_AREA_COLUMNS, np.nan)),
        "max_pressure": state.max_pressure,
        **vector_columns("centre_", state.centre_of_pressure),
        "work": state.energy.work,
        **{f"energy_{name}": getattr(state.energy, name) for name in _OF_CONTACT},
        "wall_time": wall,
    }
    columns |= {name: counts[status] for name, status in STATUS_OF_COLUMN.items()}
    columns["n_unproved"] = state.n_unproved if n_touching else 0
    columns["n_tunnelled"] = 0 if last is None else tunnelled(last, state)
    return columns


def tunnelled(last: State, now: State) -> int:
    """Return the number of points that a step released through another wall than their own.

    A point that leaves by its own wall comes out in front of it; one that tunnels is behind it by
    more than half of its depth.
    """
    rows = np.flatnonzero(now.status == ContactStatus.RELEASED)
    if len(rows) == 0:
        return 0
    kept = last.kept
    behind = -((now.points_B[rows] - kept.foot_B.at(rows)) * kept.normal_B.at(rows)).sum(axis=1)
    return int((behind > 0.5 * kept.penetration.at(rows)).sum())


def _area_columns(state: State) -> dict[str, float]:
    """Return the columns that need contact areas, in the order of `_AREA_COLUMNS`."""
    values = state.total_area, state.n_clusters, state.mean_pressure
    return dict(zip(_AREA_COLUMNS, values, strict=True))
