"""Look up tables that are linear between their rows and constant outside: pieces and slopes."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def piece_at(times: FloatArray, t: float) -> int | None:
    """Return the piece between two of `times` that has the rate at `t`; None outside.

    At a row it is the piece that begins there, at the last row the one that ends there.
    """
    if len(times) < 2 or not times[0] <= t <= times[-1]:
        return None
    return min(int(np.searchsorted(times, t, side="right")), len(times) - 1) - 1


def rate_at(times: FloatArray, rows: FloatArray, t: float) -> FloatArray:
    """Slope at `t` of what is linear between its `rows` (n, ...), zero outside."""
    k = piece_at(times, t)
    if k is None:
        return np.zeros(rows.shape[1:])
    return np.asarray((rows[k + 1] - rows[k]) / (times[k + 1] - times[k]))
