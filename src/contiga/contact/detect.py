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
from contiga.contact.kernels import place_nb
from contiga.contact.tracked import Detected, Last, Options, Step, blank, detect_inside, track
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray

KINDS = int(ContactStatus.FREE), int(ContactStatus.NOT_FINITE)


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
    found = _nowhere(len(now))
    way, ignored = np.empty(len(now)), np.empty(len(now), bool)
    rows = np.empty((2, len(now)), np.int32)
    known = last.patch, last.uv, last.near, last.safe_distance
    places = found.status, found.safe_distance, found.near, found.uv, way, ignored
    touching, free = place_nb.place(last.points_B, now, known, active, places, rows, KINDS)
    step = Step(last.points_B, now, way, ignored, last.near, last.uv)
    rows, near = rows[0, :touching], rows[1, :free]
    if options.through:
        feet = last.patch, last.uv
        rows, near = through.detect(surface, step, feet, (rows, near), found, options)
    if options.closed:
        closed_body.detect(surface, step, (last.patch, last.uv), (rows, near), found, options)
        return _with_feet(found)
    tracked = track(
        surface, (last.points_B[rows], now[rows]), (last.patch[rows], last.uv[rows]), options
    )
    open_body.detect(surface, step, (rows, near), tracked, found, options)
    return _with_feet(found)


def _nothing(p_B: FloatArray, active: np.ndarray) -> Detected:
    """Nothing in contact, and nothing known of inactive points but that they never are."""
    found = _nowhere(len(p_B))
    found.status[~np.isfinite(p_B).all(axis=1)] = ContactStatus.NOT_FINITE
    found.safe_distance[~active] = np.inf
    found.near[:] = -1
    return found


def _nowhere(n: int) -> Detected:
    """Points without feet, of which nothing is said."""
    status, near = np.zeros(n, np.int8), np.zeros(n, np.int32)
    return Detected(status, blank(n), np.zeros(n), near, np.zeros((n, 2)))


def _with_feet(found: Detected) -> Detected:
    """`found` with the parameters of the points in contact among those of the free ones."""
    rows = found.feet.patch >= 0
    found.uv[rows] = found.feet.uv[rows]
    return found
