"""The closest point of a body: branch and bound with rigorous lower bounds.

A leaf is searched cell by cell. With the point's residual r and the derivative bounds of the
leaf, a cell is dropped when

* its tangent parallelogram, less the largest departure from it, is farther than the best foot, or
  f by its Taylor series, less the bound of the remainder;
* the gradient of f = |S − P|²/2 cannot vanish in it (at a border or a kink it may point outward),
  or f is concave all over it in some direction;

and it is finished when f is convex on it (the Hessian at its middle outweighs the largest change
over the cell), because Newton's method then finds its only minimum. Other cells are halved.

A `Scope` may restrict the search to one patch, or to minima that face a guard and have the point
behind them.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE, SMOOTH
from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.bounds_nb import is_beyond_limit
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_scope_nb import (
    NO_GUARD,
    NORMAL_TOL,
    SearchLimits,
    curve_faces_away,
    faces_guard,
    is_above_border,
    is_admissible,
    is_turned_away,
)
from contiga.search.closest.kernels.local_nb import expand
from contiga.search.hierarchy.kernels.closest_cell_nb import (
    bends_down,
    convex,
    hessian,
    least_value,
    middle,
    plate_distance,
    scaled,
    without_minimum,
)
from contiga.search.hierarchy.kernels.curve_nb import (
    ELEMENT,
    LEFT_OUT,
    ROUNDING,
    S,
    T,
    closest_on_stretch,
    curve_point,
)
from contiga.search.hierarchy.kernels.face_nb import has_pole, in_face
from contiga.search.hierarchy.kernels.form_nb import (
    LAST,
    NEAREST,
    OTHER_END,
    OTHER_TURN,
    closest_on_form,
)
from contiga.search.hierarchy.kernels.plates_nb import (
    is_before_face,
    is_beyond,
    no_farther_than,
    no_nearer_than,
)
from contiga.search.hierarchy.kernels.tree_nb import next_leaves

MAX_CELLS = 20000
"""Largest number of cells of a query; with more the search ends over budget."""
MAX_LOOSE_CELLS_IN_LEAF = 32
"""Number of cells of a leaf from which on each gets bounds of its own: those of the leaf are too
loose."""
MAX_LOOSE_CELLS = 100
"""Number of cells of a query from which on each gets bounds of its own."""
MIN_HALF_SIZE = 1e-6
"""Half-size of a cell (local parameters) below which it is not halved."""
POLE_SHARE = 1.0 / 64.0
"""Share of their leaf below which cells of an element with a pole get bounds of their own: the
leaf's do not shrink towards the pole."""
MAX_STEPS = 30
"""Largest number of Newton's steps, and of halvings of a step."""
MIN_DECREASE = 1e-15
"""Smallest predicted decrease of f that is tried, as a share of f: a smaller one is rounding."""
DISTANCE_MARGIN = 1.0 + 1e-9
"""Factor that covers the rounding of the distance from which a search starts."""
EASING_CELLS, EASING_CELLS_IN_LEAF = 400, 16
"""Number of cells of a query, and of a leaf, from which on cells that promise a small gain are not
halved. Feet of points on the axis of a body of revolution form a circle at one distance."""
EASING_POWER, MAX_EASING = 8, 1e5
"""The small gain grows with this power of the number of cells, to this multiple of the least gain
searched for (1e-6 of the body's size)."""
UNRESOLVED, OVER_BUDGET = 0.5, 1.0
"""States of a search that is not complete: a cell was not halved, or cells beyond the budget were
not searched."""
MAX_HIDDEN_GAIN = 100.0
"""Largest gain that a cell which is not halved may hide, as a multiple of the least gain searched
for (1e-9 of the body's size); with more the search is unresolved."""
MIN_GAIN = 10.0
"""Least gain in distance for which a cell is opened, in tolerances."""
AXIS_SHIFT, AXIS_TURN = 1e-9, 1e-3
"""Displacement of a point, in sizes of the body, that moves its foot by more than `AXIS_TURN`
(local parameters) only if the point is on an axis."""
MAX_PENDING = 64
"""Largest number of pending leaves; further ones are opened at once."""
MIN_ANGLE = 2e-4
"""Half sides of a cell, as a share of its distance, below which its middle stands for a guarded
minimum: beside poles, and for points on axes, no bound excludes one."""


