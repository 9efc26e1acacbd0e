"""Filters and injury criteria of crash tests, from sampled signals.

>>> import numpy as np
>>> times = np.linspace(0.0, 0.02, 201)
>>> pulse = 80.0 * np.sin(np.pi * times / 0.02)
>>> round(hic(pulse, times).value, 1), round(clip(pulse, times).value, 2)
(474.7, 77.79)
>>> round(float(cfc(pulse, 1e-4, 1000).max()), 2)
80.0
"""

from __future__ import annotations

from contiga.criteria.filters import cfc
from contiga.criteria.head_injury import HIC, hic, hicd
from contiga.criteria.held_level import Clip, clip

__all__ = ["HIC", "Clip", "cfc", "clip", "hic", "hicd"]
