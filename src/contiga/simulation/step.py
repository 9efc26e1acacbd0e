"""One step of a simulation: place the bodies, then every contact in turn."""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.num.ordered import length
from contiga.records import ContactStatus, FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.simulation import Simulation

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
}


class Snapshot(NamedTuple):
    """A simulation at one time."""

    time: float
    poses: dict[str, FloatArray]
    """(4, 4) X_WB by body."""
    points: dict[str, FloatArray]
    """(n, 3) world axes, by slave."""
    states: dict[str, State]
    """By contact."""
    walls: dict[str, float]
    """Seconds each contact took, by contact."""


def place(
    simulation: Simulation, time: float
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Poses of the bodies and points of the slaves at `time`."""
    poses = {name: part.motion.pose(time) for name, part in simulation.bodies.items()}
    points = {name: part.motion.points(time) for name, part in simulation.slaves.items()}
    return poses, points


def advance(simulation: Simulation, k: int, last: dict[str, State], clock: Clock) -> Snapshot:
    """The simulation at its time number `k`, from the states at the time before (none at 0)."""
    time = float(simulation.times[k])
    with clock("motion"):
        poses, points = place(simulation, time)
    states: dict[str, State] = {}
    walls: dict[str, float] = {}
    for part in simulation.contacts:
        start = perf_counter()
        p_W, X_WB = points[part.slave], poses[part.master]
        if k == 0:
            states[part.name] = part.contact.start(p_W, X_WB, clock=clock)
        else:
            dt = time - float(simulation.times[k - 1])
            states[part.name] = part.contact.step(last[part.name], p_W, X_WB, dt, clock=clock)
        walls[part.name] = perf_counter() - start
    return Snapshot(time, poses, points, states, walls)


def history_row(simulation: Simulation, snapshot: Snapshot) -> dict[str, float]:
    """One row of the history; columns carry the contact's name where there are several."""
    row: dict[str, float] = {"time": snapshot.time}
    for part in simulation.contacts:
        state = snapshot.states[part.name]
        prefix = "" if len(simulation.contacts) == 1 else f"{part.name}."
        force, moment_about = state.total_force, state.wrench[3:]
        centre = state.centre_of_pressure
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
            "area": state.total_area,
            "n_clusters": state.n_clusters,
            "mean_pressure": state.mean_pressure,
            "max_pressure": state.max_pressure,
            "centre_x": centre[0],
            "centre_y": centre[1],
            "centre_z": centre[2],
            "wall_time": snapshot.walls[part.name],
        }
        counts = np.bincount(state.status, minlength=len(ContactStatus))
        columns |= {name: int(counts[status]) for name, status in COUNTED.items()}
        columns["n_unproved"] = state.n_unproved
        row |= {prefix + name: value for name, value in columns.items()}
    return row
