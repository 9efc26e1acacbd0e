"""These functions ask for feet of some rows of points, and copy them between records."""

from __future__ import annotations

import numpy as np

from contiga.arrays import codes
from contiga.arrays.ordered import row_lengths
from contiga.contact.search_records import BoolArray, Detected, Options
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    empty_projection,
)
from contiga.statuses import Status


def blank(n: int) -> Projection:
    """Make the feet of n points that have none."""
    feet = Projection._make(map(np.zeros_like, empty_projection(n)))
    feet.patch[:] = feet.feature[:] = -1
    return feet


def take(feet: Projection, rows: IndexArray, out: Projection, keep: BoolArray) -> None:
    """Write the rows of `out` that are kept into `rows` of `feet`."""
    for name in Projection._fields:
        getattr(feet, name)[rows[keep]] = getattr(out, name)[keep]


def closest(
    surface: Surface, p_B: FloatArray, rows: IntArray, within: FloatArray | None = None
) -> Projection:
    """Find the closest points of p_B[rows], one row an entry of `rows`; see `Surface.closest`."""
    out = empty_projection(len(rows))
    points = np.ascontiguousarray(p_B[rows])
    surface.closest(points, np.arange(len(rows), dtype=np.int32), out, within)
    return out


def follow(
    surface: Surface, path: tuple[FloatArray | None, FloatArray], start: tuple[IntArray, FloatArray]
) -> Projection:
    """Continue feet of points that went along `path` = (before, now) from `start` = (patch, uv).

    Without a before feet are not certified. Those that fail are the closest points.
    """
    before, p_B = path
    patch, uv = start
    out = empty_projection(len(p_B))
    surface.track(p_B, patch, np.ascontiguousarray(uv), out, before)
    failed = np.flatnonzero(out.status == codes.MAX_ITERATIONS).astype(np.int32)
    if len(failed):
        surface.closest(p_B, failed, out)
    return out


def at_border(feet: Projection) -> BoolArray:
    """Tell which feet have come to a border, or to the edge of a hole."""
    there: BoolArray = (feet.status == Status.BORDER) | (feet.status == Status.TRIMMED)
    return there


def continued(feet: Projection) -> ByteArray:
    """Return the `ContactStatus` of points in contact whose feet are kept."""
    status = np.where(at_border(feet), ContactStatus.HELD, ContactStatus.OLD)
    status[feet.status == Status.BRANCH_EVENT] = ContactStatus.REACQUIRED
    return status.astype(np.int8)


def apart(one: Projection, other: Projection) -> FloatArray:
    """Return how far feet of the same points are apart, (n,) length."""
    return row_lengths(one.point - other.point)


def within_depth(out: Projection, options: Options) -> BoolArray:
    """Tell which points a search by penetration takes."""
    inside: BoolArray = (out.status == Status.OK) & (out.gap <= 0.0) & (out.gap >= -options.depth)
    return inside


def free_distance(out: Projection, options: Options) -> FloatArray:
    """Return `safe_distance` of free points by their closest points: zero where none was found.

    By penetration what lies too deep is as far from contact as from that depth.
    """
    skip = max(options.band, options.depth if options.penetration else 0.0)
    safe_distance = np.where(
        out.gap > 0.0,
        np.maximum(out.gap - options.band, 0.0),
        -np.maximum(-out.gap - skip, 0.0),
    )
    return np.where(out.status == Status.OK, safe_distance, 0.0)


def take_inside(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> None:
    """Take points that lie inside, by penetration, with their feet at the closest points."""
    out = closest(surface, p_B, rows)
    keep = within_depth(out, options)
    if options.closed:
        detected.safe_distance[rows] = np.where(keep, -out.gap, free_distance(out, options))
        remember(detected, rows[~keep], out, ~keep)
    else:
        # On either side of an open surface a point is as far from contact as from its reach: in
        # front of one sheet it may lie behind another. A foot not found is looked for again.
        detected.safe_distance[rows] = np.fmax(np.abs(out.gap) - options.depth, 0.0)
    detected.status[rows[keep]] = ContactStatus.NEW
    take(detected.feet, rows, out, keep)


def remember(detected: Detected, rows: IndexArray, feet: Projection, which: BoolArray) -> None:
    """Store the feet of free points, by which the next step proves their sides."""
    detected.last_patch[rows] = feet.patch[which]
    detected.uv[rows] = feet.uv[which]
