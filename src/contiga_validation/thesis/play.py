"""Scenes run step by step with the state of every step kept, which experiments look into."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot
from typing import NamedTuple

import numpy as np

from contiga import Master, NurbsSurface, Simulation, State, build, load_case
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.thesis.scenes import scene


class Played(NamedTuple):
    """A scene with one contact, and all its steps."""

    simulation: Simulation
    states: tuple[State, ...]
    """One a step."""
    places: tuple[FloatArray, ...]
    """(n, 3) slave points after each step, world axes."""

    @property
    def history(self) -> dict[str, FloatArray]:
        """What is told of each step: columns by name, one row a step."""
        columns: dict[str, list[float]] = {
            "n_contact": [state.n_contact for state in self.states],
            "n_clusters": [state.n_clusters for state in self.states],
            "max_penetration": [state.max_penetration for state in self.states],
            "force": [hypot(*state.total_force) for state in self.states],
            "area": [state.total_area for state in self.states],
        }
        return {name: np.array(values) for name, values in columns.items()}

    @property
    def body(self) -> Master:
        """The master, in its own axes."""
        (part,) = self.simulation.bodies.values()
        return part.body

    @property
    def patches(self) -> tuple[NurbsSurface, ...]:
        """The master's exact geometry."""
        return patches_of(self.simulation)


def patches_of(simulation: Simulation) -> tuple[NurbsSurface, ...]:
    """The exact geometry of the one master of a scene."""
    (part,) = simulation.bodies.values()
    assert part.body.faces is not None
    return part.body.faces.patches


def play(name: str) -> Played:
    """Run the scene `name` (a case file with one contact) in memory.

    Raises
    ------
    FileError
        No such scene.
    """
    return played(build(load_case(scene(name))))


def played(simulation: Simulation) -> Played:
    """Run a simulation with one contact in memory and keep every step."""
    states: list[State] = []
    places: list[FloatArray] = []
    for state, points in steps_of(simulation):
        states.append(state)
        places.append(points)
    return Played(simulation, tuple(states), tuple(places))


def steps_of(simulation: Simulation) -> Iterator[tuple[State, FloatArray]]:
    """The one contact of a simulation, step by step: its state, and where the slave's points are.

    A step is worked out when it is asked for.
    """
    (part,) = simulation.contacts
    body, slave = simulation.bodies[part.master].motion, simulation.slaves[part.slave].motion
    state: State | None = None
    last = 0.0
    for time in map(float, simulation.times):
        p_W, X_WB = slave.points(time), body.pose(time)
        if state is None:
            state = part.contact.start(p_W, X_WB)
        else:
            state = part.contact.step(state, p_W, X_WB, time - last)
        last = time
        yield state, p_W
