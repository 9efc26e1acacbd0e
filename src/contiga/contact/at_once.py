"""The step of few points in contact with a closed exact body, by one kernel as far as that goes.

Where nothing has to be judged, which is most steps, that is all of the search. Of few points the
calls from Python, one after the other, take several times as long as what is done in them.
"""

from __future__ import annotations

from contiga.contact import closed_body
from contiga.contact.curved import detect_on_curves, is_turned
from contiga.contact.desk import MOST
from contiga.contact.detect import nowhere, with_feet
from contiga.contact.kernels import touching_nb
from contiga.contact.tracked import CHUNK, BoolArray, Columns, Detected, Last, Options, Room, Step
from contiga.masters.protocol import Surface
from contiga.num.arrays import locked
from contiga.num.rigid import to_body
from contiga.records import FloatArray

Moved = tuple[FloatArray, FloatArray, FloatArray]
"""(p_W, X_WB, p_B): points in the world and the pose, and what body axes are written into."""


def detect_moved(
    surface: Surface,
    moved: Moved,
    last: Last,
    active: BoolArray,
    options: Options,
    poses: tuple[FloatArray, FloatArray],
    memory: tuple[Room, Columns],
) -> Detected:
    """One step of a body that goes from one to the other of its `poses` (4, 4); see `detect`.

    The points in body axes are filled in.
    """
    if not is_turned(poses):
        found = detect_at_once(surface, moved, last, active, options, memory)
        if found is not None:
            return found
    p_W, X_WB, p_B = moved
    to_body(X_WB, p_W, p_B)
    return detect_on_curves(surface, p_B, last, active, options, poses, memory)


def detect_at_once(
    surface: Surface,
    moved: Moved,
    last: Last,
    active: BoolArray,
    options: Options,
    memory: tuple[Room, Columns],
) -> Detected | None:
    """One step of a body that does not turn, `moved` from where `last` says; see `detect`.

    None where the body or the number of points is not such: then nothing is filled in.
    """
    room, columns = memory
    if not options.closed or options.through or len(moved[0]) > CHUNK:
        return None
    places = room.small.places(surface, False)
    if places is None:
        return None
    found = nowhere(room, columns)
    counts = _advance(moved, last, active, options, (room, columns), found, places)
    if counts[2] == touching_nb.NO_BALLS:
        places = room.small.places(surface, True) or places
        counts = _advance(moved, last, active, options, (room, columns), found, places)
    touching, near, left, held = counts
    if left == 0 and near == 0:
        return found._replace(held=room.rows[2, :held].copy())
    step = Step(last.points_B, moved[2], room.way, room.ignored, last.near, last.uv, room.small)
    lists = room.rows[0, :touching], room.rows[1, :near]
    told = closed_body.told_on(room.small.desk, left) if left >= 0 else None
    feet = last.patch, last.uv
    closed_body.detect(surface, step, feet, lists, found, options, told)
    return with_feet(found, lists)


def _advance(
    moved: Moved,
    last: Last,
    active: BoolArray,
    options: Options,
    memory: tuple[Room, Columns],
    found: Detected,
    places: tuple[int, ...],
) -> tuple[int, int, int, int]:
    """See `touching_nb.advance`."""
    p_W, X_WB, p_B = moved
    room, (status, safe_distance, near, uv, *feet) = memory
    counts: tuple[int, int, int, int] = touching_nb.advance(
        (locked(p_W), p_B, last.points_B),
        X_WB,
        (last.patch, last.uv, last.near, last.safe_distance),
        locked(active),
        (status, safe_distance, near, uv, room.way, room.ignored, *feet),
        found.feet,
        room.rows,
        (options.hold, options.balls, options.band, MOST, *places),
    )
    return counts
