"""The search of a step as a contact asks for it: of points and poses in the world."""

from __future__ import annotations

from contiga.contact.curved import detect_on_curves, is_turned
from contiga.contact.detect import detect
from contiga.contact.search_records import BoolArray, Columns, Detected, Last, Options, Workspace
from contiga.contact.state_rows import kept_of
from contiga.contact.touching import ContactRows, PreviousStep, touching
from contiga.masters.protocol import Master
from contiga.records import FloatArray
from contiga.rigid.frames import to_body

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
    p_W, X_WB, p_B = moved
    state = past.state
    place = state.patch, state.uv, state.last_patch
    last = Last(state.points_B, *place, state.safe_distance, kept_of(state).holds)
    poses = state.pose, X_WB
    if is_turned(poses) and options.half is None:
        to_body(X_WB, p_W, p_B)
        detected = detect_on_curves(master.surface, p_B, last, active, options, poses, memory)
    else:
        world = p_W, X_WB
        detected = detect(master.surface, p_B, last, active, options, memory, world)
    return detected, touching(detected, p_B, past)
