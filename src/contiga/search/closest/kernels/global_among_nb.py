"""What of a body a search may answer: all of it, one patch, or minima that do not face away."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import BORDER, SMOOTH
from contiga.elements.kernels.sides_nb import normal_at
from contiga.jit import inlined, inner

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
    """What of a body a search may answer."""

    patch: int
    """−1: all patches."""
    guard: tuple[float, float, float]
    least: float
    """Cosine of guard and normals at least, and the point behind them; `ALL`: whatever is near."""
    floor: float
    """No nearer than this, where there is a guard."""


class SearchLimits(NamedTuple):
    """What a leaf is searched with."""

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
def may_hold(elements, place, point, among, h):
    """Whether neither the face at a place nor the way there faces away from the guard, and the
    point lies behind the face, no nearer than the floor; and its distance and height over the face.

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
    """Whether a place is a minimum that does not face away from the guard, the point behind it and
    no nearer than the floor.

    At a kink the surface need not be square to the way to the point. Beyond a border there is none.
    """
    e, s, t = place
    may, away, height = may_hold(elements, place, point, among, h)
    if not may:
        return False
    kind = elements.table[e]["kind"]
    is_kink = is_border = False
    for side, at in ((0, -s), (1, s), (2, -t), (3, t)):
        if at >= 0.5:
            is_border = is_border or kind[side] == BORDER
            is_kink = is_kink or kind[side] != SMOOTH
    if is_border:
        return is_over(away, height)
    return is_kink or away * away - height * height <= SQUARE * SQUARE * away * away


@inner()
def is_over(away, height):
    """Whether a point so far away, and so high over the face, is not beside a place of a border."""
    return away * away - height * height <= OVER * OVER * away * away
