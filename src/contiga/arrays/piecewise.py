"""Pieces and slopes of tables that are linear between their rows and constant outside."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray


def piece_at(times: FloatArray, t: float) -> int | None:
    """Return the number of the piece between ascending `times` that contains `t`; None outside.

    At a time the next piece counts, at the last time the last piece. Less than two times have no
    piece.
    """
    if len(times) < 2 or not times[0] <= t <= times[-1]:
        return None
    return min(int(np.searchsorted(times, t, side="right")), len(times) - 1) - 1


def rate_at(times: FloatArray, rows: FloatArray, t: float) -> FloatArray:
    """Return the slope at `t` of a table that is linear between its `rows` (n, …).

    It is zero outside; at a time it is the slope of the piece of `piece_at`.
    """
    k = piece_at(times, t)
    if k is None:
        return np.zeros(rows.shape[1:])
    return np.asarray((rows[k + 1] - rows[k]) / (times[k + 1] - times[k]))
