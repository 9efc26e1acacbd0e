"""What moves the nodes of a slave: a motion, a body, or the forces on them. One base for all.

A step is a velocity Verlet's: `drift` takes the nodes to its end and foresees their velocities
there, the contacts answer with forces, `kick` ends it with those.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import row_products
from contiga.matter.element_fields import Inside
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_world
from contiga.rigid.twist import Twist

Arrays = Mapping[str, FloatArray]
NO_ARRAYS: Arrays = MappingProxyType({})


class Pushes(NamedTuple):
    """What contacts do on the nodes they act on."""

    rows: IndexArray
    """(k,) nodes, ascending."""
    forces: FloatArray
    """(k, 3)."""


class Forces(Protocol):
    """What contacts do on the nodes of a slave, summed where it is asked for."""

    def __call__(self) -> FloatArray:
        """(n, 3) of all nodes."""

    def listed(self) -> Pushes:
        """Of those they act on."""


class SlaveState(NamedTuple):
    """A slave at one time."""

    points: FloatArray
    """(n, 3) world axes."""
    velocities: FloatArray
    """(n, 3) world axes."""

    @property
    def matter(self) -> Arrays:
        """What is inside of a slave that deforms, by name; nothing in others."""
        return NO_ARRAYS


class ElementState(SlaveState):
    """A slave that deforms at one time; a pair of points and velocities like any other."""

    _matter: Arrays

    @classmethod
    def of(cls, points: FloatArray, velocities: FloatArray, matter: Arrays) -> ElementState:
        """With what is inside."""
        state = cls(points, velocities)
        state._matter = matter
        return state

    @property
    def matter(self) -> Arrays:
        """Forces, energies, the bound of the step, what materials remember."""
        return self._matter


class Instant(NamedTuple):
    """The time that a step goes to, and what is known of then."""

    time: float
    dt: float
    """Length of the step; 0 at the start."""
    gravity: FloatArray
    """(3,)."""
    poses: FloatArray
    """(b, 4, 4) X_WB of the bodies."""
    twists: FloatArray
    """(b, 6) velocity of their origins and spin, world axes; of free ones as foreseen."""


class Stored(NamedTuple):
    """Energy in the nodes of a slave, and what they lost since the start."""

    kinetic: float = 0.0
    strain: float = 0.0
    hourglass: float = 0.0
    viscosity: float = 0.0
    hysteresis: float = 0.0
    damping: float = 0.0


class Imbalance(NamedTuple):
    """How far nodes are from rest."""

    force: float = 0.0
    """Σ|f| of what acts on each node that may move."""
    load: float = 0.0
    """Σ|p| of the loads among it."""
    reaction: float = 0.0
    """Of what elements do on nodes that are held."""
    rounding: float = 0.0
    """What of the force may be rounding."""


class Joint(NamedTuple):
    """Nodes that are fixed to a body, which carries their mass and feels the forces on them."""

    host: int
    """Number of the body."""
    rows: NDArray[np.intp]
    """(k,) nodes."""
    points_B: FloatArray
    """(k, 3) in the axes of the body."""
    mass: FloatArray
    """(k,)."""

    def place(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Have points and velocities (n, 3) of the nodes as the body carries them."""
        points[self.rows], velocities[self.rows] = on_body(now, self.host, self.points_B)


class NodeMover:
    """What moves the nodes of a slave; most movers have nothing of what is answered here."""

    host: int | None = None
    """Number of the body that they are fixed to, and that feels their forces."""
    mass: FloatArray | None = None
    """(n,) of nodes that forces move, else None."""
    joined: ClassVar[bool] = False
    """Whether they are parts of a whole, whose vibrations steps do not follow one by one."""
    bare: NDArray[np.bool_] = np.zeros(0, np.bool_)
    """(n,) nodes of what is joined that are in no element, and stay."""
    joints: tuple[Joint, ...] = ()
    """Which of the nodes of what deforms are attached to bodies."""

    @property
    def flight(self) -> FloatArray | None:
        """(3,) or (n, 3) velocity at the start of what flies on so until it touches something."""
        return None

    def start(self, now: Instant) -> SlaveState:
        """The nodes at the start."""
        raise NotImplementedError

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Where they go in a step from `last`, in which `forces` acted."""
        raise NotImplementedError

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The end of the step of `drift`, with the forces that act there: as it was foreseen."""
        return drifted

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """The same, with the velocities that bodies give in the end to nodes fixed to them."""
        return state

    def energy(self, state: SlaveState) -> Stored:
        """What is in them that the ledger counts: nothing where something else moves them."""
        return Stored()

    def acting(self, state: SlaveState, forces: Forces) -> FloatArray:
        """(n, 3) on the nodes: `forces` of contacts, and those of elements and loads."""
        return forces()

    def stiffness(self, state: SlaveState) -> FloatArray:
        """(n,) that elements hold each node with at most: see `Matter.stiffness`."""
        return np.zeros(len(state.points))

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """Σ F²/(8 m) of nodes whose kinetic energy is that between steps: what it stands below
        that of their velocities, over the square of the step before."""
        return 0.0

    def inside(self, state: SlaveState) -> Sequence[Inside]:
        """What its elements tell, which are rows of its nodes; nothing of what has none."""
        return ()

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """ω² and decay rate γ of what is fastest in them, beside their contacts."""
        return 0.0, 0.0

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Work of gravity on them in a step."""
        return 0.0

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Work of what drives them in a step, against the forces before and after it."""
        return 0.0

    def stopped(self, state: SlaveState) -> SlaveState:
        """The same without velocities, where forces move them."""
        return state

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """The nodes at the start of a run that begins from where they rest."""
        return self.start(now)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """How far they are from rest; none where something else moves them."""
        return Imbalance()

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """The same with a share of the velocities turned to where the forces pull."""
        return state

    def shaken(self, state: SlaveState) -> float:
        """Kinetic energy of what forces move, by the velocities of a state."""
        return self.energy(state).kinetic

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Adds all that decides their way."""
        raise NotImplementedError


def on_body(now: Instant, host: int, points_B: FloatArray) -> SlaveState:
    """Points (k, 3) that are fixed to a body, and how it moves them."""
    pose, twist = now.poses[host], now.twists[host]
    points = to_world(pose, points_B)
    return SlaveState(points, Twist(twist[:3], twist[3:]).at(pose[:3, 3], points))


def work_of_weight(mass: FloatArray, way: FloatArray, gravity: FloatArray) -> float:
    """Of nodes of masses (n,) that have gone ways (n, 3)."""
    return float((mass * row_products(way, gravity)).sum()) if gravity.any() else 0.0
