"""Closest points of a body: guessed by Newton's method, and the guess proved; else searched for.

Newton's method starts from the leaf kept for the point's voxel, so that the guess is a function of
the point alone. It is the closest point

* if it is no farther off than the radius of a ball that touches the body there and holds no more of
  it (Federer 1959, reach of a set; see `ball_nb`);
* or if branch and bound, which starts with the guess's distance, finds nothing closer.

Both lead to the same numbers: balls only spare work. One of many shapes of a body has no balls:
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
from contiga.search.closest.kernels.foot_nb import no_farther, write_nearest
from contiga.search.closest.kernels.global_among_nb import anywhere
from contiga.search.closest.kernels.global_nb import GIVEN_UP, PRUNE, closest
from contiga.search.closest.kernels.one_foot_nb import foot_from, parameters_of, write_proved
from contiga.search.closest.kernels.proof_nb import is_closest
from contiga.search.hierarchy.kernels.curve_nb import LEFT_OUT
from contiga.search.hierarchy.kernels.face_nb import in_face
from contiga.search.hierarchy.kernels.plates_nb import on_plate
from contiga.search.hierarchy.kernels.tree_nb import next_leaves

FAR = 1e12
"""In sizes of the body: farther than this a foot no longer depends on how far a point is."""
WITHIN = 0.99
"""Share of a touching ball's radius up to which a foot counts as proved: rounding, with much to
spare."""


@inner(linked=False)
def nearest_leaf(tables, point):
    """The leaf of a face whose plate is nearest to a point, −1 where the body has none."""
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
    """The leaf kept for the voxel that holds a point: nearest to its middle, or to a point beyond.

    Whoever asks first finds it; all find the same.
    """
    seeds = tables.seeds
    voxels = seeds.voxels
    at = 0
    for c in range(3):
        x = (point[c] - seeds.low[c]) * seeds.scale[0]
        if not 0.0 <= x < voxels[c]:
            return nearest_leaf(tables, point)
        at = at * voxels[c] + int(x)
    leaf = seeds.leaf[at]
    if leaf < 0:
        side = 1.0 / seeds.scale[0]
        i = at // (voxels[1] * voxels[2])
        j = at // voxels[2] % voxels[1]
        k = at % voxels[2]
        x = seeds.low[0] + (i + 0.5) * side
        y = seeds.low[1] + (j + 0.5) * side
        z = seeds.low[2] + (k + 0.5) * side
        leaf = nearest_leaf(tables, (x, y, z))
        seeds.leaf[at] = leaf
    return leaf


@inner(linked=False)
def _guess(tables, point):
    """A foot inside a face near a point, element −1 where none is found."""
    k = _seed(tables, point)
    if k < 0:
        return Guess(-1, (0.0, 0.0), FootRecord(point, point, 0.0))
    leaf = tables.leaves[k]
    x, y, _ = on_plate(tables.plates[k], point)
    s0, s1, t0, t1 = leaf["box"]
    place = (0.5 * (s0 + s1 + x * (s1 - s0)), 0.5 * (t0 + t1 + y * (t1 - t0)))
    elements = tables.elements
    start = parameters_of(elements.table[leaf["element"]]["box"], place)
    e, place, uv, record = foot_from(tables, leaf["element"], start, point)
    if e >= 0 and not in_face(elements, tables.trims, e, place[0], place[1]):
        e = -1
    return Guess(e, uv, record)


@inner(linked=False)
def _searched(tables, k, point, within, guess, out, nearest, h):
    """Write row k of `out`: the closest point, which is the `Guess` if nothing is closer.

    The body has a point at the distance `within`.
    """
    e, uv, record = guess.element, guess.uv, guess.record
    if e >= 0:
        distance = abs(record.gap)
        closer = closest(tables, point, anywhere(), distance, nearest, h)
        if closer < distance - PRUNE * tables.scale[1]:
            write_nearest(tables, k, point, out, nearest, h)
            return
        if nearest[LEFT_OUT] != GIVEN_UP:
            write_proved(out, k, tables.elements.table[e]["patch"], uv, record)
            out.certified[k] = 1 if nearest[LEFT_OUT] == 0.0 else 0
            return
        within = min(within, distance)
    if math.isfinite(no_farther(tables, point, anywhere(), within, nearest, h)):
        write_nearest(tables, k, point, out, nearest, h)
    else:
        blank_foot(out, k, MAX_ITERATIONS)


@inner()
def _is_finite(point):
    return math.isfinite(point[0] + point[1] + point[2])


@inner()
def _come_near(tables, point):
    """The point, and whether it has been moved: from farther than FAR sizes to there.

    Distances of farther ones round to one number, and their squares may overflow.
    """
    far = FAR * tables.scale[0]
    about = tables.elements.table[0]["origin"]
    x, y, z = point[0] - about[0], point[1] - about[1], point[2] - about[2]
    if x * x + y * y + z * z <= far * far:
        return point, False
    most = max(abs(x), abs(y), abs(z))
    x, y, z = x / most, y / most, z / most
    r = far / math.sqrt(x * x + y * y + z * z)
    return (about[0] + r * x, about[1] + r * y, about[2] + r * z), True


@inner(linked=False)
def _measure(out, k, point):
    """Give row k, found for a point that was moved, the distance of where it is."""
    x, y, z = point[0] - out.point[k, 0], point[1] - out.point[k, 1], point[2] - out.point[k, 2]
    most = max(abs(x), abs(y), abs(z))
    x, y, z = x / most, y / most, z / most
    out.gap[k] = math.copysign(most * math.sqrt(x * x + y * y + z * z), out.gap[k])


@kernel()
def project_global(tables, points, rows, within, out, start, stop):
    """Closest points of points[rows[start:stop]] into the same rows of `out`.

    `within` (one a row of `rows`) are distances of the body known not to be less than theirs.
    """
    h = scratch(4, 6)
    nearest = scratch(4)
    for i in range(start, stop):
        k = rows[i]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        near, moved = _come_near(tables, point)
        _searched(tables, k, near, within[i], _guess(tables, near), out, nearest, h)
        if moved:
            _measure(out, k, point)


@kernel()
def project_proved(tables, balls, points, rows, within, out, start, stop):
    """Do as `project_global`, with the touching balls of the body."""
    h = scratch(4, 6)
    nearest = scratch(4)
    for i in range(start, stop):
        k = rows[i]
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        near, moved = _come_near(tables, point)
        guess = _guess(tables, near)
        if guess.element >= 0:
            (u, v), gap = guess.uv, guess.record.gap
            patch = tables.elements.table[guess.element]["patch"]
            rho = radius_at(balls, tables.grid, patch, u, v, 1 if gap > 0.0 else 0)
            if not moved and abs(gap) <= WITHIN * rho:
                write_proved(out, k, patch, guess.uv, guess.record)
                continue
        _searched(tables, k, near, within[i], guess, out, nearest, h)
        if moved:
            _measure(out, k, point)


@kernel()
def project_from(tables, surroundings, points, starts, out, start, stop):
    """Write the closest points of points[start:stop] into the same rows of `out`.

    Newton's method from the feet `starts` (patch, uv) on another shape of the body, patch −1 for
    none, gives a guess. Points without a guess, or whose guess is not proved, are searched for.
    """
    h = scratch(4, 6)
    nearest = scratch(4)
    for k in range(start, stop):
        point = (points[k, 0], points[k, 1], points[k, 2])
        if not _is_finite(point):
            blank_foot(out, k, NOT_FINITE)
            continue
        near, moved = _come_near(tables, point)
        guess = Guess(-1, (0.0, 0.0), FootRecord(point, point, 0.0))
        patch = starts.patch[k]
        if patch >= 0 and not moved:
            uv = starts.uv[k, 0], starts.uv[k, 1]
            e = locate(tables.grid, patch, uv[0], uv[1])[0]
            e, place, uv, record = foot_from(tables, e, uv, point)
            if e >= 0 and in_face(tables.elements, tables.trims, e, place[0], place[1]):
                foot = e, place[0], place[1]
                if is_closest(tables, surroundings, foot, point, abs(record.gap)):
                    write_proved(out, k, patch, uv, record)
                    continue
                guess = Guess(e, uv, record)
        if guess.element < 0:
            guess = _guess(tables, near)
        _searched(tables, k, near, math.inf, guess, out, nearest, h)
        if moved:
            _measure(out, k, point)
