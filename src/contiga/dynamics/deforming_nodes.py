"""Nodes of elements: moved by element forces, contacts, loads and gravity, as far as they are free.

Elements compute their forces from the places at the end of a step, and rate-dependent forces from
the mid-step velocity. The work of damping in a step is that of the mean of its forces at both ends,
as in a leapfrog.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.ordered import length, row_lengths, row_products
from contiga.arrays.threads import run_ranges
from contiga.dynamics.holding import Drive
from contiga.dynamics.kernels import nodes_nb
from contiga.dynamics.nodal_loads import NodalForces
from contiga.dynamics.nodes import (
    Arrays,
    BodyForces,
    ElementState,
    Forces,
    Imbalance,
    Instant,
    Joint,
    JointSprings,
    NodeEnergies,
    NodeMover,
    SlaveState,
    work_of_weight,
)
from contiga.errors import ElementError
from contiga.jit import straight
from contiga.matter.element_fields import KindFields, LargestStrain
from contiga.matter.mass_scaling import MARGIN, sums_near_rest
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterForces, MatterState
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray

MIN_INTERVAL, MAX_INTERVAL = 4, 50
"""Steps from one computation of the row sums of the stiffness to the next."""
SQUARE_TOL = 0.02
"""Relative change of ω² over an interval above which the next interval is halved, else doubled."""
EPS = float(np.finfo(np.float64).eps)
MIN_NODES = 16384
"""Number of nodes below which a second thread does not pay; a multiple of the nodes of a block."""
NO_FORCES, NO_ROWS = np.zeros((0, 3)), np.zeros(0, np.int32)
"""Forces of a kind that does not act, and an empty list of nodes."""


@pass_by_pointer
class Masses(NamedTuple):
    """Nodes that forces move."""

    mass: FloatArray
    """(n,)."""
    held: NDArray[np.bool_]
    """(n, 3) degrees of freedom that no force moves; (0, 3) if there are none."""
    driven: NDArray[np.bool_]
    """(n, 3) those of them that motions or bodies move; (0, 3) if there are none."""


@pass_by_pointer
class Acting(NamedTuple):
    """Forces on nodes, (n, 3) each; (0, 3) for a kind that does not act."""

    rows: IndexArray
    """(k,) nodes on which contacts act, ascending; empty if they act on all."""
    contacts: FloatArray
    """(k, 3) of contacts on these nodes."""
    everywhere: FloatArray
    """(n, 3) forces of contacts, springs and gas if they act on all nodes, else (0, 3)."""
    elements: FloatArray
    loads: FloatArray
    drag: FloatArray
    gravity: FloatArray
    """(3,) an acceleration."""


@pass_by_pointer
class Course(NamedTuple):
    """Positions and velocities of nodes."""

    points: FloatArray
    """(n, 3)."""
    velocities: FloatArray
    """(n, 3)."""


@pass_by_pointer
class Drifted(NamedTuple):
    """Nodes after the drift of a step, (n, 3) each."""

    points: FloatArray
    velocities: FloatArray
    """Velocities predicted for the end of the step, by half a kick more."""
    half: FloatArray
    """Velocities at mid-step."""


@pass_by_pointer
class Kick(NamedTuple):
    """Input of the second half of a step's kick."""

    half: FloatArray
    """(n, 3) velocities at mid-step."""
    predicted: FloatArray
    """(n, 3) velocities predicted for the end of the step; those of driven nodes are exact."""
    dt: float
    damping: float
    """α of a force −α m v, 1/time."""


@pass_by_pointer
class Kicked(NamedTuple):
    """Nodes after a `Kick`."""

    velocities: FloatArray
    """(n, 3)."""
    energy: FloatArray
    """(b,) ½ Σ m v₋·v₊ of mid-step velocities before and after, of free degrees of freedom."""


def masses_of(mass: FloatArray, held: NDArray[np.bool_], driven: NDArray[np.bool_]) -> Masses:
    """Return masses (n,) with the degrees of freedom (n, 3) that are held, and driven.

    A mask without a True becomes (0, 3), by which kernels skip it.
    """
    masks = (locked(mask if mask.any() else mask[:0]) for mask in (held, driven))
    return Masses(locked(mass), *masks)


def accelerated(masses: Masses, forces: Acting) -> FloatArray:
    """Return the accelerations (n, 3), zero where nodes are held."""
    out = np.empty(forces.elements.shape)
    run_ranges(straight(nodes_nb.accelerate), len(out), MIN_NODES, masses, forces, out)
    return out


