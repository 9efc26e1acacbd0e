"""Nodes that matter moves: elements, contacts and gravity, with what is held of them.

Elements are asked for their forces where the step ends, and what resists a rate with the velocity
of the middle of the step. What damping takes in a step counts as the work of the mean of its forces
at both ends, which is what a leapfrog does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.dynamics.nodes import (
    ElementState,
    Forces,
    Imbalance,
    Instant,
    SlaveState,
    Stored,
    _Unmoved,
    kinetic_energy,
    work_of_weight,
)
from contiga.errors import ElementError
from contiga.matter.protocol import Matter, MatterForces, MatterState
from contiga.records import FloatArray

REFRESH = 50
"""Steps after which row sums of the stiffness are taken anew, after fewer where they change."""
GROWN = 0.02
"""Part by which ω² may change until then: beyond it they are taken twice as often."""
OFTEN = 4
"""Steps from one time to the next at least."""
MARGIN = 1.02
"""On ω², for what stiffens in between."""


class _Limit(NamedTuple):
    """What bounds the step."""

    square: float
    """ω², 1/time²."""
    left: float
    """Steps until it is taken anew."""
    interval: float
    """Steps from one time to the next."""


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
    """(n, 3)."""
    damping: float
    """α of a force −α m v, 1/time."""
    motion: object
    """What was given, for the digest."""

    @property
    def flight(self) -> FloatArray | None:
        """As they set off, where nothing holds them."""
        return None if self.held.any() else self.velocity

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
        answer = self._asked(state, points, velocities, now)
        drag = (-self.damping * self.mass)[:, None] * velocities
        kinetic = kinetic_energy(self.mass, velocities)
        inside = {
            "force": self._at_nodes(answer.force),
            "drag": drag,
            "energy": np.array([kinetic, *answer.energy[:2], 0.0, 0.0, 0.0]),
            "limit": np.array([self._square(answer.state), REFRESH, REFRESH]),
            "memory": answer.state.memory,
        }
        return ElementState.of(points, velocities, inside)

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Half a kick, a drift, and the velocity that half a kick more gives."""
        force = last.matter["force"] + last.matter["drag"]
        kick = 0.5 * now.dt * self._acceleration(force, forces, now.gravity)
        velocities = last.velocities + kick
        return ElementState.of(last.points + now.dt * velocities, velocities + kick, last.matter)

    def kick(
        self, last: SlaveState, drifted: SlaveState, forces: Forces, now: Instant
    ) -> SlaveState:
        """The forces of the elements, and the other half."""
        half = 0.5 * (last.velocities + drifted.velocities)
        before = last.matter
        state = MatterState(last.points[self.rows], before["memory"])
        answer = self._asked(state, drifted.points, half, now)
        force = self._at_nodes(answer.force)
        # Damping acts by the velocity that it leaves, so that it is of second order and stable.
        kick = 0.5 * now.dt * self._acceleration(force, forces, now.gravity)
        velocities = (half + kick) / (1.0 + 0.5 * now.dt * self.damping)
        drag = (-self.damping * self.mass)[:, None] * velocities
        taken = 0.5 * float(((before["drag"] + drag) * (drifted.points - last.points)).sum())
        # Of the middles of the steps before and after: what a leapfrog keeps of linear elements.
        after = 2.0 * velocities - half
        kinetic = 0.5 * float((self.mass * (half * after).sum(axis=1)).sum())
        energy = np.array([kinetic, *answer.energy, -taken])
        energy[3:] += before["energy"][3:]
        inside = {
            "force": force,
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

    def stopped(self, state: SlaveState) -> SlaveState:
        """The same without velocities."""
        inside = dict(state.matter)
        inside["energy"] = np.concatenate([[0.0], inside["energy"][1:]])
        inside["drag"] = np.zeros_like(inside["drag"])
        return ElementState.of(state.points, np.zeros_like(state.velocities), inside)

    def imbalance(self, state: SlaveState, forces: Forces, gravity: FloatArray) -> Imbalance:
        """Of elements, contacts, loads and weight at the nodes that are not held."""
        loads = self.mass[:, None] * gravity
        sums = (
            np.where(self.held, 0.0, each)
            for each in (forces() + state.matter["force"] + loads, loads)
        )
        return Imbalance(*(float(np.sqrt((each * each).sum(axis=1)).sum()) for each in sums))

    def energy(self, state: SlaveState) -> Stored:
        """Kinetic, and what the elements have."""
        return Stored(*state.matter["energy"].tolist())

    def by_gravity(self, last: SlaveState, now: SlaveState, gravity: FloatArray) -> float:
        """Their weight along their way."""
        return work_of_weight(self.mass, now.points - last.points, gravity)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """What was given: of elements the slave tells its own."""
        digest.thing(self.motion)
