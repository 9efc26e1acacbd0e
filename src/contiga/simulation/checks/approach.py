"""How near a slave comes to a body over its whole way.

Distance is 1-Lipschitz: at another time a point is nearer by at most the way that it has gone in
between, as the body sees it, and no point of a rigid slave goes farther than a corner of its box.
So a few exact distances, taken where they can be least, bound all others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.masters.nearness import nearest
from contiga.num import pose
from contiga.num.rigid import to_body
from contiga.records import FloatArray
from contiga.simulation.checks.scene import Pair

# Distances that are worked out at most, and the share of the least by which it may be off.
_MOST = 40
_CLOSE = 1e-3


class Approach(NamedTuple):
    """Where a slave is nearest to a body."""

    distance: float
    point: int
    """Row of the slave."""
    time: float


class _Nearest:
    """The least distance of a slave's active points, at one time after the other."""

    def __init__(self, pair: Pair) -> None:
        self._pair = pair
        self._rows = np.flatnonzero(pair.slave.active).astype(np.int32)
        self._bounds = np.zeros(0)

    def at(self, time: float, way: float, best: float) -> tuple[float, int]:
        """Distance and point at `time`, of those that may be nearer than `best`; `way` is how far
        points have gone since the first time that was asked for."""
        points, X_WB = self._pair.standing(time)
        p_B = to_body(X_WB, points)
        rows = self._rows
        if len(self._bounds):
            rows = rows[self._bounds[rows] - way < best]
        if len(rows) == 0:
            return best, -1
        found = nearest(self._pair.body.surface, p_B, rows)
        if len(self._bounds) == 0:
            self._bounds = found.bounds
        return found.gap, found.row


def closest_approach(pair: Pair) -> Approach:
    """Where the slave's active points are nearest to the body, over the planned times."""
    times, corners = _corner_ways(pair)
    ways = np.full(len(times), np.inf)
    bound = np.full(len(times), -np.inf)
    done = np.zeros(len(times), dtype=bool)
    least = _Nearest(pair)
    best = Approach(np.inf, 0, float(times[0]))
    at = 0
    for _ in range(min(_MOST, len(times))):
        distance, point = least.at(float(times[at]), float(ways[at]), best.distance)
        if distance < best.distance:
            best = Approach(distance, point, float(times[at]))
        done[at] = True
        if corners is not None:
            way = np.sqrt(np.square(corners - corners[at]).sum(axis=2)).max(axis=1)
            ways = np.minimum(ways, way) if at == 0 else ways
            # No point is nearer than the best: those left out cannot be.
            bound = np.maximum(bound, best.distance - way)
        left = np.where(done, np.inf, bound)
        at = int(np.argmin(left))
        if not left[at] < (1.0 - _CLOSE) * best.distance:
            break
    return best


def _corner_ways(pair: Pair) -> tuple[FloatArray, FloatArray | None]:
    """Times to look at, and (k, 8, 3) where the corners of the slave's box are then, body axes;
    None, and fewer times, where its points move apart from each other."""
    if pair.relative is None:
        return pair.shown_times, None
    low, high = pair.slave.bounds()
    pick = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    box = np.where(pick == 1, high, low)
    return pair.times, np.array([pose.apply(X, box) for X in pair.relative])
