"""Physical groups of Gmsh: saved with all the rest, and of several on one face."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import contiga as cg
from contiga.io.mesh.meshio_files import read_with_meshio

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


SQUARE = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Entities
0 0 1 0
1 0 0 0 1 1 0 0 0
$EndEntities
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
1 1 1 1
2 1 3 1
1 1 2 3 4
$EndElements
"""


def test_a_meshio_without_what_is_mended_reads_as_it_does(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Gmsh's files, and those of other formats, too."""
    from meshio.gmsh import _gmsh40

    (tmp_path / "square.msh").write_text(SQUARE)
    (tmp_path / "facet.stl").write_text(
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid s\n"
    )
    monkeypatch.delattr(_gmsh40, "_read_elements")
    for name, kind in (("square.msh", "quad"), ("facet.stl", "triangle")):
        blocks = read_with_meshio(tmp_path / name).blocks
        assert [(block.kind, len(block.nodes)) for block in blocks] == [(kind, 1)]


def test_version_2_saves_all_without_groups(box: Any, tmp_path: Path) -> None:
    path = str(tmp_path / "box.msh")
    box.option.setNumber("Mesh.SaveAll", 1)
    box.option.setNumber("Mesh.MshFileVersion", 2.2)
    box.write(path)
    mesh = cg.read_mesh(path)
    assert mesh.area.sum() == pytest.approx(6.0)
    assert list(mesh.parts) == []
