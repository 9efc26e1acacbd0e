"""What moves the nodes of a slave: a motion, a body, or the forces on them. One protocol for all.

A step is a velocity Verlet's: `drift` takes the nodes to its end and foresees their velocities
there, the contacts answer with forces, `kick` ends it with those.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import row_products
from contiga.dynamics.prescribed import Moved, SlaveMotion
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import to_world
from contiga.rigid.twist import Twist

Forces = Callable[[], FloatArray]
"""(n, 3) that the contacts do on the nodes; summed where it is asked for."""
Arrays = Mapping[str, FloatArray]
NO_ARRAYS: Arrays = MappingProxyType({})
# Instants a slave's motion is looked at where it is not a rigid one: a series of large files would
# have to be read again for more.
_INSTANTS = 64


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


class NodeMover(Protocol):
    """What moves the nodes of a slave."""

    @property
    def host(self) -> int | None:
        """Number of the body that they are fixed to, and that feels their forces."""

    @property
    def mass(self) -> FloatArray | None:
        """(n,) of nodes that forces move, else None."""

    @property
    def flight(self) -> FloatArray | None:
        """(3,) or (n, 3) velocity at the start of what flies on so until it touches something."""

    def start(self, now: Instant) -> SlaveState:
        """The nodes at the start."""

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Where they go in a step from `last`, in which `forces` acted."""

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The end of the step of `drift`, with the forces that act there."""

    def energy(self, state: SlaveState) -> Stored:
        """What is in them."""

    @property
    def joined(self) -> bool:
        """Whether they are parts of a whole, whose vibrations steps do not follow one by one."""

    @property
    def bare(self) -> NDArray[np.bool_]:
        """(n,) nodes of what is joined that are in no element, and stay."""

    def stress(self, state: SlaveState) -> FloatArray | None:
        """(n, 6) at the nodes of elements, NaN at others; None of what has none."""

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """ω² and decay rate γ of what is fastest in them, beside their contacts."""

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Work of gravity on them in a step."""

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Work of what drives them in a step, against the forces before and after it."""

    def stopped(self, state: SlaveState) -> SlaveState:
        """The same without velocities, where forces move them."""

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """The nodes at the start of a run that begins from where they rest."""

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """How far they are from rest."""

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """The same with a share of the velocities turned to where the forces pull."""

    def shaken(self, state: SlaveState) -> float:
        """Kinetic energy of what forces move, by the velocities of a state."""

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Adds all that decides their way."""


class _Unmoved:
    """What most movers have nothing of."""

    joined: ClassVar[bool] = False
    bare: ClassVar[NDArray[np.bool_]] = np.zeros(0, np.bool_)

    def stopped(self, state: SlaveState) -> SlaveState:
        """As they are."""
        return state

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """As they start."""
        return self.start(now)

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        raise NotImplementedError

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """None: something else moves them."""
        return Imbalance()

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """As they are."""
        return state

    def stress(self, state: SlaveState) -> FloatArray | None:
        """None."""
        return None

    def shaken(self, state: SlaveState) -> float:
        """As the ledger has it."""
        return self.energy(state).kinetic

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """None."""
        return 0.0, 0.0

    @property
    def flight(self) -> FloatArray | None:
        """None."""
        return None

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """As it was foreseen."""
        return drifted

    def energy(self, state: SlaveState) -> Stored:
        """None that the ledger counts: what moves them has it."""
        return Stored()

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """None."""
        return 0.0

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """None."""
        return 0.0


