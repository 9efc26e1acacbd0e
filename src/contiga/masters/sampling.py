"""Triangles of a given size on a body, so that flat faces have inner points, too."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from contiga.geometry.divide import divided
from contiga.masters.protocol import Master
from contiga.triangles.trimesh import TriMesh

BODY_SIZE_SHARE = 0.1
"""Longest side of triangles, as a share of the size of their body."""
OTHER_SIZE_SHARE = 0.25
"""Longest side of triangles, as a share of the smallest other body."""
MAX_TRIANGLES = 20_000
"""Number of triangles above which other bodies do not make sides shorter."""
_MIN_AREA_RATIO = 0.125
"""Least area of triangles after halving, in squares of the longest side."""


def refined(body: Master, mesh: TriMesh, size: float) -> TriMesh:
    """Return triangles divided until no side is longer than `size`, new points moved to the body.

    The move may make sides a little longer. A mesh without long sides is returned itself. New
    points without a foot, and new points on a master without patches, stay on the old sides.

    >>> from contiga.geometry import shapes
    >>> from contiga.masters.body import Body
    >>> plate = Body(shapes.plane(width=60.0, length=60.0))
    >>> len(plate.tessellate(0.1).vertices), len(plate.tessellate(0.1, size=25.0).vertices)
    (4, 25)
    """
    points, triangles = divided(mesh.vertices, mesh.triangles, size)
    count = len(mesh.vertices)
    if len(points) == count:
        return mesh
    if body.faces is not None:
        feet = body.project(points[count:]).point
        has_foot = np.isfinite(feet).all(axis=1)
        points[count:][has_foot] = feet[has_foot]
    return TriMesh(points, triangles).like(mesh.name, mesh.unit, mesh.reference_point)


def least_size(mesh: TriMesh, max_triangles: int) -> float:
    """Return a `size`, length, for which `refined` makes `max_triangles` of a mesh at most."""
    return math.sqrt(mesh.area() / (_MIN_AREA_RATIO * max_triangles))


def default_size(body: Master, mesh: TriMesh, others: Iterable[float] = ()) -> float:
    """Return the default length of the sides of triangles.

    It is a tenth of the body's size, and at most a quarter of the sizes of `others`, which could
    slip between its points, unless that takes more than 20,000 triangles.
    """
    size = BODY_SIZE_SHARE * body.size
    least = least_size(mesh, MAX_TRIANGLES)
    return min(size, max(OTHER_SIZE_SHARE * min(others, default=math.inf), least))
