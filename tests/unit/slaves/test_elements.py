"""Elements of slaves: kept by what moves them, turned by a mirror, read from files."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.dynamics.deforming_parts import ELEMENT_OF_CELL
from contiga.errors import MeshError
from contiga.slaves.cells import CORNER_EDGES, N_NODES, SOLIDS
from contiga.slaves.elements import elements_of, mirrored
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


@pytest.mark.parametrize("kind", [kind for kind in ELEMENT_OF_CELL if kind in SOLIDS])
def test_all_solids_that_deform_can_be_mirrored(kind: str) -> None:
    """The new order of corners turns every face of the old one."""
    row = np.arange(N_NODES[kind])[None]
    turned = mirrored({kind: row})[kind][0]
    assert not np.array_equal(turned, row[0]), "missing in _MIRRORED"
    faces = SOLIDS[kind].corner_faces
    cycles = {_cycle(face) for face in faces}
    assert {_cycle(turned[list(face)][::-1]) for face in faces} == cycles


def _cycle(face: object) -> tuple[int, ...]:
    """Return corners in their order, the least of them first."""
    corners = np.asarray(face)
    return tuple(np.roll(corners, -int(corners.argmin())).tolist())


@pytest.mark.parametrize("kind", CORNER_EDGES)
def test_edges_of_solids_are_those_of_their_faces(kind: str) -> None:
    faces = SOLIDS[kind].corner_faces
    sides = {frozenset((face[k - 1], face[k])) for face in faces for k in range(len(face))}
    assert {frozenset(edge) for edge in CORNER_EDGES[kind]} == sides
    assert len(CORNER_EDGES[kind]) == len(sides)


def test_all_solids_that_deform_have_edges() -> None:
    """The check of depth measures elements by them."""
    assert {kind for kind in ELEMENT_OF_CELL if kind in SOLIDS} <= CORNER_EDGES.keys()


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
