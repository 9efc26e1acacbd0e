"""Physical groups of Gmsh: saved with all the rest, and of several on one face."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import contiga as cg

gmsh = pytest.importorskip("gmsh")


@pytest.fixture
def box() -> Iterator[Any]:
    """A unit cube of tetrahedra; faces 1 and 2 are side a, 2 and 3 side b."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    for name, faces in (("a", [1, 2]), ("b", [2, 3])):
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, faces), name)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    gmsh.model.mesh.generate(3)
    yield gmsh
    gmsh.finalize()


@pytest.mark.parametrize("binary", [0, 1])
def test_groups_are_whole_where_all_is_saved(box: Any, tmp_path: Path, binary: int) -> None:
    path = str(tmp_path / "box.msh")
    box.option.setNumber("Mesh.SaveAll", 1)
    box.option.setNumber("Mesh.Binary", binary)
    box.write(path)
    mesh = cg.read_mesh(path)
    assert mesh.cells["tetra"] > 0
    assert mesh.area.sum() == pytest.approx(6.0)
    assert [part.label for part in mesh.parts] == ["1 (a)", "2 (b)"]
    for name in ("a", "b"):
        assert cg.read_mesh(path, parts=name).area.sum() == pytest.approx(2.0)


def test_version_2_saves_all_without_groups(box: Any, tmp_path: Path) -> None:
    path = str(tmp_path / "box.msh")
    box.option.setNumber("Mesh.SaveAll", 1)
    box.option.setNumber("Mesh.MshFileVersion", 2.2)
    box.write(path)
    mesh = cg.read_mesh(path)
    assert mesh.area.sum() == pytest.approx(6.0)
    assert list(mesh.parts) == []
