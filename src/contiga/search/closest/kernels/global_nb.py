"""The closest point of a body: branch and bound with rigorous lower bounds.

A leaf is searched cell by cell. With the point's residual r and the derivative bounds of the
leaf, a cell is dropped when

* its tangent parallelogram, less the largest departure from it, is farther than the best foot, or
  f by its Taylor series, less the largest rest of that;
* the gradient of f = |S − P|²/2 cannot vanish in it (at a border or a kink it may press outward),
  or f bends down all over it in some direction;

and it is finished when f is convex on it (the Hessian at its middle outweighs the largest change
over the cell), because Newton then finds its only minimum. What is neither is halved.

A search may be kept to one patch, or to minima that do not face away from a guard and have the
point behind them.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import POLE, SMOOTH
from contiga.arrays.kernels.rows_nb import put
from contiga.arrays.kernels.vector_nb import column, cross, dot
from contiga.elements.kernels.bounds_nb import look_closer
from contiga.elements.kernels.element_nb import evaluate
from contiga.jit import inner
from contiga.jit.scratch import scratch, stack_int64
from contiga.search.closest.kernels.global_among_nb import (
    ALL,
    SQUARE,
    SearchLimits,
    holds_nowhere,
    is_guarded,
    is_over,
    is_turned_away,
    may_hold,
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
"""Cells one query may open; then it is given up."""
EASY_IN_LEAF = 32
"""Cells of a leaf after which its bounds are taken for too loose, and each cell gets its own."""
EASY_IN_ALL = 100
"""Cells of a query after which all get bounds of their own."""
SMALLEST = 1e-6
"""Half-size of a cell (local parameters) that is not halved further."""
DEEP = 1.0 / 64.0
"""Cells of an element with a pole, smaller than this share of their leaf, get bounds of their own:
the leaf's do not shrink towards the pole."""
MINIMUM_STEPS = 30
LEVEL = 1e-15
"""Share of f that a step must promise; less is rounding, and halving it thirty times is no use."""
SEEN = 1.0 + 1e-9
"""Rounding of a distance that a search starts from, with much to spare."""
PATIENT, IN_LEAF = 400, 16
"""After so many cells in all, and in a leaf, one that promises little is not halved any more. Feet
of points on the axis of a body of revolution lie all along a circle, as near as each other."""
EASING_POWER, MAX_EASING = 8, 1e5
"""What is little grows with this power of the cells opened in all, to so many times the least gain
asked for (1e-6 of the body's size)."""
DROPPED, GIVEN_UP = 0.5, 1.0
"""What a search has left out: a cell that was not halved, or all that was over its budget."""
UNTOLD = 100.0
"""A cell that is not halved, and may come closer than the best foot by this many times the least
gain asked for (1e-9 of the body's size), is not told from a closer foot."""
PRUNE = 10.0
"""A cell must promise this many tolerances less distance to be opened."""
NUDGE, TURNED = 1e-9, 1e-3
"""Of a point that is moved by so little, in sizes of the body, the foot is moved by more than this
(in an element's parameters) only about an axis."""
WAITING = 64
"""Leaves that wait at once; more are opened as they come by."""
NARROW = 2e-4
"""Half sides of a cell, in its distance, within which a minimum shows in its middle: beside poles,
and of points on axes, nothing else tells."""


@inner()
def _improve(elements, trims, place, distance, best, nearest, seen):
    """The least distance, which `place` (element, s, t) may improve; then `nearest` is that place.

    `seen` is (the point, what the search is among, work).
    """
    e, s, t = place
    if distance < best and in_face(elements, trims, e, s, t):
        if seen[1].least > ALL and not is_guarded(elements, place, *seen):
            return best
        nearest[ELEMENT] = e
        nearest[S] = s
        nearest[T] = t
        return distance
    return best


