"""`read_master`: the surface of a mesh file as a master of triangles."""

from __future__ import annotations

from pathlib import Path

from contiga.errors import MeshError
from contiga.geometry.trimesh import TriMesh
from contiga.io.mesh import read_mesh
from contiga.io.raw import PartKeys


def read_master(
    path: str | Path,
    *,
    unit: str | None = None,
    file_unit: str | None = None,
    parts: PartKeys | None = None,
    normals: str = "facet",
) -> TriMesh:
    """Read the surface of a mesh as triangles.

    Solids are skinned, their normals outward; quadrilaterals are split along their shorter
    diagonal; shells keep the sense they have in the file. What the file holds beside, such as
    nodes inside solids, is left out.

    Parameters
    ----------
    path, unit, file_unit, parts : as for `read_mesh`
    normals : "facet" or "vertex", of feet

    Raises
    ------
    FileError, MeshError, UnitError
        As `read_mesh`; a cloud, which has no surface.

    Notes
    -----
    `mesh_summary(read_mesh(path))` says what the cells of the file are.
    """
    slave = read_mesh(path, unit=unit, file_unit=file_unit, parts=parts)
    if slave.facets is None or len(slave.facets) == 0:
        raise MeshError(
            "there are no facets: points alone cannot be a master",
            where=str(path),
            allowed="a mesh of shells or solids",
        )
    mesh = TriMesh(slave.points, slave.facets, name=slave.name, unit=slave.unit, normals=normals)
    return mesh.compact()
