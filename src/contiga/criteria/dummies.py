"""Sizes of dummies that criteria need: intercepts of the neck, size and scale of the chest."""

from __future__ import annotations

from typing import NamedTuple

from contiga.criteria.neck import HYBRID_III_5, HYBRID_III_50, NeckLimits


class Dummy(NamedTuple):
    """One dummy."""

    neck: NeckLimits | None
    """For `nij`; none where the criterion is not defined."""
    chest_scale: float
    chest_depth: float
    """m; both for `vc` (SAE J1727)."""


DUMMIES = {
    "HIII-50": Dummy(HYBRID_III_50, 1.3, 0.229),
    "HIII-5": Dummy(HYBRID_III_5, 1.3, 0.187),
    "EuroSID": Dummy(None, 1.0, 0.140),
}
"""Hybrid III mid-size male and small female, EuroSID, by the names that sensors take."""