@inner()
def _cell_minimum(elements, e, cell, point, h):
    """Minimum of f on a cell where it is convex: s, t and the distance.

    Newton's method with the sides of the cell as an active set; steps that do not lower f are
    halved.
    """
    s = 0.5 * (cell[0] + cell[1])
    t = 0.5 * (cell[2] + cell[3])
    q = expand(elements, e, s, t, point, h)
    for _ in range(MINIMUM_STEPS):
        f, g_s, g_t, h_ss, h_st, h_tt = q.f, q.f_s, q.f_t, q.f_ss, q.f_st, q.f_tt
        fixed_s = (s <= cell[0] and g_s > 0.0) or (s >= cell[1] and g_s < 0.0)
        fixed_t = (t <= cell[2] and g_t > 0.0) or (t >= cell[3] and g_t < 0.0)
        d_s = 0.0 if fixed_s else -g_s / h_ss
        d_t = 0.0 if fixed_t else -g_t / h_tt
        if not fixed_s and not fixed_t:
            det = h_ss * h_tt - h_st * h_st
            n_s = (-g_s * h_tt + g_t * h_st) / det
            n_t = (-g_t * h_ss + g_s * h_st) / det
            # Where it would leave the cell at once, the steps of one variable each stand in.
            if not (
                (s <= cell[0] and n_s < 0.0)
                or (s >= cell[1] and n_s > 0.0)
                or (t <= cell[2] and n_t < 0.0)
                or (t >= cell[3] and n_t > 0.0)
            ):
                d_s = n_s
                d_t = n_t
        if abs(g_s * d_s + g_t * d_t) <= LEVEL * f:
            return s, t, math.sqrt(2.0 * f)
        better = False
        for _ in range(MINIMUM_STEPS):
            new_s = min(max(s + d_s, cell[0]), cell[1])
            new_t = min(max(t + d_t, cell[2]), cell[3])
            if new_s == s and new_t == t:
                break
            q = expand(elements, e, new_s, new_t, point, h)
            better = q.f < f
            if better:
                break
            d_s *= 0.5
            d_t *= 0.5
        if not better:
            return s, t, math.sqrt(2.0 * f)
        s = new_s
        t = new_t
        if f - q.f <= LEVEL * f:
            break
    return s, t, math.sqrt(2.0 * q.f)


@inner()
def _faces_away(h, half, b, among):
    """Return whether all of a cell faces away from the guard, by bounds of its turn."""
    x = (half[0] * h[0, 1], half[0] * h[1, 1], half[0] * h[2, 1])
    y = (half[1] * h[0, 2], half[1] * h[1, 2], half[1] * h[2, 2])
    n = cross(x, y)
    area = math.sqrt(dot(n, n))
    turn_x, turn_y = b.xx + b.xy, b.xy + b.yy
    turn = math.sqrt(dot(x, x)) * turn_y + math.sqrt(dot(y, y)) * turn_x + turn_x * turn_y
    if not turn < area:
        return False
    return is_turned_away(dot(n, among.guard) / area, turn / area, among.least)


@inner()
def _halve(stack, top, cell, m, wide):
    """Put the halves of a cell on the stack, the one down the slope last."""
    s0, s1, t0, t1 = cell
    for c in range(2):
        put(stack, top + c, (s0, s1, t0, t1))
    if wide:
        sc = 0.5 * (s0 + s1)
        low = top + 1 if m.rx > 0.0 else top
        stack[low, 1] = sc
        stack[2 * top + 1 - low, 0] = sc
    else:
        tc = 0.5 * (t0 + t1)
        low = top + 1 if m.ry > 0.0 else top
        stack[low, 3] = tc
        stack[2 * top + 1 - low, 2] = tc


@inner()
def _may_come_within(bounds, limit):
    """Return whether a cell of lower bounds = (distance, f) may have a place no farther than
    `limit`."""
    return bounds[0] <= limit and not (limit > 0.0 and bounds[1] > 0.5 * limit * limit)


@inner()
def _promises_little(bounds, best, slack, before, opened):
    """Return whether a cell may be let be, after so many opened `before` and in its leaf."""
    opened_in_all = before + opened
    if opened_in_all <= PATIENT or opened <= IN_LEAF:
        return False
    little = min((opened_in_all / PATIENT) ** EASING_POWER, MAX_EASING) * slack
    return not _may_come_within(bounds, best - little)


