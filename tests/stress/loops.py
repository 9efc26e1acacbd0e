"""Bodies with sharp edges that go round closed loops, which do no work.

Where a point passes from one wall to another its force turns at once. The trapezoidal rule is then
of first order: a step in which that happens is wrong by up to half the jump of the force along it.
Cut in halves until such steps are short, the loop's work is that of the smooth ones, of second
order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from tests.scenes import square_sheet
from tests.stress import solids, subjects

import contiga as cg

POSE = cg.motion.pose


class Scene(NamedTuple):
    """A body as it is pressed into a sheet: lowest at z = 0, and a third of its thinnest wall."""

    name: str
    up: np.ndarray
    """(4, 4) how it is turned first."""
    deep: float
    n: int = 29
    """Nodes along a side of the sheet."""


SCENES = {
    "block": Scene("box", np.eye(4), 40.0 / 3.0, 21),
    "wedge on its wall": Scene("wedge", POSE.rotation("x", 0.5 * np.pi), 4.0, 21),
    "wedge on its edge": Scene(
        "wedge", POSE.rotation("x", np.pi / 2) @ POSE.rotation("z", 2.0), 4.0
    ),
    "T-section on its web": Scene("T-section", POSE.rotation("x", np.pi / 2), 2.0),
    "T-section on its end": Scene("T-section", np.eye(4), 2.0),
    "cup on its rim": Scene("cup", POSE.rotation("x", np.pi), 2.0 / 3.0),
    "cog on its teeth": Scene("cog", POSE.rotation("x", np.pi / 2), 2.0),
    "casting": Scene(solids.CLOSED_FILES[0], np.eye(4), 2.0),
}


class Loop:
    """A body that is pressed into a sheet, moved about with a turn, and drawn out again."""

    def __init__(self, scene: Scene, wave: float, **options: object) -> None:
        body = subjects.subject(scene.name).solid.body
        corners = POSE.apply(scene.up, body.tessellate(1e-3 * body.size).vertices)
        low, high = corners.min(axis=0), corners.max(axis=0)
        middle = 0.5 * (low + high)
        self.height = high[2] - low[2]
        self.first = POSE.translation([-middle[0], -middle[1], -low[2]]) @ scene.up
        side = 1.3 * np.hypot(*(high - low)[:2])
        points, quads = square_sheet(side, scene.n)
        points[:, 2] += (
            wave * scene.deep * np.sin(0.31 * points[:, 0]) * np.cos(0.23 * points[:, 1])
        )
        points[:, :2] += 0.013 * side / scene.n * np.array([1.0, 2.0])
        self.slave = cg.Slave(points, quads)
        law = cg.PenaltyLaw(1.0, per_area=True)
        self.contact = cg.Contact(body, self.slave, law=law, **options)
        low, h = 0.8 * (1.0 - wave) * scene.deep, 1.3 * (1.0 + wave) * scene.deep
        s = min(0.15 * side, 6.0 * scene.deep)
        self.corners = np.array(
            [
                [0.0, 0.0, h, 0.0],
                [0.0, 0.0, -low, 0.0],
                [s, 0.0, -low, 0.2 * scene.deep / side],
                [s, s, -1.1 * low, -0.1 * scene.deep / side],
                [0.0, 0.0, -low, 0.0],
                [0.0, 0.0, h, 0.0],
            ]
        )

    def pose(self, t: float) -> np.ndarray:
        """At a time from zero to the number of sides."""
        k = min(int(t), len(self.corners) - 2)
        x, y, z, angle = self.corners[k] + (t - k) * (self.corners[k + 1] - self.corners[k])
        turn = POSE.rotation("y", angle, [0.0, 0.0, 0.5 * self.height])
        return POSE.translation([x, y, z]) @ turn @ self.first

    def states(self, steps: int, halvings: int = 0) -> Iterator[cg.State]:
        """In so many steps a side; those are halved in which another wall pushes a point."""
        state = self.contact.start(self.slave.points, self.pose(0.0))
        yield state
        for k in range(steps * (len(self.corners) - 1)):
            state = self._halved(state, k / steps, 1.0 / steps, halvings)
            yield state

    def _halved(self, state: cg.State, t: float, dt: float, halvings: int) -> cg.State:
        after = self.contact.step(state, self.slave.points, self.pose(t + dt))
        other = state.in_contact & after.in_contact & (state.patch != after.patch)
        if halvings == 0 or not other.any():
            return after
        middle = self._halved(state, t, 0.5 * dt, halvings - 1)
        return self._halved(middle, t + 0.5 * dt, 0.5 * dt, halvings - 1)
