"""Movers of the nodes of a slave: a motion, a body, or the forces on them, with one base.

Here are those of nodes that are no elements: driven by a motion, carried by a body, or each a free
mass; `deforming_nodes` has those of elements.

A step is a velocity Verlet's: `drift` takes the nodes to its end and foresees their velocities
there, the contacts answer with forces, `kick` ends it with those.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import row_products
from contiga.dynamics.prescribed import Moved, SlaveMotion, pose_at
from contiga.errors import InputError
from contiga.matter.element_fields import Inside
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_world

Arrays = Mapping[str, FloatArray]
NO_ARRAYS: Arrays = MappingProxyType({})


_INSTANTS = 64
"""Number of samples of a motion that is not a rigid one: for more, a series of large files would
have to be read again."""


class Pushes(NamedTuple):
    """Forces of contacts on the nodes that they act on."""

    rows: IndexArray
    """(k,) nodes, ascending."""
    forces: FloatArray
    """(k, 3)."""


class Forces(Protocol):
    """Forces of contacts on the nodes of a slave, summed on demand."""

    def __call__(self) -> FloatArray:
        """Return the forces (n, 3) on all nodes."""

    def listed(self) -> Pushes:
        """Return the forces on the nodes that contacts act on."""

    def on_degrees(self) -> FloatArray | None:
        """Return the forces (m, 3) on degrees of freedom that are not nodes; None without such."""


class SlaveState(NamedTuple):
    """A slave at one time."""

    points: FloatArray
    """(n, 3) world axes."""
    velocities: FloatArray
    """(n, 3) world axes."""

    @property
    def matter(self) -> Arrays:
        """Arrays of a deforming slave by name; empty for others."""
        return NO_ARRAYS


class ElementState(SlaveState):
    """A slave that deforms at one time; a pair of points and velocities like any other."""

    _matter: Arrays

    @classmethod
    def of(cls, points: FloatArray, velocities: FloatArray, matter: Arrays) -> ElementState:
        """Return a state with the arrays of a deforming slave."""
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
    """Distance of nodes from equilibrium, in sums of forces."""

    force: float = 0.0
    """Σ|f| of the forces on nodes that may move."""
    load: float = 0.0
    """Σ|p| of the loads among it."""
    reaction: float = 0.0
    """Σ|f| of the forces of elements on nodes that are held."""
    rounding: float = 0.0
    """Part of the force that may be rounding."""


class Pull(NamedTuple):
    """Forces that nodes attached to a body hand on to it."""

    host: int
    """Number of the body."""
    points: FloatArray
    """(k, 3) world axes."""
    forces: FloatArray
    """(k, 3)."""


class JointSprings(NamedTuple):
    """Stiffness by which elements hold nodes that are attached to a body."""

    host: int
    points: FloatArray
    """(k, 3) world axes."""
    stiffness: FloatArray
    """(k,) force over length, at most: see `Matter.stiffness`."""


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
        """Write points and velocities (n, 3) of the nodes as the body carries them."""
        there = to_world(now.poses[self.host], self.points_B)
        points[self.rows], velocities[self.rows] = there, velocities_on(now, self.host, there)


class NodeMover:
    """Base of the movers of a slave's nodes; its answers are those of a mover without forces."""

    host: int | None = None
    """Number of the body that they are fixed to, and that feels their forces."""
    mass: FloatArray | None = None
    """(n,) of nodes that forces move, else None."""
    joined: ClassVar[bool] = False
    """True if they are parts of a whole, whose vibrations steps do not follow one by one."""
    has_sections: ClassVar[bool] = False
    """True if the forces of elements at nodes on one side of a plane make the force through it."""
    bare: NDArray[np.bool_] = np.zeros(0, np.bool_)
    """(n,) nodes of what is joined that are in no element, and stay."""
    stands: bool = False
    """True if nothing moves them before they are touched."""
    joints: tuple[Joint, ...] = ()
    """Nodes of a deforming slave that are attached to bodies."""

    @property
    def flight(self) -> FloatArray | None:
        """Velocity (3,) or (n, 3) at the start of nodes that keep it until they touch something."""
        return None

    def start(self, now: Instant) -> SlaveState:
        """Return the nodes at the start."""
        raise NotImplementedError

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Return the nodes after the drift of a step from `last`, in which `forces` acted."""
        raise NotImplementedError

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """Return the end of the step of `drift`, with the forces there; here as it was foreseen."""
        return drifted

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """Return the state with the final velocities of bodies at nodes that are fixed to them."""
        return state

    def energy(self, state: SlaveState) -> Stored:
        """Return their energies in the ledger; none for nodes that something else moves."""
        return Stored()

    def pulls(self, state: SlaveState, forces: Forces) -> Sequence[Pull]:
        """Return the forces on bodies from nodes that are attached to them.

        They are `forces` of contacts, and those of elements and loads.
        """
        return ()

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """Return the stiffness by which elements hold nodes that are attached to bodies."""
        return ()

    def fastest(self, rows: IndexArray, stiffness: FloatArray) -> float:
        """Return an upper bound of ω² of springs of stiffness (k,) at nodes (k,).

        Their other ends are held. For dashpots it is the decay rate.
        """
        assert self.mass is not None
        mass = self.mass if len(rows) == len(self.mass) else self.mass[rows]
        return float((stiffness / mass).max(initial=0.0))

    def swing(self, forces: FloatArray) -> float:
        """Return Σ f²/m of forces (n, 3) on the nodes.

        It bounds ω² of a spring that pulls all by these shares.
        """
        assert self.mass is not None
        return float((row_products(forces, forces) / self.mass).sum())

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """Return Σ F²/(8 m) of nodes whose kinetic energy is that between steps.

        By this, times the square of the step before, it is below that of their velocities.
        """
        return 0.0

    def inside(self, state: SlaveState) -> Sequence[Inside]:
        """Return the fields of its elements, rows of its nodes; none without elements."""
        return ()

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """Return ω² and decay rate γ of their fastest vibration without contacts."""
        return 0.0, 0.0

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Return the work of gravity on them in a step."""
        return 0.0

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Return the work of driving motions in a step, against the forces before and after it."""
        return 0.0

    def stopped(self, state: SlaveState) -> SlaveState:
        """Return the state without velocities, if forces move the nodes."""
        return state

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """Return the nodes at the start of a run that begins at their state of rest."""
        return self.start(now)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """Return their distance from equilibrium; none if something else moves them."""
        return Imbalance()

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """Return the state with a share of the velocities turned along the forces."""
        return state

    def shaken(self, state: SlaveState) -> float:
        """Return the kinetic energy of nodes that forces move, by the velocities of a state."""
        return self.energy(state).kinetic

    def kinetic_between(self, last: SlaveState, now: SlaveState, dt: float) -> float:
        """Return the kinetic energy of nodes that forces move, by their way between two states."""
        return self.shaken(SlaveState(now.points, (now.points - last.points) / dt))

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Add everything that decides their way."""
        raise NotImplementedError


