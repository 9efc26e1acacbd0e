"""Search feet for some rows of points, and copy feet between records."""

from __future__ import annotations

import numpy as np

from contiga.arrays import codes
from contiga.arrays.ordered import row_lengths
from contiga.contact.search_records import BoolArray, Detection, Options
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
    """Return records for n points without feet: patch and feature −1, all else zero."""
    feet = Projection._make(map(np.zeros_like, empty_projection(n)))
    feet.patch[:] = feet.feature[:] = -1
    return feet


def copy_feet(
    feet: Projection, rows: IndexArray, source: Projection, mask: BoolArray | None = None
) -> None:
    """Copy rows of `source` (k,) to `rows` (k,) of `feet`: the masked ones, or all of them."""
    chosen = slice(None) if mask is None else mask
    for name in Projection._fields:
        getattr(feet, name)[rows[chosen]] = getattr(source, name)[chosen]


def closest(
    surface: Surface, p_B: FloatArray, rows: IntArray, within: FloatArray | None = None
) -> Projection:
    """Return the closest points of p_B[rows], one row per row; see `Surface.closest`."""
    out = empty_projection(len(rows))
    points = np.ascontiguousarray(p_B[rows])
    surface.closest(points, np.arange(len(rows), dtype=np.int32), out, within)
    return out


def follow(
    surface: Surface, path: tuple[FloatArray | None, FloatArray], start: tuple[IntArray, FloatArray]
) -> Projection:
    """Continue feet of points along `path` = (before, now) from `start` = (patch, uv).

    Feet are certified only with positions before. Those that do not converge become the closest
    points. `path` and `start` have one row per foot.
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
    """Return a mask (n,) of the feet at a border, or at the edge of a hole."""
    is_at_border: BoolArray = (feet.status == Status.BORDER) | (feet.status == Status.TRIMMED)
    return is_at_border


def kept_statuses(feet: Projection) -> ByteArray:
    """Return the `ContactStatus` (n,) of points whose feet are kept.

    It is HELD at a border, REACQUIRED after a jump of the foot, else OLD.
    """
    status = np.where(at_border(feet), ContactStatus.HELD, ContactStatus.OLD)
    status[feet.status == Status.BRANCH_EVENT] = ContactStatus.REACQUIRED
    return status.astype(np.int8)


def distance_between(first: Projection, second: Projection) -> FloatArray:
    """Return the distances (n,) between two feet of each point, length."""
    return row_lengths(first.point - second.point)


def within_depth(feet: Projection, options: Options) -> BoolArray:
    """Return a mask (n,) of the points that a search by penetration takes into contact.

    They lie behind a closest point on a face, no deeper than `options.depth`.
    """
    is_inside: BoolArray = (
        (feet.status == Status.OK) & (feet.gap <= 0.0) & (feet.gap >= -options.depth)
    )
    return is_inside


def free_distance(feet: Projection, options: Options) -> FloatArray:
    """Return `safe_distance` (n,) of free points from their closest points; negative inside.

    It is zero for points within rounding of the surface, and where the status of the closest point
    is not OK, as at a border. In a search by penetration a point that is too deep is as far from
    contact as from that depth.
    """
    skip = max(options.band, options.depth if options.penetration else 0.0)
    safe_distance = np.where(
        feet.gap > 0.0,
        np.maximum(feet.gap - options.band, 0.0),
        -np.maximum(-feet.gap - skip, 0.0),
    )
    return np.where(feet.status == Status.OK, safe_distance, 0.0)


def take_into_contact(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detection, options: Options
) -> None:
    """Take points inside into contact, in a search by penetration, at their closest points.

    Their status NEW and their feet are written into `detected`, with the safe distances of all
    `rows`, and in a closed body the last feet of the points that stay free.
    """
    feet = closest(surface, p_B, rows)
    is_inside = within_depth(feet, options)
    if options.closed:
        detected.safe_distance[rows] = np.where(is_inside, -feet.gap, free_distance(feet, options))
        store_feet(detected, rows[~is_inside], feet, ~is_inside)
    else:
        # On either side of an open surface a point is as far from contact as from its reach: in
        # front of one sheet it may be behind another. A foot that is not found is searched again.
        detected.safe_distance[rows] = np.fmax(np.abs(feet.gap) - options.depth, 0.0)
    detected.status[rows[is_inside]] = ContactStatus.NEW
    copy_feet(detected.feet, rows, feet, is_inside)


def store_feet(detected: Detection, rows: IndexArray, feet: Projection, mask: BoolArray) -> None:
    """Write the masked feet to the last feet of free points `rows`, one row per masked foot.

    By these the next step proves the sides of the points.
    """
    detected.last_patch[rows] = feet.patch[mask]
    detected.uv[rows] = feet.uv[mask]
