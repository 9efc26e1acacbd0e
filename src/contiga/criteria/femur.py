"""The femur force criterion: compression over the time that it is held."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.criteria.held_level import clip
from contiga.criteria.samples import numbers

SHORT_LIMIT, LONG_LIMIT, LONG_DURATION = 9070.0, 7580.0, 0.010
"""Limits at once and for long, N, and the long duration, s: the limit falls linearly up to it, and
is constant for longer times (UN R94, 5.2.1.6)."""
_DURATIONS = np.linspace(0.0, LONG_DURATION, 41)


class FemurForce(NamedTuple):
    """Force on a femur, and its criterion."""

    peak: float
    """Largest compression, N."""
    held: float
    """Largest compression that is held for 10 ms, N; 0 of a signal that is shorter."""
    ratio: float
    """Largest ratio of a held compression to the limit for its duration, at 0, 0.25, …, 10 ms."""


def femur_force(force: ArrayLike, t_s: ArrayLike, *, cumulative: bool = True) -> FemurForce:
    """Return the peak, the level held for 10 ms, and the largest ratio to the limit of UN R94.

    The limit is 9.07 kN at once, falls linearly to 7.58 kN for 10 ms, and is constant for longer
    durations. The level held for a duration is that of `clip`; the ratio is the largest at
    durations of 0, 0.25, …, 10 ms, as far as the signal is long. Tension counts as zero.

    Parameters
    ----------
    force : (n,) axial force, tension positive, N, filtered by CFC600
    t_s : (n,) times in seconds, rising
    cumulative : all times above a level count together, not the longest only

    Raises
    ------
    InputError
        Lists of different lengths, not finite or of fewer than two samples, times that do not rise.

    >>> femur_force([-3790.0, -3790.0], [0.0, 0.02]).ratio
    0.5
    """
    compression = np.maximum(-numbers(force, "femur_force, force"), 0.0)
    times = numbers(t_s, "femur_force, t_s")
    length = float(times[-1] - times[0]) if times.ndim == 1 and len(times) > 1 else 0.0
    durations = _DURATIONS[(_DURATIONS > 0.0) & (min(length, LONG_DURATION) >= _DURATIONS)]
    peak = clip(compression, times, max(1e-12 * length, 1e-300), cumulative=cumulative).value
    levels = [peak]
    levels += [clip(compression, times, d, cumulative=cumulative).value for d in durations]
    shares = np.array([0.0, *durations])
    limits = SHORT_LIMIT + (LONG_LIMIT - SHORT_LIMIT) * shares / LONG_DURATION
    held = levels[-1] if len(durations) and durations[-1] == LONG_DURATION else 0.0
    return FemurForce(float(compression.max()), held, float((levels / limits).max()))
