"""Reading meshes and clouds: selection, units, and refusals."""

from __future__ import annotations

import os
from importlib import import_module
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

from contiga.errors import ContigaError, FileError, MeshError, UnitError
from contiga.io.mesh.meshio_files import read_with_meshio
from contiga.io.mesh.read_mesh import read_mesh
from contiga.slaves.mesh_summary import mesh_summary

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
CUBE = np.vstack([SQUARE, SQUARE + np.array([0, 0, 1.0])])
ABAQUS = """*HEADING
a strip of two shells beside a tetrahedron
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 2., 0., 0.
6, 2., 1., 0.
11, 0., 0., 5.
12, 1., 0., 5.
13, 0., 1., 5.
14, 0., 0., 6.
*ELEMENT, TYPE=S4, ELSET=LEFT
1, 1, 2, 3, 4
*ELEMENT, TYPE=S4R, ELSET=RIGHT
2, 2, 5, 6, 3
*ELEMENT, TYPE=C3D4, ELSET=BLOCK
3, 11, 12, 13, 14
*NSET, NSET=EDGE
1, 2, 3
*NSET, NSET=TWO
1, 6
"""


@pytest.fixture
def abaqus(tmp_path):
    path = tmp_path / "strip.inp"
    path.write_text(ABAQUS)
    return path


def write(path, points, cells, **more):
    meshio.Mesh(points, cells, **more).write(path)
    return path


def test_nodes_inside_solids_are_kept_but_not_active(tmp_path):
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(27).reshape(3, 3, 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(i, j, 1) for i, j, _ in corners]
    hexahedra = [
        [index[i + a, j + b, k + c] for a, b, c in corners]
        for i in range(2)
        for j in range(2)
        for k in range(2)
    ]
    slave = read_mesh(write(tmp_path / "block.vtu", grid, [("hexahedron", np.array(hexahedra))]))
    assert np.array_equal(slave.points, grid)
    assert np.flatnonzero(~slave.active).tolist() == [13]
    assert slave.area[13] == 0.0
    assert slave.area.sum() == pytest.approx(24.0)


def test_nodes_on_no_shell_are_kept_but_not_active(tmp_path):
    points = np.vstack([SQUARE, [[9.0, 9.0, 9.0]]])
    cells = [("quad", np.array([[0, 1, 2, 3]])), ("line", np.array([[0, 4]]))]
    slave = read_mesh(write(tmp_path / "plate.vtu", points, cells))
    assert slave.active.tolist() == [True] * 4 + [False]
    assert dict(slave.cells) == {"quad": 1, "line": 1}


@pytest.mark.parametrize("kind", ["vtu", "gmsh"])
def test_lines_are_bars_and_points_where_they_are_alone(tmp_path, kind):
    points = np.vstack([SQUARE, [[9.0, 9.0, 9.0]]])
    lines = np.array([[0, 1], [2, 3]])
    path = tmp_path / {"vtu": "net.vtu", "gmsh": "net.msh"}[kind]
    meshio.Mesh(points, [("line", lines)]).write(path, file_format=kind)
    slave = read_mesh(path)
    assert slave.facets is None
    assert slave.elements["line"].tolist() == lines.tolist()
    assert slave.active.tolist() == [True] * 4 + [False]


def test_lines_along_the_edges_of_other_cells_are_no_elements(tmp_path):
    points = np.vstack([SQUARE, SQUARE + np.array([2.0, 0.0, 0.0]), [[0.5, 0.5, 1.0]]])
    cells = [
        ("line", np.array([[1, 0], [0, 2], [2, 5], [8, 0]])),
        ("quad", np.array([[0, 1, 2, 3]])),
        ("tetra", np.array([[4, 5, 6, 8]])),
    ]
    slave = read_mesh(write(tmp_path / "some.vtu", points, cells))
    # one edge of the quadrilateral; its diagonal and two ways from cell to cell are none
    assert slave.elements["line"].tolist() == [[0, 2], [2, 5], [8, 0]]
    assert dict(slave.cells) == {"line": 4, "quad": 1, "tetra": 1}


def test_bent_lines_are_passed_over(tmp_path):
    cells = [("line3", np.array([[0, 1, 2]])), ("triangle", np.array([[0, 1, 2]]))]
    slave = read_mesh(write(tmp_path / "bent.vtu", SQUARE, cells))
    assert dict(slave.cells) == {"triangle": 1}


