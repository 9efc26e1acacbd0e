"""Conversion of triangles, or the points of a cloud, to a mesh of pyvista."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contiga.extras import require
from contiga.records import FloatArray, IntArray

if TYPE_CHECKING:
    import pyvista


def pyvista_mesh(
    purpose: str,
    points: FloatArray,
    triangles: IntArray | None,
    point_data: Mapping[str, NDArray[Any]] | None = None,
) -> pyvista.PolyData:
    """Return a copy of triangles or points as a `pyvista.PolyData`.

    Parameters
    ----------
    purpose : beginning of the message about a missing package
    points : (n, 3), length
    triangles : (m, 3) rows of `points`; None for a cloud, whose points are its cells
    point_data : arrays (n,) or (n, k) by name

    Raises
    ------
    MissingPackageError
        pyvista is not installed.
    """
    require(purpose, "pyvista")
    import pyvista

    if triangles is None:
        mesh = pyvista.PolyData(points.copy())
    else:
        mesh = pyvista.PolyData.from_regular_faces(points.copy(), triangles.astype(np.int64))
    for name, values in (point_data or {}).items():
        mesh.point_data[name] = values
    return mesh
