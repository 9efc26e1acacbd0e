"""Scenes run step by step with the state of every step kept, which experiments look into."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.case.build import build
from contiga.case.schema import load_case
from contiga.contact.state import State
from contiga.geometry.body import Body
from contiga.records import FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.simulation import Simulation
from contiga.simulation.step import Moment, advance, history_row
from contiga.thesis.scenes import scene


class Played(NamedTuple):
    """A scene with one contact, and all its steps."""

    simulation: Simulation
    moments: tuple[Moment, ...]
    history: dict[str, FloatArray]
    """Columns by name, one row a step."""

    @property
    def states(self) -> list[State]:
        """One a step."""
        (contact,) = self.simulation.contacts
        return [moment.states[contact.name] for moment in self.moments]

    @property
    def body(self) -> Body:
        """The master, in its own axes."""
        return exact_master(self.simulation)

    def points(self, k: int) -> FloatArray:
        """(n, 3) slave points after step `k`, world axes."""
        (contact,) = self.simulation.contacts
        return self.moments[k].points[contact.slave]


def exact_master(simulation: Simulation) -> Body:
    """The one master of a scene, which has patches."""
    (part,) = simulation.bodies.values()
    assert isinstance(part.body, Body)
    return part.body


def play(name: str) -> Played:
    """Run the scene `name` (a case file with one contact) in memory.

    Raises
    ------
    FileError
        No such scene.
    """
    return played(build(load_case(scene(name))))


def played(simulation: Simulation) -> Played:
    """Run a simulation in memory and keep every step."""
    moments: list[Moment] = []
    states: dict[str, State] = {}
    for k in range(len(simulation.times)):
        moments.append(advance(simulation, k, states, Clock()))
        states = moments[-1].states
    rows = [history_row(simulation, moment) for moment in moments]
    history = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return Played(simulation, tuple(moments), history)
