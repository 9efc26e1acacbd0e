"""Measure the contact areas of a state, on first use."""

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
    """The area method of a contact with its fixed input."""

    master: Master
    method: AreaMethod
    side: str
    """Side whose area is measured, "slave" or "master"."""
    slave_area: FloatArray | None
    """(n,) tributary areas of the slave, if it has any."""
    prepared: Any
    """Data of the slave that the method prepared."""
    half: FloatArray | None
    """(m,) half the thickness of a shell, the nodes first."""

    def input(self, nodes: FloatArray, patch: np.ndarray, feet: Projection) -> AreaInput:
        """Return the input of the method for nodes (n, 3), body axes, in contact if patch ≥ 0.

        `feet` has a row for each node in contact.
        """
        rows = np.flatnonzero(patch >= 0).astype(np.int32)
        return AreaInput(
            self.master, rows, nodes, feet, self.slave_area, self.side, self.prepared, {}, self.half
        )

    def input_of(self, state: State) -> AreaInput:
        """Return the input of the method for the nodes in contact in a state.

        All feet count as found, and none as certified.
        """
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
        """Return nodal areas on the side of this contact.

        Areas of the slave are carried to the master along the normals, by `offset_ratio`.
        """
        areas = self.method.measure(inp)
        if self.side == "slave" or areas.on == "master":
            return areas
        return areas._replace(area=areas.area / offset_ratio(self.master, inp.feet))

    def outlines(self, inp: AreaInput, pose: FloatArray) -> Outlines | None:
        """Return the outlines of contact, world axes; None for methods without."""
        lines = outlines_of(self.method, inp)
        return None if lines is None else lines._replace(points=to_world(pose, lines.points))
