"""Nodes x = N q of matter whose degrees of freedom q are not its nodes: splines, for one.

The control points of a spline are not on its surface. Contacts, areas, loads, fields and pictures
see nodes that are; the equations of motion are those of the degrees of freedom. Forces on nodes
come back as Nᵀ f, so that the work of both is the same.

Every row of N adds up to one and has no number below zero, as the basis of a spline has. A node is
held, driven or attached to a body where all degrees of freedom that it depends on are: these hold
other nodes beside it, too, but for nodes on the edge of a spline, which depend on its edge alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.deforming_nodes import DeformingNodes, joints_of
from contiga.dynamics.holding import Drive
from contiga.dynamics.nodal_loads import NodalForces
from contiga.dynamics.nodes import (
    ElementState,
    Forces,
    Imbalance,
    Instant,
    Joint,
    JointSprings,
    NodeMover,
    Pull,
    Pushes,
    SlaveState,
    Stored,
)
from contiga.errors import InputError
from contiga.matter.element_fields import ElementFields, Inside, Reached
from contiga.matter.protocol import Matter, MatterState
from contiga.records import FloatArray, IndexArray

MOVES = 1e-12
"""Weight in N above which a degree of freedom moves a node: less is rounding."""


def moved_by(matter: Matter, nodes: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the degrees of freedom and their ways (m, 3) that move nodes in the ways (n, 3)."""
    return np.asarray(matter.spread(nodes.astype(np.float64)) > MOVES)


def nodal_masses(matter: Matter, n: int) -> FloatArray:
    """Return the shares (n,) of nodes in the masses of degrees of freedom, by weights in N."""
    whole = matter.spread(np.ones((n, 3)))[:, 0]
    share = np.divide(matter.mass, whole, out=np.zeros(len(whole)), where=whole > MOVES)
    return np.ascontiguousarray(matter.points(np.repeat(share[:, None], 3, axis=1))[:, 0])


class Places(NamedTuple):
    """Nodes of a slave that are held, driven or attached to bodies."""

    held: NDArray[np.bool_]
    """(n, 3) ways that no force moves: held, driven or attached to bodies."""
    drives: tuple[Drive, ...]
    hosts: NDArray[np.int32]
    """(n,) body that each node is attached to, −1 none."""


def mapped(
    where: str,
    matter: Matter,
    places: Places,
    loads: Sequence[NodalForces],
    velocity: FloatArray,
    damping: float,
    motion: object,
) -> MappedNodes:
    """Return nodes x = N q, with the places and loads of nodes as those of degrees of freedom.

    Raises
    ------
    InputError
        A velocity for each node; two places that need the same degree of freedom.
    """
    if velocity.ndim == 2:
        raise InputError(
            "must be one for all points, which are not the degrees of freedom of the matter",
            where=f"{where}: velocity",
            found=velocity.shape,
            allowed="(3,)",
        )
    rest = np.ascontiguousarray(matter.start().points)
    fixed = places.held & (places.hosts < 0)[:, None]
    for drive in places.drives:
        fixed &= ~drive.ways
    taken = moved_by(matter, fixed)
    drives, hosts = [], np.full(len(rest), -1, np.int32)
    for drive in places.drives:
        ways = moved_by(matter, drive.ways)
        _take(where, ways, taken)
        rows = np.flatnonzero(ways.any(axis=1))
        drives.append(Drive(ways, rows, rest[rows], drive.motion))
    for host in np.unique(places.hosts[places.hosts >= 0]):
        ways = moved_by(matter, np.repeat((places.hosts == host)[:, None], 3, axis=1))
        _take(where, ways, taken)
        hosts[ways.any(axis=1)] = host
    mass = np.ascontiguousarray(matter.mass, np.float64)
    own = DeformingNodes(
        where,
        matter,
        np.arange(len(rest), dtype=np.intp),
        mass,
        rest,
        np.where(taken, 0.0, velocity),
        taken,
        damping,
        motion,
        tuple(SpreadLoad(matter, load) for load in loads),
        tuple(drives),
        joints_of(hosts, rest, mass),
    )
    return MappedNodes(own, nodal_masses(matter, len(places.held)))


def _take(where: str, ways: NDArray[np.bool_], taken: NDArray[np.bool_]) -> None:
    """Add ways (m, 3) of degrees of freedom to those that are taken."""
    twice = (ways & taken).any(axis=1)
    if twice.any():
        raise InputError(
            "two places need the same control points: what holds the nodes of one moves those of "
            "the other",
            where=where,
            found=f"{int(twice.sum())} control points",
            remedy="Leave more elements between the places, or name whole edges",
        )
    taken |= ways


class SpreadForces(NamedTuple):
    """Forces of contacts on nodes, as they act on degrees of freedom."""

    matter: Matter
    nodal: Forces

    def __call__(self) -> FloatArray:
        """Return the forces (m, 3) on degrees of freedom."""
        force, own = self.matter.spread(self.nodal()), self.nodal.on_degrees()
        return force if own is None else force + own

    def on_degrees(self) -> None:
        """Return None: the forces are on degrees of freedom already."""

    def listed(self) -> Pushes:
        """Return the forces on all degrees of freedom."""
        force = np.ascontiguousarray(self())
        return Pushes(np.arange(len(force), dtype=np.int32), force)


