"""Tracking with the body's tables and the feet resident on a GPU: a seam, not yet a backend.

A thread takes one point from its last foot to the next proved one (`row_nb`: the mathematics are
those of the CPU's lanes). What it cannot finish it flags: past borders and creases, near trims that
the bounds kept of the surroundings do not clear, of degrees above three, off their element's next
neighbour. Those rows alone come back and take the CPU's way (`contiga.search.track.project.track`).

Run under the simulator of CUDA only, where the feet are those of the CPU; on no GPU yet. Nothing
else of the library comes by here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.device import check_device, launch, on_host, resident
from contiga.arrays.layout import as_points
from contiga.errors import InputError
from contiga.records import FloatArray, IntArray, Projection, SurfacePlaces, empty_projection
from contiga.search.hierarchy.table_types import Tables
from contiga.search.track import project
from contiga.search.track.kernels import row_nb
from contiga.search.track.track_records import FlaggedFeet, RowStarts, Way


class FlatTables(NamedTuple):
    """What of `Tables` a thread reads: arrays of records and numbers, no pointers between them."""

    elements: Any
    grid: Any
    trims: Any
    rings: Any
    scale: Any


class Tracked(NamedTuple):
    """Feet of n points that stay on the device from step to step."""

    tables: Tables
    """Of the body, for the rows that come back."""
    flat: FlatTables
    """The same, on the device."""
    feet: Any
    """The members of a `Projection`, on the device."""
    before: Any
    """(n, 3) where the points are, on the device."""


def start(tables: Tables, feet: Projection, points: ArrayLike) -> Tracked:
    """Put the tables of a body on the device, with the feet of `points` (n, 3), body frame.

    Raises
    ------
    MissingPackageError, RunError
        No kernels can be launched here (`contiga.arrays.device.check_device`).
    InputError
        `feet` and `points` are not of the same number.
    """
    check_device()
    p_B = _points(points, len(feet.gap))
    return Tracked(tables, flat(tables), resident(feet), resident(p_B))


def flat(tables: Tables) -> FlatTables:
    """What threads read of the tables, on the device."""
    read = FlatTables(tables.elements, tables.grid, tables.trims, tables.rings, tables.scale)
    return FlatTables(*resident(read))


def track(tracked: Tracked, points: ArrayLike) -> tuple[Tracked, IntArray]:
    """The feet one step on, of the points at `points` (n, 3), body frame; certified where they can.

    Returns the new state, and which rows the CPU did. The feet of the state that was handed in are
    overwritten.
    """
    n = len(tracked.before)
    p_B = _points(points, n)
    now, back = resident((p_B, np.zeros(n, np.uint8)))
    way, results = Way(tracked.before, now), FlaggedFeet(tracked.feet, back)
    launch(row_nb.track_row, n, tracked.flat, way, results)
    rows = np.flatnonzero(on_host(back)).astype(np.int32)
    if len(rows):
        _by_the_cpu(tracked, rows, p_B[rows])
    return tracked._replace(before=now), rows


def feet_of(tracked: Tracked) -> Projection:
    """A copy of the feet, on the host."""
    return Projection(*on_host(tracked.feet))


def _by_the_cpu(tracked: Tracked, rows: IntArray, p_B: FloatArray) -> None:
    """Track some rows on the CPU; only these are copied to and fro."""
    m = len(rows)
    there = resident(rows)
    starts = resident(RowStarts(np.empty(m, np.int32), np.empty((m, 2)), np.empty((m, 3))))
    feet = RowStarts(tracked.feet.patch, tracked.feet.uv, tracked.before)
    launch(row_nb.gather_row, m, feet, there, starts)
    patch, uv, before = on_host(starts)
    out = empty_projection(m)
    project.track(tracked.tables, p_B, SurfacePlaces(patch, uv), out, before)
    launch(row_nb.scatter_row, m, resident(out), there, tracked.feet)


def _points(points: ArrayLike, n: int) -> FloatArray:
    p_B = as_points(points)
    if len(p_B) != n:
        raise InputError(
            "points must have one row a foot",
            where="points",
            found=p_B.shape,
            allowed=f"({n}, 3)",
        )
    return p_B
