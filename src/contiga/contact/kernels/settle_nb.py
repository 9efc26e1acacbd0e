"""Points in contact, and free ones near the surface, settled a chunk at a time in one call.

A point lies on the free side or behind the surface, and its foot is the closest point or not. Four
things tell, the cheapest first: the cell that it lies in (closed bodies), the ball that touches at
the foot followed from the last one, how far it has gone since its distance was known, and a search
for its closest point. Points of which these do not tell enough are listed and left to
`contiga.contact.nearest` or `contiga.contact.followed`, and nothing is said of them here: their
paths have to be looked at, or another wall than the nearest may push them.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import AT_BORDER, BRANCH_EVENT, FACE, MAX_ITERATIONS, OK, TRIMMED
from contiga.arrays.kernels.query_nb import blank_foot
from contiga.contact.kernels.carrying_nb import at
from contiga.contact.kernels.status_nb import FREE, HELD, LOST, OLD, REACQUIRED, RELEASED
from contiga.contact.settle_records import Asked, AskedFeet, FootBalls, FreeRows, TouchingRows
from contiga.jit import inner, kernel
from contiga.records import KnownSides, SurfacePlaces
from contiga.search.balls.kernels.ball_nb import radii
from contiga.search.closest.kernels.nearest_nb import project_proved
from contiga.search.sides.kernels.side_nb import clear_ways, places, sides
from contiga.search.track.kernels.track_nb import track_chunks

KEEP, KEPT = 1, 2
"""Marks of a row: its foot would do, and it is sure that it does."""
OPPOSITE = 160.0
"""Degrees between the outward normals of walls that are opposite, as in a wedge of less than 20°.

