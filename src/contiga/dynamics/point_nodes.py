"""Nodes that are no elements: driven by a motion, carried by a body, or each a free mass."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contiga.arrays.ordered import row_products
from contiga.dynamics.nodes import (
    Forces,
    Instant,
    NodeMover,
    SlaveState,
    Stored,
    on_body,
    work_of_weight,
)
from contiga.dynamics.prescribed import Moved, SlaveMotion, pose_at
from contiga.errors import InputError
from contiga.records import FloatArray

_INSTANTS = 64
"""That a motion is looked at where it is not a rigid one: a series of large files would have
to be read again for more."""


@dataclass(frozen=True, eq=False)
class DrivenNodes(NodeMover):
    """Nodes that go where a motion says, whatever the forces on them."""

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
        """Where the body has them."""
        return on_body(now, self.host, self.points_B)

    def drift(self, last: SlaveState, forces: Forces, now: Instant) -> SlaveState:
        """Where the body has them."""
        return self.start(now)

    def carried(self, state: SlaveState, now: Instant) -> SlaveState:
        """As the body moves them."""
        return self.start(now)

    def digest(self, digest: Any, times: FloatArray) -> None:
        """What they are fixed to."""
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
