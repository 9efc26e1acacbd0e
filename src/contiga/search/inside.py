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

WAYS = np.array([[0.8, 0.53, 0.29], [-0.37, 0.84, 0.4], [0.21, -0.48, 0.85]])
"""Directions from which points are come to, along no axis."""


def contains(body: Faces, points: ArrayLike) -> NDArray[np.bool_]:
    """Return whether points (n,) lie inside a closed body, or behind an open one's nearest face.

    Decided by the sign of the gap at the closest point. Where the search for that is given up, by
    where a way from outside last goes in or out of a closed body. Points whose closest point is a
    border of an open body are behind nothing: False.

    Parameters
    ----------
    body : the faces
    points : (n, 3) float64, length, body frame

    Warns
    -----
    ContigaWarning
        Neither tells the side of a point: it is that of the best foot found.
    """
    p_B = as_points(points)
    feet = project(body, p_B)
    behind = feet.gap <= 0.0
    inside = behind & (feet.status == Status.OK)
    rows: IndexArray = np.flatnonzero(np.isin(feet.status, (Status.BUDGET, Status.MAX_ITERATIONS)))
    if len(rows) and (surface := exact_surface(body)).closed:
        low, high = body.bounds()
        for way in WAYS:
            # From beyond the box, whichever side of it a point lies on.
            far = body.size + np.abs(p_B[rows] - 0.5 * (low + high)).sum(axis=1)
            start = p_B[rows] + far[:, None] * way / np.sqrt(way @ way)
            ends = np.ascontiguousarray(p_B[rows])
            hits, turn = surface.last_crossings(start, ends, np.arange(len(rows), dtype=np.int32))
            solved = hits.status != Status.BUDGET
            inside[rows[solved]] = turn[solved] > 0
            rows = rows[~solved]
            if len(rows) == 0:
                break
    inside[rows] = behind[rows]
    if len(rows):
        warnings.warn(
            f"{body.name}: the side of {len(rows)} points is not proved, the first at "
            f"{p_B[rows[0]].tolist()}; {Status.BUDGET.advice}",
            ContigaWarning,
            stacklevel=3,
        )
    return inside
