"""Nodes that matter moves: elements, contacts and gravity, with what is held of them.

Elements are asked for their forces where the step ends, and what resists a rate with the velocity
of the middle of the step. What damping takes in a step counts as the work of the mean of its forces
at both ends, which is what a leapfrog does.
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
    ElementState,
    Forces,
    Imbalance,
    Instant,
    Joint,
    JointSprings,
    NodeMover,
    Pull,
    SlaveState,
    Stored,
    work_of_weight,
)
from contiga.errors import ElementError
from contiga.jit import straight
from contiga.matter.element_fields import Inside, Reached
from contiga.matter.mass_scaling import MARGIN, sums_near_rest
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterForces, MatterState
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray

REFRESH = 50
"""Steps after which row sums of the stiffness are taken anew, after fewer where they change, and at
the start."""
GROWN = 0.02
"""Part by which ω² may change until then: beyond it they are taken twice as often."""
OFTEN = 4
"""Steps from one time to the next at least."""
EPS = float(np.finfo(np.float64).eps)
NODES = 16384
"""Below which a second thread does not pay; a multiple of the nodes of a block."""
NOTHING, NO_ROWS = np.zeros((0, 3)), np.zeros(0, np.int32)
"""Forces of a kind that does not act, and rows of none."""


@pass_by_pointer
class Masses(NamedTuple):
    """Nodes that forces move."""

    mass: FloatArray
    """(n,)."""
    held: NDArray[np.bool_]
    """(n, 3) ways that no force moves; (0, 3) where there are none."""
    led: NDArray[np.bool_]
    """(n, 3) ways in which motions or bodies have them; (0, 3) where there are none."""


@pass_by_pointer
class Acting(NamedTuple):
    """Forces on nodes, (n, 3) each, (0, 3) of those there are none of."""

    rows: IndexArray
    """(k,) nodes on which contacts act, ascending; none where they act on all."""
    contacts: FloatArray
    """(k, 3) of contacts."""
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
    """Velocities foreseen at the end of the step, after half a kick more."""
    half: FloatArray
    """Velocities of its middle."""


@pass_by_pointer
class Kick(NamedTuple):
    """Start of the second half of a step's kick."""

    half: FloatArray
    """(n, 3) velocities of the middle of the step."""
    foreseen: FloatArray
    """(n, 3) velocities at its end, by the forces at its start; of what is led as it is led."""
    dt: float
    damping: float
    """α of a force −α m v, 1/time."""


@pass_by_pointer
class Kicked(NamedTuple):
    """Nodes after a `Kick`."""

    velocities: FloatArray
    """(n, 3)."""
    energy: FloatArray
    """(b,) ½ Σ m v₋·v₊ of the middles of the steps before and after, of what forces move."""


def masses_of(mass: FloatArray, held: NDArray[np.bool_], led: NDArray[np.bool_]) -> Masses:
    """Return masses (n,), the ways (n, 3) that no force moves, and those that others lead.

    Motions or bodies lead them.
    """
    none, given = (locked(some if some.any() else some[:0]) for some in (held, led))
    return Masses(locked(mass), none, given)


def accelerated(masses: Masses, forces: Acting) -> FloatArray:
    """Return the accelerations (n, 3), zero where nodes are held."""
    out = np.empty(forces.elements.shape)
    run_ranges(straight(nodes_nb.accelerate), len(out), NODES, masses, forces, out)
    return out


def drifted(
    masses: Masses, forces: Acting, points: FloatArray, velocities: FloatArray, dt: float
) -> Drifted:
    """Return the nodes after the drift of a step from points and velocities (n, 3)."""
    shape = points.shape
    out = Drifted(np.empty(shape), np.empty(shape), np.empty(shape))
    last = Course(points, velocities)
    run_ranges(straight(nodes_nb.drift), len(points), NODES, masses, forces, last, dt, out)
    return out


