"""Nodes x = N q of matter whose degrees of freedom q are not its nodes, such as splines.

The control points of a spline are not on its surface. Contacts, areas, loads, fields and pictures
use nodes on the surface; the equations of motion are those of the degrees of freedom. Forces on
nodes become Nᵀ f, which does the same work.

Every row of N sums to one and has no negative entry, as for the basis of a spline. To hold or drive
a node, or to attach it to a body, all degrees of freedom that it depends on are held, driven or
attached. They move other nodes as well, except at the edge of a spline, whose nodes depend on the
control points of the edge only.
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
    BodyForces,
    ElementState,
    Forces,
    Imbalance,
    Instant,
    Joint,
    JointSprings,
    ListedForces,
    NodeEnergies,
    NodeMover,
    SlaveState,
)
from contiga.errors import InputError
from contiga.matter.element_fields import ElementFields, KindFields, LargestStrain
from contiga.matter.protocol import Matter, MatterState
from contiga.records import FloatArray, IndexArray

MIN_WEIGHT = 1e-12
"""Entry of N above which a degree of freedom moves a node: below it is rounding."""


def moved_by(matter: Matter, nodes: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask (m, 3) of degrees of freedom that move nodes of the mask (n, 3).

    Their weights in N, summed over these nodes, are above `MIN_WEIGHT`.
    """
    return np.asarray(matter.spread(nodes.astype(np.float64)) > MIN_WEIGHT)


def nodal_masses(matter: Matter, n: int) -> FloatArray:
    """Return the masses (n,) of nodes: those of degrees of freedom, shared by weights in N.

    The mass of a degree of freedom that moves no node is lost.
    """
    sums = matter.spread(np.ones((n, 3)))[:, 0]
    share = np.divide(matter.mass, sums, out=np.zeros(len(sums)), where=sums > MIN_WEIGHT)
    return np.ascontiguousarray(matter.points(np.repeat(share[:, None], 3, axis=1))[:, 0])


class Places(NamedTuple):
    """Nodes of a slave that are held, driven or attached to bodies."""

    held: NDArray[np.bool_]
    """(n, 3) degrees of freedom that no force moves: held, driven or attached to bodies."""
    drives: tuple[Drive, ...]
    """Nodes that motions drive, with rows and places of nodes."""
    hosts: NDArray[np.int32]
    """(n,) number of the body that each node is attached to, −1 for none."""


