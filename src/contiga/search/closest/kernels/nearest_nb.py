"""Closest points of a body: a guess by Newton's method, and its proof; otherwise a search.

Newton's method starts from the leaf cached for the point's voxel, so that the guess is a function
of the point alone. It is the closest point

* if it is no farther away than the radius of a ball that touches the body there and holds no other
  point of it (Federer 1959, reach of a set; see `ball_nb`);
* or if branch and bound, which starts with the guess's distance, finds nothing closer.

Both lead to the same numbers: balls only save work. One of many shapes of a body has no balls;
there Newton's method starts from a foot on another shape, and `proof_nb` proves the result.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import MAX_ITERATIONS, NOT_FINITE
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.elements.kernels.element_nb import locate
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.balls.kernels.ball_nb import radius_at
from contiga.search.closest.closest_records import FootRecord, Guess
from contiga.search.closest.kernels.foot_nb import closest_within, write_nearest
from contiga.search.closest.kernels.global_nb import MIN_GAIN, OVER_BUDGET, closest
from contiga.search.closest.kernels.global_scope_nb import all_patches
from contiga.search.closest.kernels.one_foot_nb import newton_foot, parameters_of, write_certified
from contiga.search.closest.kernels.proof_nb import is_closest
from contiga.search.hierarchy.kernels.curve_nb import LEFT_OUT
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.hierarchy.kernels.plates_nb import on_plate
from contiga.search.hierarchy.kernels.tree_nb import next_leaves

MAX_DISTANCE = 1e12
"""Distance beyond which a foot no longer depends on the distance of its point, in sizes of the
body."""
BALL_SHARE = 0.99
"""Share of a touching ball's radius up to which a foot counts as proved: rounding, with a wide
margin."""


@inner(linked=False)
def nearest_leaf(tables, point):
    """Return the leaf of a face whose plate is nearest to a point; −1 where the body has none.

    The first found of equally near ones; departures of leaves from plates do not count.
    """
    tree = tables.tree
    leaves = tables.leaves
    nodes = stack_int64(128)
    bounds = scratch(128)
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1 if leaves.shape[0] > 0 else 0
    best = math.inf
    leaf = -1
    while True:
        node, top = next_leaves(tree, point, best, nodes, bounds, top)
        if node < 0:
            return leaf
        first = tree[node]["first"]
        for k in range(first, first + tree[node]["count"]):
            if leaves[k]["element"] >= 0:
                square = on_plate(tables.plates[k], point)[2]
                if square < best:
                    best = square
                    leaf = k


@inner()
def _seed(tables, point):
    """Return the leaf nearest to the middle of a point's voxel, or to a point beyond the voxels.

    It is −1 for a body without leaves. The first query of a voxel stores its leaf in
    `tables.seeds`; every query would find the same one.
    """
    seeds = tables.seeds
    voxels = seeds.voxels
    voxel = 0
    for c in range(3):
        x = (point[c] - seeds.low[c]) * seeds.scale[0]
        if not 0.0 <= x < voxels[c]:
            return nearest_leaf(tables, point)
        voxel = voxel * voxels[c] + int(x)
    leaf = seeds.leaf[voxel]
    if leaf < 0:
        side = 1.0 / seeds.scale[0]
        i = voxel // (voxels[1] * voxels[2])
        j = voxel // voxels[2] % voxels[1]
        k = voxel % voxels[2]
        x = seeds.low[0] + (i + 0.5) * side
        y = seeds.low[1] + (j + 0.5) * side
        z = seeds.low[2] + (k + 0.5) * side
        leaf = nearest_leaf(tables, (x, y, z))
        seeds.leaf[voxel] = leaf
    return leaf


@inner(linked=False)
def _guess(tables, point):
    """Return a foot inside a face near a point, as a `Guess` of element −1 if none is found.

    Newton's method starts from the plate of the point's seed.
    """
    k = _seed(tables, point)
    if k < 0:
        return Guess(-1, (0.0, 0.0), FootRecord(point, point, 0.0))
    leaf = tables.leaves[k]
    x, y, _ = on_plate(tables.plates[k], point)
    s0, s1, t0, t1 = leaf["box"]
    place = (0.5 * (s0 + s1 + x * (s1 - s0)), 0.5 * (t0 + t1 + y * (t1 - t0)))
    elements = tables.elements
    start = parameters_of(elements.table[leaf["element"]]["box"], place)
    e, place, uv, record = newton_foot(tables, leaf["element"], start, point)
    if e >= 0 and not in_face(elements, tables.trims, e, place[0], place[1]):
        e = -1
    return Guess(e, uv, record)


@inner(linked=False)
def _search(tables, k, point, within, guess, out, nearest, h):
    """Write row k of `out`: the closest point, which is the `Guess` if nothing is closer.

    Closer means by more than `MIN_GAIN` tolerances; the row is certified if the search left out
    nothing. The body has a point within the distance `within`; if no search finds one, the row is
    blank with the status MAX_ITERATIONS. For other statuses see `write_nearest`.
    """
    e, uv, record = guess.element, guess.uv, guess.record
    if e >= 0:
        distance = abs(record.gap)
        closest_distance = closest(tables, point, all_patches(), distance, nearest, h)
        if closest_distance < distance - MIN_GAIN * tables.scale[1]:
            write_nearest(tables, k, point, out, nearest, h)
            return
        if nearest[LEFT_OUT] != OVER_BUDGET:
            write_certified(out, k, tables.elements.table[e]["patch"], uv, record)
            out.certified[k] = 1 if nearest[LEFT_OUT] == 0.0 else 0
            return
        within = min(within, distance)
    if math.isfinite(closest_within(tables, point, all_patches(), within, nearest, h)):
        write_nearest(tables, k, point, out, nearest, h)
    else:
        blank_foot(out, k, MAX_ITERATIONS)


@inner()
def _is_finite(point):
    """Return whether all coordinates of a point are finite."""
    return math.isfinite(point[0] + point[1] + point[2])


@inner()
def _limit_distance(tables, point):
    """Return the point, moved to `MAX_DISTANCE` if it is beyond, and whether it was moved.

    Distances of points beyond round to one number, and their squares may overflow. The point moves
    towards the origin of the first element.
    """
    limit = MAX_DISTANCE * tables.scale[0]
    origin = tables.elements.table[0]["origin"]
    x, y, z = point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]
    if x * x + y * y + z * z <= limit * limit:
        return point, False
    largest = max(abs(x), abs(y), abs(z))
    x, y, z = x / largest, y / largest, z / largest
    r = limit / math.sqrt(x * x + y * y + z * z)
    return (origin[0] + r * x, origin[1] + r * y, origin[2] + r * z), True


@inner(linked=False)
def _correct_gap(out, k, point):
    """Set the gap of row k, found for a point that was moved, to the distance of `point` itself."""
    x, y, z = point[0] - out.point[k, 0], point[1] - out.point[k, 1], point[2] - out.point[k, 2]
    largest = max(abs(x), abs(y), abs(z))
    x, y, z = x / largest, y / largest, z / largest
    out.gap[k] = math.copysign(largest * math.sqrt(x * x + y * y + z * z), out.gap[k])


@kernel()
def project_global(tables, points, rows, within, out, start, stop):
    """Write the closest points of points[rows[start:stop]] to the same rows of `out`.

    `within` (one for each of `rows`) are upper bounds of their distances. Points that are not
    finite get blank rows with NOT_FINITE; for other statuses see `_search`. Fills `tables.seeds`.
    """
    h = scratch(4, 6)
    nearest = scratch(4)
    for i in range(start, stop):
        k = rows[i]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        query, is_moved = _limit_distance(tables, point)
        _search(tables, k, query, within[i], _guess(tables, query), out, nearest, h)
        if is_moved:
            _correct_gap(out, k, point)


@kernel()
def project_proved(tables, balls, points, rows, within, out, start, stop):
    """Write the same as `project_global`; guesses inside touching `balls` need no search."""
    h = scratch(4, 6)
    nearest = scratch(4)
    for i in range(start, stop):
        k = rows[i]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        query, is_moved = _limit_distance(tables, point)
        guess = _guess(tables, query)
        if guess.element >= 0:
            (u, v), gap = guess.uv, guess.record.gap
            patch = tables.elements.table[guess.element]["patch"]
            radius = radius_at(balls, tables.grid, patch, u, v, 1 if gap > 0.0 else 0)
            if not is_moved and abs(gap) <= BALL_SHARE * radius:
                write_certified(out, k, patch, guess.uv, guess.record)
                continue
        _search(tables, k, query, within[i], guess, out, nearest, h)
        if is_moved:
            _correct_gap(out, k, point)


@kernel()
def project_from(tables, surroundings, points, starts, out, start, stop):
    """Write the closest points of points[start:stop] to the same rows of `out`.

    Newton's method from the feet `starts` (patch, uv; patch −1 for none) on another shape of the
    body gives a guess. If `is_closest` proves it, it is written as certified; otherwise branch and
    bound finds the closest point. Points that are not finite get blank rows with NOT_FINITE.
    """
    h = scratch(4, 6)
    nearest = scratch(4)
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        query, is_moved = _limit_distance(tables, point)
        guess = Guess(-1, (0.0, 0.0), FootRecord(point, point, 0.0))
        patch = starts.patch[k]
        if patch >= 0 and not is_moved:
            uv = starts.uv[k, 0], starts.uv[k, 1]
            e = locate(tables.grid, patch, uv[0], uv[1])[0]
            e, place, uv, record = newton_foot(tables, e, uv, point)
            if e >= 0 and in_face(tables.elements, tables.trims, e, place[0], place[1]):
                foot = e, place[0], place[1]
                if is_closest(tables, surroundings, foot, point, abs(record.gap)):
                    write_certified(out, k, patch, uv, record)
                    continue
                guess = Guess(e, uv, record)
        if guess.element < 0:
            guess = _guess(tables, query)
        _search(tables, k, query, math.inf, guess, out, nearest, h)
        if is_moved:
            _correct_gap(out, k, point)
