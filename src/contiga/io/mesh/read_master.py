"""`read_master`: read the surface of a mesh file as a master of triangles."""

from __future__ import annotations

from pathlib import Path

from contiga.errors import MeshError
from contiga.io.mesh.read_mesh import read_mesh
from contiga.io.naming import PartKeys
from contiga.slaves.cells import SHELLS, SOLIDS
from contiga.slaves.slave import Slave
from contiga.triangles.trimesh import TriMesh

LINEAR = {"triangle": 1, "quad": 2}
"""Number of triangles of a plane cell."""


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
    diagonal; shells keep the sense they have in the file. Everything else in the file, such as
    nodes inside solids, is left out.

    Parameters
    ----------
    path, unit, file_unit, parts : as for `read_mesh`
    normals : "facet" or "vertex": normals at feet are those of the facet, or interpolated between
        its vertices

    Raises
    ------
    FileError, MeshError, UnitError
        As `read_mesh`; a cloud, which has no surface.

    Notes
    -----
    `source` of the mesh names the cells it was made of, if they are not its triangles.

    Examples
    --------
    >>> import contiga as cg
    >>> box = cg.read_master("pad.vtu")
    >>> len(box.triangles), box.closed, box.project([[0.5, 0.5, 3.0]]).gap.tolist()
    (12, True, [2.0])
    """
    slave = read_mesh(path, unit=unit, file_unit=file_unit, parts=parts)
    return master_of(slave, where=str(path), normals=normals).compact()


def master_of(slave: Slave, *, where: str, normals: str = "facet") -> TriMesh:
    """Return the facets of `slave` as a mesh over all its points, with its name and unit.

    Inactive points stay; `TriMesh.source` is "" if the facets are the file's triangles, one for
    one, else counts the cells. `normals` is as for `TriMesh`, `where` is for messages.

    Raises
    ------
    MeshError
        There are no facets.
    """
    if slave.facets is None or len(slave.facets) == 0:
        raise MeshError(
            "there are no facets: points alone cannot be a master",
            where=where,
            allowed="a mesh of shells or solids",
        )
    linear = slave.cells.keys() <= LINEAR.keys()
    n_triangles = sum(count * LINEAR.get(kind, 0) for kind, count in slave.cells.items())
    n_omitted = n_triangles - len(slave.facets)
    texts = []
    if not linear or "quad" in slave.cells or n_omitted != 0:
        for kind, count in slave.cells.items():
            change = " skinned" if kind in SOLIDS else " split" if SHELLS.get(kind) == 4 else ""
            texts.append(f"{count} {kind}{change}")
        if linear and n_omitted:
            texts.append(f"{n_omitted} given twice or folded flat left out")
    return TriMesh(
        slave.points,
        slave.facets,
        name=slave.name,
        unit=slave.unit,
        normals=normals,
        source=", ".join(texts),
    )