@inner(linked=False)
def search_leaf(elements, trims, leaf, point, limits, nearest, stack, h):
    """Improve the best distance and `nearest` (element, s, t) by one surface leaf.

    `limits` are `SearchLimits`. Returns the best distance and the number of cells opened here.
    `stack` (64, 4) and `h` are work.
    """
    best, slack, before, among = limits.best, limits.slack, limits.opened, limits.among
    seen, guarded = (point, among, scratch(4, 6)), among.least > ALL
    easy = EASY_IN_LEAF if before < EASY_IN_ALL else 0
    e = leaf["element"]
    k = scratch(9)
    pole = has_pole(elements, e)
    whole = DEEP * (leaf["box"][1] - leaf["box"][0]) * (leaf["box"][3] - leaf["box"][2])
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
        best = _improve(elements, trims, (e, s, t), math.sqrt(m.rr), best, nearest, seen)
        hard = opened > easy
        closely = hard or (pole and 4.0 * hs * ht < whole)
        if closely:
            if look_closer(elements, e, cell, local, best - slack, k):
                continue
        else:
            for c in range(9):
                k[c] = leaf["bound"][c]
        b = scaled(k, hs, ht)
        if guarded and _faces_away(h, (hs, ht), b, among):
            continue
        least = plate_distance(m) - (0.5 * (b.xx + b.yy) + b.xy)
        if least > best - slack:
            continue
        f = hessian(m, b, hs, ht)
        bounds = least, least_value(m, f) - ROUNDING * m.rr
        if not _may_come_within(bounds, best - slack):
            continue
        if without_minimum(elements, e, cell, m, f) or bends_down(elements, e, cell, f):
            continue
        if convex(f):
            s, t, distance = _cell_minimum(elements, e, cell, point, h)
            best = _improve(elements, trims, (e, s, t), distance, best, nearest, seen)
        elif guarded and m.xx + m.yy < NARROW * NARROW * m.rr:
            continue  # its middle has told
        elif max(hs, ht) < SMALLEST or _promises_little(bounds, best, slack, before, opened):
            if _may_come_within(bounds, best - UNTOLD * slack):
                nearest[LEFT_OUT] = max(nearest[LEFT_OUT], DROPPED)
        elif before + opened > MAX_CELLS or top > 61:
            nearest[LEFT_OUT] = GIVEN_UP
        else:
            # Halved where the surface is longer, or f varies more.
            wide = abs(m.rx) + abs(f.xx) >= abs(m.ry) + abs(f.yy) if hard else m.xx >= m.yy
            _halve(stack, top, cell, m, wide)
            top += 2
    return best, opened


@inner()
def _has_kink(elements, e, first, x):
    """Return whether element e has a kink or ends at the side where one of its parameters is x
    (±1/2); `first` is that parameter's first side."""
    side = first + (1 if x > 0.0 else 0)
    kind = elements.table[e]["kind"][side]
    return kind != SMOOTH and not (kind == POLE and elements.table[e]["round"][side] == 1)


@inner()
def _improve_by_form(tables, e, point, limits, nearest, h):
    """The best distance, which element e may improve, that has a form; then `nearest` is there.

    Where trims have cut off the nearest place of it, no place is nearer than on a trimming curve,
    which has leaves of its own. With a guard all local minima of an element count; its farther ends
    are minima if the surface does not go on there.
    """
    best, slack, among = limits.best, limits.slack, limits.among
    elements, form = tables.elements, tables.items.forms[e]
    seen = point, among, h
    around = 2 * form["turned_along_t"]  # first side of the parameter that runs around the axis
    for which in range(LAST + 1 if among.least > ALL else NEAREST + 1):
        on = closest_on_form(form, point, which)
        if on.distance > best - slack or on.distance < among.floor:
            continue
        turn, along = (on.s, on.t) if around == 0 else (on.t, on.s)
        if which & OTHER_TURN and not _has_kink(elements, e, around, turn):
            continue
        if which & OTHER_END and not _has_kink(elements, e, 2 - around, along):
            continue
        best = _improve(elements, tables.trims, (e, on.s, on.t), on.distance, best, nearest, seen)
    if among.least > ALL and best == limits.best:
        # On an axis all turns are as near: the one that the guard points to may be allowed.
        g, nudge = among.guard, NUDGE * tables.scale[0]
        beside = point[0] + nudge * g[0], point[1] + nudge * g[1], point[2] + nudge * g[2]
        on, other = closest_on_form(form, point, NEAREST), closest_on_form(form, beside, NEAREST)
        turned = abs(other.s - on.s) + abs(other.t - on.t) > TURNED
        if turned and on.distance >= among.floor:
            place = e, other.s, other.t
            best = _improve(elements, tables.trims, place, on.distance, best, nearest, seen)
    return best


