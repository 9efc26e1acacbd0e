"""Data of dummies for criteria: intercepts of the neck, depth and scale of the chest."""

from __future__ import annotations

from typing import NamedTuple

from contiga.criteria.neck import HYBRID_III_5, HYBRID_III_50, NeckLimits


class Dummy(NamedTuple):
    """One dummy."""

    neck: NeckLimits | None
    """Intercepts for `nij`; None if the criterion is not defined for this dummy."""
    chest_scale: float
    """Scale for `vc` (SAE J1727)."""
    chest_depth: float
    """Depth for `vc`, m."""


DUMMIES = {
    "HIII-50": Dummy(HYBRID_III_50, 1.3, 0.229),
    "HIII-5": Dummy(HYBRID_III_5, 1.3, 0.187),
    "EuroSID": Dummy(None, 1.0, 0.140),
}
"""Hybrid III mid-size male and small female, EuroSID, by the names that sensors take."""