def velocities_on(now: Instant, host: int, points: FloatArray) -> FloatArray:
    """Return the velocities (k, 3) of points (k, 3) that are fixed to a body."""
    twist, origin = now.twists[host], now.poses[host, :3, 3]
    return np.asarray(twist[:3] + np.cross(twist[3:], points - origin))


def work_of_weight(mass: FloatArray, way: FloatArray, gravity: FloatArray) -> float:
    """Return the work of the weight of nodes of masses (n,) along ways (n, 3)."""
    return float((mass * row_products(way, gravity)).sum()) if gravity.any() else 0.0


@dataclass(frozen=True, eq=False)
class DrivenNodes(NodeMover):
    """Nodes that go where a motion says, whatever the forces on them."""

    where: str
    motion: SlaveMotion
    shape: tuple[int, ...]
    """That its rows must have."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: by the motion, checked, as it may be a user's."""
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
        """See `NodeMover`: by the motion."""
        return self.start(now)

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Return the work of the motion against the mean of the forces."""
        way = now.points - last.points
        if not way.any():
            return 0.0
        both = before() + forces()
        return -0.5 * float(np.where(np.isfinite(way), both * way, 0.0).sum())

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: by the motion."""
        _digest_motion(digest, self.motion, times)


def _digest_motion(digest: Any, motion: SlaveMotion, times: FloatArray) -> None:
    if isinstance(motion, Moved):
        digest.arrays("carried", *(pose_at(motion.motion, float(t)) for t in times))
        if isinstance(motion.base, np.ndarray):
            digest.arrays("rest", motion.base)
        else:
            _digest_motion(digest, motion.base, times)
        return
    some = np.unique(np.linspace(0, len(times) - 1, min(_INSTANTS, len(times))).round())
    for k in some.astype(int):
        digest.arrays("points", motion.points(float(times[k])))


@dataclass(frozen=True, eq=False)
class CarriedNodes(NodeMover):
    """Nodes that are fixed to a body, which feels their forces."""

    host: int = field()  # of others it is None, of the class
    points_B: FloatArray
    """(n, 3) in the axes of the body."""
    motion: object
    """What was given, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        points = to_world(now.poses[self.host], self.points_B)
        return SlaveState(points, velocities_on(now, self.host, points))

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        return self.start(now)

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        return SlaveState(state.points, velocities_on(now, self.host, state.points))

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: by the body."""
        digest.thing(self.motion)


@dataclass(frozen=True, eq=False)
class FreeNodes(NodeMover):
    """Nodes that are each a free mass."""

    mass: FloatArray = field()  # of others it is None, of the class
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(3,) or (n, 3) at the start."""
    motion: object
    """What was given, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: at rest, with the velocity of the start."""
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
        """See `NodeMover`."""
        return self.velocity

    def _acceleration(self, forces: Forces, gravity: FloatArray) -> FloatArray:
        return forces() / self.mass[:, None] + gravity

    def energy(self, state: SlaveState) -> Stored:
        """Return the kinetic energy."""
        v = state.velocities
        return Stored(0.5 * float((self.mass * row_products(v, v)).sum()))

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        return work_of_weight(self.mass, now.points - last.points, gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Add the motion; the masses are its own or the slave's."""
        digest.thing(self.motion)