@dataclass(frozen=True, eq=False)
class DrivenNodes(_Unmoved):
    """Nodes that go where a motion says, whatever the forces on them."""

    host: ClassVar[None] = None
    mass: ClassVar[None] = None
    where: str
    motion: SlaveMotion
    shape: tuple[int, ...]
    """That its rows must have."""

    def start(self, now: Instant) -> SlaveState:
        """As the motion says, checked: it may be a user's."""
        state = SlaveState(self.motion.points(now.time), self.motion.velocities(now.time))
        for what, rows in zip(state._fields, state, strict=True):
            if np.shape(rows) != self.shape:
                raise InputError(
                    f"{what}(t) must have one row a slave point",
                    where=f"{self.where} at t = {now.time:g}",
                    found=np.shape(rows),
                    allowed=str(self.shape),
                )
        return state

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """As the motion says."""
        return self.start(now)

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Against the mean of the forces."""
        way = now.points - last.points
        if not way.any():
            return 0.0
        both = before() + forces()
        return -0.5 * float(np.where(np.isfinite(way), both * way, 0.0).sum())

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Where they go."""
        _digest_motion(digest, self.motion, times)


def _digest_motion(digest: Any, motion: SlaveMotion, times: FloatArray) -> None:
    if isinstance(motion, Moved):
        digest.arrays("carried", *(motion.motion.pose(float(t)) for t in times))
        if isinstance(motion.base, np.ndarray):
            digest.arrays("rest", motion.base)
        else:
            _digest_motion(digest, motion.base, times)
        return
    some = np.unique(np.linspace(0, len(times) - 1, min(_INSTANTS, len(times))).round())
    for k in some.astype(int):
        digest.arrays("points", motion.points(float(times[k])))


@dataclass(frozen=True, eq=False)
class CarriedNodes(_Unmoved):
    """Nodes that are fixed to a body, which feels their forces."""

    mass: ClassVar[None] = None
    host: int
    points_B: FloatArray
    """(n, 3) in the axes of the body."""
    motion: object
    """What was given, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """Where the body has them."""
        pose, twist = now.poses[self.host], now.twists[self.host]
        points = to_world(pose, self.points_B)
        return SlaveState(points, Twist(twist[:3], twist[3:]).at(pose[:3, 3], points))

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Where the body has them."""
        return self.start(now)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """What they are fixed to."""
        digest.thing(self.motion)


@dataclass(frozen=True, eq=False)
class FreeNodes(_Unmoved):
    """Nodes that are each a free mass."""

    host: ClassVar[None] = None
    mass: FloatArray
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(3,) or (n, 3) at the start."""
    motion: object
    """What was given, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """At rest, and how they set off."""
        return SlaveState(self.rest.copy(), np.broadcast_to(self.velocity, self.rest.shape).copy())

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Half a kick, a drift, and the velocity that half a kick more gives."""
        points, velocities = last
        kick = 0.5 * now.dt * self._acceleration(forces, now.gravity)
        return SlaveState(points + now.dt * (velocities + kick), velocities + kick + kick)

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The other half."""
        # What was foreseen lies as far beyond the middle of the step as the last ones before it.
        half = 0.5 * (last.velocities + drifted.velocities)
        kick = 0.5 * now.dt * self._acceleration(forces, now.gravity)
        return SlaveState(drifted.points, half + kick)

    @property
    def flight(self) -> FloatArray:
        """As they set off."""
        return self.velocity

    def _acceleration(self, forces: Forces, gravity: FloatArray) -> FloatArray:
        return forces() / self.mass[:, None] + gravity

    def energy(self, state: SlaveState) -> Stored:
        """Kinetic."""
        return Stored(kinetic_energy(self.mass, state.velocities))

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Their weight along their way."""
        return work_of_weight(self.mass, now.points - last.points, gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """How they start; masses are the slave's, or in what was given."""
        digest.thing(self.motion)


def kinetic_energy(mass: FloatArray, v: FloatArray) -> float:
    """Of nodes of masses (n,) and velocities (n, 3)."""
    return 0.5 * float((mass * row_products(v, v)).sum())


def work_of_weight(mass: FloatArray, way: FloatArray, gravity: FloatArray) -> float:
    """Of nodes of masses (n,) that have gone ways (n, 3)."""
    return float((mass * row_products(way, gravity)).sum()) if gravity.any() else 0.0
