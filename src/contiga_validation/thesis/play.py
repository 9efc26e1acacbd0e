"""Scenes run step by step with the state of every step kept, which experiments look into."""

from __future__ import annotations

from typing import NamedTuple

from contiga import Simulation, State, SystemState, load_case
from contiga.case.build import build
from contiga.geometry.faces import Faces
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga_validation.thesis.scenes import scene


class Played(NamedTuple):
    """A scene with one contact, and all its steps."""

    simulation: Simulation
    snapshots: tuple[SystemState, ...]
    history: dict[str, FloatArray]
    """Columns by name, one row a step."""

    @property
    def states(self) -> list[State]:
        """One a step."""
        (contact,) = self.simulation.contacts
        return [snapshot.contacts[contact.name] for snapshot in self.snapshots]

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
        return self.snapshots[k].slaves[contact.slave].points


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
    result = simulation.run(keep=1)
    return Played(simulation, result.states, result.history)