def kicked(
    masses: Masses, forces: Acting, speeds: tuple[FloatArray, FloatArray], dt: float, damping: float
) -> Kicked:
    """Return the end of a step from the velocities (n, 3) of its middle and those foreseen."""
    half, foreseen = speeds
    out = Kicked(np.empty(half.shape), np.empty(ceil(half.size / nodes_nb.BLOCK)))
    given = Kick(half, foreseen, dt, damping)
    run_ranges(straight(nodes_nb.kick), len(half), NODES, masses, forces, given, out)
    return out


def kinetic(masses: Masses, velocities: FloatArray) -> float:
    """Return ½ Σ m v² of nodes that forces move with velocities (n, 3)."""
    out = np.empty(ceil(velocities.size / nodes_nb.BLOCK))
    run_ranges(straight(nodes_nb.kinetic), len(velocities), NODES, masses, velocities, out)
    return float(out.sum())


class _Limit(NamedTuple):
    """Bound of the step."""

    square: float
    """ω², 1/time²."""
    left: float
    """Steps until it is taken anew."""
    interval: float
    """Steps from one time to the next."""


def _all_forces(inside: Arrays) -> FloatArray:
    """Return the forces (n, 3) of elements and loads."""
    return inside["force"] + inside["load"] if "load" in inside else inside["force"]


def _acting(inside: Arrays, forces: Forces, gravity: FloatArray) -> Acting:
    """Return the forces of contacts and elements, with loads and drag if `inside` has them."""
    loads, drag = inside.get("load", NOTHING), inside.get("drag", NOTHING)
    rows, pushes = forces.listed()
    everywhere = NOTHING
    if len(pushes) == len(inside["force"]):
        rows, pushes, everywhere = NO_ROWS, NOTHING, pushes
    return Acting(rows, pushes, everywhere, inside["force"], loads, drag, gravity)


