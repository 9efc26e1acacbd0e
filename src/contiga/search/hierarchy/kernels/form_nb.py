"""Closest point of an element that is a plane parallelogram or a surface of revolution, by formula.

No place of a meridian is across its axis; so of all points at one place of the meridian the nearest
is the one with the angle nearest to that of the point, within the element's range of angles. So the
angle is computed first, and then the nearest place of the meridian, a line or an arc, in the
half-plane there. On an arc that curves away from the point both ends are local minima.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from contiga.arrays.codes import PLANE, TURNED_LINE
from contiga.jit import inner
from contiga.search.hierarchy.kernels.closest_cell_nb import Middle, nearest_on_plate

COSINE, SINE, QUARTER, RATIO = 0, 1, 2, 3
"""Columns of an arc in a form."""
NEAREST, OTHER_END, OTHER_TURN = 0, 1, 2
"""Choice of the local minimum: the nearest one; or flags for the farther end of the meridian and
the farther end of the range of angles."""
LAST = OTHER_END + OTHER_TURN


class OnForm(NamedTuple):
    """A local minimum of the distance on an element."""

    s: float
    t: float
    distance: float
    """Infinite if there is no such minimum."""


class OnArc(NamedTuple):
    """A local minimum of the distance on an arc of a circle."""

    share: float
    """(0 … 1) of the standard parameter."""
    along: float
    """Coordinate of the point from the center towards the place."""
    across: float
    """Coordinate perpendicular to that."""


@inner()
def on_arc(arc, x, y, other):
    """Return the place of an arc nearest to a point, as `OnArc`, or with `other` its farther end.

    From the center of the arc the point is at x towards its middle and y along its chord. `across`
    is infinite if the farther end is no local minimum. The nearest place to the center is the
    middle.
    """
    radius_dist = math.sqrt(x * x + y * y)
    if x >= radius_dist * arc[COSINE]:
        if other:
            return OnArc(0.5, 0.0, math.inf)
        # At the center all places are equally near: the middle is returned.
        slope = y / (radius_dist + x) if radius_dist > 0.0 else 0.0
        return OnArc(0.5 + 0.5 * slope / arc[QUARTER], radius_dist, 0.0)
    end = math.copysign(1.0, y)
    if other:
        if -x < radius_dist * arc[COSINE]:
            return OnArc(0.5, 0.0, math.inf)
        end = -end
    share = 0.5 + 0.5 * end
    return OnArc(
        share, x * arc[COSINE] + end * y * arc[SINE], end * y * arc[COSINE] - x * arc[SINE]
    )


@inner()
def _parameter(share, ratio):
    """Return the local parameter (−1/2 … 1/2) at a share of the standard parameter.

    `share` is clipped to 0 … 1, `ratio` is that of the weights.
    """
    share = min(max(share, 0.0), 1.0)
    return share / (share + ratio * (1.0 - share)) - 0.5


@inner()
def _closest_on_meridian(form, rho, height, offset, other):
    """Return the local parameter and the distance of the place of the meridian nearest to a point.

    The point is at `rho` from the axis, `height` along it and `offset` from the meridian's
    half-plane. `other` asks for the farther end instead: its distance is infinite if it is no local
    minimum.
    """
    about, toward, m = form["about"], form["toward"], form["meridian"]
    x, y = rho - about[0], height - about[1]
    along = x * toward[0] + y * toward[1]
    if form["kind"] == TURNED_LINE:
        if other:
            return 0.0, math.inf
        share = min(max(along / form["radius"], 0.0), 1.0)
        along -= share * form["radius"]
        off = y * toward[0] - x * toward[1]
        return _parameter(share, m[RATIO]), math.sqrt(along * along + off * off + offset * offset)
    across = form["across"]
    place = on_arc(m, along, x * across[0] + y * across[1], other)
    off = place.along - form["radius"]
    distance = math.sqrt(off * off + place.across * place.across + offset * offset)
    return _parameter(place.share, m[RATIO]), distance


@inner()
def closest_on_form(form, point, minimum):
    """Return a local minimum of the distance from a point to an element's `FORM`, as `OnForm`.

    `minimum` (NEAREST … LAST) selects it; `point` is in the body frame. The distance is infinite if
    there is no such minimum: a plane has the nearest one only. Trims are not tested.
    """
    o, a, b, c = form["origin"], form["x"], form["y"], form["z"]
    x, y, z = point[0] - o[0], point[1] - o[1], point[2] - o[2]
    if form["kind"] == PLANE:
        if minimum != NEAREST:
            return OnForm(0.0, 0.0, math.inf)
        m = form["metric"]
        rx = -(x * a[0] + y * a[1] + z * a[2])
        ry = -(x * b[0] + y * b[1] + z * b[2])
        rr = x * x + y * y + z * z
        i, j, _ = nearest_on_plate(Middle(rr, rx, ry, m[0], m[1], m[2], 0.0, 0.0, 0.0))
        x -= i * a[0] + j * b[0]
        y -= i * a[1] + j * b[1]
        z -= i * a[2] + j * b[2]
        return OnForm(0.5 * i, 0.5 * j, math.sqrt(x * x + y * y + z * z))
    # The angle about the axis, then the meridian in the half-plane there.
    turn = form["turn"]
    toward = x * a[0] + y * a[1] + z * a[2]
    across = x * b[0] + y * b[1] + z * b[2]
    height = x * c[0] + y * c[1] + z * c[2]
    place = on_arc(turn, toward, across, minimum & OTHER_TURN != 0)
    angle = _parameter(place.share, turn[RATIO])
    offset = place.across
    axial, distance = _closest_on_meridian(
        form, place.along, height, offset, minimum & OTHER_END != 0
    )
    if form["turned_along_t"] == 1:
        return OnForm(axial, angle, distance)
    return OnForm(angle, axial, distance)
