"""Normals, hollows and edges of the shaded pictures."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.report.camera import look, project
from contiga.report.shading import (
    cloud_layer,
    corner_normals,
    crease_edges,
    free_edges,
    hollows,
    lit,
    mesh_layer,
    shrunk,
)

from .conftest import RADIUS, ball, sheet

UP = np.array([0.0, 0.0, 1.0])


def test_corner_normals_of_a_ball_point_outward() -> None:
    points, triangles = ball(32)
    solid = np.linalg.norm(
        np.cross(
            points[triangles[:, 1]] - points[triangles[:, 0]],
            points[triangles[:, 2]] - points[triangles[:, 0]],
        ),
        axis=1,
    )
    triangles = triangles[solid > 1e-9]
    radial = points[triangles] / RADIUS
    cosine = np.einsum("mci,mci->mc", corner_normals(points, triangles), radial)
    assert cosine.min() > 0.99


def test_corner_normals_stay_sharp_across_a_right_angle() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = np.array([[0, 1, 2], [0, 3, 1]], dtype=np.int32)
    normal = corner_normals(points, triangles)
    np.testing.assert_allclose(normal[0], np.tile([0.0, 0.0, 1.0], (3, 1)), atol=1e-15)
    np.testing.assert_allclose(normal[1], np.tile([0.0, 1.0, 0.0], (3, 1)), atol=1e-15)


def _roof(degrees: float) -> tuple[np.ndarray, np.ndarray]:
    """Two squares that meet along x over a bend, each of two facets."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    points = np.array([[0, 0, 0], [1, 0, 0], [0, -1, 0], [1, -1, 0], [0, c, -s], [1, c, -s]])
    triangles = np.array([[2, 3, 1], [2, 1, 0], [0, 1, 5], [0, 5, 4]], dtype=np.int32)
    return points.astype(float), triangles


def test_corner_normals_stay_sharp_over_a_bend_and_are_one_over_a_gentle_one() -> None:
    flat, tilted = np.array([0.0, 0.0, 1.0]), np.array([0.0, np.sin(0.8), np.cos(0.8)])
    sharp = corner_normals(*_roof(np.degrees(0.8)))
    np.testing.assert_allclose(sharp[:2], np.broadcast_to(flat, (2, 3, 3)), rtol=0, atol=1e-15)
    np.testing.assert_allclose(sharp[2:], np.broadcast_to(tilted, (2, 3, 3)), rtol=0, atol=1e-15)
    points, triangles = _roof(30.0)
    gentle = corner_normals(points, triangles)
    on_fold = np.isin(triangles, [0, 1])
    assert (gentle[:2][on_fold[:2]][:, 1] > 0.1).all()


def test_a_flat_face_stays_flat_beside_a_narrow_bend() -> None:
    points, triangles = _roof(30.0)
    points[4:] *= [1.0, 0.01, 0.01]
    assert (corner_normals(points, triangles)[:2, :, 2] > 0.9999).all()


def test_crease_edges_are_those_of_the_bend() -> None:
    assert crease_edges(*_roof(45.0)).tolist() == [[0, 1]]
    assert len(crease_edges(*_roof(30.0))) == 0
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
    assert len(crease_edges(corners, faces)) == 6


def test_hollows_is_zero_on_a_slope_and_positive_in_a_groove() -> None:
    rows, columns = np.mgrid[0:40, 0:40].astype(float)
    slope = 100.0 + 0.3 * columns - 0.2 * rows
    np.testing.assert_allclose(hollows(slope, 8, 50.0), 0.0, atol=1e-12)
    groove = 100.0 - np.abs(columns - 20.0)
    found = hollows(groove, 8, 50.0)
    assert found[20, 20] > 0.0
    assert np.all(hollows(-groove + 200.0, 8, 50.0)[20, 20] < 0.0)


def test_hollows_knows_nothing_beyond_an_outline() -> None:
    depth = np.full((30, 30), np.inf)
    depth[10:20, 10:20] = 5.0
    np.testing.assert_array_equal(hollows(depth, 8, 1.0), 0.0)


def test_values_at_pixels_are_linear_on_a_mesh() -> None:
    points, triangles = sheet()
    camera = look(np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), points, (80, 80))
    layer = mesh_layer(camera, points, triangles)
    assert layer.seen.mean() > 0.5
    column = project(camera, points)[:, 0]
    np.testing.assert_allclose(layer.at_pixels(column), np.nonzero(layer.seen)[1], atol=1e-9)


@pytest.mark.parametrize("inside_out", [False, True])
def test_normals_at_pixels_are_the_surface_turned_to_the_eye(inside_out: bool) -> None:
    points, triangles = ball(48)
    camera = look(np.array([1.0, 0.2, -0.3]), UP, points, (80, 80))
    layer = mesh_layer(camera, points, triangles[:, ::-1] if inside_out else triangles)
    here = np.stack([layer.at_pixels(points[:, k]) for k in range(3)], axis=1)
    outward = here / np.linalg.norm(here, axis=1)[:, None] @ camera.axes.T
    normal = layer.normal[layer.seen]
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, rtol=1e-12)
    assert np.einsum("ki,ki->k", normal, outward).min() > 0.98


def test_every_lit_colour_is_one_that_can_be_shown() -> None:
    points, triangles = ball()
    camera = look(np.array([1.0, 0.2, -0.3]), UP, points, (60, 60))
    for layer in (mesh_layer(camera, points, triangles), cloud_layer(camera, points, 3.0)):
        picture = lit(layer, np.array([0.9, 0.5, 0.1]), 20.0)
        assert picture.shape == (layer.seen.sum(), 3)
        assert picture.min() >= 0.0
        assert picture.max() <= 1.0
        assert np.ptp(picture[:, 0]) > 0.2


def test_free_edges_of_a_sheet_are_its_border_and_of_a_ball_none() -> None:
    points, triangles = sheet(5)
    edges = free_edges(triangles)
    assert len(edges) == 16
    on_border = np.abs(points[:, :2]).max(axis=1) == 12.0
    assert on_border[edges].all()
    tetrahedron = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    assert len(free_edges(tetrahedron)) == 0


def test_shrunk_keeps_the_mean() -> None:
    picture = np.random.default_rng(0).random((6, 8, 3))
    small = shrunk(picture, 2)
    assert small.shape == (3, 4, 3)
    np.testing.assert_allclose(small[1, 2], picture[2:4, 4:6].mean(axis=(0, 1)))
