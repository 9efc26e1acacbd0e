"""Find which points lie on the contact side of a body."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import as_points
from contiga.errors import ContigaWarning
from contiga.geometry.faces import Faces
from contiga.records import IndexArray
from contiga.search.exact_surface import exact_surface
from contiga.search.track.project import project
from contiga.statuses import Status

DIRECTIONS = np.array([[0.8, 0.53, 0.29], [-0.37, 0.84, 0.4], [0.21, -0.48, 0.85]])
"""Directions of the test paths, none along an axis."""


def contains(body: Faces, points: ArrayLike) -> NDArray[np.bool_]:
    """Return (n,) whether points lie inside a closed body, or behind an open one's nearest face.

    The sign of the gap at the closest point decides; a gap of zero is inside. If that search
    exceeds its budget or does not converge, the last crossing of a path from outside a closed body
    decides. A point whose closest point is on a border of an open body is not behind the body, nor
    is a point that is not finite.

    Parameters
    ----------
    body : the faces
    points : (n, 3) float64, length, body frame

    Warns
    -----
    ContigaWarning
        Neither decides the side of a point: the gap of its best foot then does, without proof.
    """
    p_B = as_points(points)
    feet = project(body, p_B)
    is_behind = feet.gap <= 0.0
    is_inside = is_behind & (feet.status == Status.OK)
    rows: IndexArray = np.flatnonzero(np.isin(feet.status, (Status.BUDGET, Status.MAX_ITERATIONS)))
    if len(rows) and (surface := exact_surface(body)).closed:
        low, high = body.bounds()
        for direction in DIRECTIONS:
            # The start is outside the box for every point.
            distance = body.size + np.abs(p_B[rows] - 0.5 * (low + high)).sum(axis=1)
            start = p_B[rows] + distance[:, None] * direction / np.sqrt(direction @ direction)
            ends = np.ascontiguousarray(p_B[rows])
            hits, sense = surface.last_crossings(start, ends, np.arange(len(rows), dtype=np.int32))
            is_solved = hits.status != Status.BUDGET
            is_inside[rows[is_solved]] = sense[is_solved] > 0
            rows = rows[~is_solved]
            if len(rows) == 0:
                break
    is_inside[rows] = is_behind[rows]
    if len(rows):
        warnings.warn(
            f"{body.name}: the side of {len(rows)} points is not proved, the first at "
            f"{p_B[rows[0]].tolist()}; {Status.BUDGET.advice}",
            ContigaWarning,
            stacklevel=3,
        )
    return is_inside
