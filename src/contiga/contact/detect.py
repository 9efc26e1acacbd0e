"""Search and detailed search of one step: which points touch, and where their feet are.

Free points (type a): a point that cannot have come as far as the surface is left alone (distance
is 1-Lipschitz); the others are looked at, and those whose step enters start their foot where they
entered last. Points in contact (type b): the foot is continued from the last one; the point is
released when it is back on the free side (Eq. 4.7 with the sign put right) and has slid off when
the foot passed a border of the body. What holds beyond that depends on the body, closed or open
(`closed_body`, `open_body`).
"""

from __future__ import annotations

from math import ceil

import numpy as np

from contiga.contact import closed_body, open_body, through
from contiga.contact.kernels import place_nb
from contiga.contact.tracked import Detected, Last, Options, Room, Step, detect_inside, track
from contiga.masters.protocol import Surface
from contiga.num.arrays import locked
from contiga.num.threads import run_ranges
from contiga.records import ContactStatus, FloatArray, IntArray, Projection

# Points that a thread goes through at once.
CHUNK = 32768


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
    surface: Surface,
    now: FloatArray,
    last: Last,
    active: np.ndarray,
    options: Options,
    room: Room | None = None,
) -> Detected:
    """One step: from the points of the last step to those of this one, body axes.

    What is found lies in part in the `room`, and is gone with the next step in it.
    """
    room = Room.of(len(now)) if room is None else room
    found = _nowhere(room)
    step = Step(last.points_B, now, room.way, room.ignored, last.near, last.uv)
    rows, near = _place(step, last, active, found, room.rows)
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


def _place(
    step: Step, last: Last, active: np.ndarray, found: Detected, rows: IntArray
) -> tuple[IntArray, IntArray]:
    """The points that were in contact, and the free ones that may have come to the surface.

    Fills in what is known of all of them. `rows` (2, n) is where they are listed.
    """
    n = len(step.now)
    chunks = ceil(n / CHUNK)
    known = last.patch, last.uv, last.near, last.safe_distance
    places = found.status, found.safe_distance, found.near, found.uv, step.way, step.ignored
    counts = np.zeros((chunks, 2), np.int64)
    path, lists = (step.before, step.now), (rows, counts)
    run_ranges(place_nb.place, chunks, 1, path, known, locked(active), places, lists, CHUNK)
    if chunks == 1:
        return rows[0, : counts[0, 0]], rows[1, : counts[0, 1]]
    parts = [
        [own[c * CHUNK : c * CHUNK + count] for c, count in enumerate(counts[:, i])]
        for i, own in enumerate(rows)
    ]
    return np.concatenate(parts[0] or [rows[0]]), np.concatenate(parts[1] or [rows[1]])


def _nothing(p_B: FloatArray, active: np.ndarray) -> Detected:
    """Nothing in contact, and nothing known of inactive points but that they never are."""
    found = _nowhere(Room.of(len(p_B)))
    found.status[~np.isfinite(p_B).all(axis=1)] = ContactStatus.NOT_FINITE
    found.safe_distance[~active] = np.inf
    found.near[:] = -1
    return found


def _nowhere(room: Room) -> Detected:
    """Points without feet, of which nothing is said."""
    n = len(room.gap)
    none, blank = np.full(n, -1, np.int32), np.full(n, -1, np.int8)
    feet = Projection(
        none,
        *(room.uv, room.point, room.normal, room.gap),
        blank,
        room.status,
        np.zeros(n, np.int8),
    )
    return Detected(
        np.zeros(n, np.int8), feet, np.zeros(n), np.zeros(n, np.int32), np.zeros((n, 2))
    )


def _with_feet(found: Detected) -> Detected:
    """`found` with the parameters of the points in contact among those of the free ones."""
    run_ranges(place_nb.fill_in, len(found.uv), CHUNK, found.feet.patch, found.feet.uv, found.uv)
    return found