@inner()
def _improve(elements, trims, place, distance, best, nearest, query):
    """Return the smaller of `best` and the distance of `place` (element, s, t).

    A place counts if it is on the face and admissible for the guard; a nearer one is written to
    `nearest`. `query` is (point, scope, work).
    """
    e, s, t = place
    if distance < best and in_face(elements, trims, e, s, t):
        if query[1].min_cosine > NO_GUARD and not is_admissible(elements, place, *query):
            return best
        nearest[ELEMENT] = e
        nearest[S] = s
        nearest[T] = t
        return distance
    return best


@inner()
def _cell_minimum(elements, e, cell, point, h):
    """Minimise f on a cell where it is convex; return s, t and the distance.

    Newton's method with the sides of the cell as active constraints, from its middle; steps that do
    not lower f are halved. Ends where a step promises less than rounding, or after `MAX_STEPS`.
    """
    s = 0.5 * (cell[0] + cell[1])
    t = 0.5 * (cell[2] + cell[3])
    q = expand(elements, e, s, t, point, h)
    for _ in range(MAX_STEPS):
        f, g_s, g_t, h_ss, h_st, h_tt = q.f, q.f_s, q.f_t, q.f_ss, q.f_st, q.f_tt
        fixed_s = (s <= cell[0] and g_s > 0.0) or (s >= cell[1] and g_s < 0.0)
        fixed_t = (t <= cell[2] and g_t > 0.0) or (t >= cell[3] and g_t < 0.0)
        d_s = 0.0 if fixed_s else -g_s / h_ss
        d_t = 0.0 if fixed_t else -g_t / h_tt
        if not fixed_s and not fixed_t:
            det = h_ss * h_tt - h_st * h_st
            n_s = (-g_s * h_tt + g_t * h_st) / det
            n_t = (-g_t * h_ss + g_s * h_st) / det
            # A full step that leaves the cell at once is replaced by one-variable steps.
            if not (
                (s <= cell[0] and n_s < 0.0)
                or (s >= cell[1] and n_s > 0.0)
                or (t <= cell[2] and n_t < 0.0)
                or (t >= cell[3] and n_t > 0.0)
            ):
                d_s = n_s
                d_t = n_t
        if abs(g_s * d_s + g_t * d_t) <= MIN_DECREASE * f:
            return s, t, math.sqrt(2.0 * f)
        is_lower = False
        for _ in range(MAX_STEPS):
            new_s = min(max(s + d_s, cell[0]), cell[1])
            new_t = min(max(t + d_t, cell[2]), cell[3])
            if new_s == s and new_t == t:
                break
            q = expand(elements, e, new_s, new_t, point, h)
            is_lower = q.f < f
            if is_lower:
                break
            d_s *= 0.5
            d_t *= 0.5
        if not is_lower:
            return s, t, math.sqrt(2.0 * f)
        s = new_s
        t = new_t
        if f - q.f <= MIN_DECREASE * f:
            break
    return s, t, math.sqrt(2.0 * q.f)


@inner()
def _may_come_within(bounds, distance):
    """Return whether a cell with lower bounds (distance, f) may have a place within `distance`."""
    return bounds[0] <= distance and not (distance > 0.0 and bounds[1] > 0.5 * distance * distance)


