"""Mesh files as masters: solids skinned, quadrilaterals split, clouds refused."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.errors import FileError, MeshError
from contiga.io.mesh.read_master import read_master

CUBE = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
HEXAHEDRON = [[0, 1, 3, 2, 4, 5, 7, 6]]
QUADS = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def _written(path, points, cells):
    meshio.write(path, meshio.Mesh(points, cells))
    return path


@pytest.mark.parametrize("cells", [[("hexahedron", HEXAHEDRON)], [("quad", QUADS)]])
def test_solids_are_skinned_and_quads_split(tmp_path, cells):
    points = np.vstack([CUBE, [[0.5, 0.5, 9.0]]])  # a node of no cell
    mesh = read_master(_written(tmp_path / "cube.vtu", points, cells), normals="vertex")
    assert mesh.name == "cube"
    assert mesh.normal_kind == "vertex"
    assert (len(mesh.vertices), len(mesh.triangles)) == (8, 12)
    assert mesh.volume() == pytest.approx(1.0)
    assert mesh.surface.closed
    assert mesh.contains([[0.5, 0.5, 0.5], [0.5, 0.5, 2.0]]).tolist() == [True, False]


def test_units_are_converted(tmp_path):
    path = _written(tmp_path / "cube.vtu", CUBE, [("hexahedron", HEXAHEDRON)])
    mesh = read_master(path, unit="mm", file_unit="m")
    np.testing.assert_allclose(mesh.bounds(), [[0] * 3, [1000] * 3])
    assert mesh.unit == "mm"


def test_a_cloud_is_no_master(tmp_path):
    path = tmp_path / "cloud.csv"
    np.savetxt(path, CUBE, delimiter=",")
    with pytest.raises(MeshError, match="points alone cannot be a master"):
        read_master(path)
    with pytest.raises(FileError, match="no such file"):
        read_master(tmp_path / "nothing.stl")


def test_a_tyre_of_solids_is_a_closed_master(data_dir):
    mesh = read_master(data_dir / "hmmwv_lugged_tyre_c3d10.inp")
    assert mesh.surface.closed
    assert mesh.volume() > 0.0
    slave = cg.Slave([[0.0, 0.0, -1.0]], area=[1.0])
    assert cg.Contact(mesh, slave, law=cg.PenaltyLaw(1.0)).start(slave.points).n_contact == 0
