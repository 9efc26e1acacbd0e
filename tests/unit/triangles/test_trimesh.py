"""The triangle mesh record."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import TriMesh
from contiga.errors import MeshError

SQUARE = [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]]
TWO = [[0, 1, 2], [0, 2, 3]]


def test_area_bounds_and_normals():
    mesh = TriMesh(SQUARE, TWO)
    assert mesh.area() == 6.0
    np.testing.assert_array_equal(mesh.bounds(), [[0, 0, 0], [2, 3, 0]])
    np.testing.assert_array_equal(mesh.normals(), [[0, 0, 1], [0, 0, 1]])
    np.testing.assert_array_equal(mesh.flipped().normals(), [[0, 0, -1], [0, 0, -1]])


def test_moves_keep_the_free_side_even_through_a_mirror():
    mesh = TriMesh(SQUARE, TWO)
    turned = mesh.rotated("x", np.pi / 2).translated((0, 0, 1)).scaled(2.0)
    np.testing.assert_allclose(turned.normals(), [[0, -1, 0]] * 2, rtol=0, atol=1e-15)
    assert turned.area() == pytest.approx(24.0)
    mirrored = mesh.transformed(np.diag([-1.0, 1.0, 1.0, 1.0]))
    np.testing.assert_array_equal(mirrored.normals(), mesh.normals())


def test_triangle_without_area_has_no_normal():
    mesh = TriMesh([[0, 0, 0], [1, 0, 0]], [[0, 1, 1]])
    assert np.isnan(mesh.normals()).all()


def test_mesh_is_its_own_copy_and_cannot_be_changed():
    points = np.array(SQUARE, dtype=float)
    mesh = TriMesh(points, TWO)
    points[:] = 0.0
    assert mesh.area() == 6.0
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        mesh.triangles[0] = 1
    with pytest.raises(AttributeError):
        mesh.vertices = points


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (SQUARE, [[0, 1, 4]], "triangle 0 points at a vertex that is not there"),
        (SQUARE, [[0, 1, 2], [-1, 0, 1]], "triangle 1 points"),
        (SQUARE, [[0, 1]], r"shape \(m, 3\)"),
        (SQUARE, [[0.0, 1.0, 2.0]], "whole numbers"),
        ([[0, 0]], [], r"shape \(n, 3\)"),
        ([[0, 0, np.nan]], [], "vertex 0 is not finite"),
        ("abc", [], "must be numbers"),
    ],
)
def test_wrong_meshes_are_refused(vertices, triangles, message):
    with pytest.raises(MeshError, match=message):
        TriMesh(vertices, triangles)


def test_empty_mesh_has_no_bounds():
    empty = TriMesh([], [])
    assert empty.area() == 0.0
    with pytest.raises(MeshError, match="no bounds"):
        empty.bounds()
