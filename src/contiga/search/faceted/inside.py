"""Which points lie on the contact side of a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.geometry.trimesh import TriMesh
from contiga.records import Status
from contiga.search.faceted.projection import project


def contains(mesh: TriMesh, points: ArrayLike) -> NDArray[np.bool_]:
    """(n,) True inside a closed mesh, or behind the nearest facet of an open one.

    Decided by the sign of the gap at the closest point. Points whose closest point is a border of
    an open mesh are behind nothing: False.

    Parameters
    ----------
    points : (n, 3) float64, length, the mesh's frame
    """
    feet = project(mesh, points)
    return (feet.gap <= 0.0) & (feet.status == Status.OK)
