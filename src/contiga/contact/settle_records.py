"""Define records of arrays for the kernels of the search of a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.query_checks import NO_PROJECTION
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
from contiga.search.track.kernels.lanes_nb import RECORD_SIZE
from contiga.search.track.project import NO_POINTS
from contiga.search.track.track_records import Path, PendingRows, empty_pending


class TouchingRows(NamedTuple):
    """Points that were in contact and are not outside, one row each."""

    rows: IntArray
    side: ByteArray
    """−1 inside, 0 unknown."""
    reach: FloatArray
    """Radius about the point without any surface, length, if the side is known."""
    patch: IntArray
    """Patch of the last foot; `uv` are its parameters."""
    uv: FloatArray
    before: FloatArray
    """(n, 3) positions before the step, body frame; no rows if not needed."""
    now: FloatArray


class FreeRows(NamedTuple):
    """Free points whose feet are searched, one row each."""

    rows: IntArray
    """Numbers of the points among those of the call."""
    patch: IntArray
    """Patch where the search of a foot starts; `uv` are its parameters."""
    uv: FloatArray
    now: FloatArray
    """(n, 3) body frame."""


class BallQueries(NamedTuple):
    """Feet at which touching balls are looked up."""

    feet: IntArray
    """Numbers of the feet, ascending."""
    side: ByteArray
    """INNER or OUTER."""


class FootBalls(NamedTuple):
    """Radii of the balls that touch at feet."""

    feet: IntArray
    """Numbers of the feet, ascending."""
    radius: FloatArray


class Motion(NamedTuple):
    """Positions of points before and after a step."""

    before: FloatArray
    """(n, 3) length, body frame."""
    now: FloatArray
    """(n, 3)."""


class LastPlaces(NamedTuple):
    """The patches and safe distances of points at the last step."""

    patch: IntArray
    """(n,) patch of the foot, −1 without contact."""
    safe_distance: FloatArray
    """(n,)."""
    active: NDArray[np.bool_]
    """(n,)."""


class ChunkLists(NamedTuple):
    """Lists of rows that chunks fill, each from its own first row."""

    rows: IntArray
    """(n,)."""
    counts: IndexArray
    """(chunks,) number of rows in each list."""


class Candidates(NamedTuple):
    """Points whose status is to be decided, one row each."""

    rows: IntArray
    was_touching: NDArray[np.bool_]
    """Whether each was in contact before."""
    is_kept: NDArray[np.bool_]
    """Whether each was in contact before, with a foot that may be kept."""
    status: ByteArray
    """`ContactStatus` of a point whose foot is kept."""
    side: ByteArray
    """1 outside, −1 inside, 0 unknown."""
    safe_distance: FloatArray
    """Lower bound of the distance to the surface, if the side is known."""
    max_distance: FloatArray
    """Upper bound of the distance to the surface, infinite if unknown."""
    guard: FloatArray
    """(n, 3) guards of points that were in contact; zero for others."""
    depth: FloatArray
    """(n,) penetrations of points that were in contact; zero for others."""
    is_opposed: NDArray[np.bool_]
    """(n,) whether the nearest wall was opposite to the one that held the point."""
    feet: Projection
    """Feet that may be kept; at the end those of all points inside."""
    closest: Projection
    """Closest points of the rows that were searched; status −1 in others."""


class Work(NamedTuple):
    """Work arrays for n rows."""

    rows: IntArray
    side: ByteArray
    reach: FloatArray
    path: Path
    """Paths of rows with a starting foot."""
    starts: SurfacePlaces
    cell_places: SurfacePlaces
    """Places on the surface near the cells of points."""
    feet: Projection
    unsolved: PendingRows
    """Rows that lanes leave to other stages."""
    records: FloatArray
    mark: ByteArray
    ball_feet: IntArray
    """Feet at which touching balls are looked up."""
    ball_sides: ByteArray
    """Sides of these balls, INNER or OUTER."""
    radius: FloatArray
    unsettled: IntArray
    """Rows that are not settled."""
    is_clear: NDArray[np.bool_]
    max_distance: FloatArray
    none: NDArray[np.bool_]
    """False throughout."""

    @classmethod
    def of(cls, n: int, certify: bool) -> Work:
        """Allocate work arrays for n rows; to `certify` feet, with positions before the step."""
        before, now = np.empty((2, n, 3))
        rows, ball_feet, unsettled = np.empty((3, n), np.int32)
        side, mark, ball_sides = np.empty((3, n), np.int8)
        reach, radius, max_distance = np.empty((3, n))
        starts, cell_places = (
            SurfacePlaces(np.empty(n, np.int32), np.empty((n, 2))) for _ in range(2)
        )
        return cls(
            rows=rows,
            side=side,
            reach=reach,
            path=Path(before if certify else NO_POINTS, now, NO_PROJECTION),
            starts=starts,
            cell_places=cell_places,
            feet=empty_projection(n),
            unsolved=empty_pending(n),
            records=Workspace().rows(n, RECORD_SIZE),
            mark=mark,
            ball_feet=ball_feet,
            ball_sides=ball_sides,
            radius=radius,
            unsettled=unsettled,
            is_clear=np.empty(n, np.bool_),
            max_distance=max_distance,
            none=np.zeros(n, np.bool_),
        )


class DeepRows(NamedTuple):
    """Work arrays for n rows whose closest points are searched."""

    candidates: Candidates
    now: FloatArray
    """(n, 3) the points, body frame."""
    rows: IntArray
    """0 to n − 1."""

    @classmethod
    def of(cls, n: int) -> DeepRows:
        """Allocate work arrays for n rows."""
        was_touching, is_kept, is_opposed = np.empty((3, n), np.bool_)
        status, side = np.empty((2, n), np.int8)
        safe_distance, max_distance, depth = np.empty((3, n))
        guard, now = np.empty((2, n, 3))
        candidates = Candidates(
            rows=np.empty(n, np.int32),
            was_touching=was_touching,
            is_kept=is_kept,
            status=status,
            side=side,
            safe_distance=safe_distance,
            max_distance=max_distance,
            guard=guard,
            depth=depth,
            is_opposed=is_opposed,
            feet=empty_projection(n),
            closest=empty_projection(n),
        )
        return cls(candidates, now, np.arange(n, dtype=np.int32))
