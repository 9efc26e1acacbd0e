"""The closest point of an element that is a plane parallelogram or turned about an axis: formulas.

Of all points at one place of the meridian that one is nearest which is turned nearest to the point,
as far as the element's turn goes, because no place of a meridian is across its axis. So the turn is
found first, and then the nearest place of the meridian in the half-plane there: on a line or an
arc. On an arc that stretches away from the point on both sides both ends are local minima.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contiga.arrays.codes import PLANE, TURNED_LINE
from contiga.jit import inner
from contiga.search.hierarchy.kernels.closest_cell_nb import Middle, nearest_on_plate

COSINE, SINE, QUARTER, RATIO = 0, 1, 2, 3
"""Columns of what a form says of an arc."""
NEAREST, OTHER_END, OTHER_TURN = 0, 1, 2
"""Which local minimum is asked for: the nearest one; or flags, for the farther end of the meridian
and that of the turn."""
LAST = OTHER_END + OTHER_TURN


class OnForm(NamedTuple):
    """A local minimum of the distance on an element."""

    s: float
    t: float
    distance: float
    """Infinite where there is no such minimum."""


class OnArc(NamedTuple):
    """A local minimum of the distance on an arc of a circle."""

    share: float
    """(0 … 1) of the standard parameter."""
    along: float
    """Coordinate of the point towards the place, as seen from the center."""
    across: float
    """Coordinate square to that."""


@inner()
def on_arc(arc, x, y, other):
    """The place of an arc nearest to a point, or its `other` end where both are minima.

    The point is x towards the middle of the arc from its center, and y along its chord. `across` is
    infinite where there is no other end that is a minimum.
    """
    away = math.sqrt(x * x + y * y)
    if x >= away * arc[COSINE]:
        if other:
            return OnArc(0.5, 0.0, math.inf)
        # At the center all places are as near, and the middle stands for them.
        slope = y / (away + x) if away > 0.0 else 0.0
        return OnArc(0.5 + 0.5 * slope / arc[QUARTER], away, 0.0)
    end = math.copysign(1.0, y)
    if other:
        if -x < away * arc[COSINE]:
            return OnArc(0.5, 0.0, math.inf)
        end = -end
    share = 0.5 + 0.5 * end
    return OnArc(
        share, x * arc[COSINE] + end * y * arc[SINE], end * y * arc[COSINE] - x * arc[SINE]
    )


@inner()
def _parameter(share, ratio):
    """Local parameter (−1/2 … 1/2) at a share (0 … 1) of the standard one, by weights' ratio."""
    share = min(max(share, 0.0), 1.0)
    return share / (share + ratio * (1.0 - share)) - 0.5


@inner()
def _on_plane(form, x, y, z):
    """The nearest point of a parallelogram to (x, y, z), as seen from its middle."""
    a, b, m = form["x"], form["y"], form["metric"]
    rx = -(x * a[0] + y * a[1] + z * a[2])
    ry = -(x * b[0] + y * b[1] + z * b[2])
    rr = x * x + y * y + z * z
    i, j, _ = nearest_on_plate(Middle(rr, rx, ry, m[0], m[1], m[2], 0.0, 0.0, 0.0))
    x -= i * a[0] + j * b[0]
    y -= i * a[1] + j * b[1]
    z -= i * a[2] + j * b[2]
    return OnForm(0.5 * i, 0.5 * j, math.sqrt(x * x + y * y + z * z))


@inner()
def _on_meridian(form, rho, height, aside, other):
    """Parameter and distance on the meridian of the point at `rho` from the axis, `height` along it
    and `aside` from the meridian's half-plane."""
    about, toward, m = form["about"], form["toward"], form["meridian"]
    x, y = rho - about[0], height - about[1]
    along = x * toward[0] + y * toward[1]
    if form["kind"] == TURNED_LINE:
        if other:
            return 0.0, math.inf
        share = min(max(along / form["radius"], 0.0), 1.0)
        along -= share * form["radius"]
        off = y * toward[0] - x * toward[1]
        return _parameter(share, m[RATIO]), math.sqrt(along * along + off * off + aside * aside)
    across = form["across"]
    place = on_arc(m, along, x * across[0] + y * across[1], other)
    off = place.along - form["radius"]
    distance = math.sqrt(off * off + place.across * place.across + aside * aside)
    return _parameter(place.share, m[RATIO]), distance


@inner()
def closest_on_form(form, point, which):
    """The local minimum `which` (NEAREST … LAST) of the distance from `point` to an element of the
    `FORM`, which is one."""
    o, a, b, c = form["origin"], form["x"], form["y"], form["z"]
    x, y, z = point[0] - o[0], point[1] - o[1], point[2] - o[2]
    if form["kind"] == PLANE:
        if which != NEAREST:
            return OnForm(0.0, 0.0, math.inf)
        return _on_plane(form, x, y, z)
    turn = form["turn"]
    toward = x * a[0] + y * a[1] + z * a[2]
    across = x * b[0] + y * b[1] + z * b[2]
    place = on_arc(turn, toward, across, which & OTHER_TURN != 0)
    height = x * c[0] + y * c[1] + z * c[2]
    along = _parameter(place.share, turn[RATIO])
    other_end = which & OTHER_END != 0
    up, distance = _on_meridian(form, place.along, height, place.across, other_end)
    if form["turned_along_t"] == 1:
        return OnForm(up, along, distance)
    return OnForm(along, up, distance)