@inner()
def _improve_by_item(tables, k, point, limits, nearest, stack, h):
    """Search item k of a body as `search_leaf` does: an element that has a form, or a leaf of a
    surface or of a trimming curve."""
    items = tables.items
    leaf = items.leaves[k]
    e = leaf["element"]
    best, slack, among = limits.best, limits.slack, limits.among
    if leaf["has_form"] == 1:
        return _improve_by_form(tables, e, point, limits, nearest, h), 0
    if is_beyond(items.plates[k], point, best - slack):
        return best, 0
    if e >= 0:
        if limits.opened > MAX_CELLS:
            nearest[LEFT_OUT] = GIVEN_UP
            return best, 0
        return search_leaf(tables.elements, tables.trims, leaf, point, limits, nearest, stack, h)
    if is_before_face(leaf, items.plates[k], point):
        return best, 0
    if among.least > ALL and holds_nowhere(leaf, items.plates[k], point, among):
        return best, 0
    r, distance, left = closest_on_stretch(tables, leaf, point, best, slack, h)
    if left:
        nearest[LEFT_OUT] = max(nearest[LEFT_OUT], DROPPED)
    if (
        distance < best
        and among.least > ALL
        and not _edge_is_guarded(tables, leaf, r, point, among)
    ):
        return best, 0
    if distance < best:
        nearest[ELEMENT] = e
        nearest[S] = r
    return min(best, distance), 0


@inner(linked=False)
def _edge_is_guarded(tables, leaf, r, point, among):
    """Return whether the way to a point does not lead into a face at its edge.

    It is `is_guarded` for the face at the parameter r of a curve leaf's trimming piece.
    """
    h, d = scratch(4, 6), scratch(3, 3)
    elements = tables.elements
    place = curve_point(elements, tables.grid, tables.trims, -1 - leaf["element"], r, h, d)
    along = d[1, 0], d[1, 1], d[1, 2]
    may, away, height = may_hold(elements, place, point, among, h)
    if may and tables.piece_open[-1 - leaf["element"]] != 0.0:
        return is_over(away, height)
    if not may or leaf["bound"][7] == 0.0:
        return may
    way, into = cross(cross(column(h, 1), column(h, 2)), along), leaf["bound"]
    origin = elements.table[place[0]]["origin"]
    slope = side = 0.0
    for c in range(3):
        slope += way[c] * (point[c] - origin[c] - h[c, 0])
        side += way[c] * into[3 + c]
    most = SQUARE * away * math.sqrt(dot(way, way))
    return math.copysign(1.0, side) * slope <= most


@inner(linked=False)
def closest(tables, point, among, reach, nearest, h):
    """Find the closest point to `point` within `reach`, on the part that `among` selects.

    Fills `nearest` with element, s, t, or with −1 − piece and the piece's parameter when a trimming
    curve is closest, and nearest[LEFT_OUT] with 0, DROPPED or GIVEN_UP. Returns the distance,
    infinite where nothing was found.

    Formulas are looked at as they come by; leaves, which cost a hundred times as much, wait until
    the nearest of these is known, and are opened from the nearest on.
    """
    items = tables.items
    leaves, plates = items.leaves, items.plates
    best = within = reach
    nearest[LEFT_OUT] = 0.0
    hit = False
    opened = 0
    nodes, waiting = stack_int64(128), stack_int64(WAITING)
    bounds, waiting_bounds = scratch(128), scratch(WAITING)
    stack = scratch(64, 4)
    slack = PRUNE * tables.scale[1]
    nodes[0] = 0
    bounds[0] = 0.0
    top = 1 if leaves.shape[0] > 0 else 0
    wait = 0
    while not (hit and best <= slack):
        limit = min(best, within) - slack
        node, top = next_leaves(items.tree, point, limit * limit, nodes, bounds, top)
        if node < 0:
            break
        first = items.tree[node]["first"]
        for k in range(first, first + items.tree[node]["count"]):
            if among.patch >= 0 and leaves[k]["patch"] != among.patch:
                continue
            if among.least == ALL and leaves[k]["has_form"] == 0 and wait < WAITING:
                if not is_beyond(plates[k], point, min(best, within) - slack):
                    waiting[wait] = k
                    waiting_bounds[wait] = no_nearer_than(plates[k], point)
                    wait += 1
                    if among.least == ALL:
                        within = min(within, no_farther_than(plates[k], point))
                continue
            limits = SearchLimits(best, slack, opened, among)
            distance, cells = _improve_by_item(tables, k, point, limits, nearest, stack, h)
            hit = hit or distance < best
            best = distance
            opened += cells
    while wait > 0 and not (hit and best <= slack):
        next_one = 0
        for i in range(1, wait):
            if waiting_bounds[i] < waiting_bounds[next_one]:
                next_one = i
        if waiting_bounds[next_one] > best - slack:
            break
        k = waiting[next_one]
        wait -= 1
        waiting[next_one], waiting_bounds[next_one] = waiting[wait], waiting_bounds[wait]
        limits = SearchLimits(best, slack, opened, among)
        distance, cells = _improve_by_item(tables, k, point, limits, nearest, stack, h)
        hit = hit or distance < best
        best = distance
        opened += cells
    return best if hit else math.inf
