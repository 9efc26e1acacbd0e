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
def take_nearest(asked, way, limits):
    """Closest points for feet of points that were in contact, where those may push and the points
    have not left meanwhile: followed feet lead there, or they have gone less far than any surface
    is off.

    `asked` are `Asked`, of which feet, `kept` and `status` are filled in; `way` is that of all
    points, `limits` are `JudgeLimits`.
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
            if there and gone > PART * depth and turns(truth, i, asked.guard, i):
                there = False
            # What could not be followed is a closest point already.
            led = feet.certified[i] == 0 and _apart(feet, truth, i) <= limits.same_foot
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
    """Whether neither the path of row i has to be looked at, nor another foot be taken."""
    k, was, kept, truth = asked.rows[i], asked.was[i], asked.kept[i], asked.truth
    _, solved, inside, deep = _kind(asked, limits, i)
    has_past = math.isfinite(step.way[k])
    known = kept and truth.status[i] != NOT_ASKED
    same = known and _apart(asked.feet, truth, i) <= limits.same_foot
    if inside and not same and has_past and (was or not limits.penetration):
        return False
    near = truth.status[i] == OK and truth.gap[i] <= 0.0 and truth.gap[i] >= -limits.depth
    if limits.penetration and not was and near:
        return False
    old = kept and (inside or not solved)
    free = not was and (step.ignored[k] or not has_past)
    return not (deep and not old and (was or (not free and not limits.penetration)))


@inner()
def _free_way(truth, limits, i):
    """Way to the surface of a free point by its closest point; see `judge.free_distance`."""
    if truth.status[i] != OK:
        return 0.0
    if truth.gap[i] > 0.0:
        return _above_zero(truth.gap[i] - limits.band)
    reach = limits.depth if limits.penetration else 0.0
    return -_above_zero(-truth.gap[i] - max(limits.band, reach))


@inner(error_model="numpy")
def write_plain(asked, limits, detected, i):
    """Fill what was `Detected` for row i, which `is_plain`."""
    truth, status, safe_distance = asked.truth, detected.status, detected.safe_distance
    k, was, kept, side = asked.rows[i], asked.was[i], asked.kept[i], asked.side[i]
    needed, solved, inside, _ = _kind(asked, limits, i)
    known = (asked.safe_distance[i] if side != 0 else abs(truth.gap[i])) - limits.band
    if kept and (inside or not solved):
        status[k] = asked.status[i]
        safe_distance[k] = _above_zero(known) if inside else 0.0
        take_foot(detected.feet, k, asked.feet, i)
    else:
        status[k] = LOST if not solved and not kept else RELEASED if was else FREE
        safe_distance[k] = _free_way(truth, limits, i) if needed else side * known
        remember_foot(detected, k, truth, i)


@kernel(error_model="numpy")
def judge_plain(asked, step, limits, detected):
    """Fill what was `Detected` for the points that are `Asked` for; whether all of them are plain.

    Where one is not nothing is written. `step` is a `Step`, `limits` are `JudgeLimits`.
    """
    for i in range(asked.rows.shape[0]):
        if not is_plain(asked, step, limits, i):
            return False
    for i in range(asked.rows.shape[0]):
        write_plain(asked, limits, detected, i)
    return True