def test_a_plane_mesh_gets_z_zero(tmp_path):
    path = tmp_path / "plane.msh"
    write(path, SQUARE, [("triangle", np.array([[0, 1, 2]]))])
    assert read_mesh(path).points[:, 2].tolist() == [0.0] * 4


def test_duplicated_vertices_of_stl_are_merged(tmp_path):
    facets = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in SQUARE[list(corners)])
        + "endloop\nendfacet\n"
        for corners in ((0, 1, 2), (0, 2, 3))
    )
    path = tmp_path / "square.stl"
    path.write_text(f"solid s\n{facets}endsolid s\n")
    slave = read_mesh(path)
    assert len(slave) == 4
    assert sorted(map(tuple, slave.points)) == sorted(map(tuple, SQUARE))
    assert slave.area.sum() == pytest.approx(1.0)


def test_sets_of_cells_are_chosen_by_name(abaqus):
    slave = read_mesh(abaqus, parts="RIGHT")
    assert len(slave) == 10
    assert slave.area.sum() == pytest.approx(1.0)
    assert np.flatnonzero(slave.active).tolist() == [1, 2, 4, 5]
    both = read_mesh(abaqus, parts=["left", "RIGHT"])  # any case, as in Abaqus
    assert both.area.sum() == pytest.approx(2.0)
    block = read_mesh(abaqus, parts=["BLOCK"])
    assert block.area.sum() == pytest.approx(1.5 + np.sqrt(3) / 2)


def test_a_set_of_nodes_takes_its_nodes_and_the_facets_between_them(abaqus):
    slave = read_mesh(abaqus, parts="EDGE")
    assert np.flatnonzero(slave.active).tolist() == [0, 1, 2]
    assert slave.area.sum() == pytest.approx(0.5)
    loose = read_mesh(abaqus, parts="TWO")
    assert np.flatnonzero(loose.active).tolist() == [0, 5]
    assert loose.facets is None


def test_an_unknown_part_is_refused_with_those_there_are(abaqus):
    with pytest.raises(MeshError, match="LEFT, RIGHT, BLOCK, ALL, EDGE, TWO"):
        read_mesh(abaqus, parts="MIDDLE")


def test_parts_of_a_cloud_are_refused(tmp_path):
    path = tmp_path / "cloud.csv"
    path.write_text("0,0,0\n")
    with pytest.raises(MeshError, match="names no parts"):
        read_mesh(path, parts=[1])


def test_physical_groups_are_chosen_by_name_or_number(tmp_path):
    path = tmp_path / "box.msh"
    bottom, top = np.array([[0, 1, 2, 3]]), np.array([[4, 5, 6, 7]])
    mesh = meshio.Mesh(
        CUBE,
        [("quad", bottom), ("quad", top), ("hexahedron", np.arange(8)[None])],
        cell_data={
            "gmsh:physical": [np.array([1]), np.array([2]), np.array([1])],
            "gmsh:geometrical": [np.array([1]), np.array([2]), np.array([1])],
        },
        field_data={"bottom": np.array([1, 2]), "top": np.array([2, 2]), "box": np.array([1, 3])},
    )
    meshio.write(path, mesh, file_format="gmsh22")
    assert read_mesh(path).area.sum() == pytest.approx(6.0)
    assert np.flatnonzero(read_mesh(path, parts="top").active).tolist() == [4, 5, 6, 7]
    assert read_mesh(path, parts="box").area.sum() == pytest.approx(6.0)
    assert np.flatnonzero(read_mesh(path, parts=2).active).tolist() == [4, 5, 6, 7]
    labels = [part["label"] for part in mesh_summary(read_mesh(path))["parts"]]
    assert labels == ["1 (bottom)", "2 (top)", "1 (box)"]


