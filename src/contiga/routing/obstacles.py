"""Several masters as one obstacle: clearances, contact normals, and what segments run through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.masters.protocol import Master
from contiga.records import FloatArray, FootSlopes, IndexArray, Projection, empty_projection
from contiga.statuses import Status

NO_FOOT = (Status.NOT_FINITE, Status.MAX_ITERATIONS)


class Clearances(NamedTuple):
    """Distances of n points from the nearest of several masters, one row a point."""

    gap: FloatArray
    """(n,) signed distance, negative inside."""
    normal: FloatArray
    """(n, 3) gradient of the gap."""
    body: IndexArray
    """(n,) number of the nearest master."""


class Obstacles:
    """Masters, in one frame, that a string stays outside of."""

    def __init__(self, bodies: Sequence[Master]) -> None:
        self.bodies = tuple(bodies)
        boxes = np.array([body.bounds() for body in self.bodies])
        self.box: FloatArray = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
        self.size = float(np.linalg.norm(self.box[1] - self.box[0]))
        """Diagonal of the box that holds all of them, length."""

    def feet(self, points: FloatArray) -> list[Projection]:
        """Feet of `points` (n, 3) on each master."""
        rows = np.arange(len(points), dtype=np.int32)
        feet = [empty_projection(len(points)) for _ in self.bodies]
        for body, out in zip(self.bodies, feet, strict=True):
            body.surface.closest(points, rows, out)
        return feet

    def bending(self, points: FloatArray, feet: Projection, body: int) -> FloatArray:
        """Return (n, 3, 3) second derivatives of the gap to one master at `feet` of `points`."""
        out = FootSlopes(np.empty((len(points), 3)), np.empty((len(points), 3, 3)))
        self.bodies[body].surface.slopes(points, feet, out)
        return 0.5 * (out.normal + out.normal.transpose(0, 2, 1))

    def clearances(self, points: FloatArray) -> Clearances:
        """Distances of `points` (n, 3) from what is nearest to each."""
        feet = self.feet(points)
        nearest = np.argmin([one.gap for one in feet], axis=0)
        each = np.arange(len(points))
        gap, normal = (
            np.array([getattr(one, name) for one in feet])[nearest, each]
            for name in ("gap", "normal")
        )
        return Clearances(gap, normal, nearest)

    def reach(self, points: FloatArray) -> FloatArray:
        """Return a radius (n,) around `points` (n, 3) without any surface; 0 inside."""
        reach = np.full(len(points), np.inf)
        rows = np.arange(len(points), dtype=np.int32)
        for body in self.bodies:
            sides = body.surface.sides(points, rows)
            lengths = np.where(sides.side > 0, sides.reach, 0.0)
            unknown = np.flatnonzero(sides.side == 0)
            feet = empty_projection(len(unknown))
            asked = np.ascontiguousarray(points[unknown])
            body.surface.closest(asked, np.arange(len(unknown), dtype=np.int32), feet)
            lengths[unknown] = np.maximum(feet.gap, 0.0)
            np.minimum(reach, lengths, out=reach)
        return reach

    def blocks(self, starts: FloatArray, ends: FloatArray, skin: float) -> NDArray[np.bool_]:
        """Return which segments (n,) enter a master farther than `skin` from both ends.

        Starts are outside or on the surface.
        """
        blocked = np.zeros(len(starts), dtype=bool)
        lengths = np.linalg.norm(ends - starts, axis=1)
        for body in self.bodies:
            fraction = body.first_hit(starts, ends).fraction
            along = fraction * lengths
            blocked |= (along > skin) & (along < lengths - skin)
        return blocked
