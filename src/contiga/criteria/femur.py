"""The femur force criterion: compression against how long it is held."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.criteria.held_level import clip
from contiga.criteria.samples import numbers

AT_ONCE, FOR_LONG, LONG = 9070.0, 7580.0, 0.010
"""N, N and seconds: between them the limit falls along a straight line, beyond it stays (UN R94,
5.2.1.6)."""
_DURATIONS = np.linspace(0.0, LONG, 41)


class FemurForce(NamedTuple):
    """The limits of the force on a femur."""

    peak: float
    """Largest compression, N."""
    held: float
    """Largest compression that is held for 10 ms, N; 0 of a signal that is shorter."""
    ratio: float
    """The most that a compression and how long it is held take of the limit for that time."""


def femur_force(force: ArrayLike, t_s: ArrayLike, *, cumulative: bool = True) -> FemurForce:
    """Peak, 10 ms level, and the share of the femur force criterion of UN R94.

    The limit is 9.07 kN at once and 7.58 kN for 10 ms and longer; a level is held for all the
    times above it together, or for the longest of them.

    Parameters
    ----------
    force : (n,) axial force, tension positive, N, filtered by CFC600
    t_s : (n,) times in seconds, rising
    cumulative : all times above a level count together, not the longest only

    Raises
    ------
    InputError
        Lists that are not as long or not finite, times that do not rise.

    >>> femur_force([-3790.0, -3790.0], [0.0, 0.02]).ratio
    0.5
    """
    compression = np.maximum(-numbers(force, "femur_force, force"), 0.0)
    times = numbers(t_s, "femur_force, t_s")
    whole = float(times[-1] - times[0]) if times.ndim == 1 and len(times) > 1 else 0.0
    asked = _DURATIONS[(_DURATIONS > 0.0) & (min(whole, LONG) >= _DURATIONS)]
    peak = clip(compression, times, max(1e-12 * whole, 1e-300), cumulative=cumulative).value
    levels = [peak] + [clip(compression, times, d, cumulative=cumulative).value for d in asked]
    limits = AT_ONCE + (FOR_LONG - AT_ONCE) * np.array([0.0, *asked]) / LONG
    held = levels[-1] if len(asked) and asked[-1] == LONG else 0.0
    return FemurForce(float(compression.max()), held, float((levels / limits).max()))