@dataclass(frozen=True, eq=False)
class DeformingNodes(NodeMover):
    """Nodes of elements."""

    joined: ClassVar[bool] = True
    has_sections: ClassVar[bool] = True
    where: str
    matter: Matter
    rows: NDArray[np.intp]
    """(m,) node of each degree of freedom."""
    mass: FloatArray = field()  # of others it is None, of the class
    """(n,)."""
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(n, 3) at the start, zero of what is held."""
    held: NDArray[np.bool_]
    """(n, 3) ways that no force moves: they are held, driven or attached to bodies."""
    damping: float
    """α of a force −α m v, 1/time."""
    motion: object
    """What was given, for the digest."""
    loads: tuple[NodalForces, ...] = ()
    drives: tuple[Drive, ...] = ()
    joints: tuple[Joint, ...] = ()
    parts: tuple[Part, ...] = ()
    """Elements with their materials, rows of the nodes; none of matter of a user's own."""

    @cached_property
    def bare(self) -> NDArray[np.bool_]:  # type: ignore[override]  # of others it is of the class
        """Nodes (n,) that are in no element."""
        bare = np.ones(len(self.rest), np.bool_)
        bare[self.rows] = False
        return bare

    @cached_property
    def _whole(self) -> bool:
        """True if all nodes are degrees of freedom, in their order."""
        return len(self.rows) == len(self.rest) and bool((np.diff(self.rows) == 1).all())

    def _inner(self, nodal: FloatArray) -> FloatArray:
        """Return the rows (m, 3) of degrees of freedom; the same array if they are all nodes."""
        return nodal if self._whole else nodal[self.rows]

    @property
    def flight(self) -> FloatArray | None:
        """See `NodeMover`: the velocity at the start, if nothing holds the nodes."""
        return None if self.held.any() or self.loads else self.velocity

    @cached_property
    def _driven(self) -> NDArray[np.bool_]:
        """Ways (n, 3) that motions drive."""
        return np.any([np.zeros_like(self.held), *(one.ways for one in self.drives)], axis=0)

    @cached_property
    def _led(self) -> NDArray[np.bool_]:
        """Ways (n, 3) that motions drive or bodies carry, which have the kinetic energy."""
        led = self._driven.copy()
        for joint in self.joints:
            led[joint.rows] = True
        return led

    @cached_property
    def _masses(self) -> Masses:
        return masses_of(self.mass, self.held, self._led)

    @cached_property
    def _leaders(self) -> tuple[Drive | Joint, ...]:
        return (*self.drives, *self.joints)

    def start(self, now: Instant) -> SlaveState:
        """See `NodeMover`: at rest, with the forces of elements that are strained already."""
        return self._begun(self.matter.start(), self.rest.copy(), now)

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """See `NodeMover`: with the velocities of the start, and no losses."""
        state = MatterState(self._inner(rest.points), rest.matter["memory"])
        return self._begun(state, rest.points.copy(), now)

    def _begun(self, state: MatterState, points: FloatArray, now: Instant) -> SlaveState:
        """Return the state at the start of a run."""
        velocities = self.velocity.copy()
        self._lead(now, points, velocities)
        answer = self._asked(state, points, velocities, now)
        inside = {
            "force": self._at_nodes(answer.force),
            **self._drag(velocities),
            **self._loads(points, now.time),
            "energy": np.array(
                [kinetic(self._masses, velocities), *answer.energy[:2], 0.0, 0.0, 0.0]
            ),
            **self._bounds(answer.state, OFTEN),
            "memory": answer.state.memory,
        }
        return ElementState.of(points, velocities, inside)

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Half a kick, a drift, and the velocity that half a kick more gives."""
        there = _acting(last.matter, forces, now.gravity)
        points, velocities, half = drifted(self._masses, there, *last, now.dt)
        if self._leaders:
            self._lead(now, points, velocities)
            half = 0.5 * (last.velocities + velocities)
        return ElementState.of(points, velocities, {**last.matter, "half": half})

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The forces of the elements, and the other half."""
        before, half = last.matter, drifted.matter["half"]
        state = MatterState(self._inner(last.points), before["memory"])
        answer = self._asked(state, drifted.points, half, now)
        inside = {"force": self._at_nodes(answer.force)}
        if self.loads:
            inside |= self._loads(drifted.points, now.time)
        there = _acting(inside, forces, now.gravity)
        speeds = half, drifted.velocities
        velocities, swing = kicked(self._masses, there, speeds, now.dt, self.damping)
        taken = 0.0
        if self.damping:
            inside |= self._drag(velocities)
            both = before["drag"] + inside["drag"]
            taken = 0.5 * float((both * (drifted.points - last.points)).sum())
        # Of the middles of the steps before and after: what a leapfrog keeps of linear elements.
        energy = np.array([swing.sum(), *answer.energy, -taken])
        energy[3:] += before["energy"][3:]
        inside |= {
            "energy": energy,
            **self._next_bounds(before, answer.state),
            "memory": answer.state.memory,
        }
        return ElementState.of(drifted.points, velocities, inside)

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """Return the nodes with attached ones as their bodies move them."""
        if not self.joints:
            return state
        points, velocities = (part.copy() for part in state)
        for joint in self.joints:
            joint.place(now, points, velocities)
        return ElementState.of(points, velocities, state.matter)

    def _asked(
        self, state: MatterState, points: FloatArray, velocities: FloatArray, now: Instant
    ) -> MatterForces:
        """Return the forces of matter; errors of elements name the time."""
        try:
            answer = self.matter.forces(state, self._inner(points), self._inner(velocities), now.dt)
        except ElementError as error:
            raise error.at(now.time) from error
        # As kernels take them, whatever matter of a user's own answers.
        return answer._replace(force=np.require(answer.force, np.float64, ("C", "W")))

    def _lead(self, now: Instant, points: FloatArray, velocities: FloatArray) -> None:
        """Place the nodes that motions drive and bodies carry."""
        for one in self._leaders:
            one.place(now, points, velocities)

    def _loads(self, points: FloatArray, time: float) -> dict[str, FloatArray]:
        """Return the forces of the loads, empty without loads."""
        if not self.loads:
            return {}
        forces = [load.at(points, time) for load in self.loads]
        return {"load": np.asarray(sum(forces[1:], forces[0]))}

    def _drag(self, velocities: FloatArray) -> dict[str, FloatArray]:
        """Return the drag on nodes that forces move, empty without damping."""
        if self.damping == 0.0:
            return {}
        drag = (-self.damping * self.mass)[:, None] * velocities
        return {"drag": np.where(self.held, 0.0, drag) if self._leaders else drag}

    def _at_nodes(self, values: FloatArray) -> FloatArray:
        """Return values (m, …) of degrees of freedom as rows (n, …) of nodes; zero for others."""
        if self._whole:
            return values
        every = np.zeros((len(self.rest), *values.shape[1:]))
        every[self.rows] = values
        return every

    def _bounds(self, state: MatterState, interval: float) -> dict[str, FloatArray]:
        """Upper bound of ω² of the elements, and row sums of their stiffness at all nodes.

        ω² is never below that at rest: what has softened, as foam on its plateau, is as stiff again
        within few steps of an unloading.
        """
        sums = self.matter.stiffness(state)
        square = max(self._square(sums), self._at_rest)
        limit = np.array(_Limit(square, interval, interval))
        return {"limit": limit, "stiffness": self._at_nodes(MARGIN * sums)}

    @cached_property
    def _at_rest(self) -> float:
        """ω² of elements that are pressed together or pulled by next to nothing."""
        return self._square(sums_near_rest(self.matter))

    def _square(self, sums: FloatArray) -> float:
        """ω² by Gershgorin's theorem."""
        free = ~self.held[self.rows].all(axis=1)
        return MARGIN * float((sums[free] / self.mass[self.rows][free]).max(initial=0.0))

    def _next_bounds(self, before: Arrays, state: MatterState) -> dict[str, FloatArray]:
        limit = _Limit(*before["limit"].tolist())
        if limit.left > 1.0:
            waiting = np.array([limit.square, limit.left - 1.0, limit.interval])
            return {"limit": waiting, "stiffness": before["stiffness"]}
        bounds = self._bounds(state, limit.interval)
        if abs(bounds["limit"][0] - limit.square) > GROWN * limit.square:
            interval = max(0.5 * limit.interval, OFTEN)
        else:
            interval = min(2.0 * limit.interval, REFRESH)
        bounds["limit"][1:] = interval
        return bounds

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """See `NodeMover`."""
        return float(state.matter["limit"][0]), self.damping

    def pulls(self, state: SlaveState, forces: Forces) -> Sequence[Pull]:
        """See `NodeMover`: forces of contacts, elements and loads."""
        if not self.joints:
            return ()
        every = forces() + _all_forces(state.matter)
        return [Pull(one.host, state.points[one.rows], every[one.rows]) for one in self.joints]

    def springs_to_bodies(self, state: SlaveState) -> Sequence[JointSprings]:
        """See `NodeMover`: by the last stiffness that was computed, with a margin."""
        stiffness = state.matter["stiffness"]
        return [
            JointSprings(one.host, state.points[one.rows], stiffness[one.rows].astype(np.float64))
            for one in self.joints
        ]

    @property
    def stands(self) -> bool:  # type: ignore[override]  # of others it is of the class
        """See `NodeMover`."""
        return not (self.loads or self.drives or self.joints or self.velocity.any())

    def kick_energy(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> float:
        """See `NodeMover`: by all forces on nodes that are not held."""
        way = accelerated(self._masses, _acting(state.matter, forces, gravity))
        return 0.125 * float((self.mass * row_products(way, way)).sum())

    def inside(self, state: SlaveState) -> Sequence[Inside]:
        """See `NodeMover`: for matter that has `element_fields`."""
        asked = getattr(self.matter, "element_fields", None)
        if asked is None:
            return ()
        groups = asked(MatterState(self._inner(state.points), state.matter["memory"]))
        return [group._replace(elements=self.rows[group.elements]) for group in groups]

    def reached(self, state: SlaveState) -> Sequence[Reached]:
        """Return the largest strains of tables of materials since the start, if matter has them."""
        asked = getattr(self.matter, "reached", None)
        if asked is None:
            return ()
        told: Sequence[Reached] = asked(MatterState(state.points, state.matter["memory"]))
        return told

    def stopped(self, state: SlaveState) -> SlaveState:
        """See `NodeMover`."""
        inside = dict(state.matter)
        inside["energy"] = np.concatenate([[0.0], inside["energy"][1:]])
        inside |= self._drag(np.zeros_like(state.velocities))
        return ElementState.of(state.points, np.zeros_like(state.velocities), inside)

    def shaken(self, state: SlaveState) -> float:
        """See `NodeMover`."""
        return kinetic(self._masses, state.velocities)

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """See `NodeMover`."""
        way = accelerated(self._masses, _acting({**state.matter, "drag": NOTHING}, forces, gravity))
        swing, pull = (kinetic(self._masses, v) for v in (state.velocities, way))
        if swing == 0.0 or pull == 0.0:
            return state
        turned = np.sqrt(swing / pull) * way
        velocities = np.where(self.held, 0.0, (1.0 - share) * state.velocities + share * turned)
        return ElementState.of(state.points, velocities, state.matter)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """See `NodeMover`: elements, contacts, loads and weight at the nodes that are not held."""
        loads = self.mass[:, None] * gravity + state.matter.get("load", 0.0)
        inside = state.matter["force"]
        free = np.where(self.held, 0.0, forces() + inside + loads)
        force, load, reaction = (
            float(row_lengths(each).sum())
            for each in (free, np.where(self.held, 0.0, loads), np.where(self.held, inside, 0.0))
        )
        stiff = float(state.matter["limit"][0] * self.mass.sum())
        rounding = EPS * stiff * length(np.ptp(state.points, axis=0))
        return Imbalance(force, load, reaction, rounding)

    def energy(self, state: SlaveState) -> Stored:
        """See `NodeMover`: kinetic energy, and the energies of the elements."""
        return Stored(*state.matter["energy"].tolist())

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """See `NodeMover`."""
        if not gravity.any():
            return 0.0
        return work_of_weight(self.mass, self._moved(last, now), gravity)

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Return the work of motions and loads: see `NodeMover`.

        On nodes that forces move, loads do it; on the others driving forces do, against all other
        forces.
        """
        work = 0.0
        if self.loads:
            both = last.matter["load"] + now.matter["load"]
            way = np.where(self._driven, 0.0, now.points - last.points)
            work += 0.5 * float((both * way).sum())
        if self.drives:
            both = last.matter["force"] + now.matter["force"] + before() + forces()
            way = np.where(self._driven, now.points - last.points, 0.0)
            work -= 0.5 * float((both * way).sum())
        return work

    def _moved(self, last: SlaveState, now: SlaveState) -> FloatArray:
        """Return the ways (n, 3) of a step, zero for nodes that motions or bodies lead."""
        way = now.points - last.points
        return np.where(self._led, 0.0, way) if self._leaders else way

    def digest(self, digest: Any, times: FloatArray) -> None:
        """See `NodeMover`: the motion as it was given; the slave adds its elements."""
        digest.thing(self.motion)


def joints_of(hosts: NDArray[np.int32], points: FloatArray, mass: FloatArray) -> tuple[Joint, ...]:
    """Return one joint by body, of the nodes with `hosts` (n,); −1 is no body."""
    joints = []
    for host in np.unique(hosts[hosts >= 0]):
        rows = np.flatnonzero(hosts == host)
        joints.append(Joint(int(host), rows, points[rows], mass[rows]))
    return tuple(joints)
