"""What becomes of points of a closed body whose feet do not tell, where closest points do.

`contiga.contact.judge` says what follows from what, with all the cases in which paths have to be
looked at; most steps have none of these.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import OK
from contiga.contact.kernels.settle_nb import PART, holds_on, remember_foot, take_foot, turns
from contiga.contact.kernels.status_nb import FREE, LOST, OLD, RELEASED
from contiga.jit import inner, kernel

NOT_ASKED = -1
"""Status of closest points that were not asked for."""


@inner()
def _apart(feet, truth, i):
    """How far two feet are apart."""
    x, y = feet.point[i, 0] - truth.point[i, 0], feet.point[i, 1] - truth.point[i, 1]
    z = feet.point[i, 2] - truth.point[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@inner()
def _above_zero(x):
    """x, or zero where that is more or it is no number."""
    return x if x > 0.0 else 0.0


@inner()
def is_needed(was, side, penetration, nearest):
    """Whether a point's closest point is: it tells the side, or how deep one is that comes in, or,
    where the nearest wall pushes, any that is not outside."""
    return side == 0 or (nearest and side < 0) or (not was and penetration)


@kernel()
def take_nearest(asked, feet, truth, held, way, limits):
    """Closest points for feet of points that were in contact, where those may push and the points
    have not left meanwhile: followed feet lead there, or they have gone less far than any surface
    is off.

    `asked` are the columns (rows, was, kept, what becomes of those that are kept), of which the
    last two are filled in; `held` is (guard, depth, whose nearest wall was opposite), `way` that of
    all points, `limits` (band, how far feet that are one may be apart).
    """
    rows, was, kept, becomes = asked
    (guard, deep, opposed), (band, same_foot) = held, limits
    for i in range(rows.shape[0]):
        if kept[i] and feet.certified[i] == 1:
            continue  # it has its closest point already
        kept[i] = False
        if was[i] and not opposed[i] and truth.status[i] == OK and truth.gap[i] <= 0.0:
            gone, depth = way[rows[i]], -truth.gap[i] - band
            there = not math.isfinite(gone) or depth > gone
            if there and gone > PART * depth and turns(truth, i, guard, i):
                there = False
            # What could not be followed is a closest point already.
            led = feet.certified[i] == 0 and _apart(feet, truth, i) <= same_foot
            there = there or led
            kept[i] = there and holds_on(truth, i, guard, i, deep[i] - gone, band)
        if kept[i]:
            becomes[i] = OLD
            take_foot(feet, i, truth, i)


@inner()
def _kind(asked, truth, limits, i):
    """Of row i: whether its closest point was needed, whether its place is known, whether it lies
    inside."""
    was, side = asked[1], asked[4]
    penetration, nearest, band, _, _ = limits
    told = side[i] != 0
    needed = is_needed(was[i], side[i], penetration, nearest)
    solved = not needed or truth.status[i] == OK
    inside = solved and (side[i] < 0 if told else truth.gap[i] <= 0.0)
    deep = inside and (told or truth.gap[i] < -band)
    return needed, solved, inside, deep


@inner(error_model="numpy")
def _is_plain(asked, feet, truth, step, limits, i):
    """Whether neither the path of row i has to be looked at, nor another foot be taken."""
    rows, was, kept = asked[0], asked[1], asked[2]
    way, ignored = step
    penetration, _, _, depth, same_foot = limits
    _, solved, inside, deep = _kind(asked, truth, limits, i)
    has_past = math.isfinite(way[rows[i]])
    known = kept[i] and truth.status[i] != NOT_ASKED
    same = known and _apart(feet, truth, i) <= same_foot
    if inside and not same and has_past and (was[i] or not penetration):
        return False
    near = truth.status[i] == OK and truth.gap[i] <= 0.0 and truth.gap[i] >= -depth
    if penetration and not was[i] and near:
        return False
    old = kept[i] and (inside or not solved)
    free = not was[i] and (ignored[rows[i]] or not has_past)
    return not (deep and not old and (was[i] or (not free and not penetration)))


@inner()
def _free_way(truth, limits, i):
    """Way to the surface of a free point by its closest point; see `judge.free_distance`."""
    penetration, _, band, depth, _ = limits
    if truth.status[i] != OK:
        return 0.0
    if truth.gap[i] > 0.0:
        return _above_zero(truth.gap[i] - band)
    return -_above_zero(-truth.gap[i] - max(band, depth if penetration else 0.0))


@kernel(error_model="numpy")
def judge_plain(asked, feet, truth, step, limits, found):
    """Fill what was `Detected` for the points that are asked for; whether all of them are plain.

    Where one is not nothing is written. `asked` are the columns of `judge.Asked` up to the ways,
    `step` is (way, ignored) of all points, `limits` (search by penetration, whether the nearest
    wall pushes, band, depth, how far feet that are one may be apart).
    """
    rows, was, kept, becomes, side, reach = asked
    band = limits[2]
    status, safe_distance = found.status, found.safe_distance
    for i in range(rows.shape[0]):
        if not _is_plain(asked, feet, truth, step, limits, i):
            return False
    for i in range(rows.shape[0]):
        k = rows[i]
        needed, solved, inside, _ = _kind(asked, truth, limits, i)
        known = (reach[i] if side[i] != 0 else abs(truth.gap[i])) - band
        if kept[i] and (inside or not solved):
            status[k] = becomes[i]
            safe_distance[k] = _above_zero(known) if inside else 0.0
            take_foot(found.feet, k, feet, i)
        else:
            status[k] = LOST if not solved and not kept[i] else RELEASED if was[i] else FREE
            safe_distance[k] = _free_way(truth, limits, i) if needed else side[i] * known
            remember_foot(found, k, truth, i)
    return True
