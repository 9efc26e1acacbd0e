"""Records of arrays that the stages of tracking hand each other, one row a point."""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np

from contiga.pointer_records import pass_by_pointer
from contiga.records import ByteArray, FloatArray, IntArray, Projection

KEPT = 2**16
"""Rows that memory is kept for: to ask for it anew takes as long as to track a third of them."""


class Path(NamedTuple):
    """The places where points were and are.

    Where it is not told where they were, no foot is certified.
    """

    before: FloatArray
    """(n, 3) length, body frame; no rows where that is not told, or by the feet they had."""
    now: FloatArray
    """(n, 3) length, body frame."""
    feet: Projection
    """The feet that the points had, for where they were; no rows where that is not told so."""


@pass_by_pointer
class Left(NamedTuple):
    """Rows that a stage leaves to those after it, with their starts.

    The feet that rows are continued from may be overwritten by those found.
    """

    rows: IntArray
    """(m,) int32."""
    flags: IntArray
    """(m,) uint8: what is to be done (`contiga.arrays.codes.TO_…`), 0 where it is done."""
    before: FloatArray
    """(m, 3) where the points were; read where that is told."""
    patch: IntArray
    """(m,) int32 of the start."""
    uv: FloatArray
    """(m, 2) of the start."""


class Room(threading.local):
    """Memory for rows that are left, kept by the thread from one call to the next."""

    def __init__(self) -> None:
        self._left = room_for(0)

    def of(self, n: int) -> Left:
        """Memory for n rows at least, the thread's until it asks for the next."""
        if n > KEPT:
            return room_for(n)
        if n > len(self._left.rows):
            self._left = room_for(n)
        return self._left


def room_for(n: int) -> Left:
    """Memory for n rows, nothing in it."""
    return Left(
        np.empty(n, np.int32),
        np.empty(n, np.uint8),
        np.empty((n, 3)),
        np.empty(n, np.int32),
        np.empty((n, 2)),
    )


class FeetBefore(NamedTuple):
    """The columns of old feet that tell where points were; as of `Projection`."""

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
    who: IntArray
    """(3, LANES) of each: its row, the element of its start, and the one that it is in."""


class Way(NamedTuple):
    """The places where points were and are."""

    before: Any
    """(n, 3) length, body frame, on a device or not."""
    now: Any


class FlaggedFeet(NamedTuple):
    """Feet, and which of them are left to others."""

    feet: Any
    """A `Projection`, on a device or not."""
    back: Any
    """(n,) flags."""


class RowStarts(NamedTuple):
    """The starts that rows are tracked from, on a device or not."""

    patch: Any
    """(n,)."""
    uv: Any
    """(n, 2)."""
    before: Any
    """(n, 3) where the points were, length, body frame."""
    now: Any
    """(n, 3) where they are."""
