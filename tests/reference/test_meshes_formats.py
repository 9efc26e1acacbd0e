"""Meshes written by meshio in each format and read back; cell faces as VTK has them."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from contiga.io.mesh.read_mesh import read_mesh
from contiga.slaves.cells import SOLIDS

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
RT2, RT3 = np.sqrt(2.0), np.sqrt(3.0)
# Nodes of the cube that make a cell, and the area of its surface.
CELLS = {
    "triangle": ([0, 1, 2], 0.5),
    "quad": ([0, 1, 2, 3], 1.0),
    "tetra": ([0, 1, 3, 4], 1.5 + RT3 / 2),
    "hexahedron": (list(range(8)), 6.0),
    "wedge": ([0, 1, 3, 4, 5, 7], 3.0 + RT2),
    "pyramid": ([0, 1, 2, 3, 4], 2.0 + RT2),
}
LINEAR = ["triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid"]
NO_PYRAMID = [kind for kind in LINEAR if kind != "pyramid"]
QUADRATIC = ["tetra10", "hexahedron20"]
FORMATS = {
    ("vtu", ".vtu"): [*LINEAR, *QUADRATIC, "hexahedron27"],
    ("vtk", ".vtk"): [*LINEAR, *QUADRATIC, "hexahedron27"],
    ("vtk42", ".vtk"): [*LINEAR, *QUADRATIC],
    ("abaqus", ".inp"): [*NO_PYRAMID, *QUADRATIC],
    ("gmsh", ".msh"): [*LINEAR, *QUADRATIC, "hexahedron27"],
    ("gmsh22", ".msh"): [*LINEAR, *QUADRATIC],
    ("nastran", ".bdf"): [*LINEAR, *QUADRATIC],
    ("nastran", ".nas"): LINEAR,
    ("med", ".med"): [*LINEAR, *QUADRATIC],
    ("medit", ".mesh"): LINEAR,
    ("xdmf", ".xdmf"): [*LINEAR, *QUADRATIC],
    ("avsucd", ".avs"): LINEAR,
    ("permas", ".post"): LINEAR,
    ("ply", ".ply"): ["triangle", "quad"],
    ("obj", ".obj"): ["triangle", "quad"],
    ("off", ".off"): ["triangle"],
    ("stl", ".stl"): ["triangle"],
    ("ansys", ".msh"): LINEAR,
}
CASES = [(name, end, kind) for (name, end), kinds in FORMATS.items() for kind in kinds]


def one_cell(kind):
    """Points, node numbers and area of one cell, its middle nodes in VTK's places."""
    base = kind.rstrip("0123456789")
    corners, area = CELLS[base]
    if kind == base:
        return CUBE, np.array([corners]), area
    points = np.full((SOLIDS[kind].n_nodes, 3), 0.5)
    points[: len(corners)] = CUBE[corners]
    for face, on_corners in zip(SOLIDS[kind].faces, SOLIDS[kind].corner_faces, strict=True):
        n = len(on_corners)
        for i, node in enumerate(face[n : 2 * n]):
            points[node] = 0.5 * (points[face[i]] + points[face[(i + 1) % n]])
        for node in face[2 * n :]:
            points[node] = points[list(on_corners)].mean(axis=0)
    return points, np.arange(len(points))[None], area


@pytest.mark.parametrize(("name", "end", "kind"), CASES)
def test_a_mesh_written_by_meshio_reads_back(tmp_path, capfd, name, end, kind):
    points, cells, area = one_cell(kind)
    path = tmp_path / f"a{end}"
    meshio.write(path, meshio.Mesh(points, [(kind, cells)]), file_format=name)
    capfd.readouterr()
    slave = read_mesh(path)
    assert capfd.readouterr() == ("", "")
    expected = points[cells[0]] if end == ".stl" else points
    assert slave.points == pytest.approx(expected, abs=1e-7 if end == ".stl" else 1e-14)
    assert slave.area.sum() == pytest.approx(area, rel=1e-6 if end == ".stl" else 1e-14)
    assert dict(slave.cells) == {kind: 1}
    assert slave.points[slave.active] == pytest.approx(slave.points[np.unique(slave.facets)])


@pytest.mark.parametrize("binary", [True, False])
def test_stl_in_both_forms_gives_a_closed_cube(tmp_path, binary):
    quads = np.array([SOLIDS["hexahedron"].corner_faces]).reshape(-1, 4)
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    meshio.write(tmp_path / "a.stl", meshio.Mesh(CUBE, [("triangle", triangles)]), binary=binary)
    slave = read_mesh(tmp_path / "a.stl")
    assert len(slave) == 8
    assert slave.area.sum() == pytest.approx(6.0)
    assert sorted(map(tuple, slave.points.tolist())) == sorted(map(tuple, CUBE.tolist()))


_VTK_CELLS = {
    "tetra": "vtkTetra",
    "tetra10": "vtkQuadraticTetra",
    "hexahedron": "vtkHexahedron",
    "hexahedron20": "vtkQuadraticHexahedron",
    "hexahedron27": "vtkTriQuadraticHexahedron",
    "wedge": "vtkWedge",
    "wedge15": "vtkQuadraticWedge",
    "wedge18": "vtkBiQuadraticQuadraticWedge",
    "pyramid": "vtkPyramid",
    "pyramid13": "vtkQuadraticPyramid",
}


@pytest.mark.parametrize("kind", _VTK_CELLS)
def test_faces_of_cells_have_the_nodes_vtk_gives_them(kind):
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    cell = getattr(vtk, _VTK_CELLS[kind])()
    for i in range(cell.GetNumberOfPoints()):
        cell.GetPointIds().SetId(i, i)
    assert cell.GetNumberOfPoints() == SOLIDS[kind].n_nodes
    theirs = set()
    for i in range(cell.GetNumberOfFaces()):
        ids = cell.GetFace(i).GetPointIds()
        theirs.add(frozenset(ids.GetId(k) for k in range(ids.GetNumberOfIds())))
    assert {frozenset(face) for face in SOLIDS[kind].faces} == theirs


@pytest.mark.parametrize("kind", _VTK_CELLS)
def test_middle_nodes_stand_on_the_edges_vtk_gives_them(kind):
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    cell = getattr(vtk, _VTK_CELLS[kind])()
    for i in range(cell.GetNumberOfPoints()):
        cell.GetPointIds().SetId(i, i)
    theirs = set()
    for i in range(cell.GetNumberOfEdges()):
        ids = cell.GetEdge(i).GetPointIds()
        theirs.add(frozenset(ids.GetId(k) for k in range(ids.GetNumberOfIds())))
    ours = set()
    for face, corners in zip(SOLIDS[kind].faces, SOLIDS[kind].corner_faces, strict=True):
        n = len(corners)
        for i in range(n):
            middle = {face[n + i]} if len(face) > n else set()
            ours.add(frozenset({face[i], face[(i + 1) % n], *middle}))
    assert ours == theirs