def test_nastran_property_numbers_are_parts(tmp_path):
    path = tmp_path / "plate.bdf"
    mesh = meshio.Mesh(
        CUBE,
        [("quad", np.array([[0, 1, 2, 3]])), ("quad", np.array([[4, 5, 6, 7]]))],
        cell_data={"nastran:ref": [np.array([3]), np.array([8])]},
    )
    mesh.write(path)
    assert np.flatnonzero(read_mesh(path, parts=8).active).tolist() == [4, 5, 6, 7]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "x,y,z\n0,1,2\n3,4,5e0\n"),
        ("a.csv", "0;1;2\n3;4;5\n"),
        ("a.csv", "\ufeffX, Y, Z\n0, 1, 2\n\n3, 4, 5\n"),
        ("a.xyz", "0 1 2\n3 4 5\n"),
        ("a.txt", "# a comment\n0\t1\t2  # here too\n  3 4 5\n"),
        ("a.csv", '"x","y","z"\n"0","1","2"\n3,4,5\n'),
        ("a.csv", "x;y;z\n0,0;1,0;2\n3;4,0;5\n"),
    ],
)
def test_three_columns_of_text_are_a_cloud(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    slave = read_mesh(path)
    assert slave.points.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert slave.facets is None
    assert slave.area is None


def test_the_names_of_a_cloud_may_say_their_unit(tmp_path):
    path = tmp_path / "a.csv"
    for head in ("x[m],y[m],z[m]", '"x [m]","y [m]","z [m]"', "x (m) y (m) z (m)"):
        mark = "," if "," in head else " "
        path.write_text(f"{head}\n{mark.join('012')}\n")
        assert read_mesh(path, unit="mm").points.tolist() == [[0.0, 1000.0, 2000.0]]
        assert read_mesh(path).unit == "m"
        with pytest.raises(FileError, match=r"a\.csv: the file says another unit.*found 'm'"):
            read_mesh(path, unit="mm", file_unit="in")
    path.write_text("x [m],y [mm],z [m]\n0,1,2\n")
    with pytest.raises(FileError, match="several units"):
        read_mesh(path)
    path.write_text("x [left],y [left],z [left]\n0,1,2\n")
    for unit in ("mm", None):
        with pytest.raises(UnitError, match=r"a\.csv: not a known unit of length; found 'left'"):
            read_mesh(path, unit=unit)


def test_an_array_is_a_cloud(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(6).reshape(2, 3))
    assert read_mesh(tmp_path / "a.npy").points.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_lengths_are_converted_from_the_unit_of_the_file(abaqus):
    slave = read_mesh(abaqus, unit="mm", file_unit="m")
    assert slave.unit == "mm"
    assert slave.points.max() == pytest.approx(6000.0)
    assert slave.area.sum() == pytest.approx(1e6 * read_mesh(abaqus).area.sum())


def test_without_a_file_unit_numbers_are_taken_as_they_are(abaqus):
    slave = read_mesh(abaqus, unit="mm")
    assert slave.unit == "mm"
    assert slave.points.max() == 6.0
    assert read_mesh(abaqus, file_unit="in").unit == "in"
    assert read_mesh(abaqus).unit is None


def test_the_suffixes_of_every_reader_are_named(tmp_path, monkeypatch):
    """A new reader is in the message about an unknown suffix by its line in `_READERS`."""
    module = import_module("contiga.io.mesh.read_mesh")
    for suffixes in module._READERS.values():
        assert set(suffixes) <= set(module.OWN_SUFFIXES)
    monkeypatch.setattr(module, "OWN_SUFFIXES", (*module.OWN_SUFFIXES, ".unv"))
    with pytest.raises(FileError, match="no format of meshes") as refusal:
        read_with_meshio(tmp_path / "a.docx")
    named = refusal.value.allowed.split()
    assert set(module.OWN_SUFFIXES) <= set(named)
    assert len(named) == len(set(named))


def test_a_unit_that_is_none_is_refused(abaqus):
    for units in ({"unit": "furlong per"}, {"unit": "mm", "file_unit": "kg"}):
        with pytest.raises(UnitError):
            read_mesh(abaqus, **units)


@pytest.mark.parametrize(
    ("name", "content", "kind", "message"),
    [
        ("none.vtu", None, FileError, "no such file"),
        ("folder.vtu", "folder", FileError, "not a file"),
        ("a.docx", "x", FileError, r"suffix.*\.docx.*\.k .*\.csv .*\.vtu"),
        ("a", "x", FileError, "suffix"),
        ("empty.vtu", "", FileError, "empty"),
        ("a.vtu", "nonsense", FileError, "cannot be read as .vtu"),
        ("a.inp", "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=WHAT\n1, 1\n", MeshError, "line 3.*WHAT"),
        ("a.inp", "*HEADING\nnothing\n", MeshError, "no nodes"),
        (
            "a.inp",
            "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=S3\n1, 1, 2, 3\n",
            MeshError,
            "not there.*2",
        ),
        ("a.stl", "solid s\nendsolid s\n", ContigaError, "a.stl"),
        ("a.msh", "(0 cut", FileError, "cannot be read as .msh"),
        ("a.off", "OFF", FileError, "the file ends before its counts"),
        ("a.ply", "ply\nformat ascii 1.0\n", FileError, "cannot be read as .ply"),
        ("a.csv", "0,0,0\n0,0\n", FileError, "line 2.*'0,0'"),
        ("a.csv", "0,0,0\nx,y,z\n", FileError, "line 2"),
        ("a.csv", "0,0,0,0\n", FileError, "line 1"),
        ("a.xyz", "2\ncomment\nH 0 0 0\n", FileError, "line 1"),
        ("a.csv", "x,y,z\n", MeshError, "no nodes"),
        ("a.csv", "0,0,0\n1,nan,0\n", MeshError, "not finite, first row 1"),
        ("a.npy", "no array", FileError, "not a plain NumPy array"),
    ],
)
def test_bad_files_are_refused_in_one_sentence_and_in_silence(
    tmp_path, capfd, name, content, kind, message
):
    path = tmp_path / name
    if content == "folder":
        path.mkdir()
    elif content is not None:
        path.write_text(content)
    with pytest.raises(kind, match=message) as caught:
        read_mesh(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    out, err = capfd.readouterr()
    assert (out, err) == ("", "")


def test_arrays_that_are_no_cloud_are_refused(tmp_path):
    for array in (np.zeros((3, 2)), np.zeros(3), np.array([["a", "b", "c"]])):
        np.save(tmp_path / "a.npy", array)
        with pytest.raises(FileError, match="three columns"):
            read_mesh(tmp_path / "a.npy")


def test_nodes_that_are_not_finite_are_named(tmp_path):
    points = SQUARE.copy()
    points[2, 1] = np.nan
    path = write(tmp_path / "a.vtk", points, [("quad", np.array([[0, 1, 2, 3]]))])
    with pytest.raises(MeshError, match="not finite, first row 2"):
        read_mesh(path)


def test_cells_that_name_no_node_are_refused(tmp_path):
    path = tmp_path / "a.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    with pytest.raises(MeshError, match=r"line 6: a face names a node.*found 7.*0 to 2"):
        read_mesh(path)
    path = tmp_path / "a.ply"
    path.write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"
    )
    with pytest.raises(MeshError, match=r"triangle 0.*\[0, 1, 7\].*0 to 2"):
        read_mesh(path)


def test_cells_without_facets_are_refused_with_those_that_have(tmp_path):
    points = np.arange(15.0).reshape(5, 3)
    path = write(tmp_path / "a.vtu", points, [("VTK_LAGRANGE_CURVE", np.arange(5)[None])])
    with pytest.raises(MeshError, match=r"VTK_LAGRANGE_CURVE.*triangle"):
        read_mesh(path)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_refused(tmp_path):
    path = tmp_path / "a.vtu"
    path.write_text("x")
    path.chmod(0)
    with pytest.raises(FileError, match="cannot be opened"):
        read_mesh(path)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.7, 0.9, 0.97])
@pytest.mark.parametrize(
    "suffix", [".vtu", ".vtk", ".msh", ".bdf", ".ply", ".off", ".stl", ".mdpa"]
)
def test_a_file_cut_short_ends_in_an_error_or_a_smaller_mesh(tmp_path, suffix, share):
    path = write(tmp_path / f"a{suffix}", CUBE, [("triangle", np.array([[0, 1, 2], [4, 5, 6]]))])
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    try:
        slave = read_mesh(path)
    except (FileError, MeshError):
        return
    assert np.isfinite(slave.points).all()
    assert slave.facets is None or slave.facets.max() < len(slave)


def test_arrays_that_do_not_fit_together_are_a_file_error(tmp_path, monkeypatch):
    path = write(tmp_path / "a.vtu", SQUARE, [("triangle", np.array([[0, 1, 2]]))])
    ragged = SimpleNamespace(type="triangle", data=[[0, 1, 2], [0, 1]])
    mesh = SimpleNamespace(points=SQUARE, cells=[ragged])
    monkeypatch.setattr(meshio, "read", lambda *_: mesh)
    with pytest.raises(FileError, match="do not fit together"):
        read_with_meshio(path)