class SpreadLoad(NamedTuple):
    """A load on nodes, as it acts on degrees of freedom."""

    matter: Matter
    nodal: NodalForces

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the forces (m, 3) on degrees of freedom at (m, 3)."""
        return self.matter.spread(self.nodal.at(self.matter.points(points), time))


@dataclass(frozen=True, eq=False)
class MappedNodes(NodeMover):
    """Nodes that follow the degrees of freedom of matter."""

    joined: ClassVar[bool] = True
    own: DeformingNodes
    """What moves the degrees of freedom; its loads and places are theirs."""
    mass: FloatArray = field()  # of others it is None, of the class
    """(n,) shares of the nodes."""

    @cached_property
    def bare(self) -> NDArray[np.bool_]:  # type: ignore[override]  # of others it is of the class
        """See `NodeMover`: no node, as all follow degrees of freedom."""
        return np.zeros(len(self.mass), np.bool_)

    @property
    def matter(self) -> Matter:
        """Matter whose degrees of freedom the nodes follow."""
        return self.own.matter

    @property
    def flight(self) -> FloatArray | None:
        """See `NodeMover`: that of the degrees of freedom, if it is one for all."""
        flight = self.own.flight
        return flight[0] if flight is not None and (flight == flight[0]).all() else None

    @property
    def stands(self) -> bool:  # type: ignore[override]  # of others it is of the class
        """See `NodeMover`."""
        return self.own.stands

    @property
    def joints(self) -> tuple[Joint, ...]:  # type: ignore[override]  # of others it is of the class
        """Degrees of freedom that are attached to bodies."""
        return self.own.joints

    def _nodal(self, own: SlaveState) -> SlaveState:
        """The nodes of degrees of freedom, which are kept with what is inside."""
        inside = {**own.matter, "q": own.points, "q_velocity": own.velocities}
        points, velocities = (
            np.ascontiguousarray(self.matter.points(part)) for part in (own.points, own.velocities)
        )
        return ElementState.of(points, velocities, inside)

    def _of(self, state: SlaveState) -> SlaveState:
        """The degrees of freedom of nodes."""
        inside = dict(state.matter)
        return ElementState.of(inside.pop("q"), inside.pop("q_velocity"), inside)

    def _spread(self, forces: Forces) -> SpreadForces:
        return SpreadForces(self.matter, forces)

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.own.start(now))

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.own.taken_up(self._of(rest), now))

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.own.drift(self._of(last), self._spread(forces), now))

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """See `NodeMover`."""
        both = self._of(last), self._of(drifted)
        return self._nodal(self.own.kick(*both, self._spread(forces), now))

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        if not self.joints:
            return state
        return self._nodal(self.own.carried(self._of(state), now))

    def pulls(self, state: SlaveState, forces: Forces) -> Sequence[Pull]:
        """See `NodeMover`: those of degrees of freedom."""
        return self.own.pulls(self._of(state), self._spread(forces))

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """See `NodeMover`: those of degrees of freedom."""
        return self.own.springs_to_bodies(self._of(state))

    def fastest(self, rows: IndexArray, stiffness: FloatArray) -> float:
        """See `NodeMover`: Gershgorin's bound of Nᵀ k N over the masses."""
        nodal = np.zeros((len(self.mass), 3))
        nodal[rows] = stiffness[:, None]
        return self.fastest_of_degrees(self.matter.spread(nodal)[:, 0])

    def fastest_of_degrees(self, sums: FloatArray) -> float:
        """Largest ω² of row sums (m,) of a stiffness of the degrees of freedom."""
        return float((sums / self.own.mass).max(initial=0.0))

    def swing(self, forces: FloatArray) -> float:
        """See `NodeMover`."""
        return self.own.swing(self.matter.spread(forces))

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """See `NodeMover`: that of the degrees of freedom."""
        return self.own.kick_energy(self._of(state), self._spread(forces), gravity)

    def inside(self, state: SlaveState) -> Sequence[Inside]:
        """See `NodeMover`: for matter that has `nodal_fields`, each node by itself."""
        asked = getattr(self.matter, "nodal_fields", None)
        if asked is None:
            return ()
        own = MatterState(state.matter["q"], state.matter["memory"])
        columns = np.column_stack(asked(own))
        n, wide = len(self.mass), -(-columns.shape[1] // 3) * 3
        whole = np.zeros((len(columns), wide))
        whole[:, : columns.shape[1]] = columns
        at = np.concatenate(
            [
                self.matter.points(np.ascontiguousarray(part))
                for part in np.split(whole, wide // 3, 1)
            ],
            axis=1,
        )
        fields = ElementFields(at[:, :6], at[:, 6:12], at[:, 12])
        return [Inside(np.arange(n, dtype=np.int32)[:, None], np.ones(n), fields)]

    def reached(self, state: SlaveState) -> Sequence[Reached]:
        """Return the largest strains of tables of materials since the start."""
        return self.own.reached(self._of(state))

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """See `NodeMover`."""
        return self.own.rates(state)

    def energy(self, state: SlaveState) -> Stored:
        """See `NodeMover`: kinetic energy, and the energies of matter."""
        return self.own.energy(state)

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        return self.own.by_gravity(self._of(last), self._of(now), gravity)

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """See `NodeMover`."""
        both = self._spread(before), self._spread(forces)
        return self.own.by_motion(self._of(last), self._of(now), *both)

    def stopped(self, state: SlaveState) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.own.stopped(self._of(state)))

    def shaken(self, state: SlaveState) -> float:
        """See `NodeMover`."""
        return self.own.shaken(self._of(state))

    def kinetic_between(self, last: SlaveState, now: SlaveState, dt: float) -> float:
        """Return the kinetic energy that follows from the way of the degrees of freedom."""
        return self.own.kinetic_between(self._of(last), self._of(now), dt)

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """See `NodeMover`."""
        turned = self.own.steered(self._of(state), self._spread(forces), gravity, share)
        return self._nodal(turned)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """See `NodeMover`: degrees of freedom that are not held."""
        return self.own.imbalance(self._of(state), self._spread(forces), gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`."""
        self.own.digest(digest, times)
