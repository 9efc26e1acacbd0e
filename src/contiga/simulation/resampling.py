"""Resample signals of a run with unequal steps at even times."""

from __future__ import annotations

import numpy as np

from contiga.criteria.filters import MIN_RATE
from contiga.records import FloatArray

FINE = 8 * MIN_RATE
"""Samples per second for each Hz of a filter's class, for unequal steps. Averaging over a sample
attenuates by a part in 4,000 at the frequency where the filter attenuates by 3 dB."""
MAX_SAMPLES = 2_000_000
"""Largest number of samples of a resampled signal."""
_EQUAL_TOL = 1e-6


def even_times(times: FloatArray, longest: float) -> FloatArray:
    """Return even times (m,): `times` themselves, if their intervals are equal to 1e-6.

    Otherwise the first and last time stay, and the interval is at most the median one and at most
    `longest`, unless that takes more than `MAX_SAMPLES`.
    """
    steps = np.diff(times)
    if len(steps) == 0 or np.ptp(steps) <= _EQUAL_TOL * steps.max():
        return times
    step = min(longest, float(np.median(steps)))
    count = min(int(np.ceil((times[-1] - times[0]) / step - _EQUAL_TOL)), MAX_SAMPLES)
    return np.linspace(times[0], times[-1], count + 1)


def trapezoids(times: FloatArray, signal: FloatArray) -> FloatArray:
    """Return the integrals (n - 1, k) of a signal (n, k) over each step (trapezoidal rule)."""
    return np.asarray(0.5 * np.diff(times)[:, None] * (signal[1:] + signal[:-1]))


def means(
    grid: FloatArray, times: FloatArray, signal: FloatArray, impulses: FloatArray
) -> FloatArray:
    """Return the means (m, k) of a signal around each time of `grid`, half way to its neighbours.

    They conserve the integral of the signal, which the trapezoidal rule of the means reproduces.
    Between its own times the signal (n, k) is linear, shifted so that its integral over each step
    is the impulse (n - 1, k).
    """
    borders = np.concatenate([grid[:1], 0.5 * (grid[1:] + grid[:-1]), grid[-1:]])
    row = np.clip(np.searchsorted(times, borders, side="right") - 1, 0, len(times) - 2)
    steps = np.diff(times)[:, None]
    slope = np.diff(signal, axis=0) / steps
    first = impulses / steps - 0.5 * slope * steps
    before = np.concatenate([np.zeros((1, signal.shape[1])), np.cumsum(impulses, axis=0)])
    offset = (borders - times[row])[:, None]
    total = before[row] + offset * (first[row] + 0.5 * offset * slope[row])
    return np.asarray(np.diff(total, axis=0) / np.diff(borders)[:, None])
