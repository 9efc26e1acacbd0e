"""The local foot from a start: safeguarded Newton that walks over elements and patches.

Stationary points of f = |S − P|²/2 on the element's square. A foot that presses against a side
looks at the element across it (at a corner or pole: at all elements there) and goes on where f
falls; where it does not, the side is held and the foot moves along it. The foot changes element
only to one that leads down and then takes a step in it, so f falls from visit to visit and no
cycle can occur.
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
from contiga.search.closest.kernels.local_nb import POINT, direction, expand, line_search

STEPS = 400
"""Bound on the steps of one walk; each passes one element at most."""
ROUNDING = 4e-16
POSITION = 1e-3
"""Rounding of a point, as a share of the tolerance (1e-12 of the body's size)."""
QUIET = 10.0
"""A step that promises to lower f by less than this many times its rounding may find nothing."""
QUIET_STEPS = 4
"""Such steps in all, of those that do not halve the tangential miss either."""
GIVE_IN = 1e3
NEAR_POLE = 1e-6
AROUND_POLE = 1e-2
"""Distance from a pole, as a share of |S_t|, within which a long step starts from the pole."""


@inner()
def _pressed(q, s, t, miss):
    """The sides (s's, t's, −1 none) through which f falls by more than `miss` per length.

    On a collapsed side every way that does not lead down counts: others may.
    """
    g_s, g_t, a, b = q.f_s, q.f_t, q.square_s, q.square_t
    limit_s = miss * math.sqrt(a)
    limit_t = miss * math.sqrt(b)
    if a <= POINT * b:
        limit_t = -limit_t
    elif b <= POINT * a:
        limit_s = -limit_s
    out_s = -1
    if a > POINT * b:
        if s <= -0.5 and g_s > limit_s:
            out_s = 0
        elif s >= 0.5 and -g_s > limit_s:
            out_s = 1
    out_t = -1
    if b > POINT * a:
        if t <= -0.5 and g_t > limit_t:
            out_t = 2
        elif t >= 0.5 and -g_t > limit_t:
            out_t = 3
    return out_s, out_t


@inner(linked=False)
def walk(elements, start, point, tolerance, h):
    """Local foot of `point` from `start` = (element, s, t).

    Returns (status, element, s, t, feature). `tolerance` is a length: the tangential miss. `h`
    is a work table (4, 6) and holds the derivatives at the foot afterwards.
    """
    e, s, t = start
    q = expand(elements, e, s, t, point, h)
    quiet = 0
    least = math.inf
    from_pole = False
    for _ in range(STEPS):
        distance = math.sqrt(2.0 * q.f)
        miss = tolerance + 2.0 * ROUNDING * distance
        if q.square_s <= POINT * q.square_t or q.square_t <= POINT * q.square_s:
            # Within rounding of a collapsed side a foot is moved onto it.
            kind = elements.table[e]["kind"]
            narrow_s, narrow_t = q.square_s <= POINT * q.square_t, q.square_t <= POINT * q.square_s
            if narrow_s and abs(t) > 0.5 - NEAR_POLE and kind[3 if t > 0.0 else 2] == POLE:
                t = math.copysign(0.5, t)
            elif narrow_t and abs(s) > 0.5 - NEAR_POLE and kind[1 if s > 0.0 else 0] == POLE:
                s = math.copysign(0.5, s)
            q = expand(elements, e, s, t, point, h)
        out = _pressed(q, s, t, miss)
        if out[0] >= 0 or out[1] >= 0:
            # Over a side that the foot presses against, or by its corner or pole, if f falls there.
            e2, s2, t2 = -1, s, t
            corner = abs(s) >= 0.5 and abs(t) >= 0.5
            for k in range(2):
                side = out[k]
                if side < 0 or e2 >= 0:
                    continue
                kind_of_side = elements.table[e]["kind"][side]
                if kind_of_side == POLE:
                    corner = True
                elif kind_of_side <= CREASE:
                    e3, s3, t3, other = cross(elements, e, side, s, t)
                    if inward_slope(expand(elements, e3, s3, t3, point, h), other) < -miss:
                        e2, s2, t2 = e3, s3, t3
            if corner and e2 < 0:
                e2, s2, t2 = vertex_exit(elements, (e, s, t), point, miss, h)
            if e2 >= 0:
                e, s, t = e2, s2, t2
            q = expand(elements, e, s, t, point, h)
            if e2 >= 0:
                out = _pressed(q, s, t, miss)
        a = q.square_s
        b = q.square_t
        free_s = out[0] < 0 and a > POINT * b
        free_t = out[1] < 0 and b > POINT * a
        slip_s = abs(q.f_s) if free_s else 0.0
        slip_t = abs(q.f_t) if free_t else 0.0
        d_s, d_t = direction(q, s, t, free_s, free_t)
        square = d_s * d_s * a + d_t * d_t * b
        about, is_round = elements.table[e]["about"], elements.table[e]["round"]
        if (
            slip_s <= miss * math.sqrt(a)
            and slip_t <= miss * math.sqrt(b)
            and square <= miss * miss
        ):
            if about[0] != 0.0 or about[1] != 0.0:
                # One step more where the element has a pole: Newton's method does not square the
                # miss in what are polar coordinates. Elsewhere the foot is far more exact.
                s = min(max(s + d_s, -0.5), 0.5)
                t = min(max(t + d_t, -0.5), 0.5)
                expand(elements, e, s, t, point, h)
            return _settle(elements, e, s, t, out)
        # Near a smooth pole a Newton step is unreliable in (s, t), which are polar coordinates
        # there, if it is longer than half of the distance to the pole, or f is not convex.
        axis = 0 if about[0] != 0.0 else 1
        end = 2 * axis + (1 if about[axis] > 0.0 else 0)
        if not from_pole and about[axis] != 0.0 and is_round[end] != 0:
            away = h[0, 0] ** 2 + h[1, 0] ** 2 + h[2, 0] ** 2  # the element's origin is its pole
            near = away <= AROUND_POLE * AROUND_POLE * max(q.square_s, q.square_t)
            convex = q.f_ss > 0.0 and q.f_ss * q.f_tt > q.f_st * q.f_st
            if near and (not convex or square > 0.25 * away):
                # On from the pole, to where f falls most from there.
                from_pole = True
                at = (e, about[0] if about[0] != 0.0 else s, about[1] if about[1] != 0.0 else t)
                way = vertex_exit(elements, at, point, miss, h)
                e, s, t = way if way[0] >= 0 else at
                q = expand(elements, e, s, t, point, h)
                continue
        promise = -(q.f_s * d_s + q.f_t * d_t)
        noise = ROUNDING * q.f + POSITION * tolerance * (distance + POSITION * tolerance)
        slip = max(
            slip_s / math.sqrt(a) if free_s else 0.0, slip_t / math.sqrt(b) if free_t else 0.0
        )
        quiet += 1 if promise <= QUIET * noise and slip > 0.5 * least else 0
        least = min(least, slip)
        if quiet > QUIET_STEPS:
            return _settle(elements, e, s, t, out)
        moved, s, t, q = line_search(elements, e, (s, t), (d_s, d_t), q, (point, noise), h)
        if not moved:
            if promise <= GIVE_IN * noise + miss * miss:
                return _settle(elements, e, s, t, out)
            return MAX_ITERATIONS, e, s, t, FACE
    return MAX_ITERATIONS, e, s, t, FACE


@inner()
def _settle(elements, e, s, t, out):
    """Status and feature of a converged foot, from the sides it presses against."""
    status = OK
    feature = FACE
    for k in range(2):
        if out[k] < 0:
            continue
        kind = elements.table[e]["kind"][out[k]]
        if kind == BORDER:
            status = AT_BORDER
        if kind == POLE:
            feature = max(feature, FACE if elements.table[e]["round"][out[k]] else VERTEX)
        elif kind != SMOOTH:
            feature = max(feature, EDGE)
    if feature == EDGE and out[0] >= 0 and out[1] >= 0:
        feature = VERTEX
    return status, e, s, t, feature
