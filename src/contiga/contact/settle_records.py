"""What the kernels hand each other that settle points: records of arrays to be filled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import ByteArray, FloatArray, IndexArray, IntArray


class TouchingRows(NamedTuple):
    """Points in contact that are not outside, one row each."""

    rows: IntArray
    side: ByteArray
    reach: FloatArray
    patch: IntArray
    """Of the foot that each had, with the next."""
    uv: FloatArray
    before: FloatArray
    """(n, 3) where they were, body frame; no rows where nobody asks."""
    now: FloatArray

    @classmethod
    def of(cls, n: int) -> TouchingRows:
        """Memory for n rows."""
        (rows, patch), (before, now) = np.empty((2, n), np.int32), np.empty((2, n, 3))
        return cls(rows, np.empty(n, np.int8), np.empty(n), patch, np.empty((n, 2)), before, now)

    def first(self, n: int) -> TouchingRows:
        """The first n rows."""
        return TouchingRows._make(column[:n] for column in self)


class FreeRows(NamedTuple):
    """Free points whose feet are looked for, one row each."""

    which: IntArray
    """Which of the rows that were asked for."""
    patch: IntArray
    """Where each foot is looked for from, with the next."""
    uv: FloatArray
    now: FloatArray
    """(n, 3) body frame."""

    @classmethod
    def of(cls, n: int) -> FreeRows:
        """Memory for n rows."""
        which, patch = np.empty((2, n), np.int32)
        return cls(which, patch, np.empty((n, 2)), np.empty((n, 3)))

    def first(self, n: int) -> FreeRows:
        """The first n rows."""
        return FreeRows._make(column[:n] for column in self)


class AskedFeet(NamedTuple):
    """Feet that balls may tell of."""

    which: IntArray
    side: ByteArray
    """INNER or OUTER."""

    @classmethod
    def of(cls, n: int) -> AskedFeet:
        """Memory for n feet."""
        return cls(np.empty(n, np.int32), np.empty(n, np.int8))

    def first(self, n: int) -> AskedFeet:
        """The first n feet."""
        return AskedFeet(self.which[:n], self.side[:n])


class FootBalls(NamedTuple):
    """Balls that touch at feet."""

    which: IntArray
    """Of the feet, ascending."""
    radius: FloatArray


class Motion(NamedTuple):
    """Where points were and are."""

    before: FloatArray
    """(n, 3) length, body frame."""
    now: FloatArray


class LastPlaces(NamedTuple):
    """What is known of points from the last step."""

    patch: IntArray
    """(n,) −1 out of contact."""
    safe_distance: FloatArray
    """(n,)."""
    active: NDArray[np.bool_]
    """(n,)."""


class ChunkLists(NamedTuple):
    """Rows that chunks list, each from its own place on."""

    rows: IntArray
    """(n,)."""
    counts: IndexArray
    """(chunks,) how many each has listed."""
