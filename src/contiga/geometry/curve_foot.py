"""Closest points of a curve in space, for many points near it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray

PER_SPAN = 24
"""Samples of each knot span the search starts from, times the degree."""
ROUNDS = 30
MANY = 2_000_000
"""Pairs of a point and a sample from which on a tree is faster than to look at all."""
CLOSED = 1e-9
SHORT = 1e-15
"""Steps below this share of the parameters, or of the coordinates, are rounding."""


class CurveFeet:
    """Parameters of the closest points of `curve`, by samples and safeguarded Newton steps."""

    def __init__(self, curve: NurbsCurve) -> None:
        self.curve = curve
        breaks = np.unique(curve.knots)
        low, high = curve.domain
        breaks = breaks[(breaks >= low) & (breaks <= high)]
        n = PER_SPAN * max(1, curve.degree)
        parts = [np.linspace(a, b, n + 1)[:-1] for a, b in pairwise(breaks)]
        self._t = np.append(np.concatenate(parts), high)
        self._p = curve.evaluate(self._t)
        ends = np.abs(self._p[-1] - self._p[0]).max()
        self.period = high - low if ends <= CLOSED * np.ptp(self._p, axis=0).max() else 0.0
        """Length of the domain of a closed curve, else 0."""

    def __call__(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (n,) parameters and (n,) distances."""
        best = self._nearer_end(points, self._nearest(points))
        low = self._t[np.maximum(best - 1, 0)]
        high = self._t[np.minimum(best + 1, len(self._t) - 1)]
        t = self._t[best].copy()
        rounding = SHORT * float(np.abs(points).max(initial=0.0))
        for _ in range(ROUNDS):
            d = self.curve.derivatives(t, 2)
            r = d[:, 0] - points
            slope = (r * d[:, 1]).sum(axis=1)
            speed = (d[:, 1] ** 2).sum(axis=1)
            bend = speed + (r * d[:, 2]).sum(axis=1)
            low, high = np.where(slope < 0.0, t, low), np.where(slope > 0.0, t, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                new = t - slope / bend
            new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
            step = np.abs(new - t)
            done = (step <= SHORT * np.abs(t).max(initial=1.0)) | (
                step * np.sqrt(speed) <= rounding
            )
            t = new
            if done.all():
                break
        return t, np.linalg.norm(self.curve.evaluate(t) - points, axis=1)

    def _nearest(self, points: FloatArray) -> np.ndarray:
        """Return (n,) the sample that is nearest to each point."""
        if len(points) * len(self._p) > MANY:
            from scipy.spatial import cKDTree  # which takes as long to load as numba

            return np.asarray(cKDTree(self._p).query(points)[1])
        square = np.zeros((len(points), len(self._p)))
        for axis in range(3):
            square += np.subtract.outer(points[:, axis], self._p[:, axis]) ** 2
        return np.asarray(square.argmin(axis=1))

    def _nearer_end(self, points: FloatArray, best: np.ndarray) -> np.ndarray:
        """`best`, but at the seam of a closed curve that end of it which the foot is next to."""
        if not self.period:
            return best
        last = len(self._t) - 1
        after = np.linalg.norm(points - self._p[1], axis=1)
        before = np.linalg.norm(points - self._p[-2], axis=1)
        return np.where(best % last == 0, np.where(after < before, 0, last), best)
