"""Bound the smallest distance between a slave and a body over a whole motion.

Distance is 1-Lipschitz: between two times it changes by at most the path length of a point relative
to the body, and no point of a rigid slave moves farther than a corner of its box. So a few exact
distances, at times where they can be smallest, bound all others. Path lengths are integrals of
speeds: a point that returns, or makes a full turn, has a long path.
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
_PARTS_PER_SPAN = 8
# Largest number of exact distances, relative error of the smallest distance, and the share of it
# above which a bound proves a distance.
_MAX_ITERATIONS = 60
_DISTANCE_TOL = 1e-3
_BOUND_SHARE = 0.5
# Relative error of a computed distance, and the multiple of the smallest distance so far from which
# a bound is enough: far from a body all points are equally near, and each takes long.
_SEARCH_TOL = 0.25 * _DISTANCE_TOL
_FAR_FACTOR = 2.0
# Factor on path lengths for the rotation within a span.
_ROTATION_FACTOR = 1.001


class Approach(NamedTuple):
    """The nearest approach of a slave to a body."""

    distance: float
    """Smallest distance found."""
    point: int
    """Row of the slave."""
    time: float
    """Time of the approach."""
    bound: float = 0.0
    """Lower bound over the whole run, within a thousandth; 0 for a sample, which proves none."""


class _PathBounds:
    """Upper bounds of path lengths of a slave's points in the body's axes, and their distances."""

    def __init__(self, pair: Pair) -> None:
        self._pair = pair
        self._rows = np.flatnonzero(pair.slave.active).astype(np.int32)
        self._bounds = np.zeros(0)
        low, high = pair.slave.bounds()
        pick = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
        self._box = np.where(pick == 1, high, low)

    def along(self, times: FloatArray) -> FloatArray:
        """Return upper bounds (k,) of the path length of any point from the first of `times`.

        They are those of the corner of the slave's box with the longest path. Between two times no
        table has a row and rotations are small, so that a velocity v is about quadratic: ∫|v| dt is
        at most h (|v₀| + |v₁|)/2 + 2/3 h |v_½ − (v₀ + v₁)/2|.
        """
        spans = np.diff(times)
        instant = INSTANT * spans
        speed_start, speed_middle, speed_end = (
            (self._corners(at + instant) - self._corners(at)) / instant[:, None, None]
            for at in (times[:-1], 0.5 * (times[:-1] + times[1:]), times[1:] - instant)
        )
        mean, deviation = (
            0.5 * (_lengths(speed_start) + _lengths(speed_end)),
            speed_middle - 0.5 * (speed_start + speed_end),
        )
        speeds = (mean + 2.0 / 3.0 * _lengths(deviation)).max(axis=1)
        return np.concatenate([[0.0], np.cumsum(_ROTATION_FACTOR * spans * speeds)])

    def _corners(self, times: FloatArray) -> FloatArray:
        """Return the corners of the slave's box (k, 8, 3) in the body's axes."""
        poses = [self._pair.relative_at(time) for time in times.tolist()]
        return np.array([pose.apply(X, self._box) for X in poses if X is not None])

    def nearest(
        self, time: float, path_length: float, guess: int, least_so_far: float = np.inf
    ) -> Approach:
        """Return the nearest point at `time`, with a lower bound of all distances at that time.

        `path_length` is that of points since the first call, whose bounds of all points are kept,
        so that later calls search only points that may be nearest. `guess` is a point that is near.
        If all points are farther than `_FAR_FACTOR` times `least_so_far`, the bound replaces the
        distance.
        """
        points, X_WB = self._pair.placement(time)
        p_B, surface = to_body(X_WB, points), self._pair.body.surface
        rows = self._rows
        if least_so_far < np.inf:
            bounds = lower_bounds(surface, p_B, rows, None)[rows]
            row = int(bounds.argmin())
            if bounds[row] > _FAR_FACTOR * least_so_far:
                return Approach(float(bounds[row]), int(rows[row]), time, float(bounds[row]))
        if len(self._bounds):
            guess_distance = nearest(surface, p_B, np.array([guess], np.int32)).gap
            rows = rows[self._bounds[rows] - path_length <= guess_distance]
        closest = nearest(surface, p_B, rows, share=_SEARCH_TOL)
        if len(self._bounds) == 0:
            self._bounds = closest.bounds
        return Approach(closest.gap, closest.row, time, (1.0 - _SEARCH_TOL) * closest.gap)


class _Span(NamedTuple):
    """A part of the run, with lower bounds of the distances at its two ends."""

    times: FloatArray
    """(k,) times, between which the path length is taken as linear."""
    path_lengths: FloatArray
    """(k,) path lengths since the start of the run."""
    first: float
    """Lower bound of the distances at the first time, length."""
    last: float
    """Lower bound of the distances at the last time, length."""

    @property
    def least(self) -> float:
        """Lower bound of all distances between the two times, by the path lengths."""
        return 0.5 * (self.first + self.last - (self.path_lengths[-1] - self.path_lengths[0]))

    def split(self, path_bounds: _PathBounds) -> tuple[FloatArray, FloatArray, int]:
        """Return times and path lengths (k,) of the span, and an inner row near half of the path.

        A span of two times gets more in between.
        """
        times, path_lengths = self.times, self.path_lengths
        if len(times) == 2:
            times = np.linspace(times[0], times[1], _PARTS_PER_SPAN + 1)
            path_lengths = path_lengths[0] + path_bounds.along(times)
        middle = int(np.searchsorted(path_lengths, 0.5 * (path_lengths[0] + path_lengths[-1])))
        return times, path_lengths, min(max(middle, 1), len(times) - 2)


def closest_approach(pair: Pair) -> Approach | None:
    """Return the nearest approach of the slave's active points to the body in the whole run.

    It is None if no lower bound above `_BOUND_SHARE` of the distance proves that they never touch,
    or if the run has too many times to follow. A slave that deforms, or whose motion has points of
    its own, is only sampled: the result is the smallest distance at `shown_times`, with `bound` 0,
    and never None. The slave needs an active point.
    """
    path_bounds, times = _PathBounds(pair), pair.times
    if pair.relative_at(float(times[0])) is None:
        # Points read from a file: their paths in between are unknown.
        samples = (path_bounds.nearest(time, np.inf, 0) for time in pair.shown_times.tolist())
        return min(samples)._replace(bound=0.0)
    if not pair.followed:
        return None
    path_lengths = path_bounds.along(times)
    start = path_bounds.nearest(float(times[0]), 0.0, 0)
    end = path_bounds.nearest(
        float(times[-1]), float(path_lengths[-1]), start.point, start.distance
    )
    best = min(start, end)
    spans = [_Span(times, path_lengths, start.bound, end.bound)]
    for _ in range(_MAX_ITERATIONS):
        if best.distance <= 0.0:
            return None
        least_span = int(np.argmin([span.least for span in spans]))
        if spans[least_span].least > (1.0 - _DISTANCE_TOL) * best.distance:
            break
        span = spans.pop(least_span)
        times, path_lengths, m = span.split(path_bounds)
        now = path_bounds.nearest(
            float(times[m]), float(path_lengths[m]), best.point, best.distance
        )
        best = min(best, now)
        spans.append(_Span(times[: m + 1], path_lengths[: m + 1], span.first, now.bound))
        spans.append(_Span(times[m:], path_lengths[m:], now.bound, span.last))
    bound = min(span.least for span in spans)
    if bound > (1.0 - _DISTANCE_TOL) * best.distance:
        return best._replace(bound=best.distance)
    return best._replace(bound=bound) if bound > _BOUND_SHARE * best.distance else None


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.square(vectors).sum(axis=2)))
