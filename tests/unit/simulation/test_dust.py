"""Free nodes that a mesh joins fly on their own: that is told; a cloud of dust is one."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

import contiga as cg

CORNERS = np.array([[0.0, 0, 3], [1, 0, 3], [0, 1, 3], [0, 0, 4], [1, 1, 4]])


def found(slave: cg.Slave) -> list[cg.Finding]:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)])
    simulation = cg.Simulation(
        bodies={"ball": ball},
        slaves={"pad": (slave, cg.motion.Free(0.1, velocity=(0, 0, -1.0)))},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0), area=cg.NodalArea(1.0))],
        end=3.0,
        step=0.1,
    )
    return [one for one in simulation.check() if one.rule == "dust"]


def test_tetrahedra_of_a_file_are_told_to_be_dust(tmp_path: Path) -> None:
    mesh = meshio.Mesh(CORNERS, [("tetra", [[0, 1, 2, 3], [1, 2, 3, 4]])])
    meshio.write(tmp_path / "pad.vtu", mesh)
    (told,) = found(cg.read_mesh(tmp_path / "pad.vtu"))
    assert told.where == "slave pad"
    assert "5 nodes are free masses of their own: nothing holds the 2 tetra" in told.text


def test_facets_are_and_a_cloud_is_not() -> None:
    (told,) = found(cg.Slave(CORNERS, [[0, 1, 2]]))
    assert "the 1 facets together" in told.text
    assert found(cg.Slave(CORNERS)) == []


def test_of_a_part_of_a_file_its_own_cells_and_nodes_are_counted(tmp_path: Path) -> None:
    cells = [("tetra", [[0, 1, 2, 3]]), ("triangle", [[1, 2, 4]])]
    groups = {"gmsh:physical": [np.array([1]), np.array([2])]}
    geometry = {"gmsh:geometrical": [np.array([1]), np.array([1])]}
    names = {"block": np.array([1, 3]), "sheet": np.array([2, 2])}
    mesh = meshio.Mesh(CORNERS, cells, cell_data=groups | geometry, field_data=names)
    meshio.write(tmp_path / "two.msh", mesh, file_format="gmsh22")
    sheet = cg.read_mesh(tmp_path / "two.msh", parts="sheet")
    assert dict(sheet.cells) == {"triangle": 1}
    (told,) = found(sheet)
    assert "its 3 nodes are free masses of their own: nothing holds the 1 triangle to" in told.text
