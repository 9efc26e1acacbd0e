"""Cells that are told to lie on one side do, and lie as far from the surface as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage
from tests.scenes import box
from tests.stress import solids

import contiga as cg
from contiga.records import Sides, SurfacePlaces
from contiga.search.exact_surface import ExactSurface
from contiga.search.sides import side_grid
from contiga.search.sides.kernels import side_grid_nb, side_nb
from contiga.search.sides.side_grid import Layout, SideGrid, sides_of
from contiga.search.tables import tables_of

WELL_KNOWN = 0.8


def _grid(body: cg.Body) -> SideGrid:
    surface = body.surface
    assert isinstance(surface, ExactSurface)
    return sides_of(surface.tables, surface.slit)


def _sides(body: cg.Body, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return side_grid.side_of(_grid(body), points, np.arange(len(points), dtype=np.int32))


def _places(grid: SideGrid, points: np.ndarray, rows: np.ndarray) -> tuple[Sides, SurfacePlaces]:
    """Sides of points, and places of the surface near those whose side is not known."""
    n = len(rows)
    known = Sides(np.empty(n, np.int8), np.empty(n))
    near = SurfacePlaces(np.empty(n, np.int32), np.empty((n, 2)))
    side_nb.places(grid, points, rows, known, near, 0, n)
    return known, near


def _all_about(body: cg.Body, n: int, seed: int = 0) -> np.ndarray:
    low, high = body.bounds()
    rng = np.random.default_rng(seed)
    return rng.uniform(low - 0.1 * body.size, high + 0.1 * body.size, (n, 3))


def _near(body: cg.Body, n: int, share: float) -> np.ndarray:
    """Points within `share` of the size of the surface."""
    feet = body.project(_all_about(body, n, 1))
    away = np.random.default_rng(2).uniform(-share, share, n) * body.size
    points = feet.point + away[:, None] * feet.normal
    return np.ascontiguousarray(points[np.isfinite(points).all(axis=1)])


@pytest.mark.parametrize("name", ["torus", "slot", "cup", "shell", "lens", "internal gear"])
def test_sides_are_those_of_the_closed_form(name: str) -> None:
    solid = solids.solid(name)
    assert solid.field is not None
    known = 0
    for points in (_all_about(solid.body, 20000), _near(solid.body, 20000, 0.02)):
        side, reach = _sides(solid.body, points)
        told = side != 0
        distance = solid.field(points[told])
        np.testing.assert_array_equal(side[told], np.sign(distance))
        away = np.abs(solid.body.project(points[told]).gap)
        assert (reach[told] <= away + 1e-12 * solid.size).all()
        assert (reach[told] > 0.0).all()
        known += int(told.sum())
    assert known > WELL_KNOWN * 40000


def test_a_ball_inside_out_has_its_inside_everywhere_else() -> None:
    points = np.random.default_rng(3).uniform(-3.0, 3.0, (5000, 3))
    body = cg.Body([cg.shapes.sphere()])
    out, _ = _sides(body, points)
    turned, _ = _sides(body.flipped(), points)
    np.testing.assert_array_equal(out, -turned)
    assert set(out) == {-1, 0, 1}


@pytest.mark.parametrize("wall", [1e-2, 1e-4, 1e-6])
def test_walls_thinner_than_a_cell_keep_apart_what_is_beside_them(wall: float) -> None:
    inner = cg.shapes.sphere(radius=1.0 - wall).flipped()
    body = cg.Body([cg.shapes.sphere(), inner])
    rng = np.random.default_rng(4)
    d = rng.normal(size=(20000, 3))
    points = d / np.linalg.norm(d, axis=1, keepdims=True) * rng.uniform(0.0, 1.2, (len(d), 1))
    side, _ = _sides(body, points)
    radius = np.linalg.norm(points, axis=1)
    told = side != 0
    in_wall = (radius > 1.0 - wall) & (radius < 1.0)
    np.testing.assert_array_equal(side[told], np.where(in_wall, -1, 1)[told])
    assert told[radius < 0.9].all()
    assert told[radius > 1.1].all()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("away", [0.0, 1e6])
def test_of_any_size_and_anywhere(scale: float, away: float) -> None:
    centre = np.array([1.0, -0.3, 0.7]) * away * scale
    ring = cg.shapes.torus(major=1.0, minor=0.3)
    move = cg.motion.pose.translation(centre) @ np.diag([scale, scale, scale, 1.0])
    body = cg.Body([ring.transformed(move)])
    local = np.random.default_rng(5).uniform(-1.5, 1.5, (20000, 3))
    side, reach = _sides(body, local * scale + centre)
    ways = np.hypot(np.hypot(local[:, 0], local[:, 1]) - 1.0, local[:, 2]) - 0.3
    told = side != 0
    np.testing.assert_array_equal(side[told], np.sign(ways[told]))
    assert (reach[told] <= np.abs(ways[told]) * scale + 1e-9 * scale).all()
    assert told.mean() > WELL_KNOWN


def test_faces_in_the_very_planes_between_cells_are_in_the_cells_on_both_sides(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    place = Layout(np.full(3, -1.0), 0.125, (16, 16, 16), 1e-9)
    monkeypatch.setattr(side_grid, "layout", lambda *_: place)
    faces = [cg.shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3), *-np.eye(3))]
    grid = side_grid.build_sides(tables_of(cg.Body(faces)), 0.0)
    rng = np.random.default_rng(6)
    rows = np.arange(500, dtype=np.int32)
    for k in range(3):
        for value in (0.5, np.nextafter(0.5, 0.0), np.nextafter(0.5, 1.0), 0.53, 0.47):
            points = np.insert(rng.uniform(-0.4, 0.4, (500, 2)), k, value, axis=1)
            assert (side_grid.side_of(grid, points, rows)[0] == 0).all()
            assert (side_grid.side_of(grid, -points, rows)[0] == 0).all()
        for value, side in ((0.54, 1), (0.46, -1)):
            points = np.insert(rng.uniform(-0.4, 0.4, (500, 2)), k, value, axis=1)
            assert (side_grid.side_of(grid, points, rows)[0] == side).all()


def _lidded(gap: float) -> cg.Body:
    """A box whose lid ends `gap` before its walls."""
    faces = [cg.shapes.plane(centre=0.5 * n, axis=n) for n in (*np.eye(3)[:2], *-np.eye(3))]
    wide = 1.0 - 2.0 * gap
    return cg.Body([*faces, cg.shapes.plane(centre=[0.0, 0.0, 0.5], width=wide, length=wide)])


@pytest.mark.parametrize("gap", [1e-5, 0.06])
def test_a_slit_that_is_bridged_lets_nothing_through(gap: float) -> None:
    grid = sides_of(tables_of(_lidded(gap)), gap)
    points = np.random.default_rng(7).uniform(-0.9, 0.9, (20000, 3))
    side, _ = side_grid.side_of(grid, points, np.arange(len(points), dtype=np.int32))
    inside = (np.abs(points) < 0.5).all(axis=1)
    np.testing.assert_array_equal(side[side != 0], np.where(inside, -1, 1)[side != 0])
    assert (side < 0).any()
    assert (side > 0).any()


def test_what_is_joined_through_a_hole_is_not_told() -> None:
    # Cells inside and outside are joined, and the samples disagree.
    grid = sides_of(tables_of(_lidded(0.06)), 0.0)
    points = np.random.default_rng(8).uniform(-0.7, 0.7, (2000, 3))
    side, _ = side_grid.side_of(grid, points, np.arange(len(points), dtype=np.int32))
    assert (side == 0).all()


def test_clear_ways_cross_nothing_and_crossings_are_never_clear() -> None:
    body = solids.solid("slot").body
    rng = np.random.default_rng(9)
    a = _all_about(body, 6000, 10)
    d = rng.normal(size=a.shape)
    d *= body.size * 10.0 ** rng.uniform(-5, 0, (len(a), 1)) / np.linalg.norm(d, axis=1)[:, None]
    b = a + d
    rows = np.arange(len(a), dtype=np.int32)
    clear = side_grid.clear_paths(_grid(body), a, b, rows)
    _, sense = body.surface.last_crossings(a, b, rows)
    assert not (clear & (sense != 0)).any()
    assert clear.sum() > 0.6 * (sense == 0).sum()
    assert (sense != 0).sum() > 300


def test_ways_through_thin_walls_are_not_clear() -> None:
    shell = cg.Body([cg.shapes.sphere(), cg.shapes.sphere(radius=1.0 - 1e-6).flipped()])
    d = np.random.default_rng(11).normal(size=(3000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    rows = np.arange(len(d), dtype=np.int32)
    grid = _grid(shell)
    assert not side_grid.clear_paths(grid, 0.9 * d, 1.1 * d, rows).any()
    assert not side_grid.clear_paths(grid, 1.1 * d, 0.9 * d, rows).any()
    assert side_grid.clear_paths(grid, 1.1 * d, 1.3 * d, rows).all()


def test_places_near_by_lie_on_the_surface_about_a_cell_away() -> None:
    body = solids.solid("cup").body
    points = _near(body, 4000, 1e-3)
    grid = _grid(body)
    rows = np.arange(len(points), dtype=np.int32)
    known, (patch, uv) = _places(grid, points, rows)
    side = known.side
    for ours, theirs in zip(known, side_grid.side_of(grid, points, rows), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    found = np.flatnonzero(patch >= 0)
    np.testing.assert_array_equal(side[found], 0)
    assert len(found) > 0.95 * np.count_nonzero(side == 0)
    places = np.array([body.patches[patch[k]].evaluate(uv[k][None])[0] for k in found])
    away = np.linalg.norm(places - points[found], axis=1)
    assert away.max() < 12.0 * grid.size


def test_points_that_are_not_finite_are_on_no_side() -> None:
    points = np.array([[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], [0.0, 0.0, 0.0]])
    body = cg.Body([cg.shapes.sphere()])
    assert _sides(body, points)[0].tolist() == [0, 0, -1]
    rows = np.arange(3, dtype=np.int32)
    assert side_grid.clear_paths(_grid(body), points, points, rows).tolist() == [False, False, True]


@pytest.mark.interpreted
def test_sides_without_compilation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(side_grid, "MIN_CELLS", 300.0)
    monkeypatch.setattr(side_grid, "CELLS_PER_ELEMENT", 0.0)
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.04, 1.04, 1.04], [5.0, 0.0, 0.0]])
    body = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert _sides(body, points)[0].tolist() == [-1, 0, 1, 1]
    rows = np.arange(4, dtype=np.int32)
    clear = side_grid.clear_paths(_grid(body), points, points[::-1].copy(), rows)
    assert clear.tolist() == [False, False, False, False]
    assert _places(_grid(body), points, rows)[1].patch.tolist() == [-1, 0, -1, -1]


@pytest.mark.interpreted
@pytest.mark.parametrize("share", [0.0, 0.3, 0.6, 0.9, 0.999])
def test_regions_and_depths_of_cells_are_those_of_scipy(share: float) -> None:
    for seed, shape in enumerate([(7, 6, 9), (1, 12, 5), (11, 1, 1), (8, 8, 8)]):
        clear = np.random.default_rng(seed).uniform(size=shape) < share
        clear[-1, -1, -1] = False
        np.testing.assert_array_equal(side_grid_nb.label_regions(clear), ndimage.label(clear)[0])
        depth = ndimage.distance_transform_cdt(clear, metric="chessboard")
        np.testing.assert_array_equal(side_grid_nb.depths(clear), depth)


def test_depths_where_nothing_is_near_are_large() -> None:
    assert side_grid_nb.depths(np.ones((3, 4, 5), np.bool_)).min() > 5
