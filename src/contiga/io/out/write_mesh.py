"""Triangle meshes written for Gmsh (MSH 4.1), ParaView (VTU) and other programs (STL)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contiga.errors import FileError, MeshError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.triangles.trimesh import TriMesh

FORMATS: dict[str, tuple[str, dict[str, Any]]] = {
    ".msh": ("gmsh", {"binary": False, "float_fmt": ".17g"}),
    ".vtu": ("vtu", {}),
    ".stl": ("stl", {"binary": True}),
}
"""Meshio's name of the format and its options, by suffix."""


def check_suffix(path: str | Path) -> str:
    """Return the suffix of `path` in lower case, if a mesh can be written with it.

    Raises
    ------
    FileError
        It is none of `FORMATS`.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise FileError(
            "no format that can be written has this suffix",
            where=str(path),
            found=suffix,
            allowed=", ".join(FORMATS),
        )
    return suffix


def write_mesh(path: str | Path, mesh: TriMesh) -> None:
    """Write `mesh` in the format of the suffix of `path`, whole or not at all.

    Coordinates keep all their digits in .msh and .vtu; .stl has single precision and no shared
    vertices. In .msh the mesh is one surface with number 1. Vertices of no triangle are written,
    except in .stl.

    Raises
    ------
    FileError
        A suffix other than .msh, .vtu, .stl.
    MeshError
        A mesh without triangles.
    OutputError
        The folder is missing or cannot be written to.
    MissingPackageError
        The package that writes meshes is not installed.

    Examples
    --------
    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)]).tessellate(0.01)
    >>> cg.write_mesh("ball.msh", ball)
    >>> len(cg.read_master("ball.msh").triangles) == len(ball.triangles)
    True
    """
    name, options = FORMATS[check_suffix(path)]
    require("writing a mesh", "meshio")
    import meshio

    if len(mesh.triangles) == 0:
        raise MeshError("a mesh without triangles cannot be written", where=str(path))
    mesh_file = meshio.Mesh(mesh.vertices, [("triangle", mesh.triangles)])
    if name == "gmsh":
        # One surface, number 1: Gmsh counts entities from 1.
        mesh_file.point_data["gmsh:dim_tags"] = np.tile([2, 1], (len(mesh.vertices), 1))
        for tag in ("gmsh:physical", "gmsh:geometrical"):
            mesh_file.cell_data[tag] = [np.ones(len(mesh.triangles), int)]
    with atomic_write(path) as temporary:
        meshio.write(temporary, mesh_file, file_format=name, **options)
