"""Bound the least distance between a slave and a body over a whole motion.

Distance is 1-Lipschitz: at another time a point is nearer by at most the way that it has gone in
between, as the body sees it, and no point of a rigid slave goes farther than a corner of its box.
So a few exact distances, taken where they can be least, bound all others. Ways are those along the
path, by velocities: what comes back to where it was, or turns round wholly, has gone far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.masters.nearness import lower_bounds, nearest
from contiga.records import FloatArray
from contiga.rigid import pose
from contiga.rigid.frames import to_body
from contiga.simulation.checks.scene import INSTANT, Pair

# Parts of a span between two planned times.
_FINER = 8
# Distances that are worked out at most, and the share of the least by which it may be off; a bound
# above that other share of it shows that there is a distance.
_MAX_ITERATIONS = 60
_CLOSE = 1e-3
_SURE = 0.5
# Share by which a distance may be off that is looked for, and times the least that was seen from
# which on a bound is as good: far from a body all points are about as near, and each takes long.
_SEEN = 0.25 * _CLOSE
_PLAIN = 2.0
# What the turns in a span add to a way at most.
_TURNING = 1.001


class Approach(NamedTuple):
    """The nearest approach of a slave to a body."""

    distance: float
    """The least that was seen."""
    point: int
    """Row of the slave."""
    time: float
    bound: float = 0.0
    """No point is ever nearer, but for a thousandth; 0 of a sample, which shows none."""


class _Ways:
    """Upper bounds of how far points of a slave go in the body's axes, and their distances."""

    def __init__(self, pair: Pair) -> None:
        self._pair = pair
        self._rows = np.flatnonzero(pair.slave.active).astype(np.int32)
        self._bounds = np.zeros(0)
        low, high = pair.slave.bounds()
        pick = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
        self._box = np.where(pick == 1, high, low)

    def along(self, times: FloatArray) -> FloatArray:
        """Return upper bounds (k,) of the way of any point from the first of `times` to each one.

        The way is that of the corner of the slave's box that goes farthest.

        Between two of them no table has a row and nothing turns far, so that a velocity v is about
        quadratic: ∫|v| dt is at most h (|v₀| + |v₁|)/2 + 2/3 h |v_½ − (v₀ + v₁)/2|.
        """
        spans = np.diff(times)
        least = INSTANT * spans
        first, half, last = (
            (self._corners(at + least) - self._corners(at)) / least[:, None, None]
            for at in (times[:-1], 0.5 * (times[:-1] + times[1:]), times[1:] - least)
        )
        mean, off = 0.5 * (_lengths(first) + _lengths(last)), half - 0.5 * (first + last)
        speeds = (mean + 2.0 / 3.0 * _lengths(off)).max(axis=1)
        return np.concatenate([[0.0], np.cumsum(_TURNING * spans * speeds)])

    def _corners(self, times: FloatArray) -> FloatArray:
        """Return the corners of the slave's box (k, 8, 3) in the body's axes."""
        poses = [self._pair.relative_at(time) for time in times.tolist()]
        return np.array([pose.apply(X, self._box) for X in poses if X is not None])

    def nearest(self, time: float, gone: float, guess: int, least: float = np.inf) -> Approach:
        """Return the nearest point at `time`, with a lower bound of all distances at that time.

        `gone` is the way of points since the first time asked for, `guess` a point that is
        near. Where all points are clearly farther than `least`, the bound stands in place
        of the distance.
        """
        points, X_WB = self._pair.standing(time)
        p_B, surface = to_body(X_WB, points), self._pair.body.surface
        rows = self._rows
        if least < np.inf:
            bounds = lower_bounds(surface, p_B, rows, None)[rows]
            at = int(bounds.argmin())
            if bounds[at] > _PLAIN * least:
                return Approach(float(bounds[at]), int(rows[at]), time, float(bounds[at]))
        if len(self._bounds):
            near = nearest(surface, p_B, np.array([guess], np.int32)).gap
            rows = rows[self._bounds[rows] - gone <= near]
        closest = nearest(surface, p_B, rows, share=_SEEN)
        if len(self._bounds) == 0:
            self._bounds = closest.bounds
        return Approach(closest.gap, closest.row, time, (1.0 - _SEEN) * closest.gap)


class _Span(NamedTuple):
    """A part of the run, with lower bounds of the distances at its two ends."""

    times: FloatArray
    """(k,) between which the way is taken for even."""
    gone: FloatArray
    """(k,) way gone since the start of the run."""
    first: float
    last: float

    @property
    def least(self) -> float:
        """Lower bound of all distances between the two times, from the way gone."""
        return 0.5 * (self.first + self.last - (self.gone[-1] - self.gone[0]))

    def parted(self, ways: _Ways) -> tuple[FloatArray, FloatArray, int]:
        """Return times and ways with one at least in between, and the row at half of the way."""
        times, gone = self.times, self.gone
        if len(times) == 2:
            times = np.linspace(times[0], times[1], _FINER + 1)
            gone = gone[0] + ways.along(times)
        middle = int(np.searchsorted(gone, 0.5 * (gone[0] + gone[-1])))
        return times, gone, min(max(middle, 1), len(times) - 2)


def closest_approach(pair: Pair) -> Approach | None:
    """Return where the slave's active points are nearest to the body in the whole run.

    None where they may touch, since no bound shows that they do not. Where points move apart
    from each other, it is a sample.

    None where they may touch: where no bound shows that they do not. A sample where points move
    apart from each other.
    """
    ways, times = _Ways(pair), pair.times
    if pair.relative_at(float(times[0])) is None:
        # Where they are read: nobody knows how they go in between.
        seen = (ways.nearest(time, np.inf, 0) for time in pair.shown_times.tolist())
        return min(seen)._replace(bound=0.0)
    if not pair.followed:
        return None
    gone = ways.along(times)
    start = ways.nearest(float(times[0]), 0.0, 0)
    end = ways.nearest(float(times[-1]), float(gone[-1]), start.point, start.distance)
    best = min(start, end)
    spans = [_Span(times, gone, start.bound, end.bound)]
    for _ in range(_MAX_ITERATIONS):
        if best.distance <= 0.0:
            return None
        widest = int(np.argmin([one.least for one in spans]))
        if spans[widest].least > (1.0 - _CLOSE) * best.distance:
            break
        span = spans.pop(widest)
        times, gone, m = span.parted(ways)
        now = ways.nearest(float(times[m]), float(gone[m]), best.point, best.distance)
        best = min(best, now)
        spans.append(_Span(times[: m + 1], gone[: m + 1], span.first, now.bound))
        spans.append(_Span(times[m:], gone[m:], now.bound, span.last))
    bound = min(one.least for one in spans)
    if bound > (1.0 - _CLOSE) * best.distance:
        return best._replace(bound=best.distance)
    return best._replace(bound=bound) if bound > _SURE * best.distance else None


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.square(vectors).sum(axis=2)))
