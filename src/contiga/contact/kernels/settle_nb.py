"""Points of a closed body whose sides and feet tell what becomes of them: settled in single passes.

Between the passes the body is asked, for all rows at once: for sides (`Surface.sides`), feet, ways
that are clear of surface, and balls that touch at feet. `closed_body` says what follows from what.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import AT_BORDER, BRANCH_EVENT, FACE, OK, TRIMMED
from contiga.contact.kernels.carrying_nb import at
from contiga.contact.kernels.status_nb import HELD, OLD, REACQUIRED, RELEASED
from contiga.jit import inner, kernel

KEEP, KEPT = 1, 2
"""Marks of a row: its foot would do, and it is sure that it does."""
OPPOSITE = 160.0
"""Degrees between the outward normals of walls that are opposite, as in a wedge of less than 20°.

Walls of a wedge of 30° are not: a point that its edge has run over goes out by either. Those of
ribs and plates are, with the few degrees that they taper by to come out of a mould."""
LEAST = math.cos(math.radians(OPPOSITE))
ANOTHER = 0.7
"""Cosine of the normals of walls below which one is another than the other."""
PART = 1.0 / 16.0
"""Share of its depth that a point may go by in one look, where it comes to another wall: others may
have been the nearest on the way."""
INNER, OUTER = 0, 1
"""Sides on which balls touch."""


@inner()
def _at_border(status):
    return status in (AT_BORDER, TRIMMED)


@inner()
def _is_foot(status):
    """Whether the foot is a stationary point."""
    return status in (OK, BRANCH_EVENT)


@inner()
def _is_sound(feet, i, band):
    """Whether a ball that touches at the foot may tell the side of its point."""
    return _is_foot(feet.status[i]) and feet.feature[i] == FACE and abs(feet.gap[i]) > band


@inner()
def distance(feet, i, p):
    """From a point to its foot; infinite where that may be off the surface."""
    if not _is_foot(feet.status[i]):
        return math.inf
    x, y, z = p[0] - feet.point[i, 0], p[1] - feet.point[i, 1], p[2] - feet.point[i, 2]
    return math.sqrt(x * x + y * y + z * z)


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
    """Whether the wall at foot i is opposite to the guard of row j, none where that is zero."""
    n = feet.normal
    return n[i, 0] * guard[j, 0] + n[i, 1] * guard[j, 1] + n[i, 2] * guard[j, 2] < LEAST


@inner()
def holds_on(feet, i, guard, j, least, band):
    """Whether foot i may push: it is not opposite to the guard of row j, and has become as near
    within the step, if it was not before: it is no less deep than `least`."""
    return -feet.gap[i] >= least - 2.0 * band and not is_opposite(feet, i, guard, j)


@inner()
def turns(feet, i, guard, j):
    """Whether the wall at foot i is another than the one that held row j."""
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


@kernel()
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


@kernel()
def look(rows, feet, side, safe_distance, limits, mark, ways, asked):
    """Marks of points in contact by their feet; lists of those whose ways are to be looked at, and
    of those that balls may tell of, with the side of these. Returns how many they are.

    `limits` are `Limits`, `safe_distance` is of all points; `asked` are `AskedFeet` to be filled.
    """
    hold, band = limits.hold, limits.band
    index, which_side = asked.which, asked.side
    n = m = 0
    for i in range(rows.shape[0]):
        status = feet.status[i]
        solved = _is_foot(status) or (hold and _at_border(status))
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
            index[m] = i
            which_side[m] = OUTER if feet.gap[i] > 0.0 else INNER
            m += 1
    return n, m


@kernel()
def face(rows, feet, holds, way, band, mark, asked):
    """As `look`, where the nearest wall that is not opposite pushes: no way has to be looked at.

    `holds` are those of the last step, `way` is that of all points.
    """
    index, which_side = asked.which, asked.side
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
            index[m] = i
            which_side[m] = OUTER if feet.gap[i] > 0.0 else INNER
            m += 1
    return m


@kernel()
def settle(rows, feet, known, mark, balls, band, detected, left):
    """What becomes of points in contact that have been looked at; returns how many are left.

    `known` are `KnownSides`, `balls` are `FootBalls` of those that were asked for one, `detected`
    is what was `Detected`. Those left are listed in `left`, and nothing is said of them.
    """
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
        if side[i] > 0:
            status[k] = RELEASED
            safe_distance[k] = reach[i] - band
            remember_foot(detected, k, feet, i)
        elif mark[i] & KEPT:
            way = reach[i] - band if side[i] < 0 else 0.0
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
    return HELD if _at_border(status) else OLD


@kernel()
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


@kernel()
def askable(feet, count, band, asked):
    """List in `asked` (AskedFeet) the first feet that touching balls apply to; return how many."""
    index, which_side = asked.which, asked.side
    m = 0
    for i in range(count):
        if _is_sound(feet, i, band):
            index[m] = i
            which_side[m] = OUTER if feet.gap[i] > 0.0 else INNER
            m += 1
    return m


@kernel()
def tell(index, feet, points, balls, band, known, within):
    """Sides that balls at feet prove, and how far points are from their feet.

    Foot m is that of points[m]; `index` says in which rows of `known` (KnownSides) and `within`,
    the distance to a point of the surface, that is filled in. `balls` are `FootBalls` of the feet
    that were asked for one.
    """
    side, reach = known.side, known.reach
    asked, radius = balls.which, balls.radius
    j = 0
    for m in range(index.shape[0]):
        i = index[m]
        within[i] = distance(feet, m, points[m])
        if j < asked.shape[0] and asked[j] == m:
            side[i], reach[i], _ = _by_ball(feet, m, radius[j], band, side[i], reach[i])
            j += 1


@kernel()
def leave(rows, known, held, band, safe_distance, left):
    """Free points that stay so: outside, or `held` inside. Lists the others; how many there are."""
    side, reach = known.side, known.reach
    n = 0
    for i in range(rows.shape[0]):
        if side[i] > 0 or held[i]:
            safe_distance[rows[i]] = side[i] * (reach[i] - band)
        else:
            left[n] = i
            n += 1
    return n
