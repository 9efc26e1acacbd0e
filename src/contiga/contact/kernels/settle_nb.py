"""Settle points in contact, and free points near the surface, a chunk per call.

The side of a point, and whether its foot is the closest point, follow from four tests, the cheapest
first: the cell of the point (closed bodies), the ball that touches at its continued foot, its path
since its distance was known, and a search for its closest point. Points that these do not decide
are listed, without results, for `contiga.contact.nearest` or `contiga.contact.followed`: their
paths have to be examined, or another wall than the nearest may push them.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import AT_BORDER, BRANCH_EVENT, FACE, MAX_ITERATIONS, OK, TRIMMED
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.contact.kernels.carrying_nb import row_position
from contiga.contact.kernels.status_nb import FREE, HELD, LOST, OLD, REACQUIRED, RELEASED
from contiga.contact.settle_records import (
    BallQueries,
    Candidates,
    FootBalls,
    FreeRows,
    TouchingRows,
)
from contiga.jit import inner, kernel
from contiga.records import Sides, SurfacePlaces
from contiga.search.balls.kernels.ball_nb import radii
from contiga.search.closest.kernels.nearest_nb import project_proved
from contiga.search.sides.kernels.side_nb import clear_paths, places, sides
from contiga.search.track.kernels.track_nb import track_chunks

MAY_KEEP, IS_KEPT = 1, 2
"""Marks of a row: its foot may be kept; its foot is certainly kept."""
OPPOSITE = 160.0
"""Angle in degrees from which outward normals belong to opposite walls, as in a wedge of 20°.

