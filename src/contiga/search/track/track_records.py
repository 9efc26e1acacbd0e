"""Records of the stages of tracking, one row a point."""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np

from contiga.pointer_records import pass_by_pointer
from contiga.records import ByteArray, FloatArray, IntArray, Projection

MAX_KEPT_ROWS = 2**16
"""Largest number of rows of a buffer that is kept: its allocation takes a third of the tracking."""


class Path(NamedTuple):
    """Previous and present points; without the previous ones no foot is certified."""

    before: FloatArray
    """(n, 3) length, body frame; no rows if they are unknown, or given by `feet`."""
    now: FloatArray
    """(n, 3) length, body frame."""
    feet: Projection
    """The previous feet, which give the previous points; no rows if they are not used."""


@pass_by_pointer
class PendingRows(NamedTuple):
    """Rows that a stage leaves to the next ones, with copies of their starts.

    The new feet may overwrite the feet that they are continued from.
    """

    rows: IntArray
    """(m,) int32."""
    flags: IntArray
    """(m,) uint8, the next task of the row (`contiga.arrays.codes.TO_…`), 0 if it has a foot."""
    before: FloatArray
    """(m, 3) previous points; undefined if they are unknown."""
    patch: IntArray
    """(m,) int32 of the start."""
    uv: FloatArray
    """(m, 2) of the start."""


class PendingBuffer(threading.local):
    """Memory for pending rows, kept by the thread from one call to the next."""

    def __init__(self) -> None:
        self._pending = empty_pending(0)

    def of(self, n: int) -> PendingRows:
        """Return memory for at least n rows; the thread may use it until the next call."""
        if n > MAX_KEPT_ROWS:
            return empty_pending(n)
        if n > len(self._pending.rows):
            self._pending = empty_pending(n)
        return self._pending


def empty_pending(n: int) -> PendingRows:
    """Return uninitialised memory for n rows."""
    return PendingRows(
        np.empty(n, np.int32),
        np.empty(n, np.uint8),
        np.empty((n, 3)),
        np.empty(n, np.int32),
        np.empty((n, 2)),
    )


class FeetBefore(NamedTuple):
    """The columns of the previous feet that give the previous points; as in `Projection`."""

    status: ByteArray
    point: FloatArray
    gap: FloatArray
    normal: FloatArray


class Chunk(NamedTuple):
    """Rows that are tracked together."""

    first: int
    last: int
    """One past the last."""


class Waiting(NamedTuple):
    """Feet that wait until there are enough of them for a block of lanes."""

    lanes: FloatArray
    """The banks."""
    slots: IntArray
    """(3, N_LANES) row, element of the start and present element of each."""


class PointMotion(NamedTuple):
    """Previous and present points."""

    before: Any
    """(n, 3) length, body frame, on a device or not."""
    now: Any


class FlaggedFeet(NamedTuple):
    """Feet, with flags of the rows that are left to the CPU."""

    feet: Any
    """A `Projection`, on a device or not."""
    back: Any
    """(n,) flags."""


class RowStarts(NamedTuple):
    """The starts from which rows are tracked, on a device or not."""

    patch: Any
    """(n,)."""
    uv: Any
    """(n, 2)."""
    before: Any
    """(n, 3) previous points, length, body frame."""
    now: Any
    """(n, 3) present points."""
