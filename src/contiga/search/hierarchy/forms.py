"""Recognise elements whose closest point is a formula.

They are plane parallelograms, and parts of surfaces of revolution whose meridian is a line or an
arc of a circle: the planes, cylinders, cones, discs, spheres and tori of CAD. They are recognised
from the control net, to rounding, so that the source of a body and its motions do not matter; a
sheared cylinder does not count. An element has a form if

* it is bilinear, its weights are equal and its net is a parallelogram; or
* its weights are products of a row and a column, each of its rows is an arc of a circle of at most
  half a turn in the standard form of a rational quadratic (Piegl & Tiller, The NURBS Book, ch. 7),
  all about one axis, and its meridian is a line or such an arc, which does not cross the axis.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import NO_FORM, OUT, PLANE, TURNED_ARC, TURNED_LINE
from contiga.elements.element_arrays import Elements, Records
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray
from contiga.search.hierarchy.table_types import FORM

Bools = NDArray[np.bool_]

# Sine below which the sides of a parallelogram, or of an arc's triangle, are parallel.
PARALLEL_TOL = 1e-6
# Largest distance of a trimming loop outside the rectangle of its patch, as a share: rounding.
DOMAIN_TOL = 1e-9


class _Arcs(NamedTuple):
    """Arcs of circles (n,) through control points (n, 3, d), in the plane or in space."""

    center: FloatArray
    toward: FloatArray
    """(n, d) unit vectors from the center to the middle of the arc."""
    across: FloatArray
    """(n, d) unit vectors along the chord, in the sense of the parameter."""
    radius: FloatArray
    cosine: FloatArray
    """Cosine of half the angle."""
    sine: FloatArray
    """Sine of half the angle."""
    ratio: FloatArray
    """√(w2/w0) of the weights."""
    is_arc: Bools


def forms_of(elements: Elements, trims: TrimTables, tolerance: float) -> Records:
    """Return the `FORM` (elements,) of each element, body frame.

    The kind is NO_FORM if the element departs from all forms by more than `tolerance`, a length, is
    trimmed away, or has a degree other than 1 and 2; and for all elements of a patch of which a
    trimming loop leaves the rectangle. If rows and columns are arcs, the arcs along s are the turn.
    """
    table = elements.table
    forms = np.zeros(len(table), FORM)
    # Patches whose loops stay in their rectangle. Pieces are monotone, so that they do not reach
    # farther than their ends.
    rows = np.arange(len(trims.piece_degree))
    ends = np.stack([trims.piece_coefs[:, 0], trims.piece_coefs[rows, trims.piece_degree]], axis=1)
    ends = ends[..., :2] / ends[..., 2:]
    low, high = trims.domain.reshape(-1, 2, 2)[trims.piece_patch].transpose(2, 0, 1)[:, :, None]
    is_outside = np.maximum(low - ends, ends - high) > DOMAIN_TOL * (high - low)
    stays_inside = np.ones(len(trims.domain), dtype=bool)
    stays_inside[trims.piece_patch[is_outside.any(axis=(1, 2))]] = False
    is_candidate = (table["trim"] != OUT) & stays_inside[table["patch"]]
    for p, q in ((1, 1), (2, 1), (1, 2), (2, 2)):
        rows = np.flatnonzero(is_candidate & (table["degree"] == (p, q)).all(axis=1))
        if len(rows) == 0:
            continue
        places = table["bernstein"][rows][:, None] + np.arange(4 * (p + 1) * (q + 1))
        net = elements.coefs[places].reshape(len(rows), p + 1, q + 1, 4)
        points, weights = net[..., :3] / net[..., 3:], net[..., 3]  # from the elements' origins
        if p == q == 1:
            forms[rows] = _plane_forms(points, weights, tolerance)
        if p == 2:
            forms[rows] = _revolution_forms(points, weights, tolerance)
        if q == 2:
            turned = _revolution_forms(points.swapaxes(1, 2), weights.swapaxes(1, 2), tolerance)
            turned["turned_along_t"] = 1
            is_new = (turned["kind"] != NO_FORM) & (forms["kind"][rows] == NO_FORM)
            forms[rows[is_new]] = turned[is_new]
        forms["origin"][rows] += table["origin"][rows]
    return forms


def _plane_forms(points: FloatArray, weights: FloatArray, tolerance: float) -> Records:
    """Return the forms of bilinear nets (n, 2, 2, 3) with weights (n, 2, 2): PLANE or NO_FORM.

    A plane needs sides that are not parallel, a fourth corner within `tolerance` of the
    parallelogram, and weights whose relative spread times the half diagonal is within it, too. The
    other fields are meaningless without a form.
    """
    forms = np.zeros(len(points), FORM)
    corners, w = points.reshape(-1, 4, 3), weights.reshape(-1, 4)
    twist = np.linalg.norm(corners[:, 0] - corners[:, 1] - corners[:, 2] + corners[:, 3], axis=1)
    x = 0.25 * (corners[:, 2] + corners[:, 3] - corners[:, 0] - corners[:, 1])
    y = 0.25 * (corners[:, 1] + corners[:, 3] - corners[:, 0] - corners[:, 2])
    normal = np.cross(x, y)
    area = np.linalg.norm(normal, axis=1)
    xx, xy, yy = ((a * b).sum(axis=1) for a, b in ((x, x), (x, y), (y, y)))
    weight_spread = np.ptp(w, axis=1) / w.min(axis=1)
    is_plane = (twist <= tolerance) & (weight_spread * np.sqrt(xx + yy) <= tolerance)
    is_plane &= area > PARALLEL_TOL * np.sqrt(xx * yy)
    forms["kind"] = np.where(is_plane, PLANE, NO_FORM)
    forms["origin"], forms["x"], forms["y"] = corners.mean(axis=1), x, y
    forms["z"] = normal / np.where(is_plane, area, 1.0)[:, None]
    forms["metric"] = np.column_stack([xx, xy, yy])
    return forms


def _revolution_forms(points: FloatArray, weights: FloatArray, tolerance: float) -> Records:
    """Return the forms of nets (n, 3, m, 3) whose rows of three points are arcs about one axis.

    The kind is TURNED_LINE (m = 2), TURNED_ARC (m = 3) or NO_FORM. The row with the longest chord
    gives axis and angle; all control points have to agree with them within `tolerance`, and the
    meridian must not cross the axis by more than that. The other fields are meaningless without a
    form.
    """
    n, _, m, _ = points.shape
    forms = np.zeros(n, FORM)
    chords = np.linalg.norm(points[:, 2] - points[:, 0], axis=2)
    widest = chords.argmax(axis=1)
    turn = _arcs(points[np.arange(n), :, widest], weights[:, :, 0], tolerance)
    product = weights[:, :, :1] * weights[:, :1] / weights[:, :1, :1]
    product_error = np.abs(weights / product - 1.0).max(axis=(1, 2))
    is_form = turn.is_arc & (product_error * np.abs(points).max(axis=(1, 2, 3)) <= tolerance)
    axis = np.cross(turn.toward, turn.across)
    r = points - turn.center[:, None, None, :]
    x, y, z = (np.einsum("nijc,nc->nij", r, v) for v in (turn.toward, turn.across, axis))
    cosine, sine = turn.cosine[:, None], turn.sine[:, None]
    rho = 0.5 * ((x[:, 0] + x[:, 2]) * cosine + (y[:, 2] - y[:, 0]) * sine)
    height = z.mean(axis=1)
    tip = rho / np.where(is_form[:, None], cosine, 1.0)
    x_arc = np.stack([rho * cosine, tip, rho * cosine], axis=1)
    y_arc = np.stack([-rho * sine, 0.0 * rho, rho * sine], axis=1)
    error = np.abs(x - x_arc).max(axis=(1, 2))
    error = np.maximum(error, np.abs(y - y_arc).max(axis=(1, 2)))
    error = np.maximum(error, np.abs(z - height[:, None]).max(axis=(1, 2)))
    is_form &= error <= tolerance
    forms["origin"], forms["z"] = turn.center, axis
    forms["x"], forms["y"] = turn.toward, turn.across
    forms["turn"] = _range_of(turn)
    meridian = np.stack([rho, height], axis=2)
    if m == 2:
        line = meridian[:, 1] - meridian[:, 0]
        length = np.linalg.norm(line, axis=1)
        is_form &= (length > tolerance) & (rho.min(axis=1) >= -tolerance)
        forms["kind"] = TURNED_LINE
        forms["about"] = meridian[:, 0]
        forms["toward"] = line / np.where(is_form, length, 1.0)[:, None]
        forms["radius"] = length
        forms["meridian"][:, 3] = weights[:, 0, 1] / weights[:, 0, 0]
    else:
        arc = _arcs(meridian, weights[:, 0], tolerance)
        min_rho = np.where(
            -arc.toward[:, 0] >= arc.cosine, arc.center[:, 0] - arc.radius, rho[:, ::2].min(axis=1)
        )
        is_form &= arc.is_arc & (min_rho >= -tolerance)
        forms["kind"] = TURNED_ARC
        forms["about"], forms["toward"], forms["across"] = arc.center, arc.toward, arc.across
        forms["radius"] = arc.radius
        forms["meridian"] = _range_of(arc)
    forms["kind"][~is_form] = NO_FORM
    return forms


def _arcs(points: FloatArray, weights: FloatArray, tolerance: float) -> _Arcs:
    """Return the arcs with control points (n, 3, d) and weights (n, 3).

    `is_arc` is False, and the other fields are meaningless, where the net departs by more than
    `tolerance` from the standard form of an arc, or is straight.
    """
    first, tip, last = points.swapaxes(0, 1)
    half_chord, middle = 0.5 * (last - first), 0.5 * (first + last)
    to_tip = tip - middle
    half, height = np.linalg.norm(half_chord, axis=1), np.linalg.norm(to_tip, axis=1)
    is_arc = (half > tolerance) & (height > PARALLEL_TOL * half)
    half, height = np.where(is_arc, half, 1.0), np.where(is_arc, height, 1.0)
    across, toward = half_chord / half[:, None], to_tip / height[:, None]
    slant = np.hypot(half, height)
    cosine, sine = half / slant, height / slant
    radius = half / sine
    is_arc &= (np.abs((to_tip * across).sum(axis=1)) <= tolerance) & (weights > 0.0).all(axis=1)
    standard_weight = weights[:, 1] / np.sqrt(np.abs(weights[:, 0] * weights[:, 2]))
    is_arc &= np.abs(standard_weight - cosine) * radius <= tolerance
    ratio = np.sqrt(np.abs(weights[:, 2] / weights[:, 0]))
    center = middle - toward * (radius * cosine)[:, None]
    return _Arcs(center, toward, across, radius, cosine, sine, ratio, is_arc)


def _range_of(arc: _Arcs) -> FloatArray:
    """Return (n, 4) cosine and sine of half the angle, tangent of a fourth of it, and the ratio."""
    quarter = arc.sine / (1.0 + arc.cosine)
    return np.column_stack([arc.cosine, arc.sine, quarter, arc.ratio])
