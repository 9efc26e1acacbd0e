"""Runs of scenes that keep the state of every step for the experiments."""

from __future__ import annotations

from typing import NamedTuple

from contiga import Master, NurbsSurface, Simulation, State, SystemState
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.thesis.variants import simulation_of


class SceneRun(NamedTuple):
    """A scene with one contact, and all its steps."""

    simulation: Simulation
    snapshots: tuple[SystemState, ...]
    history: dict[str, FloatArray]
    """Columns by name, one row a step."""

    @property
    def states(self) -> list[State]:
        """State of the contact after each step."""
        (contact,) = self.simulation.contacts
        return [snapshot.contacts[contact.name] for snapshot in self.snapshots]

    @property
    def places(self) -> list[FloatArray]:
        """Slave points (n, 3) after each step, world axes."""
        (contact,) = self.simulation.contacts
        return [snapshot.slaves[contact.slave].points for snapshot in self.snapshots]

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
    """Return the exact geometry of the one master of a scene."""
    (part,) = simulation.bodies.values()
    assert part.body.faces is not None
    return part.body.faces.patches


def run_scene(name: str) -> SceneRun:
    """Run the scene `name` (a case file with one contact) in memory.

    Raises
    ------
    FileError
        There is no such scene.
    """
    return run_simulation(simulation_of(name))


def run_simulation(simulation: Simulation) -> SceneRun:
    """Run a simulation in memory and keep the state of every step."""
    result = simulation.run(keep=1)
    return SceneRun(simulation, result.states, result.history)
