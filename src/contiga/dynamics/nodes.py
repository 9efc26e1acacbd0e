"""Movers of the nodes of a slave, with one base: a motion, a body, or the forces on the nodes.

This file has the movers of nodes without elements: driven by a motion, carried by a body, or each
a free mass. `deforming_nodes` moves nodes of elements.

A step is one of velocity Verlet: `drift` takes the nodes to its end and predicts their velocities
there, the contacts compute their forces, and `kick` ends the step with them.
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
from contiga.matter.element_fields import KindFields
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_world

Arrays = Mapping[str, FloatArray]
NO_ARRAYS: Arrays = MappingProxyType({})


_MAX_SAMPLES = 64
"""Samples of a motion of points in a digest: each may read a large file of a series again."""


class ListedForces(NamedTuple):
    """Contact forces, of the nodes that they act on only."""

    rows: IndexArray
    """(k,) nodes, ascending."""
    forces: FloatArray
    """(k, 3)."""


class Forces(Protocol):
    """Forces of contacts on the nodes of a slave, summed on demand."""

    def __call__(self) -> FloatArray:
        """Return the forces (n, 3) on all nodes."""

    def listed(self) -> ListedForces:
        """Return the forces on the nodes that contacts act on."""

    def on_dofs(self) -> FloatArray | None:
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
    """The end of a step: its time, gravity, and the bodies there."""

    time: float
    dt: float
    """Length of the step; 0 at the start."""
    gravity: FloatArray
    """(3,)."""
    poses: FloatArray
    """(b, 4, 4) X_WB of the bodies."""
    twists: FloatArray
    """(b, 6) velocity of their origins and spin, world axes; predicted for free bodies."""


class NodeEnergies(NamedTuple):
    """Energies of the nodes of a slave at one time, and their losses since the start."""

    kinetic: float = 0.0
    strain: float = 0.0
    hourglass: float = 0.0
    """Energy stored in hourglass springs."""
    viscosity: float = 0.0
    """The first of the losses."""
    hysteresis: float = 0.0
    damping: float = 0.0


class Imbalance(NamedTuple):
    """Distance of nodes from equilibrium, in sums of forces."""

    force: float = 0.0
    """Σ|f| of the forces on nodes that may move."""
    load: float = 0.0
    """Σ|p| of the loads in it."""
    reaction: float = 0.0
    """Σ|f| of the forces of elements on nodes that are held."""
    rounding: float = 0.0
    """Part of the force that may be rounding."""


class BodyForces(NamedTuple):
    """Forces that nodes attached to a body exert on it."""

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
    """Nodes that are fixed to a body; it carries their mass, and the forces on them act on it."""

    host: int
    """Number of the body."""
    rows: NDArray[np.intp]
    """(k,) nodes."""
    points_B: FloatArray
    """(k, 3) in the axes of the body."""
    mass: FloatArray
    """(k,)."""

    def place(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Write points and velocities (n, 3) of the nodes as the body moves them."""
        points_W = to_world(now.poses[self.host], self.points_B)
        points[self.rows] = points_W
        velocities[self.rows] = velocities_on(now, self.host, points_W)


