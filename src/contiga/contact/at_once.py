"""The step of few points in contact with a closed exact body, by one kernel as far as that goes.

Where no path has to be looked at, which is most steps, that is all of the search. Of few points the
calls from Python, one after the other, take several times as long as what is done in them.
"""

from __future__ import annotations

from contiga.contact import closed_body
from contiga.contact.closed_body import SHORT
from contiga.contact.curved import detect_on_curves, is_turned
from contiga.contact.detect import detect, no_feet, nowhere, with_feet
from contiga.contact.judge import SAME_FOOT, judge
from contiga.contact.kernels import touching_nb
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.contact.touching import ContactRows, PreviousStep, touching
from contiga.contact.tracked import (
    CHUNK,
    BoolArray,
    Columns,
    Detected,
    Last,
    Options,
    Step,
    Workspace,
)
from contiga.masters.protocol import Master, Surface
from contiga.num.arrays import locked
from contiga.num.rigid import to_body
from contiga.records import FloatArray, Projection

Moved = tuple[FloatArray, FloatArray, FloatArray]
"""(p_W, X_WB, p_B): points in the world and the pose, and what body axes are written into."""


def detect_moved(
    master: Master,
    moved: Moved,
    past: PreviousStep,
    active: BoolArray,
    options: Options,
    memory: tuple[Workspace, Columns],
) -> tuple[Detected, ContactRows]:
    """One step of a body that goes from the pose of `past` to that it is `moved` to; see `detect`.

    The points in body axes are filled in.
    """
    known = detect_at_once(master, moved, past, active, options, memory)
    if known is not None:
        return known
    p_W, X_WB, p_B = moved
    state = past.state
    place = state.patch, state.uv, state.last_patch
    last = Last(state.points_B, *place, state.safe_distance, kept_of(state).holds)
    poses = state.pose, X_WB
    if is_turned(poses):
        to_body(X_WB, p_W, p_B)
        detected = detect_on_curves(master.surface, p_B, last, active, options, poses, memory)
    else:
        poses_now = p_W, X_WB
        detected = detect(master.surface, p_B, last, active, options, memory, poses_now)
    return detected, touching(detected, p_B, past)


def detect_at_once(
    master: Master,
    moved: Moved,
    past: PreviousStep,
    active: BoolArray,
    options: Options,
    memory: tuple[Workspace, Columns],
) -> tuple[Detected, ContactRows] | None:
    """One step of a body that does not turn, `moved` from where it was; see `detect`.

    None where the body, its motion or the number of points is not such: then nothing is filled in.
    States that steps have made are of arrays as kernels take them.
    """
    workspace, columns = memory
    if not (options.closed and options.nearest) or options.through:
        return None
    if len(moved[0]) > CHUNK or not kept_of(past.state).is_made:
        return None
    places = workspace.small.of(master)
    if places is None:
        return None
    feet = no_feet(workspace, columns)
    counts = _advance(moved, past, active, options, memory, feet, places)
    if counts[2] == touching_nb.NO_BALLS:
        places = workspace.small.places(master.surface, True) or places
        counts = _advance(moved, past, active, options, memory, feet, places)
    in_contact, near, left, held = counts
    if left == touching_nb.TURNED:
        return None
    if left == 0:
        rows = workspace.rows[2, :held].copy()
        status, safe_distance, close, uv, *_ = columns
        detected = Detected(status, feet, safe_distance, close, uv, rows)
        return detected, ContactRows.on(workspace.small.buffers, rows)
    detected = _finish(
        master.surface, moved[2], past.state, options, memory, (in_contact, near, left)
    )
    return detected, touching(detected, moved[2], past)


def _finish(
    surface: Surface,
    p_B: FloatArray,
    state: State,
    options: Options,
    memory: tuple[Workspace, Columns],
    counts: tuple[int, int, int],
) -> Detected:
    """What the kernel has left of a step; `counts` is what it answered."""
    (workspace, columns), (in_contact, near, left) = memory, counts
    detected = nowhere(workspace, columns)
    old = state.last_patch, state.uv, kept_of(state).holds
    step = Step(state.points_B, p_B, workspace.way, workspace.ignored, *old, workspace.small)
    lists = workspace.rows[0, :in_contact], workspace.rows[1, :near]
    if left > 0:
        opposed = judge(
            surface, step, workspace.small.buffers.doubtful.first(left), detected, options
        )
    else:
        feet = state.patch, state.uv
        opposed = closed_body.detect(surface, step, feet, lists, detected, options)
    return with_feet(detected, lists)._replace(opposed=opposed)


def _advance(
    moved: Moved,
    past: PreviousStep,
    active: BoolArray,
    options: Options,
    memory: tuple[Workspace, Columns],
    feet: Projection,
    places: tuple[int, ...],
) -> tuple[int, int, int, int]:
    """See `touching_nb.advance`."""
    p_W, X_WB, p_B = moved
    workspace, (status, safe_distance, near, uv, *rest) = memory
    state, size = past.state, options.size
    shares = SHORT * size, SAME_FOOT * size
    limits = options.balls, options.penetration, options.band, options.depth, *shares
    last = state.patch, state.uv, state.last_patch, state.safe_distance
    counts: tuple[int, int, int, int] = touching_nb.advance(
        (locked(p_W), X_WB, state.pose, p_B, state.points_B),
        (*last, *kept_of(state).deep, kept_of(state).holds),
        active,
        (status, safe_distance, near, uv, workspace.way, workspace.ignored, *rest),
        feet,
        workspace.rows,
        past.speed,
        (limits, places),
    )
    return counts