def drift_nodes(
    masses: Masses, forces: Acting, points: FloatArray, velocities: FloatArray, dt: float
) -> Drifted:
    """Return the nodes after the first half kick and the drift of a step, as new arrays.

    `points` and `velocities` (n, 3) are those before it; `forces` act at its start. `half` are the
    velocities at mid-step, `velocities` of the result those predicted for the end of the step,
    v + dt a. Held degrees of freedom, and so driven ones, keep their velocity; the caller places
    driven nodes afterwards.
    """
    shape = points.shape
    out = Drifted(np.empty(shape), np.empty(shape), np.empty(shape))
    last = Course(points, velocities)
    run_ranges(straight(nodes_nb.drift), len(points), MIN_NODES, masses, forces, last, dt, out)
    return out


def kick_nodes(
    masses: Masses,
    forces: Acting,
    half: FloatArray,
    predicted: FloatArray,
    dt: float,
    damping: float,
) -> Kicked:
    """Return the end of a step from velocities (n, 3) at mid-step, by `forces` at its end.

    Driven degrees of freedom keep the `predicted` velocity. Damping is implicit in the velocity.
    """
    out = Kicked(np.empty(half.shape), np.empty(ceil(half.size / nodes_nb.BLOCK)))
    kick = Kick(half, predicted, dt, damping)
    run_ranges(straight(nodes_nb.kick), len(half), MIN_NODES, masses, forces, kick, out)
    return out


def kinetic(masses: Masses, velocities: FloatArray) -> float:
    """Return ½ Σ m v² of nodes with velocities (n, 3), without driven degrees of freedom."""
    out = np.empty(ceil(velocities.size / nodes_nb.BLOCK))
    run_ranges(straight(nodes_nb.kinetic), len(velocities), MIN_NODES, masses, velocities, out)
    return float(out.sum())


class _Limit(NamedTuple):
    """Upper bound of ω² of the elements, which limits the step."""

    square: float
    """ω², 1/time²."""
    countdown: float
    """Steps until it is computed again."""
    interval: float
    """Steps from one computation to the next."""


def _acting(arrays: Arrays, forces: Forces, gravity: FloatArray) -> Acting:
    """Return the forces of contacts and elements, with loads and drag if `arrays` has them.

    Contact forces are listed by node unless they act on all nodes.
    """
    loads, drag = arrays.get("load", NO_FORCES), arrays.get("drag", NO_FORCES)
    rows, pushes = forces.listed()
    everywhere = NO_FORCES
    if len(pushes) == len(arrays["force"]):
        rows, pushes, everywhere = NO_ROWS, NO_FORCES, pushes
    return Acting(rows, pushes, everywhere, arrays["force"], loads, drag, gravity)


