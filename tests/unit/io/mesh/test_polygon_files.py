"""OFF, OBJ and other files of polygons: any number of corners, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning, InputError

CUBE = """8 6 12
0 0 0
1 0 0
1 1 0
0 1 0
0 0 1
1 0 1
1 1 1
0 1 1
4 0 3 2 1
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5
4 2 3 7 6
4 3 0 4 7
"""
HOUSE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0.5 0\n"
"""Corners of a square and the tip beside it."""
PLY = """ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
element face {count}
property list uchar int vertex_indices
end_header
"""


def write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n" + CUBE,
        "OFF " + CUBE,
        "# made by hand\nOFF # text\n\n" + CUBE.replace("4 3 0 4 7", "4 3 0 4 7 # last"),
        "COFF\n" + CUBE.replace("0 0 0\n", "0 0 0 255 0 0 255\n", 1),
        "OFF\n" + CUBE.replace("4 3 0 4 7", "4 3 0 4 7 0.5 0.5 0.5"),  # a colour
    ],
    ids=["plain", "one line", "comments", "colours of points", "colour of a face"],
)
def test_off_of_quadrilaterals(tmp_path: Path, text: str) -> None:
    slave = cg.read_mesh(write(tmp_path / "cube.off", text))
    assert dict(slave.cells) == {"quad": 6}
    mesh = cg.read_master(tmp_path / "cube.off")
    assert mesh.closed
    assert mesh.volume() == pytest.approx(1.0)
    assert mesh.source == "6 quad split"


def test_off_of_triangles_is_as_meshio_reads_it(tmp_path: Path) -> None:
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.05)
    path = tmp_path / "ball.off"
    meshio.write(path, meshio.Mesh(ball.vertices, [("triangle", ball.triangles)]))
    slave, other = cg.read_mesh(path), meshio.read(path)
    assert np.array_equal(slave.points, other.points)
    assert np.array_equal(slave.facets, other.cells[0].data)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", f"OFF\n5 3 0\n{HOUSE}4 0 1 2 3\n3 1 4 2\n2 0 1\n"),
        ("a.obj", "".join(f"v {row}\n" for row in HOUSE.splitlines())
         + "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -4//1 -1//1 -3//1\n"),
        ("a.ply", PLY.format(count=2) + HOUSE + "4 0 1 2 3\n3 1 4 2\n"),
    ],
)  # fmt: skip
def test_mixed_faces(tmp_path: Path, name: str, text: str) -> None:
    slave = cg.read_mesh(write(tmp_path / name, text))
    assert dict(slave.cells) == {"triangle": 1, "quad": 1}
    assert slave.area.sum() == pytest.approx(1.5)
    assert slave.active.all()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", f"OFF\n5 1 0\n{HOUSE}5 0 1 4 2 3\n"),
        ("a.obj", "".join(f"v {row}\n" for row in HOUSE.splitlines()) + "f 1 2 5 3 4\n"),
        ("a.ply", PLY.format(count=1) + HOUSE + "5 0 1 4 2 3\n"),
        ("a.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 "
         f"double\n{HOUSE}CELLS 1 6\n5 0 1 4 2 3\nCELL_TYPES 1\n7\n"),
    ],
)  # fmt: skip
def test_polygons_are_split_and_it_is_told(tmp_path: Path, name: str, text: str) -> None:
    with pytest.warns(ContigaWarning, match="1, of up to 5 corners, into 3 triangles"):
        slave = cg.read_mesh(write(tmp_path / name, text))
    assert slave.area.sum() == pytest.approx(1.5)
    corners = slave.points[slave.facets]
    assert (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 0).all()


def test_groups_of_obj_are_parts(tmp_path: Path) -> None:
    rows = "".join(f"v {row}\n" for row in HOUSE.splitlines())
    path = write(
        tmp_path / "a.obj", f"{rows}g wall left\nf 1 2 3 4\no tip\nf 2 5 3\ng wall left\nf 1 2 4\n"
    )
    assert [(part.label, part.n_cells) for part in cg.read_mesh(path).parts] == [
        ("wall left", 2),
        ("tip", 1),
    ]
    tip = cg.read_mesh(path, parts="tip")
    assert np.flatnonzero(tip.active).tolist() == [1, 2, 4]


def test_part_numbers_survive_the_splitting_of_polygons(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0.5, 0], [1, 1, 0], [0, 1, 0], [3, 3, 0]], float)
    mesh = meshio.Mesh(
        points, [("polygon", [[0, 1, 2, 3, 4]]), ("triangle", [[2, 5, 3]])],
        cell_data={"part_id": [np.array([7]), np.array([9])]},
    )  # fmt: skip
    path = tmp_path / "a.vtu"
    meshio.write(path, mesh)
    with pytest.warns(ContigaWarning, match="split"):
        assert cg.read_mesh(path, parts=7).area.sum() == pytest.approx(1.5)
    with pytest.warns(ContigaWarning, match="split"):
        assert np.flatnonzero(cg.read_mesh(path, parts=9).active).tolist() == [2, 3, 5]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.off", "OOF\n", "not an OFF file of text; found 'OOF'"),
        ("a.off", "OFF BINARY\n", "not an OFF file of text"),
        ("a.off", "4OFF\n", "not an OFF file of text"),
        ("a.off", "OFF\n", "the file ends before its counts"),
        ("a.off", "OFF\n9999999999 1 0\n0 0 0\n", "ends before point 2 of 9999999999"),
        ("a.off", "OFF\n1 1 0\n0 0 x\n", r"a\.off, line 3: a point needs three numbers"),
        ("a.off", "OFF\nx 1 0\n", "line 2: a count must be a whole number; found 'x'"),
        ("a.off", "OFF\n4\n", "a count must be a whole number"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "a face of 3 corners names fewer"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
         "line 6: a face names a node that is not there; found 3; allowed: 0 to 2"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "must be a whole number"),
        ("a.obj", "v 0 0\n", r"a\.obj, line 1: a point needs three numbers"),
        ("a.obj", "v 0 0 0\nf 1 2 3\n",
         "line 2: a face names a node that is not there; found 3; allowed: 1 to 1"),
        ("a.obj", "v 0 0 0\nf 0 1 1\n", "line 2: a face names a node that is not there"),
        ("a.obj", "v 0 0 0\nf -2 1 1\n", "line 2: a face names a node that is not there"),
        ("a.obj", "v 0 0 0\nf a b c\n", "a corner of a face must be a whole number; found 'a'"),
        ("a.obj", "mtllib x.mtl\n", "there are no nodes"),
        ("a.vtk", "# vtk DataFile Version 3.0\np\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n",
         r"POLYDATA.*can save anew, as \.vtu"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_line(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        cg.read_mesh(write(tmp_path / name, text))


SECOND_ORDER = [
    ("t10.inp", "abaqus"), ("t10.bdf", "nastran"), ("t10.msh", "gmsh22"), ("t10.msh", "gmsh"),
    ("t10.vtk", "vtk"), ("t10.vtu", "vtu"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "kind"), SECOND_ORDER)
def test_mid_side_nodes_are_on_facets_and_told_of(tmp_path: Path, name: str, kind: str) -> None:
    """A ten-node tetrahedron: four nodes of corners, six between, all on the surface."""
    from contiga.slaves.mesh_summary import mesh_summary

    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    points = np.vstack([corners, [corners[list(pair)].mean(axis=0) for pair in pairs]])
    path = tmp_path / name
    meshio.write(path, meshio.Mesh(points, [("tetra10", [list(range(10))])]), file_format=kind)
    slave = cg.read_mesh(path)
    assert slave.active.all()
    assert len(slave.facets) == 16
    assert (slave.area > 0.0).all()
    assert slave.area.sum() == pytest.approx(1.5 + np.sqrt(3.0) / 2.0, rel=1e-6)
    mesh = cg.read_master(path)
    assert mesh.closed
    assert mesh.volume() == pytest.approx(1.0 / 6.0, rel=1e-6)
    assert "mid-side nodes" in mesh_summary(slave)["second_order"]


def test_eight_node_shells_of_nastran(tmp_path: Path) -> None:
    nodes = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0), (1, 0.5), (0.5, 1), (0, 0.5)]
    grid = "".join(f"GRID,{k},,{x:.1f},{y:.1f},0.\n" for k, (x, y) in enumerate(nodes, start=1))
    path = write(
        tmp_path / "q8.bdf",
        f"CEND\nBEGIN BULK\n{grid}CQUAD8,1,1,1,2,3,4,5,6\n+,7,8\nENDDATA\n",
    )
    slave = cg.read_mesh(path)
    assert dict(slave.cells) == {"quad8": 1}
    assert slave.active.all()
    assert slave.area.sum() == pytest.approx(1.0)
