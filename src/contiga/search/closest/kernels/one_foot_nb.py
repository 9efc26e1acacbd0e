"""The foot of one point by Newton's method, in an element or the next one of its patch.

The mathematics are those of the lanes, so the results have the same bits; threads of a GPU and the
search for closest points use it.
"""

from __future__ import annotations

import math

from contiga.arrays.codes import FACE, GENERAL, OK, OUT, RATIONAL_CUBIC, SMOOTH
from contiga.elements.kernels.element_nb import locate, quotient
from contiga.jit import inlined, inner
from contiga.search.closest.closest_records import FootRecord
from contiga.search.closest.kernels.newton_nb import (
    ACTIVE,
    DONE,
    LEFT,
    REJECTED,
    ROUNDS,
    foot_record,
    local_place,
    newton_step,
    polynomial_at,
    weight_at,
)

MAX_OVERSHOOT = 1.0
"""Largest |s| and |t| of a step out of an element that is continued in the next element."""


@inner()
def may_continue(elements, e, s, t):
    """Return whether (s, t) outside the element is near it, across smooth sides in its patch.

    Near is within `MAX_OVERSHOOT`; the parameters must continue there: not across a seam.
    """
    if not (abs(s) <= MAX_OVERSHOOT and abs(t) <= MAX_OVERSHOOT):
        return False
    element = elements.table[e]
    for side, beyond in ((0, s < -0.5), (1, s > 0.5), (2, t < -0.5), (3, t > 0.5)):
        if beyond:
            if element["kind"][side] != SMOOTH:
                return False
            other = elements.table[element["neighbour"][side]]
            # Across a seam the parameters are not continuous.
            if other["patch"] != element["patch"] or other["box"][side ^ 1] != element["box"][side]:
                return False
    return True


@inner(linked=False)
def _newton(element, place, best, p, tolerance):
    """Run Newton's method in one element from place = (s, t); `p` is relative to its origin.

    It ends after `ROUNDS` rounds. `best` is the square of the distance that may not be exceeded,
    `tolerance` the square of the accepted tangential miss. Returns (s, t), the new `best`, the
    state (DONE, or why not), and the `FootRecord`, also relative to the origin.
    """
    k, centre = element["cubic"], element["about"]
    rational = element["form"] == RATIONAL_CUBIC
    s, t = place
    state = ACTIVE
    rounds = ROUNDS
    while True:  # one evaluation in the text, because its code is long
        a, b = s - centre[0], t - centre[1]
        x, y, z = polynomial_at(k, 0, 1, a, b)
        if rational:
            w = weight_at(k, 0, 1, a, b)
            x, y, z = quotient(x, w), quotient(y, w), quotient(z, w)
        if state != ACTIVE or rounds == 0:
            break
        rounds -= 1
        s, t, best, state = newton_step((s, t), (best, state), p, x, y, z, tolerance)
    n_x, n_y, n_z, gap, state = foot_record(p, state, x, y, z, tolerance)
    return (s, t), best, state, FootRecord((x[0], y[0], z[0]), (n_x, n_y, n_z), gap)


@inner()
def _in_element(tables, e, foot, best, point):
    """Run `_newton` in element e from the parameters foot = (u, v), for a point in body axes.

    Returns the same; the state is REJECTED for elements that are no cubics or are trimmed away.
    """
    element = tables.elements.table[e]
    box = element["box"]
    origin = element["origin"]
    s = local_place(foot[0], box[0], 1.0 / (box[1] - box[0]))
    t = local_place(foot[1], box[2], 1.0 / (box[3] - box[2]))
    p = (point[0] - origin[0], point[1] - origin[1], point[2] - origin[2])
    if element["form"] == GENERAL or element["trim"] == OUT:
        return (s, t), best, REJECTED, FootRecord(p, p, best)
    return _newton(element, (s, t), best, p, tables.scale[1] ** 2)


@inlined()
def parameters_of(box, place):
    """Return (u, v) of place = (s, t) in an element over `box`."""
    u = box[0] + (place[0] + 0.5) * (box[1] - box[0])
    v = box[2] + (place[1] + 0.5) * (box[3] - box[2])
    return u, v


@inner()
def newton_foot(tables, e, start, point):
    """Return the foot in element e, or in the next element of its patch where Newton's method ends.

    It starts from start = (u, v), and leaves e for one other element at most. Returns the foot's
    element, −1 for none, its (s, t), its (u, v), and its `FootRecord` in body axes. Trims are not
    checked.
    """
    elements = tables.elements
    place, best, state, record = _in_element(tables, e, start, math.inf, point)
    u, v = parameters_of(elements.table[e]["box"], place)
    if state == LEFT and may_continue(elements, e, place[0], place[1]):
        e = locate(tables.grid, elements.table[e]["patch"], u, v)[0]
        place, best, state, record = _in_element(tables, e, (u, v), best, point)
        u, v = parameters_of(elements.table[e]["box"], place)
    origin = elements.table[e]["origin"]
    x, y, z = record.point
    foot = FootRecord((x + origin[0], y + origin[1], z + origin[2]), record.normal, record.gap)
    return e if state == DONE else -1, place, (u, v), foot


@inner()
def write_certified(out, k, patch, uv, record):
    """Write row k of the projection `out`: a certified foot inside a face.

    `record` is a `FootRecord`.
    """
    out.patch[k] = patch
    out.uv[k, 0] = uv[0]
    out.uv[k, 1] = uv[1]
    for c in range(3):
        out.point[k, c] = record.point[c]
        out.normal[k, c] = record.normal[c]
    out.gap[k] = record.gap
    out.feature[k] = FACE
    out.status[k] = OK
    out.certified[k] = 1
