"""Records of arrays that the search of a step hands its kernels, and these each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.query_checks import NO_FEET
from contiga.arrays.workspace import Workspace
from contiga.records import (
    ByteArray,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
)
from contiga.search.track.kernels.lanes_nb import RECORD
from contiga.search.track.project import NOWHERE
from contiga.search.track.track_records import Left, Path, room_for


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


class FreeRows(NamedTuple):
    """Free points whose feet are looked for, one row each."""

    which: IntArray
    """Which of the rows that were asked for."""
    patch: IntArray
    """Where each foot is looked for from, with the next."""
    uv: FloatArray
    now: FloatArray
    """(n, 3) body frame."""


class AskedFeet(NamedTuple):
    """Feet that balls may tell of."""

    which: IntArray
    side: ByteArray
    """INNER or OUTER."""


class FootBalls(NamedTuple):
    """Balls that touch at feet."""

    which: IntArray
    """Of the feet, ascending."""
    radius: FloatArray


class Motion(NamedTuple):
    """The places where points were and are."""

    before: FloatArray
    """(n, 3) length, body frame."""
    now: FloatArray


class LastPlaces(NamedTuple):
    """The patches and safe distances of points at the last step."""

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


class Work(NamedTuple):
    """Memory for n rows, of which nothing is kept."""

    rows: IntArray
    side: ByteArray
    reach: FloatArray
    path: Path
    """Of rows that have a foot to start from."""
    starts: SurfacePlaces
    near: SurfacePlaces
    """Pieces of surface in the cells of points."""
    feet: Projection
    left: Left
    """Rows that lanes leave to other stages."""
    records: FloatArray
    mark: ByteArray
    asked: IntArray
    """Feet that balls are asked about."""
    which: ByteArray
    """On which side."""
    radius: FloatArray
    chosen: IntArray
    clear: NDArray[np.bool_]
    within: FloatArray
    none: NDArray[np.bool_]
    """False throughout."""

    @classmethod
    def of(cls, n: int, certify: bool) -> Work:
        """Allocate memory for n rows, whose feet are certified or not."""
        before, now = np.empty((2, n, 3))
        path = Path(before if certify else NOWHERE, now, NO_FEET)
        (rows, asked, chosen), (side, mark, which) = np.empty((3, n), np.int32), _bytes(3, n)
        reach, radius, within = np.empty((3, n))
        return cls(
            *(rows, side, reach, path, _starts(n), _starts(n), empty_projection(n), room_for(n)),
            *(
                Workspace().rows(n, RECORD),
                mark,
                asked,
                which,
                radius,
                chosen,
                np.empty(n, np.bool_),
            ),
            *(within, np.zeros(n, np.bool_)),
        )


class DeepRows(NamedTuple):
    """Memory for n rows whose closest points are asked for, of which nothing is kept."""

    asked: Asked
    now: FloatArray
    """(n, 3) the points, body frame."""
    which: IntArray
    """0 to n − 1."""

    @classmethod
    def of(cls, n: int) -> DeepRows:
        """Allocate memory for n rows."""
        (was, kept, opposed), (status, side) = np.empty((3, n), np.bool_), _bytes(2, n)
        (safe, within, depth), (guard, now) = np.empty((3, n)), np.empty((2, n, 3))
        rows = np.empty(n, np.int32)
        feet, truth = empty_projection(n), empty_projection(n)
        held = guard, depth, opposed
        asked = Asked(rows, was, kept, status, side, safe, within, *held, feet, truth)
        return cls(asked, now, np.arange(n, dtype=np.int32))


def _bytes(count: int, n: int) -> ByteArray:
    return np.empty((count, n), np.int8)


def _starts(n: int) -> SurfacePlaces:
    return SurfacePlaces(np.empty(n, np.int32), np.empty((n, 2)))
