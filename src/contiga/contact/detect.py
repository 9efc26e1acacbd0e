"""Search and detailed search of one step: which points touch, and where their feet are.

Free points: a point that cannot have come as far as the surface is left alone (distance is
1-Lipschitz); the others are looked at, and those whose path enters come into contact there. Points
in contact are pushed by the nearest wall that their guard allows (`nearest`), or keep the one that
they came in by (`followed`). Nearly all are settled by one call of a kernel (`settle`); those that
it leaves are looked at one by one.
"""

from __future__ import annotations

from math import ceil

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.contact import followed, nearest, settle, thick, through
from contiga.contact.foot_rows import closest, free_distance, remember, take_inside
from contiga.contact.kernels import place_nb
from contiga.contact.loads import Holds
from contiga.contact.search_records import (
    CHUNK,
    ChangedShape,
    Columns,
    Detected,
    Last,
    Options,
    Placing,
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
) -> Detected:
    """Search at the start: nothing is in contact, or, by penetration, what already lies inside."""
    n, finite = len(p_B), np.isfinite(p_B).all(axis=1)
    detected = Detected.into(Workspace.of(n), Columns.of(n))
    detected.status[~finite] = ContactStatus.NOT_FINITE
    detected.safe_distance[~active] = np.inf
    rows = np.flatnonzero(finite & active).astype(np.int32)
    if options.half is not None:
        thick.detect_at_start(surface, p_B, rows, detected, options)
        return with_feet(detected, Rows(rows, rows[:0]))
    listed_rows = Rows(rows, rows[:0])
    if options.closed:
        side, reach = surface.sides(p_B, rows)
        detected.safe_distance[rows] = side * (reach - options.band)
        rows = rows[side <= 0 if options.penetration else side == 0]
    else:
        surface.safe_distance(p_B, rows, detected.safe_distance)
    if options.penetration:
        take_inside(surface, p_B, rows, detected, options)
    elif options.closed:
        # Points that lie inside are not in contact until they have been outside.
        out = closest(surface, p_B, rows)
        detected.safe_distance[rows] = free_distance(out, options)
        remember(detected, rows, out, np.ones(len(rows), np.bool_))
    return with_feet(detected, listed_rows)


def detect(
    surface: Surface,
    now: FloatArray,
    last: Last,
    active: np.ndarray,
    options: Options,
    memory: tuple[Workspace, Columns] | None = None,
    moved: tuple[FloatArray, FloatArray] | None = None,
    shape: ChangedShape | None = None,
) -> Detected:
    """Search one step, from the points of the last step to those of this one, body axes.

    What is found lies in `memory`; the next step in it overwrites the workspace. With `moved`, the
    points in world axes and the pose of the body, `now` is filled in. `shape` tells how the surface
    has changed, None of one that keeps its shape.
    """
    workspace, columns = memory or (Workspace.of(len(now)), Columns.of(len(now)))
    detected = Detected.into(workspace, columns)
    if shape is not None:
        last = last._replace(holds=_turn_guards(last, shape))
    old = last.last_patch, last.uv, last.holds
    step = Step(last.points_B, now, workspace.way, workspace.ignored, *old)
    rows = _place(step, last, active, columns, workspace.rows, moved, shape)
    places = SurfacePlaces(last.patch, last.uv)
    search = StepSearch(surface, step, places, detected, options, shape)
    if options.half is not None:
        thick.detect(search, rows)
        return with_feet(detected, rows)
    left = settle.left(search, through.detect(search, rows) if options.through else rows)
    if len(left.touching) or len(left.near):
        which = nearest if options.nearest else followed
        detected = detected._replace(opposed=which.detect(search, left))
    return with_feet(detected, rows)


def _turn_guards(last: Last, shape: ChangedShape) -> Holds:
    """Return the holds of the points in contact, with guards rotated with the surface."""
    rows, guard = last.holds.rows, last.holds.guard
    feet = SurfacePlaces(last.patch[rows], last.uv[rows])
    return last.holds._replace(guard=shape.turned(feet, last.points_B[rows], guard))


def _place(
    step: Step,
    last: Last,
    active: np.ndarray,
    columns: Columns,
    rows: IntArray,
    moved: tuple[FloatArray, FloatArray] | None,
    shape: ChangedShape | None,
) -> Rows:
    """List the points that were in contact, and the free ones that may have come to the surface.

    Fills in what is known of all of them. `rows` (2, n) is where they are listed. Where the surface
    has changed its shape, ways are those beside its rigid motion.
    """
    before, surface_way = step.before, 0.0
    if shape is not None:
        before, surface_way = to_world(shape.rigid, before), shape.way
    chunks = ceil(len(step.now) / CHUNK)
    counts = np.zeros((chunks, 2), np.int64)
    ways = step.way, step.ignored
    told = before, step.now, last, locked(active), columns
    placing = Placing(*told, *ways, rows, counts, surface_way)
    if moved is None:
        run_ranges(straight(place_nb.place), chunks, 1, placing, CHUNK)
    else:
        given = placing, locked(moved[0]), moved[1], CHUNK
        run_ranges(straight(place_nb.move_and_place), chunks, 1, *given)
    return Rows(listed(rows[0], counts[:, 0]), listed(rows[1], counts[:, 1]))


def with_feet(detected: Detected, rows: Rows) -> Detected:
    """Return `detected` with the feet of points in contact among `rows`, and their parameters."""
    held = np.empty(len(rows.touching) + len(rows.near), np.int32)
    n = straight(place_nb.held)(*rows, detected, held)
    return detected._replace(held=held[:n])
