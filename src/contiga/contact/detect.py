"""Search and detailed search of one step: which points touch, and where their feet are.

Free points (type a): a point that cannot have come as far as the surface is left alone (distance
is 1-Lipschitz); the others are looked at, and those whose step enters start their foot where they
entered last. Points in contact (type b): the foot is continued from the last one; the point is
released when it is back on the free side (Eq. 4.7 with the sign put right) and has slid off when
the foot passed a border of the body. What holds beyond that depends on the body, closed or open
(`closed_body`, `open_body`).
"""

from __future__ import annotations

import numpy as np

from contiga.contact import closed_body, open_body, through
from contiga.contact.tracked import Detected, Last, Options, Step, blank, detect_inside, track
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray


def detect_at_start(
    surface: Surface, p_B: FloatArray, active: np.ndarray, options: Options
) -> Detected:
    """The start: nothing is in contact, or, by penetration, what already lies inside."""
    found = _nothing(p_B, active)
    rows = np.flatnonzero(np.isfinite(p_B).all(axis=1) & active).astype(np.int32)
    if options.closed:
        closed_body.detect_at_start(surface, p_B, rows, found, options)
        return _with_feet(found)
    surface.safe_distance(p_B, rows, found.safe_distance)
    if options.penetration:
        detect_inside(surface, p_B, rows, found, options)
    return _with_feet(found)


def detect(
    surface: Surface, now: FloatArray, last: Last, active: np.ndarray, options: Options
) -> Detected:
    """One step: from the points of the last step to those of this one, body axes."""
    before = last.points_B
    found = _nothing(now, active)
    finite = np.isfinite(now).all(axis=1)
    with np.errstate(invalid="ignore", over="ignore"):
        way = np.sqrt(np.square(now - before).sum(axis=1))
    # A point that was not finite has no path to follow: it is looked at afresh.
    way = np.where(np.isfinite(way), way, np.inf)
    touching = finite & (last.patch >= 0)
    free = finite & active & ~touching
    found.safe_distance[touching] = np.maximum(last.safe_distance - way, 0.0)[touching]
    left = np.maximum(np.abs(last.safe_distance) - way, 0.0)
    found.safe_distance[free] = np.copysign(left, last.safe_distance)[free]
    found.safe_distance[~finite & active] = 0.0
    rows = np.flatnonzero(touching).astype(np.int32)
    near = np.flatnonzero(free & (left <= 0.0)).astype(np.int32)
    step = Step(before, now, way, last.safe_distance < 0.0, last.near, last.uv)
    found.near[free] = last.near[free]
    found.uv[free] = last.uv[free]
    if options.through:
        feet = last.patch, last.uv
        rows, near = through.detect(surface, step, feet, (rows, near), found, options)
    if options.closed:
        closed_body.detect(surface, step, (last.patch, last.uv), (rows, near), found, options)
        return _with_feet(found)
    tracked = track(surface, (before[rows], now[rows]), (last.patch[rows], last.uv[rows]), options)
    open_body.detect(surface, step, (rows, near), tracked, found, options)
    return _with_feet(found)


def _nothing(p_B: FloatArray, active: np.ndarray) -> Detected:
    """Nothing in contact, and nothing known of inactive points but that they never are."""
    finite = np.isfinite(p_B).all(axis=1)
    status = np.where(finite, ContactStatus.FREE, ContactStatus.NOT_FINITE).astype(np.int8)
    n = len(p_B)
    nowhere = np.full(n, -1, np.int32)
    safe_distance = np.where(active, 0.0, np.inf)
    return Detected(status, blank(n), safe_distance, nowhere, np.zeros((n, 2)))


def _with_feet(found: Detected) -> Detected:
    """`found` with the parameters of the points in contact among those of the free ones."""
    rows = found.feet.patch >= 0
    found.uv[rows] = found.feet.uv[rows]
    return found
