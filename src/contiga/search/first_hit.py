"""Find where moving points enter a body."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.query_checks import checked_segments
from contiga.geometry.faces import Faces
from contiga.records import ByteArray, FloatArray, Hit, IntArray, empty_projection
from contiga.search.borders.openings import openings_of
from contiga.search.exact_surface import ExactSurface, exact_surface
from contiga.statuses import Feature, Status

# Halvings after which a place on a path is as sharp as its coordinates.
HALVINGS = 52
# Share of a body's size below which a slit is rounding.
ROUNDING = 1e-12


def first_hit(body: Faces, p0: ArrayLike, p1: ArrayLike) -> Hit:
    """Find where each segment p0 → p1 first enters `body` from its free side.

    Interval Newton on S(u, v) = p0 + τ (p1 − p0) over the hierarchy: the smallest τ in [0, 1]
    with (p1 − p0)·n < 0. Both ends count, and so does what lies within the rounding of the
    coordinates of them: of two paths that follow each other at least one has an entry between
    them. Complete for every length and angle. An edge belongs to both its faces within its width,
    twice its tolerance in the file. Where a path slips between two faces of a closed body all the
    same, it enters where its closest point turns from outside to inside.

    Parameters
    ----------
    body : the faces
    p0, p1 : (n, 3) float64, length, body frame

    Returns
    -------
    Hit
        fraction τ, NaN with status NO_HIT where the path does not enter; AT_START where it
        starts on the surface; BUDGET where the search was given up, with the best hit it had.

    Raises
    ------
    InputError
        Arrays that are not (n, 3) or differ in n.
    """
    a_B, b_B = checked_segments(p0, p1)
    surface = exact_surface(body)
    out = surface.entries(a_B, b_B, np.arange(len(a_B), dtype=np.int32))
    # What is nearer to an edge than its faces are apart may be on either side of them.
    slit, rounding = openings_of(body).slit, ROUNDING * body.size
    if not (surface.closed and slit > rounding):
        return out
    # Paths that begin outside and end inside, but meet no face.
    band = slit, rounding
    rows = np.flatnonzero(out.status == Status.NO_HIT).astype(np.int32)
    rows = rows[_sides(surface, b_B, rows, band) < 0]
    rows = rows[_sides(surface, a_B, rows, band) > 0]
    if len(rows) == 0:
        return out
    way = b_B[rows] - a_B[rows]
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    each = np.arange(len(rows), dtype=np.int32)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        inside = _sides(surface, a_B[rows] + middle[:, None] * way, each, band) < 0
        low, high = np.where(inside, low, middle), np.where(inside, middle, high)
    feet = empty_projection(len(rows))
    surface.closest(a_B[rows] + high[:, None] * way, each, feet)
    good = feet.status == Status.OK
    rows = rows[good]
    out.fraction[rows], out.patch[rows] = high[good], feet.patch[good]
    out.uv[rows], out.point[rows] = feet.uv[good], feet.point[good]
    out.status[rows] = Status.OK
    return out


def _sides(
    surface: ExactSurface, p_B: FloatArray, rows: IntArray, band: tuple[float, float]
) -> ByteArray:
    """1 for points p_B[rows] outside, −1 inside, 0 within `band` (edge, face) or not known."""
    side = surface.sides(p_B, rows).side
    near = np.flatnonzero(side == 0)
    feet = empty_projection(len(near))
    points = np.ascontiguousarray(p_B[rows[near]])
    surface.closest(points, np.arange(len(near), dtype=np.int32), feet)
    least = np.where(feet.feature == Feature.FACE, band[1], band[0])
    is_clear = (feet.status == Status.OK) & (np.abs(feet.gap) > least)
    side[near] = np.where(is_clear, np.sign(feet.gap), 0)
    return side
