"""Nodes that matter moves: elements, contacts and gravity, with what is held of them.

Elements are asked for their forces where the step ends, and what resists a rate with the velocity
of the middle of the step. What damping takes in a step counts as the work of the mean of its forces
at both ends, which is what a leapfrog does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length
from contiga.dynamics.holding import Drive
from contiga.dynamics.nodal_loads import NodalForces
from contiga.dynamics.nodes import (
    Arrays,
    ElementState,
    Forces,
    Imbalance,
    Instant,
    SlaveState,
    Stored,
    _Unmoved,
    work_of_weight,
)
from contiga.errors import ElementError
from contiga.matter.element_fields import Inside
from contiga.matter.protocol import Matter, MatterForces, MatterState
from contiga.records import FloatArray

REFRESH = 50
"""Steps after which row sums of the stiffness are taken anew, after fewer where they change, and at
the start."""
GROWN = 0.02
"""Part by which ω² may change until then: beyond it they are taken twice as often."""
OFTEN = 4
"""Steps from one time to the next at least."""
MARGIN = 1.02
"""On ω², for what stiffens in between."""
EPS = float(np.finfo(np.float64).eps)


class _Limit(NamedTuple):
    """What bounds the step."""

    square: float
    """ω², 1/time²."""
    left: float
    """Steps until it is taken anew."""
    interval: float
    """Steps from one time to the next."""


def _all_forces(inside: Arrays) -> FloatArray:
    """(n, 3) of elements and loads."""
    return inside["force"] + inside["load"] if "load" in inside else inside["force"]


@dataclass(frozen=True, eq=False)
class DeformingNodes(_Unmoved):
    """Nodes of elements."""

    host: ClassVar[None] = None
    joined: ClassVar[bool] = True
    where: str
    matter: Matter
    rows: NDArray[np.intp]
    """(m,) node of each degree of freedom."""
    mass: FloatArray
    """(n,)."""
    rest: FloatArray
    """(n, 3) at the start."""
    velocity: FloatArray
    """(n, 3) at the start, zero of what is held."""
    held: NDArray[np.bool_]
    """(n, 3) ways that no force moves: they are held or driven."""
    damping: float
    """α of a force −α m v, 1/time."""
    motion: object
    """What was given, for the digest."""
    loads: tuple[NodalForces, ...] = ()
    drives: tuple[Drive, ...] = ()

    @cached_property
    def bare(self) -> NDArray[np.bool_]:  # type: ignore[override]  # of others it is of the class
        """(n,) nodes that are in no element."""
        bare = np.ones(len(self.rest), np.bool_)
        bare[self.rows] = False
        return bare

    @property
    def flight(self) -> FloatArray | None:
        """As they set off, where nothing holds them."""
        return None if self.held.any() or self.loads else self.velocity

    @cached_property
    def _driven(self) -> NDArray[np.bool_]:
        """(n, 3) ways that motions drive: what moves them has their kinetic energy."""
        return np.any([np.zeros_like(self.held), *(one.ways for one in self.drives)], axis=0)

    def start(self, now: Instant) -> SlaveState:
        """As they stand, with the forces of elements that are strained already."""
        return self._begun(self.matter.start(), self.rest.copy(), now)

    def taken_up(self, rest: SlaveState, now: Instant) -> SlaveState:
        """Where they rest, with the velocities and nothing of the losses that they start with."""
        state = MatterState(rest.points[self.rows], rest.matter["memory"])
        return self._begun(state, rest.points.copy(), now)

    def _begun(self, state: MatterState, points: FloatArray, now: Instant) -> SlaveState:
        """At the start of a run."""
        velocities = self.velocity.copy()
        self._drive(now.time, points, velocities)
        answer = self._asked(state, points, velocities, now)
        kinetic = self._kinetic(velocities, velocities)
        inside = {
            "force": self._at_nodes(answer.force),
            "drag": self._drag(velocities),
            **self._loads(points, now.time),
            "energy": np.array([kinetic, *answer.energy[:2], 0.0, 0.0, 0.0]),
            "limit": np.array([self._square(answer.state), OFTEN, OFTEN]),
            "memory": answer.state.memory,
        }
        return ElementState.of(points, velocities, inside)

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Half a kick, a drift, and the velocity that half a kick more gives."""
        force = _all_forces(last.matter) + last.matter["drag"]
        kick = 0.5 * now.dt * self._acceleration(force, forces, now.gravity)
        half = last.velocities + kick
        points, velocities = last.points + now.dt * half, half + kick
        self._drive(now.time, points, velocities)
        return ElementState.of(points, velocities, last.matter)

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The forces of the elements, and the other half."""
        half = 0.5 * (last.velocities + drifted.velocities)
        before = last.matter
        state = MatterState(last.points[self.rows], before["memory"])
        answer = self._asked(state, drifted.points, half, now)
        inside = {
            "force": self._at_nodes(answer.force),
            **self._loads(drifted.points, now.time),
        }
        # Damping acts by the velocity that it leaves, so that it is of second order and stable.
        kick = 0.5 * now.dt * self._acceleration(_all_forces(inside), forces, now.gravity)
        velocities = (half + kick) / (1.0 + 0.5 * now.dt * self.damping)
        if self.drives:
            velocities = np.where(self._driven, drifted.velocities, velocities)
        drag = self._drag(velocities)
        taken = 0.5 * float(((before["drag"] + drag) * (drifted.points - last.points)).sum())
        # Of the middles of the steps before and after: what a leapfrog keeps of linear elements.
        kinetic = self._kinetic(half, 2.0 * velocities - half)
        energy = np.array([kinetic, *answer.energy, -taken])
        energy[3:] += before["energy"][3:]
        inside |= {
            "drag": drag,
            "energy": energy,
            "limit": np.array(self._next_limit(_Limit(*before["limit"].tolist()), answer.state)),
            "memory": answer.state.memory,
        }
        return ElementState.of(drifted.points, velocities, inside)

    def _asked(
        self, state: MatterState, points: FloatArray, velocities: FloatArray, now: Instant
    ) -> MatterForces:
        """What matter answers; an element that is inside out with the time and the slave."""
        q, v = points[self.rows], velocities[self.rows]
        try:
            return self.matter.forces(state, q, v, now.dt)
        except ElementError as error:
            raise error.at(now.time) from error

    def _drive(self, time: float, points: FloatArray, velocities: FloatArray) -> None:
        """Have driven nodes where they go at a time."""
        for one in self.drives:
            one.place(time, points, velocities)

    def _loads(self, points: FloatArray, time: float) -> dict[str, FloatArray]:
        """Forces of the loads, where there are any."""
        if not self.loads:
            return {}
        forces = [load.at(points, time) for load in self.loads]
        return {"load": np.asarray(sum(forces[1:], forces[0]))}

    def _drag(self, velocities: FloatArray) -> FloatArray:
        """Of nodes that forces move."""
        drag = (-self.damping * self.mass)[:, None] * velocities
        return np.where(self.held, 0.0, drag) if self.drives else drag

    def _kinetic(self, one: FloatArray, other: FloatArray) -> float:
        """½ m v·w of nodes that forces move."""
        if self.drives:
            one = np.where(self._driven, 0.0, one)
        return 0.5 * float((self.mass * (one * other).sum(axis=1)).sum())

    def _at_nodes(self, force: FloatArray) -> FloatArray:
        """(n, 3) of the slave's nodes."""
        every = np.zeros(self.rest.shape)
        every[self.rows] = force
        return every

    def _acceleration(self, force: FloatArray, forces: Forces, gravity: FloatArray) -> FloatArray:
        """(n, 3) by the forces of elements and of contacts, zero where they are held."""
        acceleration = (forces() + force) / self.mass[:, None] + gravity
        acceleration[self.held] = 0.0
        return acceleration

    def _square(self, state: MatterState) -> float:
        """ω² that no vibration of the elements is above, by Gershgorin's theorem."""
        free = ~self.held[self.rows].all(axis=1)
        sums = self.matter.stiffness(state)[free] / self.mass[self.rows][free]
        return MARGIN * float(sums.max(initial=0.0))

    def _next_limit(self, limit: _Limit, state: MatterState) -> _Limit:
        if limit.left > 1.0:
            return limit._replace(left=limit.left - 1.0)
        square, interval = self._square(state), limit.interval
        if abs(square - limit.square) > GROWN * limit.square:
            interval = max(0.5 * interval, OFTEN)
        else:
            interval = min(2.0 * interval, REFRESH)
        return _Limit(square, interval, interval)

    def rates(self, state: SlaveState) -> tuple[float, float]:
        """ω² and decay of what is fastest in them."""
        return float(state.matter["limit"][0]), self.damping

    def inside(self, state: SlaveState) -> Sequence[Inside]:
        """Of matter that tells it."""
        asked = getattr(self.matter, "element_fields", None)
        if asked is None:
            return ()
        groups = asked(MatterState(state.points[self.rows], state.matter["memory"]))
        return [group._replace(elements=self.rows[group.elements]) for group in groups]

    def stopped(self, state: SlaveState) -> SlaveState:
        """The same without velocities."""
        inside = dict(state.matter)
        inside["energy"] = np.concatenate([[0.0], inside["energy"][1:]])
        inside["drag"] = np.zeros_like(inside["drag"])
        return ElementState.of(state.points, np.zeros_like(state.velocities), inside)

    def shaken(self, state: SlaveState) -> float:
        """By their velocities now."""
        return self._kinetic(state.velocities, state.velocities)

    def steered(
        self, state: SlaveState, forces: Forces, gravity: FloatArray, share: float
    ) -> SlaveState:
        """The same with a share of the velocities turned to where the forces pull."""
        way = self._acceleration(_all_forces(state.matter), forces, gravity)
        kinetic, pull = (self._kinetic(v, v) for v in (state.velocities, way))
        if kinetic == 0.0 or pull == 0.0:
            return state
        turned = np.sqrt(kinetic / pull) * way
        velocities = np.where(self.held, 0.0, (1.0 - share) * state.velocities + share * turned)
        return ElementState.of(state.points, velocities, state.matter)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """Of elements, contacts, loads and weight at the nodes that are not held."""
        loads = self.mass[:, None] * gravity + state.matter.get("load", 0.0)
        inside = state.matter["force"]
        free = np.where(self.held, 0.0, forces() + inside + loads)
        force, load, reaction = (
            float(np.sqrt((each * each).sum(axis=1)).sum())
            for each in (free, np.where(self.held, 0.0, loads), np.where(self.held, inside, 0.0))
        )
        stiff = float(state.matter["limit"][0] * self.mass.sum())
        rounding = EPS * stiff * length(np.ptp(state.points, axis=0))
        return Imbalance(force, load, reaction, rounding)

    def energy(self, state: SlaveState) -> Stored:
        """Kinetic, and what the elements have."""
        return Stored(*state.matter["energy"].tolist())

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Their weight along their way."""
        return work_of_weight(self.mass, self._moved(last, now), gravity)

    def by_motion(self, last: SlaveState, now: SlaveState, before: Forces, forces: Forces) -> float:
        """Of loads on what forces move, and of what drives the others against all other forces."""
        work = 0.0
        if self.loads:
            both = last.matter["load"] + now.matter["load"]
            work += 0.5 * float((both * self._moved(last, now)).sum())
        if self.drives:
            both = last.matter["force"] + now.matter["force"] + before() + forces()
            way = np.where(self._driven, now.points - last.points, 0.0)
            work -= 0.5 * float((both * way).sum())
        return work

    def _moved(self, last: SlaveState, now: SlaveState) -> FloatArray:
        """(n, 3) ways of a step, zero of what is driven."""
        way = now.points - last.points
        return np.where(self._driven, 0.0, way) if self.drives else way

    def digest(self, digest: Any, times: FloatArray) -> None:
        """What was given: of elements the slave tells its own."""
        digest.thing(self.motion)
