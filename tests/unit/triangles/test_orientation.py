"""Triangles turned so that neighbours face the same way."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import TriMesh
from contiga.errors import MeshError


@pytest.mark.parametrize("seed", [0, 1])
def test_closed_pieces_turned_at_random_face_outward_again(seed):
    rng = np.random.default_rng(seed)
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.02)
    other = ball.translated([3.0, 0.0, 0.0])
    n = len(ball.vertices)
    triangles = np.concatenate([ball.triangles, other.triangles + n])
    turned = rng.random(len(triangles)) < 0.5
    triangles[turned] = triangles[turned][:, ::-1]
    mesh = TriMesh(np.concatenate([ball.vertices, other.vertices]), triangles).oriented()
    assert mesh.volume() == pytest.approx(2.0 * ball.volume(), rel=1e-12)


def test_an_open_sheet_keeps_the_sense_of_most_of_its_area():
    sheet = cg.shapes.bumpy_plate().tessellate(0.01)
    triangles = sheet.triangles.copy()
    triangles[:3] = triangles[:3, ::-1]
    np.testing.assert_array_equal(
        TriMesh(sheet.vertices, triangles).oriented().normals(), sheet.normals()
    )


def test_a_soup_without_shared_vertices_is_turned_too():
    ball = cg.shapes.sphere(radius=1.0).tessellate(0.05)
    corners = ball.corners().copy()
    corners[::3] = corners[::3, ::-1]
    soup = TriMesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    assert soup.oriented().volume() == pytest.approx(ball.volume(), rel=1e-12)


def test_a_moebius_strip_is_refused():
    a = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    rim = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1)
    lean = np.stack([np.cos(a / 2) * np.cos(a), np.cos(a / 2) * np.sin(a), np.sin(a / 2)], axis=1)
    points = np.concatenate([rim - 0.3 * lean, rim + 0.3 * lean])
    triangles = []
    for k in range(12):
        low, high = (k, k + 12)
        next_low, next_high = ((k + 1), (k + 13)) if k < 11 else (12, 0)
        triangles += [[low, next_low, high], [next_low, next_high, high]]
    with pytest.raises(MeshError, match="one side only"):
        TriMesh(points, triangles, name="strip").oriented()


def test_an_empty_mesh_stays_empty():
    assert len(TriMesh([], []).oriented().triangles) == 0
