"""Conversion of triangle meshes to and from objects of other packages, without a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

import numpy as np

from contiga.arrays.layout import real
from contiga.errors import MeshError
from contiga.extras import imported, require
from contiga.records import FloatArray, IntArray
from contiga.triangles.pyvista_mesh import pyvista_mesh
from contiga.triangles.triangle_arrays import TriangleArrays

if TYPE_CHECKING:
    import meshio
    import pyvista

IGNORED_CELLS = ("vertex", "line")
"""Prefixes of the meshio cell types that bound no surface."""


class Exchanged(TriangleArrays):
    """Methods of `TriMesh` that exchange meshes with meshio, trimesh and pyvista."""

    @classmethod
    def from_meshio(cls, mesh: meshio.Mesh, *, name: str = "mesh", **options: Any) -> Self:
        """Return the triangles of a `meshio.Mesh`; quadrilaterals are cut by the shorter diagonal.

        Points and lines are left out. All vertices are kept, in their order.

        Parameters
        ----------
        mesh : points (n, 3), or (n, 2) in the plane z = 0
        name : name in reports and messages
        options : arguments of `TriMesh` (`normals`, `unit`, `reference_point`, `source`)

        Raises
        ------
        MeshError
            Cells that are neither triangles nor quadrilaterals, or a mesh that `TriMesh` refuses.

        Examples
        --------
        >>> import meshio
        >>> from contiga import TriMesh
        >>> square = meshio.Mesh([[0, 0], [2, 0], [2, 1], [0, 1]], [("quad", [[0, 1, 2, 3]])])
        >>> TriMesh.from_meshio(square, name="plate").area()
        2.0
        """
        points = np.asarray(real(mesh.points), dtype=np.float64)
        if points.ndim == 2 and points.shape[1] == 2:
            points = np.pad(points, ((0, 0), (0, 1)))
        corners: list[IntArray] = [np.zeros((0, 3), np.int64)]
        for block in mesh.cells:
            kind, nodes = str(block.type), np.asarray(block.data)
            if kind.startswith(IGNORED_CELLS):
                continue
            if kind not in ("triangle", "quad"):
                raise MeshError(
                    "cells of a kind that is no surface of flat facets",
                    where=name,
                    found=kind,
                    allowed="triangle, quad; vertex and line, which are left out",
                    remedy="From a file, contiga.read_master takes the skin of solids and splits "
                    "facets of second order",
                )
            corners.append(nodes if kind == "triangle" else _split_quads(nodes, points, name))
        return cls(points, np.concatenate(corners), name=name, **options)

    def to_meshio(self) -> meshio.Mesh:
        """Return a `meshio.Mesh` with the vertices and one block of triangles.

        Raises
        ------
        MissingPackageError
            meshio is not installed.

        Examples
        --------
        >>> from contiga import TriMesh
        >>> TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).to_meshio().cells[0].type
        'triangle'
        """
        require("TriMesh.to_meshio", "meshio")
        import meshio

        return meshio.Mesh(self.vertices.copy(), [("triangle", self.triangles.copy())])

    @classmethod
    def from_trimesh(cls, mesh: Any, *, name: str = "mesh", **options: Any) -> Self:
        """Return the triangles of a `trimesh.Trimesh`, with its vertices in their order.

        Parameters
        ----------
        mesh : object with `vertices` (n, 3) and `faces` (m, 3)
        name : name in reports and messages
        options : arguments of `TriMesh` (`normals`, `unit`, `reference_point`, `source`)

        Raises
        ------
        MeshError
            A scene or a cloud, or a mesh that `TriMesh` refuses.
        """
        if not hasattr(mesh, "faces"):
            raise MeshError(
                "expected a trimesh.Trimesh",
                where=name,
                found=type(mesh).__name__,
                allowed="an object with vertices and faces",
                remedy="Of a scene take scene.to_mesh()",
            )
        return cls(np.asarray(mesh.vertices), np.asarray(mesh.faces), name=name, **options)

    def to_trimesh(self) -> Any:
        """Return a `trimesh.Trimesh` with the same vertices and triangles: nothing is merged.

        Raises
        ------
        MissingPackageError
            trimesh is not installed.
        """
        trimesh = imported("TriMesh.to_trimesh", "trimesh")
        return trimesh.Trimesh(self.vertices.copy(), self.triangles.copy(), process=False)

    def to_pyvista(self) -> pyvista.PolyData:
        """Return a copy as a `pyvista.PolyData` with the same vertices and triangles.

        Raises
        ------
        MissingPackageError
            pyvista is not installed.
        """
        return pyvista_mesh("TriMesh.to_pyvista", self.vertices, self.triangles)


def _split_quads(nodes: IntArray, points: FloatArray, name: str) -> IntArray:
    """Return the halves (2 m, 3) of quadrilaterals (m, 4), each cut by its shorter diagonal.

    If the diagonals are equal, the one from the first corner cuts. Raises MeshError for nodes that
    are no rows of `points`.
    """
    is_outside = (nodes < 0) | (nodes >= len(points))
    if is_outside.any():
        bad = int(np.argmax(is_outside.any(axis=1)))
        raise MeshError(
            f"quad {bad} points at a vertex that is not there",
            where=name,
            found=nodes[bad].tolist(),
            allowed=f"0 to {len(points) - 1}",
        )
    a, b, c, d = points[nodes].transpose(1, 0, 2)
    by_first = ((c - a) ** 2).sum(axis=1) <= ((d - b) ** 2).sum(axis=1)
    halves = np.where(by_first[:, None, None], nodes[:, _FIRST_SPLIT], nodes[:, _SECOND_SPLIT])
    return halves.reshape(-1, 3)


_FIRST_SPLIT = np.array([[0, 1, 2], [0, 2, 3]])
_SECOND_SPLIT = np.array([[0, 1, 3], [1, 2, 3]])
"""Halves of a quadrilateral by each of its diagonals."""
