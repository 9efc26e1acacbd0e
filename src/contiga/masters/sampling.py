"""The surface of a body as points and triangles of a size, so that flat faces have points, too."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from contiga.geometry.divide import divided
from contiga.masters.protocol import Master
from contiga.triangles.trimesh import TriMesh

OF_ITSELF = 0.1
"""Share of the size of a body that the sides of its triangles have at most."""
OF_OTHERS = 0.25
"""The same of the smallest body that it is to meet."""
FULL = 20_000
"""Triangles beyond which sides are no shorter for what is met."""


_SLIM = 0.125
"""Area of a right triangle that halving has just made too short, in squares of the longest side."""


def refined(body: Master, mesh: TriMesh, size: float) -> TriMesh:
    """Triangles of a body cut until no side is longer than `size`; new points lie on the body.

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
        known = np.isfinite(feet).all(axis=1)
        points[count:][known] = feet[known]
    return TriMesh(points, triangles).like(mesh.name, mesh.unit, mesh.reference_point)


def least_size(mesh: TriMesh, most: int) -> float:
    """Longest sides, length, with which `refined` makes no more than `most` triangles of a mesh."""
    return math.sqrt(mesh.area() / (_SLIM * most))


def default_size(body: Master, mesh: TriMesh, others: Iterable[float] = ()) -> float:
    """Return the length of the sides of triangles where none is given.

    A tenth of the body's size, and a quarter of the `others`' (of bodies that it is to meet), which
    would else slip through between its points, as long as that takes no more than 20,000 triangles.
    """
    size = OF_ITSELF * body.size
    least = least_size(mesh, FULL)
    return min(size, max(OF_OTHERS * min(others, default=math.inf), least))
