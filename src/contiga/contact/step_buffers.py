"""Memory for steps with few points in contact, laid out once for kernels that do all at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.jit.pinned import Pinned
from contiga.masters.protocol import Master, Surface
from contiga.pointer_records import pass_by_pointer
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


@pass_by_pointer
class Asked(NamedTuple):
    """Points to be judged, one row each."""

    rows: IntArray
    was: NDArray[np.bool_]
    """In contact before."""
    kept: NDArray[np.bool_]
    """In contact before, with a foot that would do."""
    status: ByteArray
    """What the foot would make of a point that is kept."""
    side: ByteArray
    """1 outside, −1 inside, 0 not known."""
    safe_distance: FloatArray
    """Way to the surface at least, where the side is known."""
    within: FloatArray
    """Distance to a point of the surface, infinite where none is known."""
    guard: FloatArray
    """(n, 3) normals that tell which walls are opposite to those that were in contact, else 0."""
    depth: FloatArray
    """(n,) how deep those were, else 0."""
    opposed: NDArray[np.bool_]
    """(n,) whose nearest walls were opposite to those that held them."""
    feet: Projection
    """The feet that would do; then those of all points inside."""
    truth: Projection
    """The closest points, of the rows that are asked for them; status −1 in others."""

    @classmethod
    def of(cls, n: int) -> Asked:
        """For n points, with nothing filled in."""
        flags, codes, lengths = np.empty((2, n), np.bool_), np.empty((2, n), np.int8), (2, n)
        feet = empty_projection(n), empty_projection(n)
        own = (
            np.empty(n, np.int32),
            *flags,
            *codes,
            *np.empty(lengths),
            np.empty((n, 3)),
            np.empty(n),
            np.empty(n, np.bool_),
            *feet,
        )
        return cls._make(own)

    def first(self, n: int) -> Asked:
        """The first n of them."""
        *columns, feet, truth = self
        both = (Projection._make(values[:n] for values in part) for part in (feet, truth))
        return Asked._make((*(values[:n] for values in columns), *both))


@pass_by_pointer
class Carried(NamedTuple):
    """What is known of points in contact before forces, a row each; see `ContactRows`."""

    depth: FloatArray
    normal: FloatArray
    foot: FloatArray
    path: FloatArray
    old: NDArray[np.bool_]
    rate: FloatArray

    @classmethod
    def of(cls, n: int) -> Carried:
        """For n points, with nothing filled in."""
        old, rate = np.empty(n, np.bool_), np.empty(n)
        return cls._make((np.empty(n), *np.empty((3, n, 3)), old, rate))


@pass_by_pointer
class StepBuffers(NamedTuple):
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
    doubtful: Asked
    """Twice as many: those in contact, and free ones."""
    stand: FloatArray
    """(2 n, 3) where these are."""
    needed: IntArray
    """(2 n,) those of them whose closest points are looked for."""
    within: FloatArray
    """(2 n,) how far these are at most."""
    carried: Carried
    """Those in contact after the step: of as many."""
    counts: IndexArray
    """(1, 2) how many points are listed."""

    @classmethod
    def of(cls, n: int) -> StepBuffers:
        """For n points."""
        rows, patch, ways, way, asked = np.empty((5, n), np.int32)
        side, own_side, mark, which = np.empty((4, n), np.int8)
        reach, own_reach, radius = np.empty((3, n))
        uv, spot, before, now = *np.empty((2, n, 2)), *np.empty((2, n, 3))
        clear = np.empty(n, np.bool_)
        own = rows, own_side, own_reach, patch, uv, spot, before, now
        feet = empty_projection(n), mark, ways, way, clear, asked, which, radius
        nobody, counts = empty_projection(0), np.zeros((1, 2), np.int64)
        doubtful = Asked.of(2 * n), np.empty((2 * n, 3)), np.empty(2 * n, np.int32)
        last = np.empty(2 * n), Carried.of(2 * n), counts
        return cls._make((side, reach, *own, *feet, nobody, *doubtful, *last))


class Small:
    """The buffers of one step at a time, and where the search of its body is in memory."""

    def __init__(self) -> None:
        self.buffers = StepBuffers.of(MOST)
        self._pinned = Pinned(self.buffers)
        self._search: tuple[Pinned, ...] | None = None
        self._master: Master | None = None
        self._surface: Surface | None = None
        self._places: tuple[int, ...] = ()

    def of(self, master: Master) -> tuple[int, ...] | None:
        """The places of the surface of a closed master, which is asked for once."""
        if self._master is not master:
            self._master = master
            return self.places(master.surface, False)
        return None if self._search is None else self._places

    def places(self, surface: Surface, with_balls: bool) -> tuple[int, ...] | None:
        """Addresses of the search of a closed surface (see `Surface.pinned_parts`) and of the
        buffers; None of one of which nothing is done at once."""
        if self._surface is not surface or with_balls:
            self._surface, self._search = surface, surface.pinned_parts(with_balls)
            self._places = tuple(part.address for part in (*(self._search or ()), self._pinned))
        return None if self._search is None else self._places
