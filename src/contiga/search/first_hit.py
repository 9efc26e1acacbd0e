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

N_HALVINGS = 52
"""Number of halvings after which a position on a path is as exact as its coordinates."""
ROUNDING = 1e-12
"""Share of a body's size below which a slit is rounding."""


def first_hit(body: Faces, p0: ArrayLike, p1: ArrayLike) -> Hit:
    """Find where each segment p0 → p1 first enters `body` from its free side.

    Interval Newton on S(u, v) = p0 + τ (p1 − p0) over the hierarchy: the smallest τ in [0, 1] with
    (p1 − p0)·n < 0. Both ends count, and so do entries within the rounding of their coordinates:
    where one path continues another, at least one of them has the entry at their common end.
    The search is complete for every length and angle. An edge belongs to both its faces within its
    width, twice its tolerance in the file. A path that still slips between two faces of a closed
    body enters where the side of its points changes from outside to inside.

    Parameters
    ----------
    body : the faces
    p0, p1 : (n, 3) float64, length, body frame

    Returns
    -------
    Hit
        fraction τ, NaN with status NO_HIT where the path does not enter; AT_START where it
        enters at its start; NOT_FINITE for ends that are not finite; BUDGET where the search
        exceeded its budget, with the first entry found, if any.

    Raises
    ------
    InputError
        Arrays that are not (n, 3) or differ in n.
    """
    a_B, b_B = checked_segments(p0, p1)
    surface = exact_surface(body)
    out = surface.entries(a_B, b_B, np.arange(len(a_B), dtype=np.int32))
    # A point within the slit of an edge may be on either side of the faces.
    slit, rounding = openings_of(body).slit, ROUNDING * body.size
    if not (surface.closed and slit > rounding):
        return out
    # Paths that begin outside and end inside but meet no face: bisection by sides.
    band = slit, rounding
    rows = np.flatnonzero(out.status == Status.NO_HIT).astype(np.int32)
    rows = rows[_sides(surface, b_B, rows, band) < 0]
    rows = rows[_sides(surface, a_B, rows, band) > 0]
    if len(rows) == 0:
        return out
    displacement = b_B[rows] - a_B[rows]
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    path_rows = np.arange(len(rows), dtype=np.int32)
    for _ in range(N_HALVINGS):
        middle = 0.5 * (low + high)
        is_inside = _sides(surface, a_B[rows] + middle[:, None] * displacement, path_rows, band) < 0
        low, high = np.where(is_inside, low, middle), np.where(is_inside, middle, high)
    feet = empty_projection(len(rows))
    surface.closest(a_B[rows] + high[:, None] * displacement, path_rows, feet)
    is_solved = feet.status == Status.OK
    rows = rows[is_solved]
    out.fraction[rows], out.patch[rows] = high[is_solved], feet.patch[is_solved]
    out.uv[rows], out.point[rows] = feet.uv[is_solved], feet.point[is_solved]
    out.status[rows] = Status.OK
    return out


def _sides(
    surface: ExactSurface, p_B: FloatArray, rows: IntArray, band: tuple[float, float]
) -> ByteArray:
    """Return sides (len(rows),) of p_B[rows]: 1 outside, −1 inside, 0 unknown.

    Points that the grid does not decide have the sign of the gap at their closest point, if its
    magnitude exceeds the first length of `band` at an edge or vertex, the second on a face.
    """
    side = surface.sides(p_B, rows).side
    unknown_rows = np.flatnonzero(side == 0)
    feet = empty_projection(len(unknown_rows))
    points = np.ascontiguousarray(p_B[rows[unknown_rows]])
    surface.closest(points, np.arange(len(unknown_rows), dtype=np.int32), feet)
    min_gap = np.where(feet.feature == Feature.FACE, band[1], band[0])
    is_clear = (feet.status == Status.OK) & (np.abs(feet.gap) > min_gap)
    side[unknown_rows] = np.where(is_clear, np.sign(feet.gap), 0)
    return side