class NodeMover:
    """Base of the movers of a slave's nodes, with the methods of nodes that forces do not move."""

    host: int | None = None
    """Number of the body that the nodes are fixed to, and that their forces act on."""
    mass: FloatArray | None = None
    """(n,) masses if forces move the nodes, else None."""
    has_elements: ClassVar[bool] = False
    """True if elements connect the nodes: steps need not resolve their fastest vibrations."""
    has_sections: ClassVar[bool] = False
    """True if the element forces at nodes on one side of a plane add up to its section force."""
    bare: NDArray[np.bool_] = np.zeros(0, np.bool_)
    """(n,) nodes that are in no element though others are; they do not move."""
    is_at_rest: bool = False
    """True if nothing moves the nodes before a contact."""
    joints: tuple[Joint, ...] = ()
    """Nodes of a deforming slave that are attached to bodies."""

    @property
    def flight(self) -> FloatArray | None:
        """Velocity (3,) or (n, 3) at the start, if it is constant until the first contact."""
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
        """Return the end of the step of `drift`, with the forces there; here the predicted one."""
        return drifted

    def with_carried_nodes(self, state: SlaveState, now: Instant) -> SlaveState:
        """Return the state in which nodes fixed to bodies move as these do at the end of the step.

        Here, without such nodes, it is `state` itself.
        """
        return state

    def energy(self, state: SlaveState) -> NodeEnergies:
        """Return the energies of the nodes for the ledger; zeros if forces do not move them."""
        return NodeEnergies()

    def forces_on_bodies(self, state: SlaveState, forces: Forces) -> Sequence[BodyForces]:
        """Return the forces that nodes attached to bodies exert on them.

        They include contact `forces`, element forces and loads.
        """
        return ()

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """Return the stiffness by which elements hold nodes that are attached to bodies."""
        return ()

    def square_bound(self, rows: IndexArray, stiffness: FloatArray) -> float:
        """Return an upper bound of ω² of springs (k,) from nodes (k,) to fixed points.

        For dashpots it bounds the decay rate. `rows` are different nodes; as many as there are
        nodes must be all of them, in order.
        """
        assert self.mass is not None
        mass = self.mass if len(rows) == len(self.mass) else self.mass[rows]
        return float((stiffness / mass).max(initial=0.0))

    def force_square_over_mass(self, forces: FloatArray) -> float:
        """Return Σ f²/m of forces (n, 3) on the nodes.

        It bounds ω² of a spring that distributes its force in these shares.
        """
        assert self.mass is not None
        return float((row_products(forces, forces) / self.mass).sum())

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """Return Σ F²/(8 m) if the kinetic energy is the leapfrog's, from mid-step velocities.

        That energy is lower than ½ Σ m v² by this times the square of the last step.
        """
        return 0.0

    def inside(self, state: SlaveState) -> Sequence[KindFields]:
        """Return the fields in the elements, which are rows of nodes; none without elements."""
        return ()

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """Return an upper bound of ω² without contacts, and the decay rate γ; zeros here."""
        return 0.0, 0.0

    def gravity_work(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Return the work of gravity on the nodes in a step; 0 if forces do not move them."""
        return 0.0

    def motion_work(
        self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces
    ) -> float:
        """Return the work of motions and loads in a step, from the contact forces at both ends."""
        return 0.0

    def without_velocities(self, state: SlaveState) -> SlaveState:
        """Return the state without velocities, if forces move the nodes."""
        return state

    def restarted(self, rest: SlaveState, now: Instant) -> SlaveState:
        """Return the nodes at the start of a run from `rest`, their state of equilibrium.

        Nodes without elements start where their motion says, whatever `rest` is.
        """
        return self.start(now)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """Return the distance of the nodes from equilibrium; zeros if forces do not move them."""
        return Imbalance()

    def with_mixed_velocities(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """Return the state with a share of the velocities turned towards the accelerations (FIRE).

        That share has the kinetic energy of all velocities. Only deforming nodes are changed; also
        they are not without velocities or without forces.
        """
        return state

    def velocity_energy(self, state: SlaveState) -> float:
        """Return ½ Σ m v² of the nodes that forces move, by the velocities of a state."""
        return self.energy(state).kinetic

    def kinetic_between(self, last: SlaveState, now: SlaveState, dt: float) -> float:
        """Return ½ Σ m v² of the nodes that forces move, with the mean velocity of a step."""
        return self.velocity_energy(SlaveState(now.points, (now.points - last.points) / dt))

    def digest(self, digest: Any, times: FloatArray) -> None:
        """Add everything that decides the motion of the nodes at `times` (t,) to `digest`."""
        raise NotImplementedError


def velocities_on(now: Instant, host: int, points: FloatArray) -> FloatArray:
    """Return the velocities (k, 3) of points (k, 3) that are fixed to a body, world axes."""
    twist, origin = now.twists[host], now.poses[host, :3, 3]
    return np.asarray(twist[:3] + np.cross(twist[3:], points - origin))


def work_of_weight(mass: FloatArray, displacement: FloatArray, gravity: FloatArray) -> float:
    """Return the work of gravity on nodes of masses (n,) over displacements (n, 3)."""
    return float((mass * row_products(displacement, gravity)).sum()) if gravity.any() else 0.0


@dataclass(frozen=True, eq=False)
class DrivenNodes(NodeMover):
    """Nodes that follow a motion, whatever the forces on them."""

    where: str
    motion: SlaveMotion
    shape: tuple[int, ...]
    """Shape that the arrays of the motion must have."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: by the motion; an `InputError` is raised for rows of another shape."""
        state = SlaveState(self.motion.points(now.time), self.motion.velocities(now.time))
        for method, rows in zip(state._fields, state, strict=True):
            if np.shape(rows) != self.shape:
                raise InputError(
                    f"{method}(t) must have one row a slave point",
                    where=f"{self.where} at t = {now.time:g}",
                    found=np.shape(rows),
                    allowed=str(self.shape),
                )
        return state

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`: by the motion."""
        return self.start(now)

    def motion_work(
        self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces
    ) -> float:
        """See `NodeMover`: the work against the mean of the forces.

        Displacements that are not finite do not count.
        """
        displacement = now.points - last.points
        if not displacement.any():
            return 0.0
        work = (before() + forces()) * displacement
        return -0.5 * float(np.where(np.isfinite(displacement), work, 0.0).sum())

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: by the motion."""
        _digest_motion(digest, self.motion, times)


def _digest_motion(digest: Any, motion: SlaveMotion, times: FloatArray) -> None:
    """Add the poses of a moved motion at all times, and its base; else samples of the points.

    There are up to `_MAX_SAMPLES` samples, at evenly spaced rows of `times`, with both ends.
    """
    if isinstance(motion, Moved):
        digest.arrays("carried", *(pose_at(motion.motion, float(t)) for t in times))
        if isinstance(motion.base, np.ndarray):
            digest.arrays("rest", motion.base)
        else:
            _digest_motion(digest, motion.base, times)
        return
    samples = np.unique(np.linspace(0, len(times) - 1, min(_MAX_SAMPLES, len(times))).round())
    for k in samples.astype(int):
        digest.arrays("points", motion.points(float(times[k])))


@dataclass(frozen=True, eq=False)
class CarriedNodes(NodeMover):
    """Nodes that are fixed to a body; their forces act on it."""

    host: int = field()  # overrides the class attribute of the base, None
    points_B: FloatArray
    """(n, 3) in the axes of the body."""
    motion: object
    """The motion of the slave, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        points = to_world(now.poses[self.host], self.points_B)
        return SlaveState(points, velocities_on(now, self.host, points))

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        return self.start(now)

    def with_carried_nodes(self, state: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`: by the body."""
        return SlaveState(state.points, velocities_on(now, self.host, state.points))

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: by the body."""
        digest.add_value(self.motion)


@dataclass(frozen=True, eq=False)
class FreeNodes(NodeMover):
    """Nodes that are each a free mass."""

    mass: FloatArray = field()  # overrides the class attribute of the base, None
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(3,) or (n, 3) at the start."""
    motion: object
    """The motion of the slave, for the digest."""

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: at rest, with the velocity of the start."""
        return SlaveState(self.rest.copy(), np.broadcast_to(self.velocity, self.rest.shape).copy())

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`: half a kick and a drift; a second half kick predicts the velocities."""
        points, velocities = last
        kick = 0.5 * now.dt * self._acceleration(forces, now.gravity)
        return SlaveState(points + now.dt * (velocities + kick), velocities + kick + kick)

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """See `NodeMover`: the second half of the kick."""
        # The mid-step velocity is the mean of the last and the predicted one.
        half = 0.5 * (last.velocities + drifted.velocities)
        kick = 0.5 * now.dt * self._acceleration(forces, now.gravity)
        return SlaveState(drifted.points, half + kick)

    @property
    def flight(self) -> FloatArray:
        """See `NodeMover`."""
        return self.velocity

    def _acceleration(self, forces: Forces, gravity: FloatArray) -> FloatArray:
        return forces() / self.mass[:, None] + gravity

    def energy(self, state: SlaveState) -> NodeEnergies:
        """See `NodeMover`: the kinetic energy."""
        v = state.velocities
        return NodeEnergies(0.5 * float((self.mass * row_products(v, v)).sum()))

    def gravity_work(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        return work_of_weight(self.mass, now.points - last.points, gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: the motion; the slave adds its masses itself."""
        digest.add_value(self.motion)