@inner(linked=False)
def search_leaf(elements, trims, leaf, point, limits, nearest, stack, h):
    """Improve the best distance and `nearest` (element, s, t) by one surface leaf.

    `limits` are `SearchLimits`. Returns the best distance, old or new, and the number of cells
    opened here. Raises nearest[LEFT_OUT] to UNRESOLVED or OVER_BUDGET if a cell is left that may
    hide a foot. `stack` (64, 4) and `h` are work.
    """
    best, slack, before, scope = limits.best, limits.slack, limits.opened, limits.scope
    query, has_guard = (point, scope, scratch(4, 6)), scope.min_cosine > NO_GUARD
    max_loose = MAX_LOOSE_CELLS_IN_LEAF if before < MAX_LOOSE_CELLS else 0
    e = leaf["element"]
    bound = scratch(9)
    pole = has_pole(elements, e)
    pole_area = POLE_SHARE * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
    origin = elements.table[e]["origin"]
    local = (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])
    for c in range(4):
        stack[0, c] = leaf["box"][c]
    top = 1
    opened = 0
    while top > 0:
        top -= 1
        opened += 1
        cell = (stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3])
        s, t = 0.5 * (cell[0] + cell[1]), 0.5 * (cell[2] + cell[3])
        hs, ht = 0.5 * (cell[1] - cell[0]), 0.5 * (cell[3] - cell[2])
        evaluate(elements, e, s, t, h)
        m = middle(h, local, hs, ht)
        best = _improve(elements, trims, (e, s, t), math.sqrt(m.rr), best, nearest, query)
        is_hard = opened > max_loose
        if is_hard or (pole and 4.0 * hs * ht < pole_area):
            if is_beyond_limit(elements, e, cell, local, best - slack, bound):
                continue
        else:
            for c in range(9):
                bound[c] = leaf["bound"][c]
        b = scaled(bound, hs, ht)
        if has_guard and _faces_away(h, (hs, ht), b, scope):
            continue
        lower_bound = plate_distance(m) - (0.5 * (b.xx + b.yy) + b.xy)
        if lower_bound > best - slack:
            continue
        f = hessian(m, b, hs, ht)
        bounds = lower_bound, least_value(m, f) - ROUNDING * m.rr
        if not _may_come_within(bounds, best - slack):
            continue
        if without_minimum(elements, e, cell, m, f) or bends_down(elements, e, cell, f):
            continue
        if convex(f):
            s, t, distance = _cell_minimum(elements, e, cell, point, h)
            best = _improve(elements, trims, (e, s, t), distance, best, nearest, query)
            continue
        if has_guard and m.xx + m.yy < MIN_ANGLE * MIN_ANGLE * m.rr:
            continue  # the middle stands for the cell
        promises_little = False
        if before + opened > EASING_CELLS and opened > EASING_CELLS_IN_LEAF:
            easing = min(((before + opened) / EASING_CELLS) ** EASING_POWER, MAX_EASING)
            promises_little = not _may_come_within(bounds, best - easing * slack)
        if max(hs, ht) < MIN_HALF_SIZE or promises_little:
            if _may_come_within(bounds, best - MAX_HIDDEN_GAIN * slack):
                nearest[LEFT_OUT] = max(nearest[LEFT_OUT], UNRESOLVED)
        elif before + opened > MAX_CELLS or top > 61:
            nearest[LEFT_OUT] = OVER_BUDGET
        else:
            # Halved where the surface is longer, or f varies more; the half down the slope is next.
            is_wide = abs(m.rx) + abs(f.xx) >= abs(m.ry) + abs(f.yy) if is_hard else m.xx >= m.yy
            axis = 0 if is_wide else 2
            low = top + 1 if (m.rx if is_wide else m.ry) > 0.0 else top
            put(stack, top, cell)
            put(stack, top + 1, cell)
            stack[low, axis + 1] = stack[2 * top + 1 - low, axis] = s if is_wide else t
            top += 2
    return best, opened


@inner()
def _faces_away(h, half, b, scope):
    """Return whether all of a cell is proved to face away from the guard.

    The proof uses the normal in its middle, of the derivatives `h`, and scaled bounds b of its
    rotation.
    """
    x = (half[0] * h[0, 1], half[0] * h[1, 1], half[0] * h[2, 1])
    y = (half[1] * h[0, 2], half[1] * h[1, 2], half[1] * h[2, 2])
    n = cross(x, y)
    area = math.sqrt(dot(n, n))
    turn_x, turn_y = b.xx + b.xy, b.xy + b.yy
    turn = math.sqrt(dot(x, x)) * turn_y + math.sqrt(dot(y, y)) * turn_x + turn_x * turn_y
    if not turn < area:
        return False
    return is_turned_away(dot(n, scope.guard) / area, turn / area, scope.min_cosine)


