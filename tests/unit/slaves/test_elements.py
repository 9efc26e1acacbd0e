"""Elements of slaves: kept by what moves them, turned by a mirror, read from files."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.errors import MeshError
from contiga.slaves.elements import elements_of
from contiga.slaves.skin import CellBlock, _volumes


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_elements_stay_with_the_points_and_proper_in_a_mirror(kind: str) -> None:
    slave = block((2, 1, 1), (2.0, 1.0, 1.0), kind=kind)
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    top = slave.selected(side=([0, 0, 1], 10.0))
    for moved in (slave, slave.transformed(mirror), slave.scaled(2.0), top):
        cells = np.asarray(moved.elements[kind], np.int64)
        assert (_volumes(moved.points, kind, cells) > 0.0).all()
    again = pickle.loads(pickle.dumps(slave))
    np.testing.assert_array_equal(again.elements[kind], slave.elements[kind])


def test_shells_on_solids_are_no_elements_and_others_are() -> None:
    slave = block((1, 1, 1), (1.0, 1.0, 1.0), kind="hexahedron")
    cells = np.asarray(slave.elements["hexahedron"], np.int64)
    border = CellBlock("quad", np.array([[0, 1, 3, 2]]))
    away = CellBlock("triangle", np.array([[0, 1, 9]]))
    elements = elements_of([CellBlock("hexahedron", cells), border, away])
    assert {kind: rows.tolist() for kind, rows in elements.items()} == {
        "hexahedron": cells.tolist(),
        "triangle": [[0, 1, 9]],
    }


def test_a_mesh_from_a_file_has_its_elements(tmp_path) -> None:
    meshio = pytest.importorskip("meshio")
    slave = block((2, 2, 2), (1.0, 1.0, 1.0))
    cells = np.asarray(slave.elements["tetra"])
    meshio.write_points_cells(tmp_path / "block.vtu", slave.points, [("tetra", cells)])
    read = cg.read_mesh(tmp_path / "block.vtu", layer="all")
    np.testing.assert_array_equal(read.elements["tetra"], cells)
    assert read.active.all()


@pytest.mark.parametrize(
    "elements", [{"tetra": [[0, 1, 2]]}, {"tetra": [[0, 1, 2, 9]]}, {"brick": [[0, 1, 2, 3]]}]
)
def test_elements_that_do_not_fit_are_refused(elements: dict) -> None:
    points = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    with pytest.raises(MeshError, match="element"):
        cg.Slave(points, elements=elements)