Walls of a wedge of 30° are not: a point that its edge has run over goes out by either. Those of
ribs and plates are, with the few degrees that they taper by to come out of a mould."""
OPPOSITE_COSINE = math.cos(math.radians(OPPOSITE))
ANOTHER = 0.7
"""Cosine of the normals of walls below which one is another than the other."""
PART = 1.0 / 16.0
"""Share of its depth that a point may go by in one look, where it comes to another wall: others may
have been the nearest on the way."""
INNER, OUTER = 0, 1
"""Sides on which balls touch."""


@inner()
def is_at_border(status):
    """Tell whether the foot stands at a border, or at the edge of a hole."""
    return status in (AT_BORDER, TRIMMED)


@inner()
def _is_foot(status):
    """Tell whether the foot is a stationary point."""
    return status in (OK, BRANCH_EVENT)


@inner()
def _is_sound(feet, i, band):
    """Tell whether a ball that touches at the foot may prove the side of its point."""
    return _is_foot(feet.status[i]) and feet.feature[i] == FACE and abs(feet.gap[i]) > band


@inner()
def length_between(one, other, i):
    """Return the distance between rows i of two arrays of points (n, 3)."""
    x, y, z = one[i, 0] - other[i, 0], one[i, 1] - other[i, 1], one[i, 2] - other[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@inner()
def distance(feet, i, points):
    """Return the distance from point i to its foot; infinite where that may be off the surface."""
    return length_between(points, feet.point, i) if _is_foot(feet.status[i]) else math.inf


@inner()
def _ask_ball(feet, i, asked, m):
    """List foot i as the m-th that a ball is asked for, with its side; return how many there are.

    `asked` are `AskedFeet`.
    """
    asked.which[m] = i
    asked.side[m] = OUTER if feet.gap[i] > 0.0 else INNER
    return m + 1


@inner()
def _by_ball(feet, i, radius, band, side, reach):
    """Improve a side and a lower bound of the distance by the ball that touches at the foot; also
    return whether the ball proves the foot to be the closest point.

    The ball holds no surface: a point is on its side up to 2ρ from the foot, and no wall is nearer
    than the ball's nearer end.
    """
    sign = 1 if feet.gap[i] > 0.0 else -1
    height = abs(feet.gap[i])
    way = min(height, 2.0 * radius - height)
    if way > band and side != -sign:
        side = sign
        reach = max(reach, way)
    return side, reach, height + band <= radius


@inner()
def is_opposite(feet, i, guard, j):
    """Tell whether the wall at foot i is opposite to the guard of row j; none is to a zero."""
    n = feet.normal
    return n[i, 0] * guard[j, 0] + n[i, 1] * guard[j, 1] + n[i, 2] * guard[j, 2] < OPPOSITE_COSINE


@inner()
def holds_on(feet, i, guard, j, least, band):
    """Tell whether foot i may push: it is not opposite to the guard of row j, and no less deep than
    `least`, so that it has become as near within the step."""
    return -feet.gap[i] >= least - 2.0 * band and not is_opposite(feet, i, guard, j)


@inner()
def turns(feet, i, guard, j):
    """Tell whether the wall at foot i is another than the one that held row j."""
    n = feet.normal
    g = guard[j, 0], guard[j, 1], guard[j, 2]
    along = n[i, 0] * g[0] + n[i, 1] * g[1] + n[i, 2] * g[2]
    return along < ANOTHER and g[0] * g[0] + g[1] * g[1] + g[2] * g[2] > 0.0


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
    """Store the foot of a free point: the next step proves the side of the point by it."""
    detected.last_patch[k] = feet.patch[i]
    detected.uv[k, 0] = feet.uv[i, 0]
    detected.uv[k, 1] = feet.uv[i, 1]


@inner()
def stay(rows, known, step, last, detected, band, staying):
    """Release points in contact that are outside; list what is known of the others in `staying`.

    `known` are `KnownSides`, `step` a `Step`, `last` the `SurfacePlaces` of the feet of all points,
    `detected` what was `Detected`; `staying` are `TouchingRows`, which may be where it is read
    from. No `before` is filled in that has no rows. Returns how many there are.
    """
    side, reach, before = known.side, known.reach, staying.before
    n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        if side[i] > 0:
            detected.status[k] = RELEASED
            detected.safe_distance[k] = reach[i] - band
            continue
        staying.rows[n], staying.side[n], staying.reach[n] = k, side[i], reach[i]
        staying.patch[n] = last.patch[k]
        staying.uv[n, 0], staying.uv[n, 1] = last.uv[k, 0], last.uv[k, 1]
        for c in range(3):
            staying.now[n, c] = step.now[k, c]
        if before.shape[0] > 0:
            for c in range(3):
                before[n, c] = step.before[k, c]
        n += 1
    return n


@inner()
def look(rows, feet, side, safe_distance, limits, mark, ways, asked):
    """Mark points in contact by their feet; list those whose ways must be examined, and those whose
    side a ball may prove, with that side. Returns how many there are of each.

    `limits` are `Limits`, `safe_distance` is of all points; `asked` are `AskedFeet` to be filled.
    """
    hold, band = limits.hold, limits.band
    n = m = 0
    for i in range(rows.shape[0]):
        status = feet.status[i]
        solved = _is_foot(status) or (hold and is_at_border(status))
        mark[i] = 0
        if solved and feet.gap[i] <= 0.0:
            mark[i] = KEEP
            # What is no deeper than rounding is on the surface.
            if safe_distance[rows[i]] > 0.0 or -feet.gap[i] <= band:
                mark[i] = KEEP | KEPT
                continue
            if side[i] < 0:
                ways[n] = i
                n += 1
        if _is_sound(feet, i, band):
            m = _ask_ball(feet, i, asked, m)
    return n, m


@inner()
def face(rows, feet, holds, way, band, mark, asked):
    """Do as `look` where the nearest wall pushes that is not opposite: no way must be examined.

    `holds` are those of the last step, `way` is that of all points.
    """
    m = j = 0
    for i in range(rows.shape[0]):
        mark[i] = 0
        j = at(holds.rows, rows[i], j)
        held = j < holds.rows.shape[0] and holds.rows[j] == rows[i]
        # What could not be followed is a closest point, which is proved: its way is looked at.
        sound = feet.certified[i] == 0 and _is_foot(feet.status[i]) and feet.gap[i] <= 0.0
        if sound and held:
            least = holds.depth[j] - way[rows[i]]
            sound = not holds.opposed[j] and holds_on(feet, i, holds.guard, j, least, band)
        if sound:
            mark[i] = KEEP
            # What is no deeper than rounding is on the surface.
            if -feet.gap[i] <= band:
                mark[i] = KEEP | KEPT
                feet.certified[i] = 1
                continue
        if feet.certified[i] == 0 and _is_sound(feet, i, band):
            m = _ask_ball(feet, i, asked, m)
    return m


@inner()
def settle(rows, feet, known, mark, balls, limits, detected, left):
    """Decide what becomes of points in contact that are marked; returns how many are left.

    `known` are `KnownSides`, `balls` are `FootBalls` of those that were asked for one, `detected`
    is what was `Detected`. Those left are listed in `left`, and nothing is said of them. In front
    of an open body a point may be behind another sheet of it.
    """
    band, closed = limits.band, limits.closed
    side, reach = known.side, known.reach
    index, radius = balls.which, balls.radius
    status, safe_distance = detected.status, detected.safe_distance
    j = n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        nearest = False
        if j < index.shape[0] and index[j] == i:
            if not mark[i] & KEPT:
                side[i], reach[i], nearest = _by_ball(feet, i, radius[j], band, side[i], reach[i])
            j += 1
        if nearest and mark[i] & KEEP:
            mark[i] |= KEPT
            feet.certified[i] = 1
        if side[i] > 0 and closed:
            status[k] = RELEASED
            safe_distance[k] = reach[i] - band
            remember_foot(detected, k, feet, i)
        elif side[i] <= 0 and mark[i] & KEPT:
            way = reach[i] - band if side[i] < 0 and closed else 0.0
            if not safe_distance[k] >= way:
                safe_distance[k] = way
            status[k] = becomes(feet.status[i])
            take_foot(detected.feet, k, feet, i)
        else:
            left[n] = i
            n += 1
    return n


@inner()
def becomes(status):
    """Return the `ContactStatus` of a point in contact whose foot, of this status, is kept."""
    if status == BRANCH_EVENT:
        return REACQUIRED
    return HELD if is_at_border(status) else OLD


@inner()
def starts(rows, side, place, step, last_patch, far, begun):
    """List the free points of unknown side and the starting points of the search for their feet:
    the last foot, or a place near by for points that have moved farther than `far`.

    `place` are `SurfacePlaces` in the points' cells, `step` is a `Step`, `last_patch` that of the
    last feet of all points; `begun` are `FreeRows`, to be filled. Returns how many have a start.
    """
    patch, uv = place.patch, place.uv
    way, old_patch, old_uv = step.way, step.last_patch, step.uv
    n = 0
    for i in range(rows.shape[0]):
        k = rows[i]
        if side[i] != 0:
            last_patch[k] = -1
            continue
        if old_patch[k] >= 0 and (way[k] <= far or patch[i] < 0):
            begun.patch[n] = old_patch[k]
            begun.uv[n, 0], begun.uv[n, 1] = old_uv[k, 0], old_uv[k, 1]
        elif patch[i] >= 0:
            begun.patch[n] = patch[i]
            begun.uv[n, 0], begun.uv[n, 1] = uv[i, 0], uv[i, 1]
        else:
            continue
        begun.which[n] = i
        for c in range(3):
            begun.now[n, c] = step.now[k, c]
        n += 1
    return n


@inner()
def askable(feet, count, band, asked):
    """List in `asked` (AskedFeet) the first feet that touching balls apply to; return how many."""
    m = 0
    for i in range(count):
        if _is_sound(feet, i, band):
            m = _ask_ball(feet, i, asked, m)
    return m


@inner()
def tell(index, feet, points, balls, band, known, within):
    """Fill in the sides that balls at feet prove, and how far points are from their feet.

    Foot m is that of points[m]; `index` says in which rows of `known` (KnownSides) and `within`,
    the distance to a point of the surface, that is filled in. `balls` are `FootBalls` of the feet
    that were asked for one.
    """
    side, reach = known.side, known.reach
    asked, radius = balls.which, balls.radius
    j = 0
    for m in range(index.shape[0]):
        i = index[m]
        within[i] = distance(feet, m, points)
        if j < asked.shape[0] and asked[j] == m:
            side[i], reach[i], _ = _by_ball(feet, m, radius[j], band, side[i], reach[i])
            j += 1


@inner()
def leave(rows, known, held, band, safe_distance, left):
    """Keep points free that are outside, or `held` inside; list the others and return how many."""
    side, reach = known.side, known.reach
    n = 0
    for i in range(rows.shape[0]):
        if side[i] > 0 or held[i]:
            safe_distance[rows[i]] = side[i] * (reach[i] - band)
        else:
            left[n] = i
            n += 1
    return n


NOT_ASKED = -1
"""Status of closest points that were not asked for."""


@inner()
def _above_zero(x):
    """Return x, or zero where x is negative or no number."""
    return x if x > 0.0 else 0.0


@inner()
def is_needed(was, side, penetration, nearest):
    """Tell whether a point needs its closest point: for its side, for the depth of one that comes
    in, or, where the nearest wall pushes, of any that is not outside."""
    return side == 0 or (nearest and side < 0) or (not was and penetration)


@kernel()
def take_nearest(asked, way, limits):
    """Make closest points the feet of points that were in contact, where those may push and the
    points have not left meanwhile: followed feet lead there, or they have gone less far than any
    surface is off.

    `asked` are `Asked`, of which feet, `kept` and `status` are filled in; `way` is that of all
    points, `limits` are `Limits`.
    """
    kept, feet, truth, band = asked.kept, asked.feet, asked.truth, limits.band
    for i in range(asked.rows.shape[0]):
        if kept[i] and feet.certified[i] == 1:
            continue  # it has its closest point already
        kept[i] = False
        may = asked.was[i] and not asked.opposed[i]
        if may and truth.status[i] == OK and truth.gap[i] <= 0.0:
            gone, depth = way[asked.rows[i]], -truth.gap[i] - band
            there = not math.isfinite(gone) or depth > gone
            if there and turns(truth, i, asked.guard, i):
                # On an open body a wall entered around its border must not take over, and on no
                # body a wall opposite to the rotated guard.
                there = gone <= PART * depth and limits.closed
                there = there and not is_opposite(truth, i, feet.normal, i)
            # What could not be followed is a closest point already.
            led = (
                feet.certified[i] == 0
                and length_between(feet.point, truth.point, i) <= limits.same_foot
            )
            there = there or led
            least = asked.depth[i] - gone
            kept[i] = there and holds_on(truth, i, asked.guard, i, least, band)
        if kept[i]:
            asked.status[i] = OLD
            take_foot(feet, i, truth, i)


@inner()
def _kind(asked, limits, i):
    """Classify row i: closest point needed, position known, inside, inside beyond rounding."""
    truth, side = asked.truth, asked.side[i]
    needed = is_needed(asked.was[i], side, limits.penetration, limits.nearest)
    solved = not needed or truth.status[i] == OK
    inside = solved and (side < 0 if side != 0 else truth.gap[i] <= 0.0)
    deep = inside and (side != 0 or truth.gap[i] < -limits.band)
    return needed, solved, inside, deep


@inner(error_model="numpy")
def is_plain(asked, step, limits, i):
    """Tell whether row i needs neither a look at its path nor another foot."""
    k, was, kept, truth = asked.rows[i], asked.was[i], asked.kept[i], asked.truth
    if not limits.closed:
        return kept
    _, solved, inside, deep = _kind(asked, limits, i)
    has_past = math.isfinite(step.way[k])
    known = kept and truth.status[i] != NOT_ASKED
    same = known and length_between(asked.feet.point, truth.point, i) <= limits.same_foot
    if inside and not same and has_past and (was or not limits.penetration):
        return False
    near = truth.status[i] == OK and truth.gap[i] <= 0.0 and truth.gap[i] >= -limits.depth
    if limits.penetration and not was and near:
        return False
    old = kept and (inside or not solved)
    free = not was and (step.ignored[k] or not has_past)
    return not (deep and not old and (was or (not free and not limits.penetration)))


@inner(error_model="numpy")
def write_plain(asked, limits, detected, i):
    """Write what becomes of row i, which `is_plain`, into `detected`."""
    truth, status, safe_distance = asked.truth, detected.status, detected.safe_distance
    k, was, kept, side = asked.rows[i], asked.was[i], asked.kept[i], asked.side[i]
    needed, solved, inside, _ = _kind(asked, limits, i)
    known = (asked.safe_distance[i] if side != 0 else abs(truth.gap[i])) - limits.band
    if kept and (inside or not solved):
        status[k] = asked.status[i]
        # A point may slide off an open body without having crossed it.
        safe_distance[k] = _above_zero(known) if inside and limits.closed else 0.0
        take_foot(detected.feet, k, asked.feet, i)
    else:
        status[k] = LOST if not solved and not kept else RELEASED if was else FREE
        way = 0.0  # of a free point: see `foot_rows.free_distance`
        if truth.status[i] == OK and truth.gap[i] > 0.0:
            way = _above_zero(truth.gap[i] - limits.band)
        elif truth.status[i] == OK:
            reach = limits.depth if limits.penetration else 0.0
            way = -_above_zero(-truth.gap[i] - max(limits.band, reach))
        safe_distance[k] = way if needed else side * known
        remember_foot(detected, k, truth, i)


@kernel(error_model="numpy")
def judge_plain(asked, step, limits, detected):
    """Write what becomes of the points that are `asked` for; tell whether all of them are plain.

    If one is not, nothing is written. `step` is a `Step`, `limits` are `Limits`.
    """
    for i in range(asked.rows.shape[0]):
        if not is_plain(asked, step, limits, i):
            return False
    for i in range(asked.rows.shape[0]):
        write_plain(asked, limits, detected, i)
    return True


@inner(linked=False)
def _follow(tables, work, n):
    """Follow the feet of the first n rows of `work` in lanes; those that need more have none."""
    start = work.starts
    m = track_chunks(
        tables.body, work.path, start, n, work.records, work.left, work.feet, (0, 1 if n else 0)
    )
    for j in range(m):
        blank_foot(work.feet, work.left.rows[j], MAX_ITERATIONS)


@inner(linked=False)
def _ask_balls(tables, work, m):
    """Look up the radii of the balls at the first m feet that are asked for."""
    feet = SurfacePlaces(work.feet.patch, work.feet.uv)
    radii(tables.balls, tables.body.grid, feet, work.asked, work.which, work.radius, 0, m)


@inner(linked=False)
def settled(tables, step, last, rows, limits, work, detected, left):
    """Settle points that were in contact, `rows`; returns how many of `work.rows` are left, listed
    in `work.chosen`. `left` is memory. The rest is as of `settle_touching`."""
    n, band = rows.shape[0], limits.band
    side, reach = work.side, work.reach
    sides(tables.grid, step.now, rows, side, reach, 0, n)
    known, begun, path = KnownSides(side, reach), work.starts, work.path
    columns = TouchingRows(work.rows, side, reach, begun.patch, begun.uv, path.before, path.now)
    n = stay(rows, known, step, last, detected, band, columns)
    _follow(tables, work, n)
    staying, feet, mark = work.rows[:n], work.feet, work.mark
    asked = AskedFeet(work.asked, work.which)
    if limits.nearest:
        m = face(staying, feet, step.holds, step.way, band, mark, asked)
    else:
        ways, m = look(
            staying, feet, side, detected.safe_distance, limits, mark, work.chosen, asked
        )
        for j in range(ways):
            left[j] = staying[work.chosen[j]]
        clear_ways(tables.grid, step.before, step.now, left, work.clear, 0, ways)
        for j in range(ways):
            if work.clear[j]:
                mark[work.chosen[j]] |= KEPT
    _ask_balls(tables, work, m)
    balls = FootBalls(work.asked[:m], work.radius[:m])
    return settle(staying, feet, known, mark, balls, limits, detected, work.chosen)


@kernel()
def settle_touching(tables, step, last, rows, limits, work, detected, left):
    """Settle points that were in contact, `rows`; returns how many are `left`, listed there.

    `tables` are `ContactTables`, `step` a `Step`, `last` the `SurfacePlaces` of all points,
    `limits` are `Limits`, `work` is `Work` for as many rows or more, `detected` is what was
    `Detected`.
    """
    n = settled(tables, step, last, rows, limits, work, detected, left)
    for j in range(n):
        left[j] = work.rows[work.chosen[j]]
    return n


@kernel()
def settle_free(tables, step, rows, limits, work, detected, left):
    """Settle free points near the surface that stay free; the rest as of `settle_touching`."""
    n, band = rows.shape[0], limits.band
    known = KnownSides(work.side, work.reach)
    places(tables.grid, step.now, rows, known, work.near, 0, n)
    columns = FreeRows(work.rows, work.starts.patch, work.starts.uv, work.path.now)
    m = starts(rows, work.side, work.near, step, detected.last_patch, limits.far, columns)
    _follow(tables, work, m)
    for j in range(m):
        k = rows[work.rows[j]]
        detected.last_patch[k] = work.feet.patch[j]
        detected.uv[k, 0], detected.uv[k, 1] = work.feet.uv[j, 0], work.feet.uv[j, 1]
    asked = askable(work.feet, m, band, AskedFeet(work.asked, work.which))
    _ask_balls(tables, work, asked)
    balls = FootBalls(work.asked[:asked], work.radius[:asked])
    tell(work.rows[:m], work.feet, work.path.now, balls, band, known, work.within)
    n = leave(rows, known, work.none, band, detected.safe_distance, work.chosen)
    for j in range(n):
        left[j] = rows[work.chosen[j]]
    return n


@kernel()
def settle_deep(tables, step, last, rows, limits, work, deep, detected, left):
    """Settle points as `settle_touching`, by closest points too, where the nearest wall pushes.

    `deep` are `DeepRows` for as many rows or more.
    """
    n = settled(tables, step, last, rows, limits, work, detected, left)
    # Kernels go by how many `rows` there are.
    of = deep.asked
    asked = Asked(
        of.rows[:n],
        of.was,
        of.kept,
        of.status,
        of.side,
        of.safe_distance,
        of.within,
        of.guard,
        of.depth,
        of.opposed,
        of.feet,
        of.truth,
    )
    holds, j = step.holds, 0
    for a in range(n):
        i = work.chosen[a]
        asked.rows[a], asked.side[a] = work.rows[i], work.side[i]
        asked.safe_distance[a] = work.reach[i]
        asked.was[a], asked.kept[a] = True, work.mark[i] & KEEP > 0
        asked.status[a] = becomes(work.feet.status[i])
        asked.within[a] = distance(work.feet, i, work.path.now)
        j = at(holds.rows, work.rows[i], j)
        is_held = j < holds.rows.shape[0] and holds.rows[j] == work.rows[i]
        asked.depth[a] = holds.depth[j] if is_held else 0.0
        asked.opposed[a] = is_held and holds.opposed[j]
        for c in range(3):
            asked.guard[a, c] = holds.guard[j, c] if is_held else 0.0
            deep.now[a, c] = work.path.now[i, c]
        take_foot(asked.feet, a, work.feet, i)
    project_proved(tables.body, tables.balls, deep.now, deep.which, asked.within, asked.truth, 0, n)
    take_nearest(asked, step.way, limits)
    k = 0
    for a in range(n):
        if is_plain(asked, step, limits, a):
            write_plain(asked, limits, detected, a)
        else:
            left[k] = work.rows[work.chosen[a]]
            k += 1
    return k
