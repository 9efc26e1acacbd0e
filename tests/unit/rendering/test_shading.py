"""Normals, hollows and edges of the shaded pictures."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from tests.unit.report.conftest import RADIUS, ball, sheet

from contiga.rendering.camera import look, project
from contiga.rendering.kernels.shading_groups_nb import joined
from contiga.rendering.kernels.shading_nb import paint as paint_pixels
from contiga.rendering.shading import (
    _LAMPS,
    Layer,
    cloud_layer,
    corner_normals,
    crease_edges,
    free_edges,
    hollows,
    mesh_layer,
    paint,
    sharp_mesh,
    shrunk,
    veil,
)

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
    assert crease_edges(*_roof(32.0)).tolist() == [[0, 1]]
    assert len(crease_edges(*_roof(28.0))) == 0
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype=np.int32)
    assert len(crease_edges(corners, faces)) == 6


def test_hollows_is_zero_on_a_slope_and_positive_in_a_groove() -> None:
    rows, columns = np.mgrid[0:40, 0:40].astype(float)
    slope = 100.0 + 0.3 * columns - 0.2 * rows
    np.testing.assert_allclose(hollows(slope, 4, 50.0), 0.0, atol=1e-12)
    groove = 100.0 - np.abs(columns - 20.0)
    actual = hollows(groove, 4, 50.0)
    assert actual.shape == (20, 20)
    assert actual[10, 10] > 0.0
    assert hollows(-groove + 200.0, 4, 50.0)[10, 10] < 0.0


def test_hollows_knows_nothing_beyond_an_outline() -> None:
    depth = np.full((30, 30), np.inf)
    depth[10:20, 10:20] = 5.0
    np.testing.assert_array_equal(hollows(depth, 8, 1.0), 0.0)


def shifted(depth: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """`depth` moved by whole pixels, infinity coming in from outside."""
    wide = np.pad(depth, 9, constant_values=np.inf)
    h, w = depth.shape
    return wide[9 - rows : 9 - rows + h, 9 - columns : 9 - columns + w]


@pytest.mark.interpreted
@pytest.mark.parametrize("shape", [(30, 34), (31, 25), (7, 5)])
@pytest.mark.parametrize("reach", [1, 3, 9])
def test_hollows_are_sums_over_opposite_pairs(shape: tuple[int, int], reach: int) -> None:
    rng = np.random.default_rng(3)
    depth = np.where(rng.random(shape) < 0.1, np.inf, 5.0 + rng.random(shape))
    half, size = depth[::2, ::2], 0.4
    total, steps = np.zeros(half.shape), {max(1, reach // 4), max(1, reach // 2), reach}
    for step in sorted(steps):
        for rows, columns in ((0, step), (step, 0), (step, step), (step, -step)):
            pair = [shifted(half, way * rows, way * columns) for way in (1, -1)]
            with np.errstate(invalid="ignore"):
                bends = [np.clip(half - other, -size, size) for other in pair]
            total += np.where(np.isfinite(pair).all(axis=0), bends[0] + bends[1], 0.0)
    np.testing.assert_array_equal(
        hollows(depth, reach, size), np.clip(total / (8.0 * len(steps) * size), -1.0, 1.0)
    )


def test_values_at_pixels_are_linear_on_a_mesh() -> None:
    points, triangles = sheet()
    camera = look(np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0]), points, (80, 80))
    layer = mesh_layer(camera, points, triangles)
    assert layer.seen.mean() > 0.5
    column = project(camera, points)[:, 0]
    np.testing.assert_allclose(layer.at_pixels(column), np.nonzero(layer.seen)[1], atol=1e-9)


def normals_of(layer: Layer) -> np.ndarray:
    """(k, 3) unit normals in camera axes at the pixels of `layer.seen`, turned to the eye."""
    a, b = layer.buffer.a[layer.seen], layer.buffer.b[layer.seen]
    if layer.triangles is None:
        return np.stack([a, b, -np.sqrt(np.maximum(1.0 - a * a - b * b, 0.0))], axis=1)
    corners = layer.corners[layer.buffer.owner[layer.seen]]
    blended = np.einsum("kc,kci->ki", np.stack([a, b, 1.0 - a - b], axis=1), corners)
    turned = blended @ layer.axes.T
    turned *= np.where(turned[:, 2:] > 0.0, -1.0, 1.0)
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


@pytest.mark.parametrize("inside_out", [False, True])
def test_normals_at_pixels_are_the_surface_turned_to_the_eye(inside_out: bool) -> None:
    points, triangles = ball(48)
    camera = look(np.array([1.0, 0.2, -0.3]), UP, points, (80, 80))
    layer = mesh_layer(camera, points, triangles[:, ::-1] if inside_out else triangles)
    here = np.stack([layer.at_pixels(points[:, k]) for k in range(3)], axis=1)
    outward = here / np.linalg.norm(here, axis=1)[:, None] @ camera.axes.T
    assert np.einsum("ki,ki->k", normals_of(layer), outward).min() > 0.98


def scenes(size: int) -> tuple[Layer, Layer]:
    """A ball as a mesh and as a cloud."""
    points, triangles = ball()
    camera = look(np.array([1.0, 0.2, -0.3]), UP, points, (size, size))
    return mesh_layer(camera, points, triangles), cloud_layer(camera, points, 3.0)


def shaded(layer: Layer, own: np.ndarray) -> np.ndarray:
    """(k, 3) the formulas of the light, by arrays."""
    n = normals_of(layer)
    key, gloss = np.maximum(n @ _LAMPS.T, 0.0).T
    rows, columns = np.nonzero(layer.seen)
    bend = hollows(layer.buffer.depth, 2, 0.02 * 20.0)[rows // 2, columns // 2]
    shade = 1.0 - 0.75 * np.maximum(bend, 0.0)
    factor = (0.46 + 0.24 * (0.5 - 0.5 * n[:, 1]) + 0.46 * key) * shade
    added = 0.10 * gloss**40 + 0.18 * (1.0 - np.clip(-n[:, 2], 0.0, 1.0)) ** 3
    return np.clip(own * factor[:, None] + added[:, None], 0.0, 1.0)


@pytest.mark.interpreted
@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize("opacity", [1.0, 0.3])
def test_paint_blends_lit_colours_where_nothing_is_before_them(kind: int, opacity: float) -> None:
    layer, rng = scenes(60)[kind], np.random.default_rng(1)
    seen, k = layer.seen, int(layer.seen.sum())
    near = rng.random(seen.shape) < 0.3
    nearest = np.where(near, layer.buffer.depth - 1e-9, layer.buffer.depth)
    for own in (np.array([0.9, 0.5, 0.1]), rng.random((k, 3))):
        under = rng.random((60, 60, 3)).astype(np.float32)
        picture = under.copy()
        paint(picture, layer, own, 20.0, nearest, opacity)
        wanted = under.astype(float)
        wanted[seen] = opacity * shaded(layer, own) + (1.0 - opacity) * wanted[seen]
        wanted[near] = under[near]
        np.testing.assert_allclose(picture, wanted, rtol=0, atol=1e-7)
        assert np.ptp(picture[seen & ~near][:, 0]) > 0.2
        np.testing.assert_array_equal(picture[~seen | near], under[~seen | near])


@pytest.mark.interpreted
def test_a_veil_is_thicker_at_the_rim() -> None:
    layer, colour = scenes(60)[0], np.array([0.1, 0.2, 0.3])
    picture = np.ones((60, 60, 3), dtype=np.float32)
    veil(picture, layer, colour)
    cover = 0.05 + 0.38 * (1.0 + normals_of(layer)[:, 2:]) ** 2
    np.testing.assert_allclose(picture[layer.seen], 1.0 - cover + cover * colour, atol=1e-7)
    assert (picture[~layer.seen] == 1.0).all()
    assert cover[np.nonzero(layer.seen)[0].argmin()] > 0.2


def test_meshes_and_clouds_are_painted_by_one_kernel() -> None:
    for layer in scenes(20):
        paint(np.ones((20, 20, 3), np.float32), layer, np.ones(3), 20.0, layer.buffer.depth)
    assert len(getattr(paint_pixels, "signatures", [0])) == 1


@pytest.mark.interpreted
@pytest.mark.parametrize("n", [1, 2, 30])
def test_corners_are_joined_as_scipy_does(n: int) -> None:
    rng = np.random.default_rng(n)
    for count in (0, n // 2, 2 * n):
        pairs = rng.integers(0, n, (count, 2))
        graph = coo_array((np.ones(count), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
        sets, theirs = connected_components(graph, directed=False)
        group = joined(pairs, n)
        assert group.max() + 1 == sets
        assert group.tolist() == theirs.tolist()


def test_points_are_repeated_along_creases_only() -> None:
    bent = sharp_mesh(*_roof(32.0))
    assert np.bincount(bent.rows).tolist()[:2] == [2, 2]
    assert set(np.bincount(bent.rows).tolist()[2:]) == {1}
    assert set(np.bincount(sharp_mesh(*_roof(28.0)).rows).tolist()) == {1}
    points, triangles = _roof(32.0)
    np.testing.assert_array_equal(points[bent.rows][bent.triangles], points[triangles])


def test_free_edges_of_a_sheet_are_its_border_and_of_a_ball_none() -> None:
    points, triangles = sheet(5)
    edges = free_edges(triangles)
    assert len(edges) == 16
    on_border = np.abs(points[:, :2]).max(axis=1) == 12.0
    assert on_border[edges].all()
    tetrahedron = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    assert len(free_edges(tetrahedron)) == 0


@pytest.mark.parametrize(("shape", "factor"), [((6, 8, 3), 2), ((7, 10, 3), 3), ((5, 5, 1), 1)])
def test_shrunk_keeps_the_mean(shape: tuple[int, int, int], factor: int) -> None:
    picture = np.random.default_rng(0).random(shape).astype(np.float32)
    h, w = shape[0] // factor, shape[1] // factor
    blocks = picture[: h * factor, : w * factor].reshape(h, factor, w, factor, shape[2])
    small = shrunk(picture, factor)
    assert small.dtype == np.float32
    np.testing.assert_allclose(small, blocks.mean(axis=(1, 3), dtype=float), rtol=0, atol=2e-7)
