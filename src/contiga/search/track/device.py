"""Tracking with the body's tables and the feet resident on a GPU: a seam, not yet a backend.

A thread takes one point from its last foot to the next proved one (`row_nb`: the mathematics are
those of the CPU's lanes). What it cannot finish it flags: past borders and creases, near trims that
the bounds kept of the surroundings do not clear, of degrees above three, off their element's next
neighbour. Those rows alone come back and take the CPU's way (`contiga.search.track.project.track`).

Nothing else of the library comes by here.
"""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.device import check_device, is_resident, launch, on_host, resident
from contiga.arrays.layout import as_points
from contiga.errors import InputError
from contiga.records import IntArray, Projection, SurfacePlaces, empty_projection
from contiga.search.certify.neighbourhoods import with_neighbourhoods
from contiga.search.hierarchy.table_types import Tables
from contiga.search.track import project
from contiga.search.track.kernels import row_nb
from contiga.search.track.track_records import FlaggedFeet, RowStarts, Way


class FlatTables(NamedTuple):
    """The part of `Tables` that a thread reads.

    These are arrays of records and numbers, with no pointers between them.
    """

    elements: Any
    grid: Any
    trims: Any
    neighbourhoods: Any
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
    back: Any
    """(n,) uint8 on the device: the rows of the last step that the CPU did."""


def start(tables: Tables, feet: Projection, points: Any) -> Tracked:
    """Put the tables of a body on the device, with the feet of `points` (n, 3), body frame.

    Raises
    ------
    MissingPackageError, RunError
        No kernels can be launched here (`contiga.arrays.device.check_device`).
    InputError
        `feet` and `points` are not of the same number.
    """
    check_device()
    n = len(feet.gap)
    there, tables = _on_device(points, n), with_neighbourhoods(tables)
    return Tracked(tables, flat(tables), resident(feet), there, resident(np.zeros(n, np.uint8)))


def flat(tables: Tables) -> FlatTables:
    """Put what threads read of the tables on the device."""
    read = FlatTables(
        tables.elements, tables.grid, tables.trims, tables.neighbourhoods, tables.scale
    )
    return FlatTables(*resident(read))


def track(tracked: Tracked, points: Any) -> tuple[Tracked, IntArray]:
    """The feet one step on, of the points at `points` (n, 3), body frame; certified where they can.

    `points` may be on the device already, as C-contiguous float64. They are kept there as they are,
    not copied, for the next step: write its points to other memory.

    Returns the new state, and which rows the CPU did. The feet of the state that was handed in are
    overwritten.
    """
    now = _on_device(points, len(tracked.before))
    track_there(tracked, now)
    return track_left(tracked, now)


def track_there(tracked: Tracked, now: Any) -> None:
    """Start the device's part of a step, without waiting for it.

    It flags in `tracked.back` the rows that it leaves. `now` (n, 3) is on the device.
    """
    way, results = Way(tracked.before, now), FlaggedFeet(tracked.feet, tracked.back)
    launch(row_nb.track_row, len(tracked.before), tracked.flat, way, results)


def track_left(tracked: Tracked, now: Any) -> tuple[Tracked, IntArray]:
    """Finish the step on the CPU for the flagged rows.

    Only these are copied to and fro. It returns what `track` does.
    """
    # A bit a flag is fetched, the flags stay where they are.
    bytes_there = resident(np.empty(ceil(len(tracked.back) / 8), np.uint8))
    launch(row_nb.pack_flags, len(bytes_there), tracked.back, bytes_there)
    packed = on_host(bytes_there)
    some = np.flatnonzero(packed)
    bits = np.unpackbits(packed[some, None], axis=1, bitorder="little").astype(bool)
    rows = (8 * some[:, None] + np.arange(8))[bits].astype(np.int32)
    m = len(rows)
    if m:
        there = resident(rows)
        starts = resident(
            RowStarts(np.empty(m, np.int32), np.empty((m, 2)), np.empty((m, 3)), np.empty((m, 3)))
        )
        feet = RowStarts(tracked.feet.patch, tracked.feet.uv, tracked.before, now)
        launch(row_nb.gather_row, m, feet, there, starts)
        patch, uv, before, p_B = on_host(starts)
        out = empty_projection(m)
        project.track(tracked.tables, p_B, SurfacePlaces(patch, uv), out, before)
        launch(row_nb.scatter_row, m, resident(out), there, tracked.feet)
    return tracked._replace(before=now), rows


def feet_of(tracked: Tracked) -> Projection:
    """A copy of the feet, on the host."""
    return Projection(*on_host(tracked.feet))


def _on_device(points: Any, n: int) -> Any:
    """Points (n, 3) on the device: those given, or a copy of those of the host."""
    p_B = points if is_resident(points) else as_points(points)
    if p_B.shape != (n, 3):
        raise InputError(
            "points must have one row a foot",
            where="points",
            found=p_B.shape,
            allowed=f"({n}, 3)",
        )
    return resident(p_B)
