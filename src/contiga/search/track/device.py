"""Tracking with the body's tables and the feet resident on a GPU: an interface, not yet a backend.

A thread continues one point from its last foot to the next proved one (`row_nb`, with the
mathematics of the CPU's lanes). It flags rows that it cannot finish: past borders and creases, near
trims that the neighbourhood does not exclude, of degrees above three, beyond the neighbours of
their element. Only these rows come back, to the CPU (`contiga.search.track.project.track`).

No other part of the library uses this module.
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
from contiga.search.track.track_records import FlaggedFeet, PointMotion, RowStarts


class FlatTables(NamedTuple):
    """The part of `Tables` that a thread reads: arrays, without pointers between them."""

    elements: Any
    grid: Any
    trims: Any
    neighbourhoods: Any
    scale: Any


class Tracked(NamedTuple):
    """Feet of n points that stay on the device from step to step."""

    tables: Tables
    """Tables of the body on the host, for the rows that come back."""
    flat: FlatTables
    """The part of these tables on the device."""
    feet: Any
    """The members of a `Projection`, on the device."""
    before: Any
    """(n, 3) present points, on the device."""
    back: Any
    """(n,) uint8 flags on the device: 1 for the rows of the last step that the CPU did, else 0."""


def start(tables: Tables, feet: Projection, points: Any) -> Tracked:
    """Put the tables of a body and the feet of `points` (n, 3), body frame, on the device.

    Returns the state for `track`.

    Raises
    ------
    MissingPackageError, RunError
        No kernels can be launched here (`contiga.arrays.device.check_device`).
    InputError
        `feet` and `points` differ in number.
    """
    check_device()
    n = len(feet.gap)
    p_B, tables = _on_device(points, n), with_neighbourhoods(tables)
    return Tracked(tables, flat(tables), resident(feet), p_B, resident(np.zeros(n, np.uint8)))


def flat(tables: Tables) -> FlatTables:
    """Return the part of the tables that threads read, as arrays on the device."""
    return FlatTables(*resident(FlatTables(*(getattr(tables, f) for f in FlatTables._fields))))


def track(tracked: Tracked, points: Any) -> tuple[Tracked, IntArray]:
    """Continue the feet to `points` (n, 3), body frame, and certify them as far as possible.

    `points` may be on the device already, as C-contiguous float64. They are not copied but kept for
    the next step: write its points to other memory.

    Returns the new state, and the indices (m,) of the rows that the CPU did. The feet of the given
    state are overwritten.
    """
    now = _on_device(points, len(tracked.before))
    start_on_device(tracked, now)
    return finish_on_host(tracked, now)


def start_on_device(tracked: Tracked, now: Any) -> None:
    """Start the device's part of a step, without waiting for it.

    It overwrites finished rows of `tracked.feet` and flags the others in `tracked.back`. `now`
    (n, 3) is on the device.
    """
    motion, results = PointMotion(tracked.before, now), FlaggedFeet(tracked.feet, tracked.back)
    launch(row_nb.track_row, len(tracked.before), tracked.flat, motion, results)


def finish_on_host(tracked: Tracked, now: Any) -> tuple[Tracked, IntArray]:
    """Finish the step on the CPU for the flagged rows; return the result of `track`.

    Only these rows are copied between host and device; they are overwritten in `tracked.feet`.
    """
    # The flags are fetched as one bit each.
    packed_on_device = resident(np.empty(ceil(len(tracked.back) / 8), np.uint8))
    launch(row_nb.pack_flags, len(packed_on_device), tracked.back, packed_on_device)
    packed = on_host(packed_on_device)
    bytes_with_flags = np.flatnonzero(packed)
    bits = np.unpackbits(packed[bytes_with_flags, None], axis=1, bitorder="little").astype(bool)
    rows = (8 * bytes_with_flags[:, None] + np.arange(8))[bits].astype(np.int32)
    m = len(rows)
    if m:
        rows_on_device = resident(rows)
        starts = resident(
            RowStarts(np.empty(m, np.int32), np.empty((m, 2)), np.empty((m, 3)), np.empty((m, 3)))
        )
        feet = RowStarts(tracked.feet.patch, tracked.feet.uv, tracked.before, now)
        launch(row_nb.gather_row, m, feet, rows_on_device, starts)
        patch, uv, before, p_B = on_host(starts)
        out = empty_projection(m)
        project.track(tracked.tables, p_B, SurfacePlaces(patch, uv), out, before)
        launch(row_nb.scatter_row, m, resident(out), rows_on_device, tracked.feet)
    return tracked._replace(before=now), rows


def feet_of(tracked: Tracked) -> Projection:
    """Return a copy of the feet on the host."""
    return Projection(*on_host(tracked.feet))


def _on_device(points: Any, n: int) -> Any:
    """Return points (n, 3) on the device, copied if they are on the host."""
    p_B = points if is_resident(points) else as_points(points)
    if p_B.shape != (n, 3):
        raise InputError(
            "points must have one row a foot",
            where="points",
            found=p_B.shape,
            allowed=f"({n}, 3)",
        )
    return resident(p_B)
