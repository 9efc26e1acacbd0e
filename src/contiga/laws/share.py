"""Sharing of one total force among the points in contact (thesis, Eq. 3.3)."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def share(total: float, penetration: FloatArray, area: FloatArray) -> FloatArray:
    """Share the force `total`: F_i = F λ_i A_i / Σ_j λ_j A_j (Eq. 3.3).

    Parameters
    ----------
    total : force F
    penetration, area : (n,) λ_i ≥ 0 and A_i ≥ 0

    Returns
    -------
    (n,) forces whose sum is `total` to rounding; empty where there are no points.

    Notes
    -----
    If Σ λ_j A_j = 0, the force is shared by penetration alone; if all penetrations are zero, by
    area alone; if all areas are zero as well, equally.
    """
    if penetration.size == 0:
        return np.zeros(0)
    depth, extent = _relative(penetration), _relative(area)
    for weight in (depth * extent, depth, extent):
        sum_of_weights = float(weight.sum())
        if sum_of_weights > 0.0:
            shares: FloatArray = total * (weight / sum_of_weights)
            return shares
    return np.full(penetration.shape, total / penetration.size)


def _relative(values: FloatArray) -> FloatArray:
    """Return values over their largest, so that a product of two tiny numbers does not vanish."""
    largest = float(values.max())
    return values / largest if largest > 0.0 else np.zeros_like(values)
