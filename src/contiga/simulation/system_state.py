"""The state of a run: where everything stands at one time, how it moves, what the contacts hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from contiga.contact.state import State
from contiga.num.twist import Twist
from contiga.records import FloatArray
from contiga.shown import Facts, Shown


class BodyState(NamedTuple):
    """A body at one time."""

    pose: FloatArray
    """(4, 4) X_WB."""
    twist: Twist
    """Velocity of the origin of its frame, and spin."""


class SlaveState(NamedTuple):
    """A slave at one time."""

    points: FloatArray
    """(n, 3) world axes."""
    velocities: FloatArray
    """(n, 3) world axes."""


class Energy(NamedTuple):
    """Where the energy of a system is, and where it went since the start."""

    contact: float
    """Stored in the contacts: what their laws and sticking friction would give back."""
    hysteresis: float = 0.0
    """Lost in laws that unload by another curve than they load."""
    damping: float = 0.0
    """Taken by the damping of laws."""
    friction: float = 0.0
    """Taken by sliding."""
    error: float = 0.0
    """Work done on the contacts that is nowhere."""


def energy_of(contacts: Mapping[str, State]) -> Energy:
    """The energies of all contacts together."""
    energies = [state.energy for state in contacts.values()]
    names = ("stored", "hysteresis", "damping", "friction", "error")
    return Energy(*(sum(float(getattr(e, name)) for e in energies) for name in names))


@dataclass(frozen=True, eq=False, repr=False)
class SystemState(Shown):
    """A simulation at one time: all that its next step needs."""

    time: float
    bodies: dict[str, BodyState]
    """By name."""
    slaves: dict[str, SlaveState]
    """By name."""
    contacts: dict[str, State]
    """By name."""
    energy: Energy

    def _facts(self) -> Facts:
        return [
            ("time", float(self.time)),
            ("bodies", len(self.bodies)),
            ("slaves", len(self.slaves)),
            ("contacts", len(self.contacts)),
            ("in contact", self.n_contact),
            ("stored", self.energy.contact),
        ]

    @property
    def n_contact(self) -> int:
        """Points in contact, over all contacts."""
        return sum(state.n_contact for state in self.contacts.values())
