"""Colours as numbers, without matplotlib, whose import takes as long as a picture."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray
from contiga.report.style import SCALE

_STEPS = 256
"""Number of colours of a colour map of matplotlib."""


def channels(colour: str) -> FloatArray:
    """Return red, green and blue (3,) from 0 to 1.

    >>> channels("#ff0033").tolist()
    [1.0, 0.0, 0.2]
    """
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0


def scale_colours(share: FloatArray) -> FloatArray:
    """Return red, green and blue (k, 3) at shares (k,) of `SCALE`, in 256 steps as `colour_map`.

    Shares below 0 and NaN have the first colour, shares above 1 the last.
    """
    stops = np.array([channels(colour) for colour in SCALE])
    places, steps = np.linspace(0.0, 1.0, len(stops)), np.linspace(0.0, 1.0, _STEPS)
    table = np.stack([np.interp(steps, places, of) for of in stops.T], axis=1)
    at = np.fmin(np.fmax(share * _STEPS, 0.0), _STEPS - 1.0)
    return np.asarray(table[at.astype(np.intp)])
