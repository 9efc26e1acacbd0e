"""The arrays of a triangle mesh, checked once, and measures that need no search."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, read_only, real
from contiga.arrays.ordered import length
from contiga.errors import MeshError
from contiga.records import FloatArray, IntArray
from contiga.triangles.facets import NORMALS
from contiga.triangles.kernels.mesh_sides_nb import side_numbers


class TriangleArrays:
    """The arrays of a `TriMesh`, as the search reads them: `TriMesh` is above the search."""

    vertices: FloatArray
    """(n, 3), read-only."""
    triangles: IntArray
    """(m, 3) int32, read-only."""
    name: str
    normal_kind: str
    """"facet" or "vertex"."""
    unit: str | None
    reference_point: FloatArray
    """(3,), read-only."""
    source: str

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        name: str = "mesh",
        normals: str = "facet",
        unit: str | None = None,
        reference_point: ArrayLike = (0.0, 0.0, 0.0),
        source: str = "",
    ) -> None:
        real(vertices)
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
        indices = np.asarray(real(triangles))
        if indices.size == 0:
            indices = np.zeros((0, 3), dtype=np.int32)
        if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in "iu":
            raise MeshError(
                "triangles must be whole numbers of shape (m, 3)",
                found=(indices.shape, str(indices.dtype)),
            )
        corners = np.array(indices, dtype=np.int32, order="C")
        outside = np.flatnonzero(((corners < 0) | (corners >= len(points))).any(axis=1))
        if len(outside):
            raise MeshError(
                f"triangle {outside[0]} points at a vertex that is not there",
                found=corners[outside[0]].tolist(),
                allowed=f"0 to {len(points) - 1}",
            )
        if normals not in NORMALS:
            raise MeshError(
                "unknown kind of normals",
                where=name,
                found=normals,
                allowed='"facet", "vertex"',
            )
        corners.flags.writeable = False
        values: dict[str, Any] = {
            "vertices": read_only(points),
            "triangles": corners,
            "name": str(name),
            "normal_kind": normals,
            "unit": unit,
            "reference_point": read_only(as_points(reference_point, "reference_point")[0]),
            "source": str(source),
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a TriMesh cannot be changed: {name}")

    def corners(self) -> FloatArray:
        """Return the corner points (m, 3, 3) of the triangles."""
        return self.vertices[self.triangles]

    def _crosses(self) -> FloatArray:
        """Return (b − a) × (c − a) (m, 3) of the corners a, b, c of each triangle."""
        a, b, c = self.corners().transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def areas(self) -> FloatArray:
        """Return the areas (m,) of the triangles."""
        return np.asarray(0.5 * np.linalg.norm(self._crosses(), axis=1))

    def area(self) -> float:
        """Return the total area."""
        return float(self.areas().sum())

    def bounds(self) -> FloatArray:
        """Return the lowest and highest coordinates (2, 3) of the triangles' corners.

        Vertices of no triangle do not count.

        Raises
        ------
        MeshError
            There are no triangles.
        """
        if len(self.triangles) == 0:
            raise MeshError("a mesh without triangles has no bounds")
        used = self.vertices[self.triangles].reshape(-1, 3)
        return np.array([used.min(axis=0), used.max(axis=0)])

    @property
    def size(self) -> float:
        """Length of the diagonal of `bounds`; MeshError if there are no triangles."""
        low, high = self.bounds()
        return length(high - low)

    def volume(self) -> float:
        """Return the volume of a closed mesh, length³: positive if its normals point outward.

        It is the sum of signed tetrahedra over the triangles with the first vertex as apex, which
        has no meaning for an open mesh.
        """
        a, b, c = (self.corners() - self.vertices[:1]).transpose(1, 0, 2)
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    def normals(self) -> FloatArray:
        """Return (m, 3) unit normals to the free side; NaN for triangles without area."""
        crosses = self._crosses()
        size = np.linalg.norm(crosses, axis=1, keepdims=True)
        return np.divide(crosses, size, out=np.full_like(crosses, np.nan), where=size > 0.0)

    def open_edges(self) -> IntArray:
        """Return the vertices (k, 2) of boundary edges, in the orientation of their triangle.

        Vertices at one place are not merged here.
        """
        numbers, times = side_numbers(self.triangles, len(self.vertices))
        ends = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2)
        return np.asarray(ends[times[numbers] == 1])
