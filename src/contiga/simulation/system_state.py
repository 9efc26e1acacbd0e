"""Define the state of a simulation at one time: positions, velocities, contacts and energies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.display import Displayed, Facts
from contiga.dynamics.linkage import JointStates
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.slip_rings import SlipRingState
from contiga.dynamics.springs import SpringState
from contiga.records import FloatArray
from contiga.rigid.rigid_lanes import STATE
from contiga.rigid.twist import Twist
from contiga.simulation.gas import ChamberState
from contiga.simulation.settle import Rest
from contiga.simulation.trigger import TriggerState


class BodyState(NamedTuple):
    """The state of a body at one time."""

    pose: FloatArray
    """(4, 4) X_WB."""
    twist: Twist
    """Velocity of the origin of its frame, and spin."""


class BodyStates(Mapping[str, BodyState]):
    """The states of all bodies at one time, by name.

    Parameters
    ----------
    index : row of each of the b bodies, by name
    poses : (b, 4, 4) X_WB
    twists : (b, 6) velocity of the frames' origins and spin, world axes
    """

    __slots__ = ("_index", "poses", "twists")

    def __init__(self, index: Mapping[str, int], poses: FloatArray, twists: FloatArray) -> None:
        self._index = index
        self.poses = poses
        self.twists = twists

    def __getitem__(self, name: str) -> BodyState:
        i = self._index[name]
        return BodyState(self.poses[i], Twist(self.twists[i, :3], self.twists[i, 3:]))

    def __iter__(self) -> Iterator[str]:
        return iter(self._index)

    def __len__(self) -> int:
        return len(self._index)


class Energy(NamedTuple):
    """Energies of a system, stored and lost since the start."""

    contact: float
    """Energy stored in the contacts, which their laws and sticking friction would return."""
    hysteresis: float = 0.0
    """Hysteresis loss of laws, springs, joints and materials with a separate unloading curve."""
    damping: float = 0.0
    """Loss by damping of laws, springs, joints and nodes."""
    friction: float = 0.0
    """Loss by friction of contacts, of webbing in slip rings and of joints."""
    kinetic: float = 0.0
    """Kinetic energy of free bodies and nodes."""
    strain: float = 0.0
    """Energy stored in springs, in laws of joints and in deforming slaves."""
    external: float = 0.0
    """Work done since the start by gravity, loads, pretensioners and prescribed motions, and the
    enthalpy of inflowing gas, less that of outflowing gas."""
    initial: float = 0.0
    """Kinetic and stored energy at the start."""
    hourglass: float = 0.0
    """Energy of hourglass modes: shapes of elements without strain at their points."""
    viscosity: float = 0.0
    """Loss by viscosity of elements."""
    gas: float = 0.0
    """Energy stored in gas since the start, with the work of the surroundings on it."""

    @property
    def total(self) -> float:
        """Kinetic and stored energy."""
        return self.kinetic + self.strain + self.contact + self.hourglass + self.gas

    @property
    def lost(self) -> float:
        """Energy lost since the start by friction, damping, viscosity and hysteresis."""
        return self.hysteresis + self.damping + self.friction + self.viscosity

    @property
    def error(self) -> float:
        """Error of the energy balance: initial and external, less stored and lost energy.

        It falls with the square of the step, unless forces are no gradient of an energy.
        """
        return self.initial + self.external - self.total - self.lost


class Acting(NamedTuple):
    """The forces between the parts of a model at one time, each by name."""

    contacts: dict[str, State]
    springs: dict[str, SpringState]
    gas: dict[str, ChamberState]
    rings: dict[str, SlipRingState]
    joints: JointStates | None = None
    """None without joints."""


@dataclass(frozen=True, eq=False, repr=False)
class SystemState(Displayed):
    """The state of a simulation at one time, with all that its next step needs."""

    time: float
    bodies: BodyStates
    """By name."""
    slaves: dict[str, SlaveState]
    """By name."""
    contacts: dict[str, State]
    """By name."""
    energy: Energy
    step: float = 0.0
    """Length of the step that led here; 0 at the start."""
    rigid: FloatArray = field(default_factory=lambda: np.zeros((0, STATE)))
    """(b, 19) free bodies, columns by `contiga.rigid.rigid_lanes`."""
    wrenches: FloatArray = field(default_factory=lambda: np.zeros((0, 6)))
    """(n, 6) force and moment on each body about the origin of its frame, world axes, of contacts,
    springs, joints, loads and weight, attached bodies included; no rows if forces move nothing."""
    springs: dict[str, SpringState] = field(default_factory=dict)
    """By name."""
    gas: dict[str, ChamberState] = field(default_factory=dict)
    """By name."""
    slip_rings: dict[str, SlipRingState] = field(default_factory=dict)
    """By name."""
    joints: JointStates | None = None
    """The states of all joints; None without joints."""
    triggers: dict[str, TriggerState] = field(default_factory=dict)
    """By the name of their sensor."""
    peak_energy: float = 0.0
    """The largest energy so far: kinetic, stored and lost."""
    shaking: float = 0.0
    """Recent rate of change of forces over √mass; with the next field, of automatic steps: see
    `contiga.simulation.step_size`."""
    leak: float = 0.0
    """Energy balance error per time that shorter steps would not reduce."""
    rest: Rest | None = None
    """How the simulation came to rest before the run; None if it did not."""
    place_error: float = 0.0
    """Error of depths of points that share a force, length: `contiga.simulation.step_size`."""
    speed_error: float = 0.0
    """Error of the rate of these depths, length/time."""

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
    def acting(self) -> Acting:
        """The forces between the parts of the model."""
        return Acting(self.contacts, self.springs, self.gas, self.slip_rings, self.joints)

    @property
    def n_contact(self) -> int:
        """Number of points in contact, over all contacts."""
        return sum(state.n_contact for state in self.contacts.values())
