"""Meshes to and from meshio and trimesh: every vertex, every triangle, in their order."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.errors import MeshError, MissingPackageError

SIDES = "021 123 456 576 014 154 263 367 042 246 135 375"
CUBE = cg.TriMesh(
    [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)],
    [[int(k) for k in side] for side in SIDES.split()],
    name="cube",
)


def assert_same(one: cg.TriMesh, other: cg.TriMesh) -> None:
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_meshio_and_back_is_the_same_mesh() -> None:
    there = CUBE.to_meshio()
    assert [(block.type, len(block.data)) for block in there.cells] == [("triangle", 12)]
    back = cg.TriMesh.from_meshio(there, name="again", unit="mm", normals="vertex")
    assert_same(back, CUBE)
    assert (back.name, back.unit, back.normal_kind) == ("again", "mm", "vertex")


def test_what_is_given_away_can_be_changed_and_leaves_the_mesh_as_it_was() -> None:
    there = CUBE.to_meshio()
    there.points += 1.0
    there.cells[0].data[:] = 0
    assert CUBE.volume() == 1.0


def test_quadrilaterals_are_split_by_their_shorter_diagonal_and_keep_their_side() -> None:
    corners = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [3.0, 3.0, 0.0], [0.0, 2.0, 0.0]]
    for turn in range(4):
        mesh = meshio.Mesh(np.roll(corners, turn, axis=0), [("quad", [[0, 1, 2, 3]])])
        split = cg.TriMesh.from_meshio(mesh)
        np.testing.assert_allclose(split.normals(), [[0, 0, 1], [0, 0, 1]])
        assert split.area() == pytest.approx(4.5)  # by the shoelace formula
        (shared,) = {tuple(sorted(e)) for e in _sides(split)} - {
            tuple(sorted(e)) for e in split.open_edges().tolist()
        }
        ends = np.asarray(mesh.points)[list(shared)]
        assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(np.sqrt(5.0))


def _sides(mesh: cg.TriMesh) -> list[list[int]]:
    return [[t[k], t[k - 1]] for t in mesh.triangles.tolist() for k in range(3)]


def test_points_in_a_plane_and_lines_are_taken_for_what_they_are() -> None:
    blocks = [("line", [[0, 1]]), ("triangle", [[0, 1, 2]]), ("vertex", [[3]])]
    mesh = cg.TriMesh.from_meshio(meshio.Mesh([[0, 0], [1, 0], [0, 1], [5, 5]], blocks))
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 0]]
    assert mesh.triangles.tolist() == [[0, 1, 2]]


def test_cells_that_are_no_flat_facets_are_refused() -> None:
    solid = meshio.Mesh(np.eye(4, 3), [("tetra", [[0, 1, 2, 3]])])
    with pytest.raises(MeshError, match=r"part: cells of a kind.*found 'tetra'.*read_master"):
        cg.TriMesh.from_meshio(solid, name="part")
    lost = meshio.Mesh(np.eye(4, 3), [("quad", [[0, 1, 2, 4]])])
    with pytest.raises(MeshError, match=r"quad 0 points at a vertex that is not there"):
        cg.TriMesh.from_meshio(lost)


def test_what_has_vertices_and_faces_is_taken_as_trimesh_has_it() -> None:
    given = SimpleNamespace(vertices=CUBE.vertices, faces=CUBE.triangles)
    assert_same(cg.TriMesh.from_trimesh(given, name="cube"), CUBE)
    with pytest.raises(MeshError, match=r"expected a trimesh.Trimesh; found 'SimpleNamespace'"):
        cg.TriMesh.from_trimesh(SimpleNamespace(vertices=CUBE.vertices))


def test_trimesh_and_back_is_the_same_mesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    there = CUBE.to_trimesh()
    assert isinstance(there, trimesh.Trimesh)
    assert there.volume == pytest.approx(CUBE.volume())
    assert_same(cg.TriMesh.from_trimesh(there), CUBE)
    twice = cg.TriMesh(np.concatenate([CUBE.vertices] * 2), CUBE.triangles)
    assert len(twice.to_trimesh().vertices) == 16  # nothing is merged or left out


def test_without_trimesh_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(MissingPackageError, match=r"pip install trimesh$"):
        CUBE.to_trimesh()
