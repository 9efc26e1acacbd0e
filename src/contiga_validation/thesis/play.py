"""Scenes run step by step with the state of every step kept, which experiments look into."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga import State, load_case
from contiga.case.build import build
from contiga.geometry.faces import Faces
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.simulation import Simulation
from contiga.simulation.step import Snapshot, advance, history_row
from contiga_validation.thesis.scenes import scene


class Played(NamedTuple):
    """A scene with one contact, and all its steps."""

    simulation: Simulation
    snapshots: tuple[Snapshot, ...]
    history: dict[str, FloatArray]
    """Columns by name, one row a step."""

    @property
    def states(self) -> list[State]:
        """One a step."""
        (contact,) = self.simulation.contacts
        return [snapshot.states[contact.name] for snapshot in self.snapshots]

    @property
    def body(self) -> Master:
        """The master, in its own axes."""
        (part,) = self.simulation.bodies.values()
        return part.body

    @property
    def faces(self) -> Faces:
        """The master's exact geometry."""
        return exact_master(self.simulation)

    def points(self, k: int) -> FloatArray:
        """(n, 3) slave points after step `k`, world axes."""
        (contact,) = self.simulation.contacts
        return self.snapshots[k].points[contact.slave]


def exact_master(simulation: Simulation) -> Faces:
    """The geometry of the one master of a scene, which has patches."""
    (part,) = simulation.bodies.values()
    faces = part.body.faces
    assert faces is not None
    return faces


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
    snapshots: list[Snapshot] = []
    states: dict[str, State] = {}
    for k in range(len(simulation.times)):
        snapshots.append(advance(simulation, k, states, Clock()))
        states = snapshots[-1].states
    rows = [history_row(simulation, snapshot) for snapshot in snapshots]
    history = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return Played(simulation, tuple(snapshots), history)