def mapped(
    where: str,
    matter: Matter,
    places: Places,
    loads: Sequence[NodalForces],
    velocity: FloatArray,
    damping: float,
    motion: object,
) -> MappedNodes:
    """Return nodes x = N q, with places and loads of the nodes transferred to q.

    All degrees of freedom that move a held, driven or attached node are held, driven or attached;
    an attached one in all three directions. `velocity` (3,) holds for all that are free.

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
        fixed &= ~drive.dofs
    held = moved_by(matter, fixed)
    drives, hosts = [], np.full(len(rest), -1, np.int32)
    for drive in places.drives:
        dofs = moved_by(matter, drive.dofs)
        _add_held(where, dofs, held)
        rows = np.flatnonzero(dofs.any(axis=1))
        drives.append(Drive(dofs, rows, rest[rows], drive.motion))
    for host in np.unique(places.hosts[places.hosts >= 0]):
        dofs = moved_by(matter, np.repeat((places.hosts == host)[:, None], 3, axis=1))
        _add_held(where, dofs, held)
        hosts[dofs.any(axis=1)] = host
    mass = np.ascontiguousarray(matter.mass, np.float64)
    dofs_mover = DeformingNodes(
        where,
        matter,
        np.arange(len(rest), dtype=np.intp),
        mass,
        rest,
        np.where(held, 0.0, velocity),
        held,
        damping,
        motion,
        tuple(SpreadLoad(matter, load) for load in loads),
        tuple(drives),
        joints_of(hosts, rest, mass),
    )
    return MappedNodes(dofs_mover, nodal_masses(matter, len(places.held)))


def _add_held(where: str, dofs: NDArray[np.bool_], held: NDArray[np.bool_]) -> None:
    """Write degrees of freedom (m, 3) into `held`.

    An `InputError` is raised if any is there already.
    """
    is_shared = (dofs & held).any(axis=1)
    if is_shared.any():
        raise InputError(
            "two places need the same control points: what holds the nodes of one moves those of "
            "the other",
            where=where,
            found=f"{int(is_shared.sum())} control points",
            remedy="Leave more elements between the places, or name whole edges",
        )
    held |= dofs


class SpreadForces(NamedTuple):
    """Forces of contacts on nodes, as they act on degrees of freedom."""

    matter: Matter
    nodal: Forces

    def __call__(self) -> FloatArray:
        """Return the forces (m, 3) on degrees of freedom, with any that act on these directly."""
        force, direct = self.matter.spread(self.nodal()), self.nodal.on_dofs()
        return force if direct is None else force + direct

    def on_dofs(self) -> None:
        """Return None: the forces are on degrees of freedom already."""

    def listed(self) -> ListedForces:
        """Return the forces on all degrees of freedom, zeros among them."""
        force = np.ascontiguousarray(self())
        return ListedForces(np.arange(len(force), dtype=np.int32), force)


class SpreadLoad(NamedTuple):
    """A load on nodes, as it acts on degrees of freedom."""

    matter: Matter
    nodal: NodalForces

    def at(self, points: FloatArray, time: float) -> FloatArray:
        """Return the forces (m, 3) on degrees of freedom with values `points` (m, 3)."""
        return self.matter.spread(self.nodal.at(self.matter.points(points), time))


@dataclass(frozen=True, eq=False)
class MappedNodes(NodeMover):
    """Nodes that follow the degrees of freedom of matter."""

    has_elements: ClassVar[bool] = True
    dofs: DeformingNodes
    """Mover of the degrees of freedom."""
    mass: FloatArray = field()  # overrides the class attribute of the base, None
    """(n,) masses of the nodes."""

    @cached_property
    def bare(self) -> NDArray[np.bool_]:  # type: ignore[override]  # a class attribute of the base
        """See `NodeMover`: no node, since all follow degrees of freedom."""
        return np.zeros(len(self.mass), np.bool_)

    @property
    def matter(self) -> Matter:
        """Matter whose degrees of freedom the nodes follow."""
        return self.dofs.matter

    @property
    def flight(self) -> FloatArray | None:
        """See `NodeMover`: the velocity of all degrees of freedom, if it is the same."""
        flight = self.dofs.flight
        return flight[0] if flight is not None and (flight == flight[0]).all() else None

    @property
    def is_at_rest(self) -> bool:  # type: ignore[override]  # a class attribute of the base
        """See `NodeMover`."""
        return self.dofs.is_at_rest

    @property
    def joints(self) -> tuple[Joint, ...]:  # type: ignore[override]  # a class attribute of the base
        """Degrees of freedom that are attached to bodies."""
        return self.dofs.joints

    def _nodal(self, dofs: SlaveState) -> SlaveState:
        """Return the state of the nodes; its arrays contain the degrees of freedom."""
        arrays = {**dofs.matter, "q": dofs.points, "q_velocity": dofs.velocities}
        points = np.ascontiguousarray(self.matter.points(dofs.points))
        velocities = np.ascontiguousarray(self.matter.points(dofs.velocities))
        return ElementState.of(points, velocities, arrays)

    def _of(self, state: SlaveState) -> SlaveState:
        """Return the state of the degrees of freedom from that of the nodes."""
        arrays = dict(state.matter)
        return ElementState.of(arrays.pop("q"), arrays.pop("q_velocity"), arrays)

    def _spread(self, forces: Forces) -> SpreadForces:
        return SpreadForces(self.matter, forces)

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.dofs.start(now))

    def restarted(self, rest: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.dofs.restarted(self._of(rest), now))

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.dofs.drift(self._of(last), self._spread(forces), now))

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """See `NodeMover`."""
        spread = self._spread(forces)
        return self._nodal(self.dofs.kick(self._of(last), self._of(drifted), spread, now))

    def with_carried_nodes(self, state: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`."""
        if not self.joints:
            return state
        return self._nodal(self.dofs.with_carried_nodes(self._of(state), now))

    def forces_on_bodies(self, state: SlaveState, forces: Forces) -> Sequence[BodyForces]:
        """See `NodeMover`: forces of degrees of freedom."""
        return self.dofs.forces_on_bodies(self._of(state), self._spread(forces))

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """See `NodeMover`: stiffness of degrees of freedom."""
        return self.dofs.springs_to_bodies(self._of(state))

    def square_bound(self, rows: IndexArray, stiffness: FloatArray) -> float:
        """See `NodeMover`: Gershgorin's bound of Nᵀ k N over the masses."""
        nodal = np.zeros((len(self.mass), 3))
        nodal[rows] = stiffness[:, None]
        return self.square_bound_of_dofs(self.matter.spread(nodal)[:, 0])

    def square_bound_of_dofs(self, sums: FloatArray) -> float:
        """Return the upper bound of ω² by row sums (m,) of a stiffness of degrees of freedom."""
        return float((sums / self.dofs.mass).max(initial=0.0))

    def force_square_over_mass(self, forces: FloatArray) -> float:
        """See `NodeMover`."""
        return self.dofs.force_square_over_mass(self.matter.spread(forces))

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """See `NodeMover`: by the degrees of freedom."""
        return self.dofs.kick_energy(self._of(state), self._spread(forces), gravity)

    def inside(self, state: SlaveState) -> Sequence[KindFields]:
        """Return the matter's `nodal_fields` at the nodes, () if it has none; see `NodeMover`.

        Each node is an element of its own, of weight 1, with the fields interpolated by N.
        """
        nodal_fields = getattr(self.matter, "nodal_fields", None)
        if nodal_fields is None:
            return ()
        dofs = MatterState(state.matter["q"], state.matter["memory"])
        columns = np.column_stack(nodal_fields(dofs))
        # `points` maps three columns at a time.
        n, n_triples = len(self.mass), -(-columns.shape[1] // 3)
        padded = np.zeros((len(columns), 3 * n_triples))
        padded[:, : columns.shape[1]] = columns
        triples = [np.ascontiguousarray(triple) for triple in np.split(padded, n_triples, axis=1)]
        nodal = np.concatenate([self.matter.points(triple) for triple in triples], axis=1)
        fields = ElementFields(nodal[:, :6], nodal[:, 6:12], nodal[:, 12])
        return [KindFields(np.arange(n, dtype=np.int32)[:, None], np.ones(n), fields)]

    def reached(self, state: SlaveState) -> Sequence[LargestStrain]:
        """See `NodeMover`: the largest strains of material tables; () if matter has none."""
        return self.dofs.reached(self._of(state))

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """See `NodeMover`."""
        return self.dofs.rates(state)

    def energy(self, state: SlaveState) -> NodeEnergies:
        """See `NodeMover`: kinetic energy, and the energies of matter."""
        return self.dofs.energy(state)

    def gravity_work(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        return self.dofs.gravity_work(self._of(last), self._of(now), gravity)

    def motion_work(
        self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces
    ) -> float:
        """See `NodeMover`."""
        spread_before, spread_after = self._spread(before), self._spread(forces)
        return self.dofs.motion_work(self._of(last), self._of(now), spread_before, spread_after)

    def without_velocities(self, state: SlaveState) -> SlaveState:
        """See `NodeMover`."""
        return self._nodal(self.dofs.without_velocities(self._of(state)))

    def velocity_energy(self, state: SlaveState) -> float:
        """See `NodeMover`."""
        return self.dofs.velocity_energy(self._of(state))

    def kinetic_between(self, last: SlaveState, now: SlaveState, dt: float) -> float:
        """See `NodeMover`: by the mean velocities of the degrees of freedom."""
        return self.dofs.kinetic_between(self._of(last), self._of(now), dt)

    def with_mixed_velocities(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """See `NodeMover`."""
        dofs = self.dofs.with_mixed_velocities(
            self._of(state), self._spread(forces), gravity, share
        )
        return self._nodal(dofs)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """See `NodeMover`: by the free degrees of freedom."""
        return self.dofs.imbalance(self._of(state), self._spread(forces), gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`."""
        self.dofs.digest(digest, times)
