"""What kernels that settle the usual points are handed, and work in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.query_checks import NO_FEET
from contiga.arrays.workspace import Workspace
from contiga.contact.asked_records import Asked, JudgeLimits
from contiga.contact.tracked import Options
from contiga.records import (
    ByteArray,
    FloatArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
)
from contiga.search.track.kernels.lanes_nb import RECORD
from contiga.search.track.project import NOWHERE
from contiga.search.track.track_records import Left, Path, room_for

# Feet closer than this, relative to the body's size, are one.
SAME_FOOT = 1e-9


class Limits(NamedTuple):
    """What decides."""

    nearest: bool
    """Whether the nearest wall pushes."""
    hold: bool
    """Whether points are held on borders."""
    band: float
    """Distance below which rounding decides whether a point is inside, length."""
    far: float
    """Way beyond which the last foot of a free point is no longer near by, length."""


def limits_of(options: Options) -> Limits:
    """Of the options of a contact."""
    return Limits(options.nearest, options.hold, options.band, options.far)


def judge_limits_of(options: Options) -> JudgeLimits:
    """Of the options of a contact."""
    same_foot = SAME_FOOT * options.size
    return JudgeLimits(options.penetration, options.nearest, options.band, options.depth, same_foot)


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
        """For n rows, whose feet are certified or not."""
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
    place: IntArray
    """Where rows that are left stand among those asked for, −1 where they do not."""

    @classmethod
    def of(cls, n: int) -> DeepRows:
        """For n rows."""
        (was, kept, opposed), (status, side) = np.empty((3, n), np.bool_), _bytes(2, n)
        (safe, within, depth), (guard, now) = np.empty((3, n)), np.empty((2, n, 3))
        rows, place = np.empty((2, n), np.int32)
        feet, truth = empty_projection(n), empty_projection(n)
        held = guard, depth, opposed
        asked = Asked(rows, was, kept, status, side, safe, within, *held, feet, truth)
        return cls(asked, now, np.arange(n, dtype=np.int32), place)


def _bytes(count: int, n: int) -> ByteArray:
    return np.empty((count, n), np.int8)


def _starts(n: int) -> SurfacePlaces:
    return SurfacePlaces(np.empty(n, np.int32), np.empty((n, 2)))
