"""Filters and injury criteria of crash tests, from sampled signals.

Question: how severe is this signal? Functions take arrays of samples only. Read `samples` (checks
of signals), `filters`, `head_injury` with `pairs`, `held_level`, `brain`, `chest`, `neck`, `femur`,
`dummies` (data of their sizes), `bands` and `rating`.

>>> import numpy as np
>>> times = np.linspace(0.0, 0.02, 201)
>>> pulse = 80.0 * np.sin(np.pi * times / 0.02)
>>> round(hic(pulse, times).value, 1), round(clip(pulse, times).value, 2)
(474.7, 77.79)
>>> round(float(cfc(pulse, 1e-4, 1000).max()), 2)
80.0
"""

from __future__ import annotations

from contiga.criteria.bands import Bands
from contiga.criteria.brain import BrIC, bric
from contiga.criteria.chest import Viscous, vc
from contiga.criteria.femur import FemurForce, femur_force
from contiga.criteria.filters import cfc
from contiga.criteria.head_injury import HIC, hic, hicd
from contiga.criteria.held_level import Clip, clip
from contiga.criteria.neck import HYBRID_III_5, HYBRID_III_50, NeckLimits, Nij, nij
from contiga.criteria.rating import Rating, iso18571

__all__ = [
    "HIC",
    "HYBRID_III_5",
    "HYBRID_III_50",
    "Bands",
    "BrIC",
    "Clip",
    "FemurForce",
    "NeckLimits",
    "Nij",
    "Rating",
    "Viscous",
    "bric",
    "cfc",
    "clip",
    "femur_force",
    "hic",
    "hicd",
    "iso18571",
    "nij",
    "vc",
]
