"""Meshes written for Gmsh, ParaView and STL, opened by others."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import meshio
import numpy as np
import pytest

from contiga import TriMesh, read_cad, read_mesh, shapes
from contiga.errors import FileError, MeshError, OutputError
from contiga.io.out.write_mesh import write_mesh


@pytest.fixture(scope="module")
def torus() -> TriMesh:
    return shapes.torus(major=2.0, minor=0.5).rotated("x", 0.3).tessellate(0.05)


@pytest.fixture(scope="module")
def gmsh() -> ModuleType:
    try:
        import gmsh as package
    except (ImportError, OSError) as error:  # it needs libraries of the window system
        pytest.skip(f"gmsh cannot be loaded: {error}")
    return package


def test_gmsh_opens_the_mesh_with_every_digit(gmsh, torus, tmp_path):
    path = tmp_path / "torus.msh"
    write_mesh(path, torus)
    assert path.read_text().startswith("$MeshFormat\n4.1 0 8\n")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        assert gmsh.model.getEntities() == [(2, 1)]
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        kinds, _, corners = gmsh.model.mesh.getElements(2)
        gmsh.model.mesh.createEdges()
        quality = gmsh.model.mesh.getElementQualities(
            gmsh.model.mesh.getElements(2)[1][0], "minSICN"
        )
    finally:
        gmsh.finalize()
    np.testing.assert_array_equal(tags, np.arange(1, len(torus.vertices) + 1))
    np.testing.assert_array_equal(coordinates.reshape(-1, 3), torus.vertices)
    assert kinds.tolist() == [2]
    np.testing.assert_array_equal(corners[0].reshape(-1, 3) - 1, torus.triangles)
    assert np.min(quality) > 0.0


def test_gmsh_finds_the_mesh_of_a_cad_file_sound(gmsh, data_dir, tmp_path):
    mesh = read_cad(data_dir / "goteborg_hull.step").tessellate(0.006)
    path = tmp_path / "hull.msh"
    write_mesh(path, mesh)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        (tags,) = gmsh.model.mesh.getElements(2)[1]
        area = np.sum(gmsh.model.mesh.getElementQualities(tags, "volume"))
        quality = gmsh.model.mesh.getElementQualities(tags, "minSICN")
        sides = gmsh.model.mesh.getElementEdgeNodes(2).reshape(-1, 2).astype(np.int64)
        doubled = gmsh.model.mesh.getDuplicateNodes()
    finally:
        gmsh.finalize()
    assert len(tags) == len(mesh.triangles)
    assert area == pytest.approx(mesh.area(), rel=1e-12)
    assert np.min(quality) > 0.0
    assert len(doubled) == 0
    forward, times = np.unique(sides, axis=0, return_counts=True)
    assert times.max() == 1  # neighbours run along their common side in opposite ways
    there = {tuple(side) for side in forward.tolist()}
    assert sum((b, a) not in there for a, b in there) == len(mesh.open_edges())


@pytest.mark.parametrize("suffix", [".msh", ".vtu", ".MSH"])
def test_meshio_reads_back_every_digit(torus, tmp_path, suffix):
    path = tmp_path / f"torus{suffix}"
    write_mesh(path, torus)
    back = meshio.read(path, file_format="gmsh" if suffix.lower() == ".msh" else "vtu")
    np.testing.assert_array_equal(back.points, torus.vertices)
    np.testing.assert_array_equal(back.cells_dict["triangle"], torus.triangles)


def test_stl_has_the_same_surface_in_single_precision(torus, tmp_path):
    path = tmp_path / "torus.stl"
    write_mesh(path, torus)
    back = read_mesh(path)
    mesh = TriMesh(back.points, back.facets)
    assert len(mesh.triangles) == len(torus.triangles)
    assert mesh.volume() == pytest.approx(torus.volume(), rel=1e-6)


def test_what_cannot_be_written_is_refused_and_leaves_nothing(torus, tmp_path):
    with pytest.raises(FileError, match=r"found '\.obj'; allowed: \.msh, \.vtu, \.stl"):
        write_mesh(tmp_path / "torus.obj", torus)
    with pytest.raises(MeshError, match="without triangles"):
        write_mesh(tmp_path / "empty.msh", TriMesh([], []))
    with pytest.raises(OutputError):
        write_mesh(tmp_path / "nowhere" / "torus.msh", torus)
    assert list(tmp_path.iterdir()) == []


def test_a_failure_half_way_keeps_the_old_file(torus, tmp_path, monkeypatch):
    path = tmp_path / "torus.vtu"
    path.write_text("old")

    def fail(file: Path, *_: object, **__: object) -> None:
        Path(file).write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(meshio, "write", fail)
    with pytest.raises(OSError, match="disk full"):
        write_mesh(path, torus)
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["torus.vtu"]
