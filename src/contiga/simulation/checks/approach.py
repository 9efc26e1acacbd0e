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

# Parts of a span between two planned times.
_FINER = 8
# Distances that are worked out at most, and the share of the least by which it may be off; a bound
# above that other share of it shows that there is a distance.
_MOST = 60
_CLOSE = 1e-3
_SURE = 0.5


class Approach(NamedTuple):
    """Where a slave is nearest to a body."""

    distance: float
    point: int
    """Row of the slave."""
    time: float


class _Ways:
    """How far points of a slave go, at most, as the body sees them, and how near they are."""

    def __init__(self, pair: Pair) -> None:
        self._pair = pair
        self._rows = np.flatnonzero(pair.slave.active).astype(np.int32)
        self._bounds = np.zeros(0)
        low, high = pair.slave.bounds()
        pick = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
        self._box = np.where(pick == 1, high, low)

    def along(self, times: FloatArray) -> FloatArray:
        """(k,) way gone until each of `times` since the first one, by the corner that goes most."""
        poses = [self._pair.relative_at(float(time)) for time in times]
        corners = np.array([pose.apply(X, self._box) for X in poses if X is not None])
        steps = np.sqrt(np.square(np.diff(corners, axis=0)).sum(axis=2)).max(axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def nearest(self, time: float, gone: float, guess: int) -> Approach:
        """The nearest point at `time`; `gone` is how far points have gone since the first time
        that was asked for, `guess` one that is near."""
        points, X_WB = self._pair.standing(time)
        p_B, surface = to_body(X_WB, points), self._pair.body.surface
        rows = self._rows
        if len(self._bounds):
            near = nearest(surface, p_B, np.array([guess], np.int32)).gap
            rows = rows[self._bounds[rows] - gone <= near]
        found = nearest(surface, p_B, rows)
        if len(self._bounds) == 0:
            self._bounds = found.bounds
        return Approach(found.gap, found.row, time)


class _Span(NamedTuple):
    """A part of the time, with the distances at its ends."""

    times: FloatArray
    """(k,) between which the way is taken for even."""
    gone: FloatArray
    """(k,) way gone since the start of the run."""
    first: float
    last: float

    @property
    def least(self) -> float:
        """No point is nearer in between: each distance changes by no more than the way."""
        return 0.5 * (self.first + self.last - (self.gone[-1] - self.gone[0]))

    def parted(self, ways: _Ways) -> tuple[FloatArray, FloatArray, int]:
        """Times and ways with one inside, and the one in the middle of the way."""
        times, gone = self.times, self.gone
        if len(times) == 2:
            times = np.linspace(times[0], times[1], _FINER + 1)
            gone = gone[0] + ways.along(times)
        middle = int(np.searchsorted(gone, 0.5 * (gone[0] + gone[-1])))
        return times, gone, min(max(middle, 1), len(times) - 2)


def closest_approach(pair: Pair) -> Approach | None:
    """Where the slave's active points are nearest to the body, over all the time of the run.

    None where they may touch: where no bound shows that they do not.
    """
    ways, times = _Ways(pair), pair.times
    if pair.relative_at(float(times[0])) is None:
        # Points that move apart from each other: where they are read.
        return min(ways.nearest(time, np.inf, 0) for time in pair.shown_times.tolist())
    gone = ways.along(times)
    start = ways.nearest(float(times[0]), 0.0, 0)
    end = ways.nearest(float(times[-1]), float(gone[-1]), start.point)
    best = min(start, end)
    spans = [_Span(times, gone, start.distance, end.distance)]
    for _ in range(_MOST):
        if best.distance <= 0.0:
            return None
        widest = int(np.argmin([one.least for one in spans]))
        if spans[widest].least > (1.0 - _CLOSE) * best.distance:
            break
        span = spans.pop(widest)
        times, gone, m = span.parted(ways)
        now = ways.nearest(float(times[m]), float(gone[m]), best.point)
        best = min(best, now)
        spans.append(_Span(times[: m + 1], gone[: m + 1], span.first, now.distance))
        spans.append(_Span(times[m:], gone[m:], now.distance, span.last))
    return best if min(one.least for one in spans) > _SURE * best.distance else None
