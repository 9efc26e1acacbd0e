"""Contact areas of a state, measured when somebody looks at them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.area.method import AreaInput, AreaMethod, Areas, Outlines, outlines_of
from contiga.area.offset import offset_ratio
from contiga.contact.state import State
from contiga.masters.protocol import Master
from contiga.records import FloatArray, Projection
from contiga.rigid.frames import to_world
from contiga.statuses import Status


class Measure(NamedTuple):
    """The way in which the contact area of a contact is measured."""

    master: Master
    method: AreaMethod
    side: str
    """Whose area is wanted, "slave" or "master"."""
    own: FloatArray | None
    """(n,) tributary areas of the slave, where it has them."""
    prepared: Any
    """What the method keeps about the slave."""
    half: FloatArray | None
    """(m,) half the thickness of a shell, the nodes first."""

    def input(self, nodes: FloatArray, patch: np.ndarray, feet: Projection) -> AreaInput:
        """Make what the method sees of nodes (n, 3), body axes; patch ≥ 0 are in contact."""
        rows = np.flatnonzero(patch >= 0).astype(np.int32)
        return AreaInput(
            self.master, rows, nodes, feet, self.own, self.side, self.prepared, {}, self.half
        )

    def input_of(self, state: State) -> AreaInput:
        """Make what the method sees of a state."""
        n = len(state.force)
        rows = np.flatnonzero(state.patch[:n] >= 0)
        feet = Projection(
            state.patch[rows],
            state.uv[rows],
            state.foot_B[rows],
            state.kept.normal_B.at(rows),
            -state.penetration[rows],
            state.feature[rows],
            np.full(len(rows), Status.OK, np.int8),
            np.zeros(len(rows), np.int8),
        )
        return self.input(state.points_B[:n], state.patch[:n], feet)

    def areas(self, inp: AreaInput) -> Areas:
        """Nodal areas on the side that is wanted."""
        areas = self.method.measure(inp)
        if self.side == "slave" or areas.on == "master":
            return areas
        return areas._replace(area=areas.area / offset_ratio(self.master, inp.feet))

    def outlines(self, inp: AreaInput, pose: FloatArray) -> Outlines | None:
        """Return the lines where contact ends, world axes; None for methods that do not say."""
        lines = outlines_of(self.method, inp)
        return None if lines is None else lines._replace(points=to_world(pose, lines.points))
