"""Several masters as one obstacle: clearances, normals, and which segments enter a master."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.masters.protocol import Master
from contiga.records import FloatArray, FootSlopes, IndexArray, Projection, empty_projection


class Clearances(NamedTuple):
    """Distances of n points from the nearest of several masters, one row a point."""

    gap: FloatArray
    """(n,) signed distance, negative inside."""
    normal: FloatArray
    """(n, 3) gradient of the gap to the nearest master."""
    body: IndexArray
    """(n,) index of the nearest master, the first of equals."""


class Obstacles:
    """Masters, in one frame, that a string stays outside of."""

    def __init__(self, bodies: Sequence[Master]) -> None:
        self.bodies = tuple(bodies)
        boxes = np.array([body.bounds() for body in self.bodies])
        self.box: FloatArray = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
        self.size = float(np.linalg.norm(self.box[1] - self.box[0]))
        """Diagonal of the box that holds all of them, length."""

    def feet(self, points: FloatArray) -> list[Projection]:
        """Return the closest points to `points` (n, 3) on the masters, a `Projection` for each."""
        rows = np.arange(len(points), dtype=np.int32)
        feet = [empty_projection(len(points)) for _ in self.bodies]
        for body, out in zip(self.bodies, feet, strict=True):
            body.surface.closest(points, rows, out)
        return feet

    def bending(self, points: FloatArray, feet: Projection, body: int) -> FloatArray:
        """Return (n, 3, 3) second derivatives of the gap to one master, made symmetric.

        `feet` are those of `points` (n, 3) on the master with the index `body`.
        """
        out = FootSlopes(np.empty((len(points), 3)), np.empty((len(points), 3, 3)))
        self.bodies[body].surface.slopes(points, feet, out)
        return 0.5 * (out.normal + out.normal.transpose(0, 2, 1))

    def clearances(self, points: FloatArray) -> Clearances:
        """Return the least gap of each of `points` (n, 3), its gradient, and the nearest master."""
        feet = self.feet(points)
        gap = np.array([foot.gap for foot in feet])
        normal = np.array([foot.normal for foot in feet])
        nearest = np.argmin(gap, axis=0)
        rows = np.arange(len(points))
        return Clearances(gap[nearest, rows], normal[nearest, rows], nearest)

    def reach(self, points: FloatArray) -> FloatArray:
        """Return a lower bound (n,) of the distance from all surfaces; 0 inside a master.

        The bound is that of the grid of known sides, and the distance where that is undecided.
        """
        reach = np.full(len(points), np.inf)
        rows = np.arange(len(points), dtype=np.int32)
        for body in self.bodies:
            sides = body.surface.sides(points, rows)
            radius = np.where(sides.side > 0, sides.reach, 0.0)
            undecided = np.flatnonzero(sides.side == 0)
            feet = empty_projection(len(undecided))
            p_B = np.ascontiguousarray(points[undecided])
            body.surface.closest(p_B, np.arange(len(undecided), dtype=np.int32), feet)
            radius[undecided] = np.maximum(feet.gap, 0.0)
            np.minimum(reach, radius, out=reach)
        return reach

    def blocks(self, starts: FloatArray, ends: FloatArray, skin: float) -> NDArray[np.bool_]:
        """Return a mask (n,) of segments that first hit a master more than `skin` from both ends.

        The starts are outside or on the surface. Hits of a master after its first do not count.
        """
        blocked = np.zeros(len(starts), dtype=bool)
        lengths = np.linalg.norm(ends - starts, axis=1)
        for body in self.bodies:
            depth = body.first_hit(starts, ends).fraction * lengths
            blocked |= (depth > skin) & (depth < lengths - skin)
        return blocked
