"""Closest points of a curve in space, for many points near it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.records import FloatArray

SAMPLES_PER_SPAN = 24
"""Samples of each knot span from which the search starts, times the degree."""
MAX_STEPS = 30
MIN_PAIRS_FOR_TREE = 2_000_000
"""Number of pairs of a point and a sample from which a tree is faster than all distances."""
CLOSED_TOL = 1e-9
"""Distance of the ends of a closed curve, share of its size."""
STEP_TOL = 1e-15
"""Steps below this share of the parameters, or of the coordinates, are rounding."""


class CurveFeet:
    """Function of points that returns the closest points of `curve`.

    Newton steps, kept in a bracket, start from the nearest of `SAMPLES_PER_SPAN` × degree samples
    of each knot span: a closer point away from that sample is missed.
    """

    def __init__(self, curve: NurbsCurve) -> None:
        self.curve = curve
        breaks = np.unique(curve.knots)
        low, high = curve.domain
        breaks = breaks[(breaks >= low) & (breaks <= high)]
        n = SAMPLES_PER_SPAN * max(1, curve.degree)
        parts = [np.linspace(a, b, n + 1)[:-1] for a, b in pairwise(breaks)]
        self._t = np.append(np.concatenate(parts), high)
        self._p = curve.evaluate(self._t)
        ends = np.abs(self._p[-1] - self._p[0]).max()
        self.period = high - low if ends <= CLOSED_TOL * np.ptp(self._p, axis=0).max() else 0.0
        """Length of the domain of a closed curve, else 0."""

    def __call__(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the parameters (n,) of the feet of points (n, 3) and their distances (n,)."""
        if len(points) * len(self._p) > MIN_PAIRS_FOR_TREE:
            from scipy.spatial import cKDTree  # which takes as long to load as numba

            nearest = np.asarray(cKDTree(self._p).query(points)[1])
        else:
            square = np.zeros((len(points), len(self._p)))
            for axis in range(3):
                square += np.subtract.outer(points[:, axis], self._p[:, axis]) ** 2
            nearest = square.argmin(axis=1)
        if self.period:
            # At the seam of a closed curve the search starts at the end next to the foot.
            last = len(self._t) - 1
            after = np.linalg.norm(points - self._p[1], axis=1)
            before = np.linalg.norm(points - self._p[-2], axis=1)
            nearest = np.where(nearest % last == 0, np.where(after < before, 0, last), nearest)
        low = self._t[np.maximum(nearest - 1, 0)]
        high = self._t[np.minimum(nearest + 1, len(self._t) - 1)]
        t = self._t[nearest].copy()
        rounding = STEP_TOL * float(np.abs(points).max(initial=0.0))
        for _ in range(MAX_STEPS):
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
            done = (step <= STEP_TOL * np.abs(t).max(initial=1.0)) | (
                step * np.sqrt(speed) <= rounding
            )
            t = new
            if done.all():
                break
        return t, np.linalg.norm(self.curve.evaluate(t) - points, axis=1)