@inner()
def _has_kink(elements, e, first_side, x):
    """Return whether element e ends or has a kink at the side x = ±1/2 of a parameter.

    It is the parameter with the sides `first_side` and `first_side` + 1; a round pole is no kink.
    """
    side = first_side + (1 if x > 0.0 else 0)
    kind = elements.table[e]["kind"][side]
    return kind != SMOOTH and not (kind == POLE and elements.table[e]["round"][side] == 1)


@inner()
def _improve_by_form(tables, e, point, limits, nearest, h):
    """Improve `nearest` by element e, which has a form; return the best distance, old or new.

    Where trims cut off its nearest place, the nearest one is on a trimming curve, which has leaves
    of its own. With a guard all local minima of an element count; its farther ends are minima if
    the surface does not go on there.
    """
    best, slack, scope = limits.best, limits.slack, limits.scope
    elements, form = tables.elements, tables.items.forms[e]
    query = point, scope, h
    # The first side of the parameter that runs around the axis.
    turn_side = 2 * form["turned_along_t"]
    for minimum in range(LAST + 1 if scope.min_cosine > NO_GUARD else NEAREST + 1):
        foot = closest_on_form(form, point, minimum)
        if foot.distance > best - slack or foot.distance < scope.min_distance:
            continue
        angle, axial = (foot.s, foot.t) if turn_side == 0 else (foot.t, foot.s)
        if minimum & OTHER_TURN and not _has_kink(elements, e, turn_side, angle):
            continue
        if minimum & OTHER_END and not _has_kink(elements, e, 2 - turn_side, axial):
            continue
        place = e, foot.s, foot.t
        best = _improve(elements, tables.trims, place, foot.distance, best, nearest, query)
    if scope.min_cosine > NO_GUARD and best == limits.best:
        # From a point on the axis all angles are as near: the one the guard points to may count.
        g, nudge = scope.guard, AXIS_SHIFT * tables.scale[0]
        shifted = point[0] + nudge * g[0], point[1] + nudge * g[1], point[2] + nudge * g[2]
        foot = closest_on_form(form, point, NEAREST)
        shifted_foot = closest_on_form(form, shifted, NEAREST)
        is_on_axis = abs(shifted_foot.s - foot.s) + abs(shifted_foot.t - foot.t) > AXIS_TURN
        if is_on_axis and foot.distance >= scope.min_distance:
            place = e, shifted_foot.s, shifted_foot.t
            best = _improve(elements, tables.trims, place, foot.distance, best, nearest, query)
    return best


@inner()
def _improve_by_item(tables, k, point, limits, nearest, stack, h):
    """Search item k of a body as `search_leaf` does; return the best distance and opened cells.

    The item is an element with a form, or a leaf of a surface or of a trimming curve; only a
    surface's leaf opens cells.
    """
    items = tables.items
    leaf = items.leaves[k]
    e = leaf["element"]
    best, slack, scope = limits.best, limits.slack, limits.scope
    if leaf["has_form"] == 1:
        return _improve_by_form(tables, e, point, limits, nearest, h), 0
    if is_beyond(items.plates[k], point, best - slack):
        return best, 0
    if e >= 0:
        if limits.opened > MAX_CELLS:
            nearest[LEFT_OUT] = OVER_BUDGET
            return best, 0
        return search_leaf(tables.elements, tables.trims, leaf, point, limits, nearest, stack, h)
    if is_before_face(leaf, items.plates[k], point):
        return best, 0
    has_guard = scope.min_cosine > NO_GUARD
    if has_guard and curve_faces_away(leaf, items.plates[k], point, scope):
        return best, 0
    parameter, distance, is_unresolved = closest_on_stretch(tables, leaf, point, best, slack, h)
    if is_unresolved:
        nearest[LEFT_OUT] = max(nearest[LEFT_OUT], UNRESOLVED)
    if not distance < best:
        return best, 0
    if has_guard and not _edge_is_admissible(tables, leaf, parameter, point, scope):
        return best, 0
    nearest[ELEMENT] = e
    nearest[S] = parameter
    return distance, 0