@dataclass(frozen=True, eq=False)
class DeformingNodes(NodeMover):
    """Nodes of elements."""

    has_elements: ClassVar[bool] = True
    has_sections: ClassVar[bool] = True
    where: str
    matter: Matter
    rows: NDArray[np.intp]
    """(m,) node of each degree of freedom."""
    mass: FloatArray = field()  # overrides the class attribute of the base, None
    """(n,)."""
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(n, 3) at the start, zero for held degrees of freedom."""
    held: NDArray[np.bool_]
    """(n, 3) degrees of freedom that no force moves: held, driven or attached to bodies."""
    damping: float
    """α of a force −α m v, 1/time."""
    motion: object
    """The motion of the slave, for the digest."""
    loads: tuple[NodalForces, ...] = ()
    drives: tuple[Drive, ...] = ()
    """Nodes that motions drive."""
    joints: tuple[Joint, ...] = ()
    """Nodes that are attached to bodies."""
    parts: tuple[Part, ...] = ()
    """Elements with their materials, as rows of the nodes; empty for matter of a user's own."""

    @cached_property
    def bare(self) -> NDArray[np.bool_]:  # type: ignore[override]  # a class attribute of the base
        """Nodes (n,) that are in no element."""
        bare = np.ones(len(self.rest), np.bool_)
        bare[self.rows] = False
        return bare

    @cached_property
    def _all_nodes_are_dofs(self) -> bool:
        """True if all nodes are degrees of freedom, in the same order."""
        return len(self.rows) == len(self.rest) and bool((np.diff(self.rows) == 1).all())

    def _of_dofs(self, nodal: FloatArray) -> FloatArray:
        """Return the rows (m, 3) of degrees of freedom; the same array if they are all nodes."""
        return nodal if self._all_nodes_are_dofs else nodal[self.rows]

    def _at_nodes(self, values: FloatArray) -> FloatArray:
        """Return values (m, …) of degrees of freedom as rows (n, …) of nodes, else zeros."""
        if self._all_nodes_are_dofs:
            return values
        nodal = np.zeros((len(self.rest), *values.shape[1:]))
        nodal[self.rows] = values
        return nodal

    @property
    def flight(self) -> FloatArray | None:
        """See `NodeMover`: the velocity at the start, if nothing holds or loads the nodes."""
        return None if self.held.any() or self.loads else self.velocity

    @cached_property
    def _driven_by_motions(self) -> NDArray[np.bool_]:
        """Mask (n, 3) of degrees of freedom that motions drive."""
        return np.any([np.zeros_like(self.held), *(drive.dofs for drive in self.drives)], axis=0)

    @cached_property
    def _driven(self) -> NDArray[np.bool_]:
        """Mask (n, 3) of those that motions drive or bodies carry; not in the kinetic energy."""
        driven = self._driven_by_motions.copy()
        for joint in self.joints:
            driven[joint.rows] = True
        return driven

    @cached_property
    def _masses(self) -> Masses:
        return masses_of(self.mass, self.held, self._driven)

    @cached_property
    def _drivers(self) -> tuple[Drive | Joint, ...]:
        return (*self.drives, *self.joints)

    def _place_driven(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Write points and velocities (n, 3) of the nodes that motions drive or bodies carry."""
        for driver in self._drivers:
            driver.place(now, points, velocities)

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: undeformed, but with the forces of elements with a prestrain."""
        return self._start_from(self.matter.start(), self.rest.copy(), now)

    def restarted(self, rest: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`: with the velocities of the start, and no losses."""
        state = MatterState(self._of_dofs(rest.points), rest.matter["memory"])
        return self._start_from(state, rest.points.copy(), now)

    def _start_from(self, state: MatterState, points: FloatArray, now: Instant) -> SlaveState:
        """Return the state at the start of a run; writes the driven nodes into `points`."""
        velocities = self.velocity.copy()
        self._place_driven(now, points, velocities)
        response = self._matter_forces(state, points, velocities, now)
        arrays = {
            "force": self._at_nodes(response.force),
            **self._drag(velocities),
            **self._loads(points, now.time),
            "energy": np.array(
                [kinetic(self._masses, velocities), *response.energy[:2], 0.0, 0.0, 0.0]
            ),
            **self._bounds(response.state, MIN_INTERVAL),
            "memory": response.state.memory,
        }
        return ElementState.of(points, velocities, arrays)

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """See `NodeMover`: half a kick and a drift; a second half kick predicts the velocities.

        Mid-step velocities are "half" in the arrays of the result. If nodes are driven, these are
        placed, and every mid-step velocity is the mean of both ends.
        """
        acting = _acting(last.matter, forces, now.gravity)
        points, velocities, half = drift_nodes(self._masses, acting, *last, now.dt)
        if self._drivers:
            self._place_driven(now, points, velocities)
            half = 0.5 * (last.velocities + velocities)
        return ElementState.of(points, velocities, {**last.matter, "half": half})

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """See `NodeMover`: the element forces, and the second half of the kick.

        The losses in the energies are summed up; the bound of ω² is computed again when its
        interval has passed.
        """
        before, half = last.matter, drifted.matter["half"]
        state = MatterState(self._of_dofs(last.points), before["memory"])
        response = self._matter_forces(state, drifted.points, half, now)
        arrays = {
            "force": self._at_nodes(response.force),
            **self._loads(drifted.points, now.time),
        }
        acting = _acting(arrays, forces, now.gravity)
        velocities, kinetic_energies = kick_nodes(
            self._masses, acting, half, drifted.velocities, now.dt, self.damping
        )
        drag_work = 0.0
        if self.damping:
            arrays |= self._drag(velocities)
            drag = before["drag"] + arrays["drag"]
            drag_work = 0.5 * float((drag * (drifted.points - last.points)).sum())
        # With this kinetic energy, of mid-step velocities, a leapfrog conserves the total energy of
        # linear elements.
        energy = np.array([kinetic_energies.sum(), *response.energy, -drag_work])
        energy[3:] += before["energy"][3:]
        arrays |= {
            "energy": energy,
            **self._next_bounds(before, response.state),
            "memory": response.state.memory,
        }
        return ElementState.of(drifted.points, velocities, arrays)

    def with_carried_nodes(self, state: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`: attached nodes move with their bodies."""
        if not self.joints:
            return state
        points, velocities = (part.copy() for part in state)
        for joint in self.joints:
            joint.place(now, points, velocities)
        return ElementState.of(points, velocities, state.matter)

    def _matter_forces(
        self, state: MatterState, points: FloatArray, velocities: FloatArray, now: Instant
    ) -> MatterForces:
        """Return the forces of matter; an `ElementError` is raised again with the time in it."""
        points_of_dofs, velocities_of_dofs = self._of_dofs(points), self._of_dofs(velocities)
        try:
            response = self.matter.forces(state, points_of_dofs, velocities_of_dofs, now.dt)
        except ElementError as error:
            raise error.at(now.time) from error
        # Kernels need this layout, which matter of a user's own may not have.
        return response._replace(force=np.require(response.force, np.float64, ("C", "W")))

    def _loads(self, points: FloatArray, time: float) -> dict[str, FloatArray]:
        """Return {"load": sum (n, 3) of the forces of the loads}, {} without loads."""
        if not self.loads:
            return {}
        forces = [load.at(points, time) for load in self.loads]
        return {"load": np.asarray(sum(forces[1:], forces[0]))}

    def _drag(self, velocities: FloatArray) -> dict[str, FloatArray]:
        """Return {"drag": −α m v (n, 3)}, zero where driven nodes are held; {} without damping."""
        if self.damping == 0.0:
            return {}
        drag = (-self.damping * self.mass)[:, None] * velocities
        return {"drag": np.where(self.held, 0.0, drag) if self._drivers else drag}

    def _bounds(self, state: MatterState, interval: float) -> dict[str, FloatArray]:
        """Return the `_Limit` of the elements as "limit", and their row sums as "stiffness" (n,).

        Both have the factor `MARGIN`. ω² is never below that at rest: a material that has softened,
        such as foam on its plateau, is stiff again within a few steps of unloading.
        """
        sums = self.matter.stiffness(state)
        square = max(self._gershgorin_bound(sums), self._bound_at_rest)
        limit = np.array(_Limit(square, interval, interval))
        return {"limit": limit, "stiffness": self._at_nodes(MARGIN * sums)}

    @cached_property
    def _bound_at_rest(self) -> float:
        """Upper bound of ω² of elements with next to no strain, of either sign."""
        return self._gershgorin_bound(sums_near_rest(self.matter))

    def _gershgorin_bound(self, sums: FloatArray) -> float:
        """Return `MARGIN` times the bound of ω² by row sums (m,) of the stiffness (Gershgorin).

        Nodes that are wholly held do not count; 0 if all are.
        """
        is_free = ~self.held[self.rows].all(axis=1)
        return MARGIN * float((sums[is_free] / self.mass[self.rows][is_free]).max(initial=0.0))

    def _next_bounds(self, before: Arrays, state: MatterState) -> dict[str, FloatArray]:
        """Return "limit" and "stiffness": the last ones, or new ones if their interval has passed.

        The next interval is half as long if ω² changed by more than `SQUARE_TOL` of itself, else
        twice as long, within `MIN_INTERVAL` and `MAX_INTERVAL`.
        """
        limit = _Limit(*before["limit"].tolist())
        if limit.countdown > 1.0:
            same_limit = limit._replace(countdown=limit.countdown - 1.0)
            return {"limit": np.array(same_limit), "stiffness": before["stiffness"]}
        bounds = self._bounds(state, limit.interval)
        if abs(bounds["limit"][0] - limit.square) > SQUARE_TOL * limit.square:
            interval = max(0.5 * limit.interval, MIN_INTERVAL)
        else:
            interval = min(2.0 * limit.interval, MAX_INTERVAL)
        bounds["limit"][1:] = interval
        return bounds

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """See `NodeMover`."""
        return float(state.matter["limit"][0]), self.damping

    def forces_on_bodies(self, state: SlaveState, forces: Forces) -> Sequence[BodyForces]:
        """See `NodeMover`: forces of contacts, elements and loads; () if no node is attached."""
        if not self.joints:
            return ()
        arrays = state.matter
        inner = arrays["force"] + arrays["load"] if "load" in arrays else arrays["force"]
        total = forces() + inner
        return [
            BodyForces(joint.host, state.points[joint.rows], total[joint.rows])
            for joint in self.joints
        ]

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """See `NodeMover`: by the last stiffness that was computed, with a margin."""
        springs = []
        for joint in self.joints:
            stiffness = state.matter["stiffness"][joint.rows].astype(np.float64)
            springs.append(JointSprings(joint.host, state.points[joint.rows], stiffness))
        return springs

    @property
    def is_at_rest(self) -> bool:  # type: ignore[override]  # a class attribute of the base
        """See `NodeMover`."""
        return not (self.loads or self.drives or self.joints or self.velocity.any())

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """See `NodeMover`: by all forces on free degrees of freedom."""
        a = accelerated(self._masses, _acting(state.matter, forces, gravity))
        return 0.125 * float((self.mass * row_products(a, a)).sum())

    def inside(self, state: SlaveState) -> Sequence[KindFields]:
        """See `NodeMover`: for matter that has `element_fields`."""
        element_fields = getattr(self.matter, "element_fields", None)
        if element_fields is None:
            return ()
        groups = element_fields(MatterState(self._of_dofs(state.points), state.matter["memory"]))
        return [group._replace(elements=self.rows[group.elements]) for group in groups]

    def reached(self, state: SlaveState) -> Sequence[LargestStrain]:
        """See `NodeMover`: the largest strains of material tables; () if matter has none."""
        reached = getattr(self.matter, "reached", None)
        if reached is None:
            return ()
        strains: Sequence[LargestStrain] = reached(
            MatterState(state.points, state.matter["memory"])
        )
        return strains

    def without_velocities(self, state: SlaveState) -> SlaveState:
        """See `NodeMover`."""
        velocities = np.zeros_like(state.velocities)
        energy = np.concatenate([[0.0], state.matter["energy"][1:]])
        arrays = {**state.matter, "energy": energy, **self._drag(velocities)}
        return ElementState.of(state.points, velocities, arrays)

    def velocity_energy(self, state: SlaveState) -> float:
        """See `NodeMover`."""
        return kinetic(self._masses, state.velocities)

    def with_mixed_velocities(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """See `NodeMover`."""
        arrays = {**state.matter, "drag": NO_FORCES}
        accelerations = accelerated(self._masses, _acting(arrays, forces, gravity))
        kinetic_energy = kinetic(self._masses, state.velocities)
        pull = kinetic(self._masses, accelerations)
        if kinetic_energy == 0.0 or pull == 0.0:
            return state
        turned = np.sqrt(kinetic_energy / pull) * accelerations
        velocities = np.where(self.held, 0.0, (1.0 - share) * state.velocities + share * turned)
        return ElementState.of(state.points, velocities, state.matter)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """See `NodeMover`: elements, contacts, loads and weight at free degrees of freedom."""
        loads = self.mass[:, None] * gravity + state.matter.get("load", 0.0)
        inner = state.matter["force"]
        force = np.where(self.held, 0.0, forces() + inner + loads)
        load, reaction = np.where(self.held, 0.0, loads), np.where(self.held, inner, 0.0)
        stiffness = float(state.matter["limit"][0] * self.mass.sum())
        return Imbalance(
            float(row_lengths(force).sum()),
            float(row_lengths(load).sum()),
            float(row_lengths(reaction).sum()),
            rounding=EPS * stiffness * length(np.ptp(state.points, axis=0)),
        )

    def energy(self, state: SlaveState) -> NodeEnergies:
        """See `NodeMover`: kinetic energy, and the energies of the elements."""
        return NodeEnergies(*state.matter["energy"].tolist())

    def gravity_work(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        if not gravity.any():
            return 0.0
        displacement = now.points - last.points
        if self._drivers:
            displacement = np.where(self._driven, 0.0, displacement)
        return work_of_weight(self.mass, displacement, gravity)

    def motion_work(
        self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces
    ) -> float:
        """See `NodeMover`: work of motions and loads.

        Loads do work on degrees of freedom that no motion drives; on those that motions drive, the
        driving forces do work against all other forces.
        """
        work, displacement = 0.0, now.points - last.points
        if self.loads:
            loads = last.matter["load"] + now.matter["load"]
            not_driven = np.where(self._driven_by_motions, 0.0, displacement)
            work += 0.5 * float((loads * not_driven).sum())
        if self.drives:
            resisting = last.matter["force"] + now.matter["force"] + before() + forces()
            driven = np.where(self._driven_by_motions, displacement, 0.0)
            work -= 0.5 * float((resisting * driven).sum())
        return work

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: the motion; the slave adds its elements itself."""
        digest.add_value(self.motion)


def joints_of(hosts: NDArray[np.int32], points: FloatArray, mass: FloatArray) -> tuple[Joint, ...]:
    """Return one joint for each body in `hosts` (n,), the bodies of the nodes; −1 is no body."""
    joints = []
    for host in np.unique(hosts[hosts >= 0]):
        rows = np.flatnonzero(hosts == host)
        joints.append(Joint(int(host), rows, points[rows], mass[rows]))
    return tuple(joints)
