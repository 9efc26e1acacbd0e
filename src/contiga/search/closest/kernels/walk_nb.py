"""The local foot from a start: safeguarded Newton's method that walks over elements and patches.

It finds stationary points of f = |S − P|²/2 on the element's square. Where a foot presses against a
side, the element across it (at a corner or pole: every element there) is examined, and the walk
continues in it if f falls; otherwise the side is held and the foot moves along it. The foot changes
element only to one that leads down and then takes a step in it, so f falls from visit to visit and
no cycle can occur.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import (
    AT_BORDER,
    BORDER,
    CREASE,
    EDGE,
    FACE,
    MAX_ITERATIONS,
    OK,
    POLE,
    SMOOTH,
    VERTEX,
)
from contiga.jit import inner
from contiga.search.closest.kernels.around_nb import cross, inward_slope, vertex_exit
from contiga.search.closest.kernels.local_nb import COLLAPSED, direction, expand, line_search

MAX_STEPS = 400
"""Largest number of steps of a walk; each passes one element at most."""
ROUNDING = 4e-16
"""Relative rounding of f."""
POSITION_TOL = 1e-3
"""Rounding of a point, as a share of the tolerance (1e-12 of the body's size)."""
STALL_FACTOR = 10.0
"""Predicted decrease of f, in its rounding errors, below which a step may have no effect."""
MAX_STALLED_STEPS = 4
"""Largest number of steps without effect that do not halve the tangential miss either."""
STALL_LIMIT = 1e3
"""Predicted decrease of f, in its rounding errors, below which a walk that cannot move has
converged."""
POLE_TOL = 1e-6
"""Distance to a collapsed side (local parameters) below which a foot is moved onto it."""
POLE_RADIUS = 1e-2
"""Distance from a pole, as a share of |S_t|, within which a long step starts from the pole."""


@inner()
def _pressed(q, s, t, miss):
    """Return the sides of s and of t across which f falls by more than `miss` per length.

    They are (0 or 1, 2 or 3), −1 for none. At a collapsed side the foot counts as pressed unless f
    falls inwards: f may fall in another direction from there.
    """
    g_s, g_t, a, b = q.f_s, q.f_t, q.square_s, q.square_t
    limit_s = miss * math.sqrt(a)
    limit_t = miss * math.sqrt(b)
    if a <= COLLAPSED * b:
        limit_t = -limit_t
    elif b <= COLLAPSED * a:
        limit_s = -limit_s
    out_s = -1
    if a > COLLAPSED * b:
        if s <= -0.5 and g_s > limit_s:
            out_s = 0
        elif s >= 0.5 and -g_s > limit_s:
            out_s = 1
    out_t = -1
    if b > COLLAPSED * a:
        if t <= -0.5 and g_t > limit_t:
            out_t = 2
        elif t >= 0.5 and -g_t > limit_t:
            out_t = 3
    return out_s, out_t


@inner()
def _exit_over(elements, foot, sides, point, miss, h):
    """Return the place (element, s, t) across the sides that a foot presses against.

    The first of the two sides counts in whose neighbour f falls inwards by more than `miss` per
    length; if there is none, the place at the corner or pole of the foot from which f falls most.
    Element −1 if it falls nowhere. `h` is overwritten.
    """
    e, s, t = foot
    at_corner = abs(s) >= 0.5 and abs(t) >= 0.5
    for k in range(2):
        if sides[k] < 0:
            continue
        kind = elements.table[e]["kind"][sides[k]]
        if kind == POLE:
            at_corner = True
        elif kind <= CREASE:
            e2, s2, t2, other = cross(elements, e, sides[k], s, t)
            if inward_slope(expand(elements, e2, s2, t2, point, h), other) < -miss:
                return e2, s2, t2
    if at_corner:
        return vertex_exit(elements, foot, point, miss, h)
    return -1, s, t


@inner(linked=False)
def walk(elements, start, point, tolerance, h):
    """Return the local foot of `point` from `start` = (element, s, t).

    Returns (status, element, s, t, feature). The status is OK, AT_BORDER where the foot presses
    against a border, or MAX_ITERATIONS, where f still falls but no step lowers it or the steps ran
    out; the feature is FACE, EDGE or VERTEX. Trims are not tested. `tolerance` is the accepted
    tangential miss, a length. `h` (4, 6) is work, and holds the derivatives at the foot afterwards.
    """
    e, s, t = start
    q = expand(elements, e, s, t, point, h)
    stalled = 0
    least_slip = math.inf
    was_at_pole = False
    for _ in range(MAX_STEPS):
        distance = math.sqrt(2.0 * q.f)
        miss = tolerance + 2.0 * ROUNDING * distance
        narrow_s = q.square_s <= COLLAPSED * q.square_t
        narrow_t = q.square_t <= COLLAPSED * q.square_s
        if narrow_s or narrow_t:
            # A foot within rounding of a collapsed side is moved onto it.
            kind = elements.table[e]["kind"]
            if narrow_s and abs(t) > 0.5 - POLE_TOL and kind[3 if t > 0.0 else 2] == POLE:
                t = math.copysign(0.5, t)
            elif narrow_t and abs(s) > 0.5 - POLE_TOL and kind[1 if s > 0.0 else 0] == POLE:
                s = math.copysign(0.5, s)
            q = expand(elements, e, s, t, point, h)
        sides = _pressed(q, s, t, miss)
        if sides[0] >= 0 or sides[1] >= 0:
            e2, s2, t2 = _exit_over(elements, (e, s, t), sides, point, miss, h)
            if e2 >= 0:
                e, s, t = e2, s2, t2
            q = expand(elements, e, s, t, point, h)
            if e2 >= 0:
                sides = _pressed(q, s, t, miss)
        a = q.square_s
        b = q.square_t
        free_s = sides[0] < 0 and a > COLLAPSED * b
        free_t = sides[1] < 0 and b > COLLAPSED * a
        slip_s = abs(q.f_s) if free_s else 0.0
        slip_t = abs(q.f_t) if free_t else 0.0
        d_s, d_t = direction(q, s, t, free_s, free_t)
        square = d_s * d_s * a + d_t * d_t * b
        pole, is_round = elements.table[e]["about"], elements.table[e]["round"]
        if (
            slip_s <= miss * math.sqrt(a)
            and slip_t <= miss * math.sqrt(b)
            and square <= miss * miss
        ):
            if pole[0] != 0.0 or pole[1] != 0.0:
                # One more step if the element has a pole: in polar coordinates Newton's method does
                # not square the miss. Elsewhere the foot is far more exact.
                s = min(max(s + d_s, -0.5), 0.5)
                t = min(max(t + d_t, -0.5), 0.5)
                expand(elements, e, s, t, point, h)
            return _settle(elements, e, s, t, sides)
        # Near a smooth pole (s, t) are polar coordinates. A Newton step is unreliable there if it
        # is longer than half of the distance to the pole, or f is not convex.
        axis = 0 if pole[0] != 0.0 else 1
        end = 2 * axis + (1 if pole[axis] > 0.0 else 0)
        if not was_at_pole and pole[axis] != 0.0 and is_round[end] != 0:
            # The element's origin is its pole.
            pole_square = h[0, 0] ** 2 + h[1, 0] ** 2 + h[2, 0] ** 2
            is_near = pole_square <= POLE_RADIUS * POLE_RADIUS * max(q.square_s, q.square_t)
            is_convex = q.f_ss > 0.0 and q.f_ss * q.f_tt > q.f_st * q.f_st
            if is_near and (not is_convex or square > 0.25 * pole_square):
                # Continue from the pole in the direction of deepest descent.
                was_at_pole = True
                pole_place = (e, pole[0] if pole[0] != 0.0 else s, pole[1] if pole[1] != 0.0 else t)
                pole_exit = vertex_exit(elements, pole_place, point, miss, h)
                e, s, t = pole_exit if pole_exit[0] >= 0 else pole_place
                q = expand(elements, e, s, t, point, h)
                continue
        decrease = -(q.f_s * d_s + q.f_t * d_t)
        noise = ROUNDING * q.f + POSITION_TOL * tolerance * (distance + POSITION_TOL * tolerance)
        slip = max(
            slip_s / math.sqrt(a) if free_s else 0.0, slip_t / math.sqrt(b) if free_t else 0.0
        )
        stalled += 1 if decrease <= STALL_FACTOR * noise and slip > 0.5 * least_slip else 0
        least_slip = min(least_slip, slip)
        if stalled > MAX_STALLED_STEPS:
            return _settle(elements, e, s, t, sides)
        has_moved, s, t, q = line_search(elements, e, (s, t), (d_s, d_t), q, (point, noise), h)
        if not has_moved:
            if decrease <= STALL_LIMIT * noise + miss * miss:
                return _settle(elements, e, s, t, sides)
            return MAX_ITERATIONS, e, s, t, FACE
    return MAX_ITERATIONS, e, s, t, FACE


@inner()
def _settle(elements, e, s, t, sides):
    """Return status, element, s, t and feature of a converged foot.

    The sides that the foot presses against decide. The status is AT_BORDER where the surface ends,
    else OK; the feature is EDGE at a border or kink, VERTEX at two sides or a pole that is not
    round, else FACE.
    """
    status = OK
    feature = FACE
    for k in range(2):
        if sides[k] < 0:
            continue
        kind = elements.table[e]["kind"][sides[k]]
        if kind == BORDER:
            status = AT_BORDER
        if kind == POLE:
            feature = max(feature, FACE if elements.table[e]["round"][sides[k]] else VERTEX)
        elif kind != SMOOTH:
            feature = max(feature, EDGE)
    if feature == EDGE and sides[0] >= 0 and sides[1] >= 0:
        feature = VERTEX
    return status, e, s, t, feature
