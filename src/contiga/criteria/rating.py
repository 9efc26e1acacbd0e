"""Objective rating of a signal against a test signal, by ISO/TS 18571.

The package objective-rating-metrics (Vehicle Safety Institute, TU Graz) computes the scores of
corridor, phase, magnitude (by dynamic time warping) and slope.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.criteria.samples import checked_signal
from contiga.errors import InputError
from contiga.extras import require

SAMPLE_RATE = 10_000.0
"""Sample rate of the standard, 1/s."""
MIN_SAMPLES = 10
"""Smallest number of samples: the slope is averaged over nine of them."""
MAX_SAMPLES = 5000
"""Largest number of samples: dynamic time warping needs its square in memory."""
_GRADES = ((0.94, "excellent"), (0.80, "good"), (0.58, "fair"))


class Rating(NamedTuple):
    """Scores from 0 (nothing alike) to 1 (the same)."""

    corridor: float
    """Mean score in corridors about the test: 1 inside the inner, 0 outside the outer one."""
    phase: float
    """Score of the time shift with the largest cross-correlation."""
    magnitude: float
    """Score of the difference of the shifted and warped signals."""
    slope: float
    """Score of the difference of the derivatives of the shifted signals."""
    overall: float
    """0.4 corridor + 0.2 phase + 0.2 magnitude + 0.2 slope."""

    @property
    def grade(self) -> str:
        """Grade: "excellent" above 0.94, "good" above 0.80, "fair" above 0.58, else "poor"."""
        return next((grade for above, grade in _GRADES if self.overall > above), "poor")


def iso18571(
    reference: ArrayLike, signal: ArrayLike, t_s: ArrayLike, t_reference_s: ArrayLike | None = None
) -> Rating:
    """Return the scores of a signal against a test signal, by ISO/TS 18571.

    Both are interpolated linearly to 10 kHz over their common time. Pass only the times to rate,
    and signals of the same filter.

    Parameters
    ----------
    reference : (m,) signal of the test
    signal : (n,) signal to rate, in the same unit
    t_s : (n,) times of the signal, seconds
    t_reference_s : (m,) times of the test, seconds; `t_s` if omitted

    Returns
    -------
    Rating
        corridor, phase, magnitude, slope and overall score, from 0 to 1

    Raises
    ------
    InputError
        Times that do not rise, values that are not finite, a common time below 1 ms or above 0.5 s,
        or a constant signal.
    MissingPackageError
        objective-rating-metrics is not installed.
    """
    require("a rating by ISO/TS 18571", "objective_rating_metrics")
    where, test_t_s = "iso18571", t_s if t_reference_s is None else t_reference_s
    values, times = checked_signal(signal, t_s, where, ("signal", "t_s"))
    test, test_times = checked_signal(reference, test_t_s, where, ("reference", "t_reference_s"))
    start, end = max(times[0], test_times[0]), min(times[-1], test_times[-1])
    count = int(np.floor((end - start) * SAMPLE_RATE + 1e-6)) + 1
    if not MIN_SAMPLES <= count <= MAX_SAMPLES:
        raise InputError(
            "the common time of both signals cannot be rated",
            where=where,
            found=f"{start:g} to {end:g} s" if count > 0 else "none",
            allowed=f"{MIN_SAMPLES / SAMPLE_RATE:g} to {MAX_SAMPLES / SAMPLE_RATE:g} s",
        )
    grid = start + np.arange(count) / SAMPLE_RATE
    resampled = np.interp(grid, times, values), np.interp(grid, test_times, test)
    for name, samples in zip(("signal", "reference"), resampled, strict=True):
        if np.ptp(samples) <= 1e-9 * np.abs(samples).max():
            raise InputError("a constant signal has no rating", where=f"{where}, {name}")
    from objective_rating_metrics.rating import ISO18571

    curve, test_curve = (np.column_stack([grid, samples]) for samples in resampled)
    rating = ISO18571(reference_curve=test_curve, comparison_curve=curve, dt=1.0 / SAMPLE_RATE)
    scores = (
        *(rating.corridor_rating(-1), rating.phase_rating(-1), rating.magnitude_rating(-1)),
        *(rating.slope_rating(-1), rating.overall_rating(-1)),
    )
    return Rating(*map(float, scores))
