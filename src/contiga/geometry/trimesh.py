"""A plain triangle mesh: what tessellation gives, and the faceted rival of an exact body."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.errors import MeshError
from contiga.geometry import transform
from contiga.num.arrays import read_only
from contiga.records import FloatArray, IntArray


class TriMesh:
    """Triangles over shared vertices. It never changes; methods return new ones.

    Parameters
    ----------
    vertices : (n, 3), finite
    triangles : (m, 3) indices into them, anticlockwise seen from the free side

    Raises
    ------
    MeshError
        wrong shapes, coordinates that are not finite, indices that point at no vertex.

    >>> TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).area()
    0.5
    """

    __slots__ = ("__dict__", "__weakref__")
    vertices: FloatArray
    """(n, 3), read-only."""
    triangles: IntArray
    """(m, 3) int32, read-only."""

    def __init__(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        points, corners = _checked_points(vertices), _checked_triangles(triangles)
        if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
            bad = int(np.argmax(((corners < 0) | (corners >= len(points))).any(axis=1)))
            raise MeshError(
                f"triangle {bad} points at a vertex that is not there",
                found=corners[bad].tolist(),
                allowed=f"0 to {len(points) - 1}",
            )
        corners.flags.writeable = False
        object.__setattr__(self, "vertices", read_only(points))
        object.__setattr__(self, "triangles", corners)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a TriMesh cannot be changed: {name}")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.vertices, self.triangles)

    def __repr__(self) -> str:
        return f"<TriMesh, {len(self.vertices)} vertices, {len(self.triangles)} triangles>"

    def corners(self) -> FloatArray:
        """(m, 3, 3) the corner points of each triangle."""
        return self.vertices[self.triangles]

    def _crosses(self) -> FloatArray:
        a, b, c = self.corners().transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def areas(self) -> FloatArray:
        """(m,) area of each triangle."""
        return np.asarray(0.5 * np.linalg.norm(self._crosses(), axis=1))

    def area(self) -> float:
        """Total area."""
        return float(self.areas().sum())

    def bounds(self) -> FloatArray:
        """(2, 3) lower and upper corner."""
        if len(self.vertices) == 0:
            raise MeshError("a mesh without vertices has no bounds")
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def normals(self) -> FloatArray:
        """(m, 3) unit normals to the free side; NaN for triangles without area."""
        crosses = self._crosses()
        size = np.linalg.norm(crosses, axis=1, keepdims=True)
        return np.divide(crosses, size, out=np.full_like(crosses, np.nan), where=size > 0.0)

    def flipped(self) -> TriMesh:
        """The same mesh with its sides swapped."""
        return TriMesh(self.vertices, self.triangles[:, ::-1])

    def transformed(self, matrix: ArrayLike) -> TriMesh:
        """The mesh moved by a regular affine (4, 4) matrix; the free side stays the free side."""
        regular = transform.affine(matrix)
        order = -1 if transform.reflects(regular) else 1
        return TriMesh(transform.apply(regular, self.vertices), self.triangles[:, ::order])

    def translated(self, d: ArrayLike) -> TriMesh:
        """The mesh moved by the vector `d`."""
        return self.transformed(transform.translation(d))

    def rotated(
        self, axis: transform.Axis, angle: float, origin: ArrayLike = (0.0, 0.0, 0.0)
    ) -> TriMesh:
        """The mesh turned by `angle` (radians) about `axis` ("x", "y", "z" or a vector)."""
        return self.transformed(transform.rotation(axis, angle, origin))

    def scaled(self, s: float | ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0)) -> TriMesh:
        """The mesh scaled by `s` > 0, one number or one for each axis."""
        return self.transformed(transform.scaling(s, origin))


def _checked_points(vertices: ArrayLike) -> FloatArray:
    try:
        points = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError("vertices must be numbers", allowed="shape (n, 3)") from error
    if points.size == 0:
        points = points.reshape(0, 3)
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError("vertices must have shape (n, 3)", found=points.shape)
    if not np.isfinite(points).all():
        bad = int(np.argmax(~np.isfinite(points).all(axis=1)))
        raise MeshError(f"vertex {bad} is not finite", found=points[bad].tolist())
    return points


def _checked_triangles(triangles: ArrayLike) -> IntArray:
    given = np.asarray(triangles)
    if given.size == 0:
        return np.zeros((0, 3), dtype=np.int32)
    if given.ndim != 2 or given.shape[1] != 3 or given.dtype.kind not in "iu":
        raise MeshError(
            "triangles must be whole numbers of shape (m, 3)",
            found=(given.shape, str(given.dtype)),
        )
    return np.array(given, dtype=np.int32, order="C")
