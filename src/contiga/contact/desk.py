"""Memory for steps with few points in contact, laid out once for kernels that do all at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.handed import by_reference
from contiga.masters.protocol import Surface
from contiga.num.resident import Resident
from contiga.records import (
    ByteArray,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    empty_projection,
)

MOST = 128
"""Points in contact that are few. Of more the calls are no longer what takes the time."""


@by_reference
class Desk(NamedTuple):
    """What is worked out of the points in contact on the way, a row each; nothing of it is kept."""

    side: ByteArray
    """With the next of all of them, then of those that are not outside."""
    reach: FloatArray
    rows: IntArray
    own_side: ByteArray
    own_reach: FloatArray
    patch: IntArray
    uv: FloatArray
    spot: FloatArray
    before: FloatArray
    now: FloatArray
    feet: Projection
    flags: NDArray[np.uint8]
    mark: ByteArray
    ways: IntArray
    """The rows whose ways are looked at; then those that are left."""
    way: IntArray
    clear: NDArray[np.bool_]
    asked: IntArray
    """With the next two of those that balls may tell of."""
    which: ByteArray
    radius: FloatArray
    nobody: Projection
    """Feet of no points."""
    counts: IndexArray
    """(1, 2) how many points are listed."""

    @classmethod
    def of(cls, n: int) -> Desk:
        """For n points."""
        rows, patch, ways, way, asked = np.empty((5, n), np.int32)
        side, own_side, mark, which = np.empty((4, n), np.int8)
        reach, own_reach, radius = np.empty((3, n))
        uv, spot, before, now = *np.empty((2, n, 2)), *np.empty((2, n, 3))
        flags, clear = np.empty(n, np.uint8), np.empty(n, np.bool_)
        own = rows, own_side, own_reach, patch, uv, spot, before, now
        told = empty_projection(n), flags, mark, ways, way, clear, asked, which, radius
        nobody, counts = empty_projection(0), np.zeros((1, 2), np.int64)
        return cls._make((side, reach, *own, *told, nobody, counts))


class Small:
    """The desk of one step at a time, and where the search of its body is in memory."""

    def __init__(self) -> None:
        self.desk = Desk.of(MOST)
        self._resident = Resident(self.desk)
        self._search: tuple[Resident, ...] | None = None
        self._surface: Surface | None = None
        self._places: tuple[int, ...] = ()

    def places(self, surface: Surface, with_balls: bool) -> tuple[int, ...] | None:
        """Where the search of a closed surface stands (see `Surface.residents`), and the desk;
        None of one of which nothing is done at once."""
        if self._surface is not surface or with_balls:
            self._surface, self._search = surface, surface.residents(with_balls)
            self._places = tuple(part.place for part in (*(self._search or ()), self._resident))
        return None if self._search is None else self._places