@inner(linked=False)
def _edge_is_admissible(tables, leaf, r, point, scope):
    """Return whether a place on a trimming curve is a minimum that the scope admits.

    It corresponds to `is_admissible`, at the parameter r of a curve leaf's trimming piece: the
    place must face the guard (`faces_guard`), and the direction to the point must not lead into the
    face. On an open piece the point must be straight above or below it instead (`is_above_border`).
    """
    h, d = scratch(4, 6), scratch(3, 3)
    elements = tables.elements
    place = curve_point(elements, tables.grid, tables.trims, -1 - leaf["element"], r, h, d)
    tangent = d[1, 0], d[1, 1], d[1, 2]
    faces, distance, height = faces_guard(elements, place, point, scope, h)
    if faces and tables.piece_open[-1 - leaf["element"]] != 0.0:
        return is_above_border(distance, height)
    if not faces or leaf["bound"][7] == 0.0:
        return faces
    across, bound = cross(cross(column(h, 1), column(h, 2)), tangent), leaf["bound"]
    origin = elements.table[place[0]]["origin"]
    slope = side = 0.0
    for c in range(3):
        slope += across[c] * (point[c] - origin[c] - h[c, 0])
        side += across[c] * bound[3 + c]
    tol = NORMAL_TOL * distance * math.sqrt(dot(across, across))
    return math.copysign(1.0, side) * slope <= tol


@inner(linked=False)
def closest(tables, point, scope, reach, nearest, h):
    """Find the closest point to `point` within `reach`, in a `Scope`; return its distance.

    Infinite if nothing is that near; points that gain less than `MIN_GAIN` tolerances may be
    missed. Writes element, s, t to `nearest`, or −1 − piece and the piece's parameter if a trimming
    curve is closest; and 0, UNRESOLVED or OVER_BUDGET to nearest[LEFT_OUT]. If nothing is found,
    only nearest[LEFT_OUT] is written.

    Forms are evaluated at once. Leaves, which cost a hundred times as much, are pending until the
    nearest form is known, and are then opened from the nearest on; with a guard in `scope` they
    are opened as the search meets them.
    """
    items = tables.items
    leaves, plates = items.leaves, items.plates
    best = upper_bound = reach
    nearest[LEFT_OUT] = 0.0
    has_foot = False
    opened = 0
    nodes, pending = stack_int64(128), stack_int64(MAX_PENDING)
    bounds, pending_bounds = scratch(128), scratch(MAX_PENDING)
    stack = scratch(64, 4)
    slack = MIN_GAIN * tables.scale[1]
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1 if leaves.shape[0] > 0 else 0
    n_pending = 0
    while not (has_foot and best <= slack):
        limit = min(best, upper_bound) - slack
        node, top = next_leaves(items.tree, point, limit * limit, nodes, bounds, top)
        if node < 0:
            break
        first_item = items.tree[node]["first"]
        for k in range(first_item, first_item + items.tree[node]["count"]):
            if scope.patch >= 0 and leaves[k]["patch"] != scope.patch:
                continue
            can_wait = leaves[k]["has_form"] == 0 and n_pending < MAX_PENDING
            if scope.min_cosine == NO_GUARD and can_wait:
                if not is_beyond(plates[k], point, min(best, upper_bound) - slack):
                    pending[n_pending] = k
                    pending_bounds[n_pending] = no_nearer_than(plates[k], point)
                    n_pending += 1
                    upper_bound = min(upper_bound, no_farther_than(plates[k], point))
                continue
            limits = SearchLimits(best, slack, opened, scope)
            distance, cells = _improve_by_item(tables, k, point, limits, nearest, stack, h)
            has_foot = has_foot or distance < best
            best = distance
            opened += cells
    while n_pending > 0 and not (has_foot and best <= slack):
        first = 0
        for i in range(1, n_pending):
            if pending_bounds[i] < pending_bounds[first]:
                first = i
        if pending_bounds[first] > best - slack:
            break
        k = pending[first]
        n_pending -= 1
        pending[first], pending_bounds[first] = pending[n_pending], pending_bounds[n_pending]
        limits = SearchLimits(best, slack, opened, scope)
        distance, cells = _improve_by_item(tables, k, point, limits, nearest, stack, h)
        has_foot = has_foot or distance < best
        best = distance
        opened += cells
    return best if has_foot else math.inf