A wedge of 30° has no opposite walls: a point that its edge has run over leaves by either. Ribs and
plates have opposite walls, also with a draft angle of a few degrees."""
OPPOSITE_COSINE = math.cos(math.radians(OPPOSITE))
OTHER_WALL_COSINE = 0.7
"""Cosine between normals below which they belong to different walls."""
LOOK_SHARE = 1.0 / 16.0
"""Largest part of a path that ends at another wall, as a share of the depth: other walls may have
been the nearest in between."""
INNER, OUTER = 0, 1
"""Sides of the surface on which balls touch."""


@inner()
def is_at_border(status):
    """Return whether the foot is at a border, or at the edge of a hole."""
    return status in (AT_BORDER, TRIMMED)


@inner()
def _is_foot(status):
    """Return whether the foot is a stationary point of the distance."""
    return status in (OK, BRANCH_EVENT)


@inner()
def _is_sound(feet, i, band):
    """Return whether a ball that touches at the foot may prove the side of its point."""
    return _is_foot(feet.status[i]) and feet.feature[i] == FACE and abs(feet.gap[i]) > band


@inner()
def length_between(first, second, i):
    """Return the distance between rows i of two arrays of points (n, 3)."""
    x, y, z = first[i, 0] - second[i, 0], first[i, 1] - second[i, 1], first[i, 2] - second[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@inner()
def distance_to_foot(feet, i, points):
    """Return the distance from point i to its foot; infinite if the foot may be off the surface."""
    return length_between(points, feet.point, i) if _is_foot(feet.status[i]) else math.inf


@inner()
def _add_ball_query(feet, i, queries, m):
    """List foot i and its side as the m-th of the `BallQueries`; return their number."""
    queries.feet[m] = i
    queries.side[m] = OUTER if feet.gap[i] > 0.0 else INNER
    return m + 1


@inner()
def _apply_ball(feet, i, radius, band, side, reach):
    """Return side and lower bound of the distance, and whether the foot is proved the closest.

    The ball at the foot contains no surface: a point up to 2ρ from the foot is on its side, and no
    wall is nearer than the nearer end of the ball. A known side that is not the ball's is kept. The
    foot is the closest point if the radius exceeds the height by `band` or more.
    """
    sign = 1 if feet.gap[i] > 0.0 else -1
    height = abs(feet.gap[i])
    distance = min(height, 2.0 * radius - height)
    if distance > band and side != -sign:
        side = sign
        reach = max(reach, distance)
    return side, reach, height + band <= radius


@inner()
def is_opposite(feet, i, guard, j):
    """Return whether the wall at foot i is opposite to the guard of row j; false without guard."""
    n = feet.normal
    return n[i, 0] * guard[j, 0] + n[i, 1] * guard[j, 1] + n[i, 2] * guard[j, 2] < OPPOSITE_COSINE


@inner()
def may_push(feet, i, guard, j, min_depth, band):
    """Return whether foot i may push: not opposite to the guard of row j, and deep enough.

    With a depth of `min_depth`, less twice the `band`, it can have become the nearest within the
    step.
    """
    return -feet.gap[i] >= min_depth - 2.0 * band and not is_opposite(feet, i, guard, j)


@inner()
def is_other_wall(feet, i, guard, j):
    """Return whether the wall at foot i differs from the one that held row j.

    Their normals then have a cosine below `OTHER_WALL_COSINE`; without a guard they do not differ.
    """
    n = feet.normal
    g = guard[j, 0], guard[j, 1], guard[j, 2]
    cosine = n[i, 0] * g[0] + n[i, 1] * g[1] + n[i, 2] * g[2]
    return cosine < OTHER_WALL_COSINE and g[0] * g[0] + g[1] * g[1] + g[2] * g[2] > 0.0


@inner()
def take_foot(feet, k, source, i):
    """Write foot i of `source` to row k of `feet`."""
    feet.patch[k] = source.patch[i]
    feet.gap[k] = source.gap[i]
    feet.feature[k] = source.feature[i]
    feet.status[k] = source.status[i]
    feet.certified[k] = source.certified[i]
    for c in range(2):
        feet.uv[k, c] = source.uv[i, c]
    for c in range(3):
        feet.point[k, c] = source.point[i, c]
        feet.normal[k, c] = source.normal[i, c]


@inner()
def remember_foot(detected, k, feet, i):
    """Store the foot of a free point, by which the next step proves its side."""
    detected.last_patch[k] = feet.patch[i]
    detected.uv[k, 0] = feet.uv[i, 0]
    detected.uv[k, 1] = feet.uv[i, 1]


@inner()
def release_outside(rows, known_sides, step, last, detected, band, touching_rows):
    """Release points in contact that are outside; list the others, and return their number.

    `known_sides` are `Sides`, `step` a `Step`, `last` the `SurfacePlaces` of the feet of all
    points, `detected` a `Detection`. `touching_rows` are `TouchingRows` to be filled, which may
    share arrays with `known_sides`; their positions `before` are filled in if they have rows.
    """
    side, reach, before = known_sides.side, known_sides.reach, touching_rows.before
    n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        if side[i] > 0:
            detected.status[k] = RELEASED
            detected.safe_distance[k] = reach[i] - band
            continue
        touching_rows.rows[n], touching_rows.side[n], touching_rows.reach[n] = k, side[i], reach[i]
        touching_rows.patch[n] = last.patch[k]
        touching_rows.uv[n, 0], touching_rows.uv[n, 1] = last.uv[k, 0], last.uv[k, 1]
        for c in range(3):
            touching_rows.now[n, c] = step.now[k, c]
        if before.shape[0] > 0:
            for c in range(3):
                before[n, c] = step.before[k, c]
        n += 1
    return n


@inner()
def mark_followed(rows, feet, side, safe_distance, limits, mark, paths, queries):
    """Write marks of points in contact, by their feet; return the counts of `paths` and `queries`.

    A foot with the point behind may be kept; it is kept for certain if the path is shorter than the
    safe distance, or the point no deeper than rounding. `paths` lists points inside whose paths
    must be examined, `queries` (`BallQueries`) feet whose balls may prove sides. `limits` are
    `Limits`, `safe_distance` is that of all points.
    """
    hold, band = limits.hold, limits.band
    n = m = 0
    for i in range(rows.shape[0]):
        status = feet.status[i]
        has_foot = _is_foot(status) or (hold and is_at_border(status))
        mark[i] = 0
        if has_foot and feet.gap[i] <= 0.0:
            mark[i] = MAY_KEEP
            # A point no deeper than rounding is on the surface.
            if safe_distance[rows[i]] > 0.0 or -feet.gap[i] <= band:
                mark[i] = MAY_KEEP | IS_KEPT
                continue
            if side[i] < 0:
                paths[n] = i
                n += 1
        if _is_sound(feet, i, band):
            m = _add_ball_query(feet, i, queries, m)
    return n, m


@inner()
def mark_nearest(rows, feet, guard_states, path_length, band, mark, queries):
    """Mark points as `mark_followed` does, if the nearest wall pushes: no paths are examined.

    A foot may be kept that is not opposite to its guard, and deep enough for the path. Feet of
    points no deeper than rounding get certified. `guard_states` are those of the last step,
    `path_length` is that of all points. Returns the number of `queries`.
    """
    m = j = 0
    for i in range(rows.shape[0]):
        mark[i] = 0
        j = row_position(guard_states.rows, rows[i], j)
        has_guard = j < guard_states.rows.shape[0] and guard_states.rows[j] == rows[i]
        # A foot that could not be continued is a certified closest point: its path is examined.
        is_kept = feet.certified[i] == 0 and _is_foot(feet.status[i]) and feet.gap[i] <= 0.0
        if is_kept and has_guard:
            least = guard_states.depth[j] - path_length[rows[i]]
            is_kept = not guard_states.is_opposed[j] and may_push(
                feet, i, guard_states.guard, j, least, band
            )
        if is_kept:
            mark[i] = MAY_KEEP
            # A point no deeper than rounding is on the surface.
            if -feet.gap[i] <= band:
                mark[i] = MAY_KEEP | IS_KEPT
                feet.certified[i] = 1
                continue
        if feet.certified[i] == 0 and _is_sound(feet, i, band):
            m = _add_ball_query(feet, i, queries, m)
    return m


@inner()
def settle_marked(rows, feet, known_sides, mark, balls, limits, detected, unsettled):
    """Settle marked points in contact; list the others in `unsettled`, and return their number.

    `known_sides` are `Sides`, `balls` the `FootBalls` of the queries, `detected` a `Detection`. By
    the balls `known_sides`, `mark` and `feet.certified` are updated. In front of an open body a
    point may be behind another sheet of it, and is not settled.
    """
    band, closed = limits.band, limits.closed
    side, reach = known_sides.side, known_sides.reach
    ball_rows, radius = balls.feet, balls.radius
    status, safe_distance = detected.status, detected.safe_distance
    j = n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        is_nearest = False
        if j < ball_rows.shape[0] and ball_rows[j] == i:
            if not mark[i] & IS_KEPT:
                side[i], reach[i], is_nearest = _apply_ball(
                    feet, i, radius[j], band, side[i], reach[i]
                )
            j += 1
        if is_nearest and mark[i] & MAY_KEEP:
            mark[i] |= IS_KEPT
            feet.certified[i] = 1
        if side[i] > 0 and closed:
            status[k] = RELEASED
            safe_distance[k] = reach[i] - band
            remember_foot(detected, k, feet, i)
        elif side[i] <= 0 and mark[i] & IS_KEPT:
            distance = reach[i] - band if side[i] < 0 and closed else 0.0
            if not safe_distance[k] >= distance:
                safe_distance[k] = distance
            status[k] = status_of_kept(feet.status[i])
            take_foot(detected.feet, k, feet, i)
        else:
            unsettled[n] = i
            n += 1
    return n


@inner()
def status_of_kept(status):
    """Return the `ContactStatus` of a point in contact whose foot with this status is kept."""
    if status == BRANCH_EVENT:
        return REACQUIRED
    return HELD if is_at_border(status) else OLD


@inner()
def list_starts(rows, side, cell_place, step, last_patch_out, short_path, start_rows):
    """List free points of unknown side with starts for their feet, and return their number.

    The start is the last foot, or the place in the cell for points that moved more than
    `short_path`; points with neither are not listed. The last feet of points of known side are
    forgotten, in `last_patch_out` of the detection. `cell_place` are `SurfacePlaces`, `step` is a
    `Step`, and `start_rows` are `FreeRows` to be filled.
    """
    patch, uv = cell_place.patch, cell_place.uv
    path_length, last_patch, last_uv = step.path_length, step.last_patch, step.uv
    n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        if side[i] != 0:
            last_patch_out[k] = -1
            continue
        if last_patch[k] >= 0 and (path_length[k] <= short_path or patch[i] < 0):
            start_rows.patch[n] = last_patch[k]
            start_rows.uv[n, 0], start_rows.uv[n, 1] = last_uv[k, 0], last_uv[k, 1]
        elif patch[i] >= 0:
            start_rows.patch[n] = patch[i]
            start_rows.uv[n, 0], start_rows.uv[n, 1] = uv[i, 0], uv[i, 1]
        else:
            continue
        start_rows.rows[n] = i
        for c in range(3):
            start_rows.now[n, c] = step.now[k, c]
        n += 1
    return n


@inner()
def list_ball_queries(feet, count, band, queries):
    """List the first `count` feet that have touching balls in `queries`; return their number."""
    m = 0
    for i in range(count):
        if _is_sound(feet, i, band):
            m = _add_ball_query(feet, i, queries, m)
    return m


@inner()
def apply_balls(rows_of_feet, feet, points, balls, band, known_sides, max_distance):
    """Fill in the sides that balls at feet prove, and the distances of points from their feet.

    Foot m is that of points[m]; `rows_of_feet` are its rows in `known_sides` (`Sides`) and in
    `max_distance`, the upper bound of the distance to the surface. `balls` are `FootBalls`.
    """
    side, reach = known_sides.side, known_sides.reach
    ball_feet, radius = balls.feet, balls.radius
    j = 0
    for m in range(rows_of_feet.shape[0]):
        i = rows_of_feet[m]
        max_distance[i] = distance_to_foot(feet, m, points)
        if j < ball_feet.shape[0] and ball_feet[j] == m:
            side[i], reach[i], _ = _apply_ball(feet, m, radius[j], band, side[i], reach[i])
            j += 1


@inner()
def keep_free(rows, known_sides, stays_inside, band, safe_distance, unsettled):
    """Keep points free that are outside or `stays_inside`; list the others, return their number.

    The safe distances of the free points are written, negative inside; the others are listed by
    their positions in `rows`, in `unsettled`.
    """
    side, reach = known_sides.side, known_sides.reach
    n = 0
    for i in range(rows.shape[0]):
        if side[i] > 0 or stays_inside[i]:
            safe_distance[rows[i]] = side[i] * (reach[i] - band)
        else:
            unsettled[n] = i
            n += 1
    return n


NOT_SEARCHED = -1
"""Status of closest points that were not searched."""


@inner()
def _above_zero(x):
    """Return x, or zero if x is negative or not a number."""
    return x if x > 0.0 else 0.0


@inner()
def needs_closest(was_touching, side, penetration, nearest):
    """Return whether a point needs its closest point.

    That is for its side, for the depth of an entering point, or for any point that is not outside
    if the nearest wall pushes.
    """
    return side == 0 or (nearest and side < 0) or (not was_touching and penetration)


@kernel()
def take_closest(candidates, path_length, limits):
    """Make closest points the feet of points that were in contact, if they may push.

    The points must not have left in between: either the followed feet lead to the closest points,
    or the paths are shorter than the distance to any surface, and much shorter (`LOOK_SHARE`, on a
    closed body) if the closest point is on another wall. Feet that are certified already stay.
    `candidates` are `Candidates`, whose feet, `is_kept` and `status` are filled in; `path_length`
    is that of all points, `limits` are `Limits`.
    """
    is_kept, feet, closest, band = (
        candidates.is_kept,
        candidates.feet,
        candidates.closest,
        limits.band,
    )
    for i in range(candidates.rows.shape[0]):
        if is_kept[i] and feet.certified[i] == 1:
            continue  # its foot is the closest point already
        is_kept[i] = False
        may_take = candidates.was_touching[i] and not candidates.is_opposed[i]
        if may_take and closest.status[i] == OK and closest.gap[i] <= 0.0:
            path, depth = path_length[candidates.rows[i]], -closest.gap[i] - band
            is_reached = not math.isfinite(path) or depth > path
            if is_reached and is_other_wall(closest, i, candidates.guard, i):
                # On an open body a wall reached around its border must not take over; on no body
                # may a wall do so that is opposite to the rotated guard.
                is_reached = path <= LOOK_SHARE * depth and limits.closed
                is_reached = is_reached and not is_opposite(closest, i, feet.normal, i)
            # A foot that could not be continued is a closest point already.
            same_foot = (
                feet.certified[i] == 0
                and length_between(feet.point, closest.point, i) <= limits.same_foot
            )
            is_reached = is_reached or same_foot
            least = candidates.depth[i] - path
            is_kept[i] = is_reached and may_push(closest, i, candidates.guard, i, least, band)
        if is_kept[i]:
            candidates.status[i] = OLD
            take_foot(feet, i, closest, i)


@inner()
def _classify(candidates, limits, i):
    """Return whether row i needs its closest point, has a known side, is inside, is deep inside.

    An unknown side is that of the closest point, if this was found; deep is then a point that is
    inside by more than rounding, else any point inside.
    """
    closest, side = candidates.closest, candidates.side[i]
    needed = needs_closest(candidates.was_touching[i], side, limits.penetration, limits.nearest)
    solved = not needed or closest.status[i] == OK
    inside = solved and (side < 0 if side != 0 else closest.gap[i] <= 0.0)
    deep = inside and (side != 0 or closest.gap[i] < -limits.band)
    return needed, solved, inside, deep


@inner(error_model="numpy")
def is_decided(candidates, step, limits, i):
    """Return whether row i can be decided without examining its path or searching another foot.

    On an open body that is a kept foot. On a closed one it is not a point inside whose kept foot is
    not its closest point and whose path is known, nor one that enters or has to restart.
    """
    k, was_touching, is_kept, closest = (
        candidates.rows[i],
        candidates.was_touching[i],
        candidates.is_kept[i],
        candidates.closest,
    )
    if not limits.closed:
        return is_kept
    _, solved, inside, deep = _classify(candidates, limits, i)
    has_past = math.isfinite(step.path_length[k])
    has_both = is_kept and closest.status[i] != NOT_SEARCHED
    is_same = (
        has_both and length_between(candidates.feet.point, closest.point, i) <= limits.same_foot
    )
    if inside and not is_same and has_past and (was_touching or not limits.penetration):
        return False
    is_within_depth = (
        closest.status[i] == OK and closest.gap[i] <= 0.0 and closest.gap[i] >= -limits.depth
    )
    if limits.penetration and not was_touching and is_within_depth:
        return False
    stays = is_kept and (inside or not solved)
    may_be_free = not was_touching and (step.inside_since_start[k] or not has_past)
    return not (
        deep and not stays and (was_touching or (not may_be_free and not limits.penetration))
    )


@inner(error_model="numpy")
def write_decided(candidates, limits, detected, i):
    """Write the decision on row i, which `is_decided`, into `detected`.

    The point keeps its foot, or is free or LOST with its closest point as last foot.
    """
    closest, status, safe_distance = candidates.closest, detected.status, detected.safe_distance
    k, was_touching, is_kept, side = (
        candidates.rows[i],
        candidates.was_touching[i],
        candidates.is_kept[i],
        candidates.side[i],
    )
    needed, solved, inside, _ = _classify(candidates, limits, i)
    distance = (candidates.safe_distance[i] if side != 0 else abs(closest.gap[i])) - limits.band
    if is_kept and (inside or not solved):
        status[k] = candidates.status[i]
        # A point may slide off an open body without crossing it.
        safe_distance[k] = _above_zero(distance) if inside and limits.closed else 0.0
        take_foot(detected.feet, k, candidates.feet, i)
    else:
        status[k] = LOST if not solved and not is_kept else RELEASED if was_touching else FREE
        free_distance = 0.0  # of a free point: see `foot_rows.free_distance`
        if closest.status[i] == OK and closest.gap[i] > 0.0:
            free_distance = _above_zero(closest.gap[i] - limits.band)
        elif closest.status[i] == OK:
            reach = limits.depth if limits.penetration else 0.0
            free_distance = -_above_zero(-closest.gap[i] - max(limits.band, reach))
        safe_distance[k] = free_distance if needed else side * distance
        remember_foot(detected, k, closest, i)


@kernel(error_model="numpy")
def decide_all(candidates, step, limits, detected):
    """Write the decisions on all candidates, if all can be decided; return whether they can.

    If one cannot, nothing is written. `candidates` are `Candidates`, `step` is a `Step`, `limits`
    are `Limits`.
    """
    for i in range(candidates.rows.shape[0]):
        if not is_decided(candidates, step, limits, i):
            return False
    for i in range(candidates.rows.shape[0]):
        write_decided(candidates, limits, detected, i)
    return True


@inner(linked=False)
def _follow_feet(tables, work, n):
    """Continue the feet of the first n rows of `work` in lanes, into `work.feet`.

    Rows that lanes leave get no foot, and the status MAX_ITERATIONS.
    """
    starts = work.starts
    m = track_chunks(
        tables.body,
        work.path,
        starts,
        n,
        work.records,
        work.unsolved,
        work.feet,
        (0, 1 if n else 0),
    )
    for j in range(m):
        blank_foot(work.feet, work.unsolved.rows[j], MAX_ITERATIONS)


@inner(linked=False)
def _find_radii(tables, work, m):
    """Write radii of the touching balls at the first m feet of the queries to `work.radius`."""
    feet = SurfacePlaces(work.feet.patch, work.feet.uv)
    radii(tables.balls, tables.body.grid, feet, work.ball_feet, work.ball_sides, work.radius, 0, m)


@inner(linked=False)
def settle_by_feet(tables, step, last, rows, limits, work, detected, path_rows):
    """Settle points that were in contact, `rows`; return the number that remain unsettled.

    Their positions in `work.rows` are listed in `work.unsettled`. `path_rows` is memory for rows;
    for the other arguments see `settle_touching`.
    """
    n, band = rows.shape[0], limits.band
    side, reach = work.side, work.reach
    sides(tables.grid, step.now, rows, side, reach, 0, n)
    known_sides, starts, path = Sides(side, reach), work.starts, work.path
    touching_rows = TouchingRows(
        work.rows, side, reach, starts.patch, starts.uv, path.before, path.now
    )
    n = release_outside(rows, known_sides, step, last, detected, band, touching_rows)
    _follow_feet(tables, work, n)
    remaining, feet, mark = work.rows[:n], work.feet, work.mark
    queries = BallQueries(work.ball_feet, work.ball_sides)
    if limits.nearest:
        m = mark_nearest(remaining, feet, step.guard_states, step.path_length, band, mark, queries)
    else:
        n_paths, m = mark_followed(
            remaining, feet, side, detected.safe_distance, limits, mark, work.unsettled, queries
        )
        for j in range(n_paths):
            path_rows[j] = remaining[work.unsettled[j]]
        clear_paths(tables.grid, step.before, step.now, path_rows, work.is_clear, 0, n_paths)
        for j in range(n_paths):
            if work.is_clear[j]:
                mark[work.unsettled[j]] |= IS_KEPT
    _find_radii(tables, work, m)
    balls = FootBalls(work.ball_feet[:m], work.radius[:m])
    return settle_marked(
        remaining, feet, known_sides, mark, balls, limits, detected, work.unsettled
    )


@kernel()
def settle_touching(tables, step, last, rows, limits, work, detected, unsettled):
    """Settle points that were in contact, `rows`; list the others and return their number.

    Results of settled points are written into `detected`; of the others only work arrays change.
    `tables` are `ContactTables`, `step` a `Step`, `last` the `SurfacePlaces` of all points,
    `limits` are `Limits`, `work` is `Work` for at least as many rows, `detected` a `Detection`.
    """
    n = settle_by_feet(tables, step, last, rows, limits, work, detected, unsettled)
    for j in range(n):
        unsettled[j] = work.rows[work.unsettled[j]]
    return n


@kernel()
def settle_free(tables, step, rows, limits, work, detected, unsettled):
    """Settle free points near the surface that are outside; list the others, return their number.

    Safe distances of settled points are written into `detected`, and as last feet the feet that
    were searched, of other points too; the balls that touch there prove sides. For arguments see
    `settle_touching`.
    """
    n, band = rows.shape[0], limits.band
    known_sides = Sides(work.side, work.reach)
    places(tables.grid, step.now, rows, known_sides, work.cell_places, 0, n)
    free_rows = FreeRows(work.rows, work.starts.patch, work.starts.uv, work.path.now)
    m = list_starts(
        rows, work.side, work.cell_places, step, detected.last_patch, limits.short_path, free_rows
    )
    _follow_feet(tables, work, m)
    for j in range(m):
        k = rows[work.rows[j]]
        detected.last_patch[k] = work.feet.patch[j]
        detected.uv[k, 0], detected.uv[k, 1] = work.feet.uv[j, 0], work.feet.uv[j, 1]
    n_queries = list_ball_queries(work.feet, m, band, BallQueries(work.ball_feet, work.ball_sides))
    _find_radii(tables, work, n_queries)
    balls = FootBalls(work.ball_feet[:n_queries], work.radius[:n_queries])
    apply_balls(
        work.rows[:m], work.feet, work.path.now, balls, band, known_sides, work.max_distance
    )
    n = keep_free(rows, known_sides, work.none, band, detected.safe_distance, work.unsettled)
    for j in range(n):
        unsettled[j] = rows[work.unsettled[j]]
    return n


@kernel()
def settle_deep(tables, step, last, rows, limits, work, deep, detected, unsettled):
    """Settle points as `settle_touching` does, also by closest points, if the nearest wall pushes.

    `deep` are `DeepRows` for at least as many rows.
    """
    n = settle_by_feet(tables, step, last, rows, limits, work, detected, unsettled)
    # The length of `rows` is the number of candidates for the kernels.
    arrays = deep.candidates
    candidates = Candidates(
        arrays.rows[:n],
        arrays.was_touching,
        arrays.is_kept,
        arrays.status,
        arrays.side,
        arrays.safe_distance,
        arrays.max_distance,
        arrays.guard,
        arrays.depth,
        arrays.is_opposed,
        arrays.feet,
        arrays.closest,
    )
    guard_states, j = step.guard_states, 0
    for a in range(n):
        i = work.unsettled[a]
        candidates.rows[a], candidates.side[a] = work.rows[i], work.side[i]
        candidates.safe_distance[a] = work.reach[i]
        candidates.was_touching[a], candidates.is_kept[a] = True, work.mark[i] & MAY_KEEP > 0
        candidates.status[a] = status_of_kept(work.feet.status[i])
        candidates.max_distance[a] = distance_to_foot(work.feet, i, work.path.now)
        j = row_position(guard_states.rows, work.rows[i], j)
        has_guard = j < guard_states.rows.shape[0] and guard_states.rows[j] == work.rows[i]
        candidates.depth[a] = guard_states.depth[j] if has_guard else 0.0
        candidates.is_opposed[a] = has_guard and guard_states.is_opposed[j]
        for c in range(3):
            candidates.guard[a, c] = guard_states.guard[j, c] if has_guard else 0.0
            deep.now[a, c] = work.path.now[i, c]
        take_foot(candidates.feet, a, work.feet, i)
    project_proved(
        tables.body,
        tables.balls,
        deep.now,
        deep.rows,
        candidates.max_distance,
        candidates.closest,
        0,
        n,
    )
    take_closest(candidates, step.path_length, limits)
    k = 0
    for a in range(n):
        if is_decided(candidates, step, limits, a):
            write_decided(candidates, limits, detected, a)
        else:
            unsettled[k] = work.rows[work.unsettled[a]]
            k += 1
    return k
