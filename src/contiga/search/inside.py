"""Which points lie on the contact side of a body."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.geometry.faces import Faces
from contiga.num.arrays import as_points
from contiga.search.project import project
from contiga.statuses import Status


def contains(body: Faces, points: ArrayLike) -> NDArray[np.bool_]:
    """(n,) True where a point lies inside a closed body, or behind the nearest face of an open one.

    Decided by the sign of the gap at the closest point. Points whose closest point is a border of
    an open body are behind nothing: False.

    Parameters
    ----------
    points : (n, 3) float64, length, body frame
    """
    feet = project(body, as_points(points))
    return (feet.gap <= 0.0) & (feet.status == Status.OK)
