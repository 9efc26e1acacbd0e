"""Search of one step: which points are in contact, and where their feet are.

A free point that cannot have reached the surface stays free (distance is 1-Lipschitz); the others
are examined, and those whose path enters come into contact. Points in contact are pushed by the
nearest wall that their guard allows (`nearest`), or keep the wall by which they entered
(`followed`). One call of a kernel settles nearly all of them (`settle`); the rest is examined point
by point.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.contact import followed, nearest, settle, thick, through
from contiga.contact.foot_rows import closest, free_distance, store_feet, take_into_contact
from contiga.contact.kernels import place_nb
from contiga.contact.search_records import (
    CHUNK,
    ChangedShape,
    Columns,
    Detection,
    Last,
    Options,
    PlacementArrays,
    Rows,
    Step,
    StepSearch,
    Workspace,
    listed,
)
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IntArray, SurfacePlaces
from contiga.rigid.frames import to_world


def detect_at_start(
    surface: Surface, p_B: FloatArray, active: np.ndarray, options: Options
) -> Detection:
    """Search at the start: by penetration points inside are in contact, else no point is.

    Points (n, 3) are in body axes. Points inside a closed body that are not in contact have a
    negative safe distance, points that are not `active` (n,) an infinite one. The status of points
    that are not finite is NOT_FINITE.
    """
    n, finite = len(p_B), np.isfinite(p_B).all(axis=1)
    detected = Detection.into(Workspace.of(n), Columns.of(n))
    detected.status[~finite] = ContactStatus.NOT_FINITE
    detected.safe_distance[~active] = np.inf
    rows = np.flatnonzero(finite & active).astype(np.int32)
    all_rows = Rows(rows, rows[:0])
    if options.half is not None:
        thick.detect_at_start(surface, p_B, rows, detected, options)
        return with_feet(detected, all_rows)
    if options.closed:
        side, reach = surface.sides(p_B, rows)
        detected.safe_distance[rows] = side * (reach - options.band)
        rows = rows[side <= 0 if options.penetration else side == 0]
    else:
        surface.safe_distance(p_B, rows, detected.safe_distance)
    if options.penetration:
        take_into_contact(surface, p_B, rows, detected, options)
    elif options.closed:
        # Points inside are not in contact until they have been outside.
        feet = closest(surface, p_B, rows)
        detected.safe_distance[rows] = free_distance(feet, options)
        store_feet(detected, rows, feet, np.ones(len(rows), np.bool_))
    return with_feet(detected, all_rows)


def detect(
    surface: Surface,
    now: FloatArray,
    last: Last,
    active: np.ndarray,
    options: Options,
    memory: tuple[Workspace, Columns] | None = None,
    moved: tuple[FloatArray, FloatArray] | None = None,
    shape: ChangedShape | None = None,
) -> Detection:
    """Search one step from the points of the last step to the points `now`, both in body axes.

    The results are views of `memory`; the next step with it overwrites the workspace. With
    `moved`, points in world axes and the pose of the body, `now` is filled in. `shape` is the
    change of the surface, None for a constant shape.
    """
    workspace, columns = memory or (Workspace.of(len(now)), Columns.of(len(now)))
    detected = Detection.into(workspace, columns)
    if shape is not None:  # guards rotate with the surface
        guarded, guard = last.guard_states.rows, last.guard_states.guard
        feet = SurfacePlaces(last.patch[guarded], last.uv[guarded])
        guard = shape.turned(feet, last.points_B[guarded], guard)
        last = last._replace(guard_states=last.guard_states._replace(guard=guard))
    step = Step(
        last.points_B,
        now,
        workspace.path_length,
        workspace.inside_since_start,
        last.last_patch,
        last.uv,
        last.guard_states,
    )
    rows = _place(step, last, active, columns, workspace.rows, moved, shape)
    search = StepSearch(surface, step, SurfacePlaces(last.patch, last.uv), detected, options, shape)
    if options.half is not None:
        thick.detect(search, rows)
        return with_feet(detected, rows)
    open_rows = through.detect(search, rows) if options.through else rows
    open_rows = settle.settle_points(search, open_rows)
    if len(open_rows.touching) or len(open_rows.free):
        point_by_point = nearest if options.nearest else followed
        detected = detected._replace(guards=point_by_point.detect(search, open_rows))
    return with_feet(detected, rows)


def _place(
    step: Step,
    last: Last,
    active: np.ndarray,
    columns: Columns,
    lists: IntArray,
    moved: tuple[FloatArray, FloatArray] | None,
    shape: ChangedShape | None,
) -> Rows:
    """List the points that were in contact, and the free ones that may have reached the surface.

    It fills in path lengths, statuses and safe distances, resets the other `columns`, and uses
    `lists` (2, n) as memory. With `moved` it fills in `step.now`. If the surface has changed its
    shape, path lengths are relative to its rigid motion, plus the remaining travel of the surface.
    """
    before, surface_travel = step.before, 0.0
    if shape is not None:
        before, surface_travel = to_world(shape.rigid, before), shape.travel
    chunks = ceil(len(step.now) / CHUNK)
    counts = np.zeros((chunks, 2), np.int64)
    arrays = PlacementArrays(
        before,
        step.now,
        last,
        locked(active),
        columns,
        step.path_length,
        step.inside_since_start,
        lists,
        counts,
        surface_travel,
    )
    if moved is None:
        run_ranges(straight(place_nb.place), chunks, 1, arrays, CHUNK)
    else:
        p_W, pose = moved
        run_ranges(straight(place_nb.move_and_place), chunks, 1, arrays, locked(p_W), pose, CHUNK)
    return Rows(listed(lists[0], counts[:, 0]), listed(lists[1], counts[:, 1]))


def with_feet(detected: Detection, rows: Rows) -> Detection:
    """Return `detected` with the list of points in contact among `rows`.

    `detected.uv` is written into: parameters of feet in contact, zeros of points without any foot.
    """
    touching = np.empty(len(rows.touching) + len(rows.free), np.int32)
    n = straight(place_nb.list_touching)(*rows, detected, touching)
    return detected._replace(touching=touching[:n])
