"""Choose which part of a body answers a search: all, one patch, or minima that face a guard."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import BORDER, SMOOTH
from contiga.arrays.kernels.vector_nb import cross, dot
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inlined, inner
from contiga.search.closest.kernels.around_nb import collapsed_side, vertex_exit

BESIDE = 1e-9
"""Share of its distance by which a point may stand before a surface that it is beside: rounding."""
SQUARE = 1e-3
"""Sine of the angle with the normal under which a minimum is seen: half the digits of one are
known, and beside a pole fewer."""
OVER = 1e-7
"""The same for a place of a border, which points behind the face have up to there: rounding."""
ALL = -2.0
"""A cosine that no two directions are short of."""


class Among(NamedTuple):
    """The part of a body that a search may answer."""

    patch: int
    """−1: all patches."""
    guard: tuple[float, float, float]
    least: float
    """Cosine of guard and normals at least, and the point behind them; `ALL`: whatever is near."""
    floor: float
    """No nearer than this, where there is a guard."""


class SearchLimits(NamedTuple):
    """The state and limits of a search, as a leaf is handed them."""

    best: float
    """Distance of the nearest place so far."""
    slack: float
    """What is nearer by less than this is not looked for, length."""
    opened: int
    """Cells opened before."""
    among: Among


@inlined()
def anywhere():
    """All of a body."""
    return Among(-1, (0.0, 0.0, 0.0), ALL, 0.0)


@inlined()
def on_patch(patch):
    """All of one patch, an integer of whatever size: each size would be compiled for itself."""
    return Among(np.int64(patch), (0.0, 0.0, 0.0), ALL, 0.0)


@inner()
def holds_nowhere(leaf, plate, point, among):
    """Return whether all along a curve leaf its face faces away from the guard or has the point
    before it, by its normal in the middle and how far that turns."""
    m, k, x = plate["middle"], leaf["bound"], plate["x"]
    if not k[8] < 1.0 or plate["metric"][0] == 0.0:
        return False
    sine, scale = k[8], (-1.0 if k[7] < 0.0 else 1.0) / math.sqrt(plate["metric"][0])
    n = cross((x[0], x[1], x[2]), (k[3], k[4], k[5]))
    if is_turned_away(scale * dot(n, among.guard), sine, among.least):
        return True
    r = point[0] - m[0], point[1] - m[1], point[2] - m[2]
    away = math.sqrt(dot(r, r)) + plate["radius"]
    return scale * dot(n, r) > plate["departure"] + (math.sqrt(2.0) * sine + BESIDE) * away


@inlined()
def is_turned_away(along, sine, least):
    """Return whether normals at the angle of `sine` at most from one whose product with the guard
    is `along` all have a smaller one than `least`."""
    level = math.sqrt(1.0 - sine * sine)
    # Of these normals, the one nearest to the guard.
    nearest = along * level + math.sqrt(max(1.0 - along * along, 0.0)) * sine
    return along < level and nearest < least


@inner()
def may_hold(elements, place, point, among, h):
    """Return whether neither the face at a place nor the way there faces away from the guard, and
    the point lies behind the face, no nearer than the floor; and its distance and height over the
    face.

    The way there is the normal at a kink.
    """
    e, s, t = place
    n = normal_at(elements, e, s, t, h)
    origin = elements.table[e]["origin"]
    height = square = along = toward = 0.0
    for c in range(3):
        r = point[c] - origin[c] - h[c, 0]
        square += r * r
        height += r * n[c]
        along += n[c] * among.guard[c]
        toward -= r * among.guard[c]
    away = math.sqrt(square)
    may = height <= BESIDE * away and along >= among.least and toward >= among.least * away
    return may and away >= among.floor, away, height


@inner(linked=False)
def is_guarded(elements, place, point, among, h):
    """Return whether a place is a minimum that the guard and the floor admit.

    On a side where the surface has a kink it need not be square to the way to the point, but no
    place of its own face beside it may be nearer; at a pole, none around it. Beyond a border there
    is none.
    """
    e, s, t = place
    may, away, height = may_hold(elements, place, point, among, h)
    if not may:
        return False
    if collapsed_side(elements, e, s, t) >= 0:
        return vertex_exit(elements, place, point, SQUARE * away, h)[0] < 0
    kind, origin = elements.table[e]["kind"], elements.table[e]["origin"]
    for side, at in ((0, -s), (1, s), (2, -t), (3, t)):
        if at >= 0.5 and kind[side] == BORDER:
            return is_over(away, height)
    f_s = f_t = a = b = 0.0
    for c in range(3):
        r = origin[c] + h[c, 0] - point[c]
        f_s += r * h[c, 1]
        f_t += r * h[c, 2]
        a += h[c, 1] * h[c, 1]
        b += h[c, 2] * h[c, 2]
    most_s, most_t = SQUARE * away * math.sqrt(a), SQUARE * away * math.sqrt(b)
    held_s = s <= -0.5 and kind[0] != SMOOTH and f_s >= -most_s
    held_s = held_s or (s >= 0.5 and kind[1] != SMOOTH and f_s <= most_s)
    held_t = t <= -0.5 and kind[2] != SMOOTH and f_t >= -most_t
    held_t = held_t or (t >= 0.5 and kind[3] != SMOOTH and f_t <= most_t)
    if held_s or held_t:
        return (held_s or abs(f_s) <= most_s) and (held_t or abs(f_t) <= most_t)
    return away * away - height * height <= SQUARE * SQUARE * away * away


@inner()
def is_over(away, height):
    """Return whether a point so far away, and so high over the face, is not beside a place of a
    border."""
    return away * away - height * height <= OVER * OVER * away * away
