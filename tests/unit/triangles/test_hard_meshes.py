"""The search on meshes that are hard: slivers, far from the origin, sharp, nested, touching."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import Status, TriMesh

ONE = TriMesh([[0, 0, 0], [1, 0, 0], [0.2, 1, 0.1]], [[0, 1, 2]])


def _mesh(oracle, name: str) -> TriMesh:
    if name == "torus":
        return cg.shapes.torus(major=2.0, minor=0.5).tessellate(0.1)
    made = {"one": lambda: ONE, "box": oracle.box, "rough": lambda: oracle.rough(0)}
    return made.get(name, lambda: oracle.star(0, 0.4))()


def _points(mesh: TriMesh, seed: int, n: int = 150) -> np.ndarray:
    """At random, and on corners, on middles of edges, on and close to middles of triangles."""
    rng = np.random.default_rng(seed)
    p = mesh.corners()[:40]
    middle = p.mean(axis=1)
    return np.concatenate(
        [
            mesh.bounds().mean(axis=0) + mesh.size * rng.uniform(-1, 1, (n, 3)),
            p.reshape(-1, 3),
            0.5 * (p + np.roll(p, 1, axis=1)).reshape(-1, 3),
            middle,
            middle + 1e-9 * mesh.size * rng.normal(size=middle.shape),
        ]
    )


def _same_bits(a, b) -> None:
    for name, x, y in zip(a._fields, a, b, strict=True):
        np.testing.assert_array_equal(x, y, err_msg=name)


def _check_feet(oracle, mesh: TriMesh, points: np.ndarray) -> None:
    feet = mesh.project(points)
    closest = oracle.distances(mesh, points).min(axis=1)
    size, rounding = mesh.size, 4e-16 * np.abs(points).max()
    np.testing.assert_allclose(np.abs(feet.gap), closest, rtol=0, atol=1e-12 * size)
    reached = oracle.distances(mesh, feet.point)[np.arange(len(points)), feet.patch]
    np.testing.assert_allclose(reached, 0.0, rtol=0, atol=1e-12 * size + rounding)
    np.testing.assert_allclose(np.linalg.norm(feet.normal, axis=1), 1.0, rtol=0, atol=1e-12)
    order = np.random.default_rng(1).permutation(len(points))
    _same_bits(mesh.project(points[order]), type(feet)(*(a[order] for a in feet)))
    one = mesh.project(points[-1:])
    _same_bits(one, type(feet)(*(a[-1:] for a in feet)))
    _same_bits(mesh.project(points, start=feet, mode="track")._replace(**_sided(feet)), feet)


def _sided(feet) -> dict:
    """What a tracked foot has otherwise: on a border, and in what is proved of it."""
    return {"gap": feet.gap, "normal": feet.normal, "certified": feet.certified}


@pytest.mark.parametrize("move", ["", "far", "small", "large"])
@pytest.mark.parametrize("name", ["one", "box", "rough", "star", "torus"])
def test_feet_are_exact_wherever_and_however_large_the_mesh_is(oracle, name, move):
    mesh = _mesh(oracle, name)
    if move == "far":
        mesh = mesh.translated([1e6, -1e6, 1e6])
    elif move:
        mesh = mesh.scaled({"small": 1e-6, "large": 1e6}[move])
    _check_feet(oracle, mesh, _points(mesh, 0))


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-8])
def test_feet_on_slivers_are_those_of_every_triangle(oracle, height):
    rng = np.random.default_rng(2)
    turns = np.linalg.qr(rng.normal(size=(30, 3, 3)))[0]
    first = rng.uniform(-1, 1, (30, 3))
    third = first + rng.uniform(0, 1, (30, 1)) * turns[:, 0] + height * turns[:, 1]
    corners = np.stack([first, first + turns[:, 0], third], axis=1)
    apart = TriMesh(corners.reshape(-1, 3), np.arange(90).reshape(-1, 3))
    _check_feet(oracle, apart, _points(apart, 3, 400))
    a = np.linspace(0, 50 * height, 60)
    rim = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    fan = TriMesh(np.vstack([np.zeros(3), rim]), [[0, i, i + 1] for i in range(1, 60)])
    _check_feet(oracle, fan, _points(fan, 4))
    share = rng.uniform(0.05, 0.95, (100, 2))
    a = share[:, 0] * a[-1]
    aim = share[:, 1:] * np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    up = np.array([0.0, 0.0, 0.5])
    hits = fan.first_hit(aim + up, aim - up)
    np.testing.assert_allclose(hits.fraction, 0.5, rtol=0, atol=1e-15)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_sign_at_sharp_edges_and_corners_is_that_of_the_winding_number(oracle, seed):
    star = oracle.star(seed, 0.9)
    rng = np.random.default_rng(seed)
    on = star.corners()[rng.integers(0, len(star.triangles), 1500)]
    on = (rng.dirichlet([0.3] * 3, 1500)[..., None] * on).sum(axis=1)
    points = on + 10.0 ** rng.uniform(-5, 0, (1500, 1)) * rng.normal(size=(1500, 3))
    feet = star.project(points)
    inside = oracle.windings(star, points) > 0.5
    clear = np.abs(feet.gap) > 1e-9 * star.size
    assert clear.sum() > 1400
    assert np.bincount(feet.feature, minlength=3).min() > 3
    np.testing.assert_array_equal((feet.gap < 0.0)[clear], inside[clear])
    np.testing.assert_array_equal(star.contains(points)[clear], inside[clear])


def test_shells_in_shells_and_pieces_apart_hold_what_their_normals_say(oracle):
    radii, places = (2.0, 1.0, 0.4, 0.5), (0.0, 0.0, 0.0, 6.0)
    shells = [
        cg.shapes.sphere(radius=r, centre=(x, 0, 0)).tessellate(0.02)
        for r, x in zip(radii, places, strict=True)
    ]
    mesh = oracle.together(shells[0], shells[1].flipped(), *shells[2:])
    points = np.random.default_rng(5).uniform([-3, -3, -3], [7, 3, 3], (4000, 3))
    away = [np.linalg.norm(points - [x, 0, 0], axis=1) for x in places]
    clear = np.min([np.abs(a - r) for a, r in zip(away, radii, strict=True)], axis=0) > 0.03
    inside = ((away[0] < 2.0) & (away[0] > 1.0)) | (away[0] < 0.4) | (away[3] < 0.5)
    np.testing.assert_array_equal(mesh.contains(points)[clear], inside[clear])


@pytest.mark.parametrize("step", [[1, 1, 0], [1, 1, 1]])
def test_boxes_that_touch_in_an_edge_or_a_corner_keep_their_sides(oracle, step):
    mesh = oracle.together(oracle.box(), oracle.box().translated(step))
    points = np.random.default_rng(6).uniform(-1, 2, (3000, 3))
    inside = (np.abs(points) < 0.5).all(axis=1) | (np.abs(points - step) < 0.5).all(axis=1)
    np.testing.assert_array_equal(mesh.project(points).gap < 0.0, inside)


@pytest.mark.parametrize("jump", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("name", ["one", "box", "rough", "star"])
def test_a_tracked_foot_is_a_local_minimum_however_far_the_point_went(oracle, name, jump):
    mesh = _mesh(oracle, name)
    rng = np.random.default_rng(7)
    size = mesh.size
    points = mesh.bounds().mean(axis=0) + 0.6 * size * rng.uniform(-1, 1, (150, 3))
    feet = mesh.project(points)
    for _ in range(3):
        points = points + jump * size * rng.normal(size=points.shape)
        feet = mesh.project(points, start=feet, mode="track")
        way = np.linalg.norm(points - feet.point, axis=1)
        to = oracle.distances(mesh, points)
        touching = oracle.distances(mesh, feet.point) < 1e-11 * size
        around = np.where(touching, to, np.inf).min(axis=1)
        np.testing.assert_allclose(way, around, rtol=1e-12, atol=1e-12 * size)
        closest = mesh.project(points)
        same = (way - np.abs(closest.gap) < 1e-12 * size) & (feet.status == Status.OK)
        np.testing.assert_array_equal(np.sign(feet.gap[same]), np.sign(closest.gap[same]))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("n", [0, 3, 200])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_points_that_are_no_numbers_or_none_at_all_are_marked(oracle, n, bad):
    box, points = oracle.box(), np.full((n, 3), bad)
    feet = box.project(points)
    tracked = box.project(points, start=feet, mode="track")
    for found in (feet, tracked, box.first_hit(points, points)):
        assert found.status.tolist() == [Status.NOT_FINITE] * n
        assert (found.patch == -1).all()
    assert box.contains(points).tolist() == [False] * n
    mixed = np.concatenate([points, [[0.0, 0.1, 2.0]] * 100, [[bad, 0.0, -bad]]])
    assert (box.project(mixed).gap[n:-1] == 1.5).all()
