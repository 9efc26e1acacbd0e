"""Taut strings: closed forms on smooth bodies, over sharp edges, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import contiga as cg
from contiga.routing.obstacles import Obstacles
from contiga.routing.start import first_polyline

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
TUBE = cg.Body([cg.shapes.cylinder(radius=1.0, height=6.0)], name="tube")
RING = cg.Body(cg.shapes.torus(major=3.0, minor=1.0), name="ring")
OVER_THE_BALL = [-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [[0.0, 0.0, 1.5]]


def box(half: float = 1.0) -> cg.TriMesh:
    """A cube about the origin."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return cg.TriMesh(half * corners, triangles, name="box")


def errors(exact: float, body: cg.Body, start, end, via=()) -> np.ndarray:
    """Of the length, as a share of it, at 100, 200 and 400 points."""
    lengths = [cg.route(body, start, end, via, points=n).length for n in (100, 200, 400)]
    return np.array(lengths) / exact - 1.0


def assert_second_order(found: np.ndarray) -> None:
    assert abs(found[1]) < 2e-4
    np.testing.assert_allclose(found[:-1] / found[1:], 4.0, rtol=0.15)


def test_over_a_sphere_two_tangents_and_a_great_circle() -> None:
    assert_second_order(errors(2.0 * np.sqrt(3.0) + np.pi / 3.0, BALL, *OVER_THE_BALL))


def test_a_sphere_through_its_middle_is_passed_on_some_side() -> None:
    found = errors(2.0 * np.sqrt(3.0) + np.pi / 3.0, BALL, *OVER_THE_BALL[:2])
    assert_second_order(found)


def test_a_helix_of_two_turns() -> None:
    turns = np.arange(1, 8) * np.pi / 2
    via = np.stack([1.5 * np.cos(turns), 1.5 * np.sin(turns), -2 + turns / np.pi], axis=1)
    found = errors(np.hypot(4.0 * np.pi, 4.0), TUBE, [1.0, 0.0, -2.0], [1.0, 0.0, 2.0], via)
    assert_second_order(found)


def test_over_a_torus_through_its_hole() -> None:
    away = np.hypot(3.0, 1.2)
    angle = np.pi + 2.0 * np.arctan2(1.2, 3.0) - 2.0 * np.arccos(1.0 / away)
    exact = 2.0 * np.sqrt(away**2 - 1.0) + angle
    found = errors(exact, RING, [0.0, 0.0, -1.2], [6.0, 0.0, -1.2], [[3.0, 0.0, 1.5]])
    assert_second_order(found)


def test_over_an_ellipse_by_quadrature() -> None:
    a, b, d = 2.0, 1.0, 3.0
    body = cg.Body.from_profile(cg.shapes.ellipse(axes=(a, b)), depth=4.0)
    # The tangent from (d, 0) touches at cos t = a/d.
    t = np.arccos(a / d)
    straight = np.hypot(d - a * np.cos(t), b * np.sin(t))
    arc, _ = quad(lambda s: np.hypot(a * np.sin(s), b * np.cos(s)), t, np.pi - t)
    found = errors(2.0 * straight + arc, body, [-d, 0, 0], [d, 0, 0], [[0, 2, 0]])
    assert_second_order(found)


def test_wrap_angle_and_lift_off_of_the_sphere() -> None:
    (wrap,) = cg.route(BALL, *OVER_THE_BALL, points=400).wraps
    assert wrap.body == "ball"
    assert abs(wrap.angle - np.pi / 3.0) < 1e-4
    spacing = 4.6 / 400
    np.testing.assert_allclose(wrap.first, [-0.5, 0.0, np.sqrt(0.75)], atol=spacing)
    assert abs(wrap.end - wrap.start - np.pi / 3.0) < 2.0 * spacing


def test_a_path_along_a_surface_turns_by_its_normal_curvature_from_end_to_end() -> None:
    path = cg.route(TUBE, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    assert abs(path.wrap_angle - np.pi / 2.0) < 1e-4
    np.testing.assert_allclose(np.linalg.norm(path.points[:, :2], axis=1), 1.0, atol=1e-9)


def test_sharp_edges_are_not_cut_off() -> None:
    exact = 2.0 * np.hypot(2.0, 1.0) + 2.0
    path = cg.route(box(), [-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [[0.0, 0.0, 2.0]])
    assert abs(path.length / exact - 1.0) < 2e-5
    assert abs(path.wrap_angle - 2.0 * np.arctan(0.5)) < 1e-2


def test_an_edge_is_crossed_at_the_angle_of_the_unfolded_faces() -> None:
    # From the middle of one face to another's, off to the side: straight when they are unfolded.
    path = cg.route(box(), [1.0, -0.5, 0.0], [0.0, 0.5, 1.0])
    assert abs(path.length / np.hypot(2.0, 1.0) - 1.0) < 1e-5


def test_a_way_that_is_free_is_straight() -> None:
    path = cg.route(BALL, [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0])
    assert path.wraps == ()
    assert abs(path.length - 4.0) < 1e-12


def test_a_string_over_two_bodies_touches_both() -> None:
    other = cg.Body([cg.shapes.sphere(radius=1.0, centre=(4.0, 0.0, 0.0))], name="other")
    path = cg.route([BALL, other], [-2.0, 0.0, 0.0], [6.0, 0.0, 0.0], [[0, 0, 2], [4, 0, 2]])
    assert [wrap.body for wrap in path.wraps] == ["ball", "other"]
    assert abs(path.length / (2.0 * np.sqrt(3.0) + 4.0 + np.pi / 3.0) - 1.0) < 1e-4


def test_what_is_thinner_than_a_cell_of_the_grid_is_gone_round() -> None:
    plate = cg.TriMesh(box().vertices * [0.03, 1.0, 1.0], box().triangles, name="plate")
    way = first_polyline(Obstacles([plate]), np.array([-1.0, 0, 0]), np.array([1.0, 0, 0]))
    assert np.abs(way[:, 1:]).max() > 1.0
    path = cg.route(plate, [-1.0, 0.3, 0.0], [1.0, 0.3, 0.0])
    assert abs(path.length - 2.0 * np.hypot(0.97, 0.7) - 0.06) < 1e-3


def test_the_path_moves_with_the_body_and_scales_with_it() -> None:
    larger = cg.Body([cg.shapes.sphere(radius=2.0, centre=(5.0, 0.0, 0.0))])
    ends = np.array([[-2.0, 0.0, 0.3], [2.0, 0.2, 0.0]])
    one = cg.route(BALL, *ends)
    other = cg.route(larger, *(2.0 * ends + [5.0, 0.0, 0.0]))
    np.testing.assert_allclose(other.points, 2.0 * one.points + [5.0, 0.0, 0.0], atol=1e-7)


@pytest.mark.parametrize(
    ("start", "end", "via", "where"),
    [
        ([0.0, 0.0, 0.5], [2.0, 0.0, 0.0], (), "start"),
        ([2.0, 0.0, 0.0], [0.0, 0.2, 0.0], (), "end"),
        ([-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [[0.0, 0.0, 2.0], [0.1, 0.0, 0.0]], "via[1]"),
        ([-2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], (), "end"),
        ([-2.0, 0.0, np.nan], [2.0, 0.0, 0.0], (), "start"),
        ([-2.0, 0.0], [2.0, 0.0, 0.0], (), "start"),
    ],
)
def test_points_that_no_path_leads_through_are_named(start, end, via, where) -> None:
    with pytest.raises(cg.errors.InputError) as told:
        cg.route(BALL, start, end, via)
    assert told.value.where == where


def test_an_end_that_is_shut_in_is_told() -> None:
    # Normals of a hollow ball's inner face lead into the hollow: the point is outside, and inside.
    shell = [box(2.0), cg.TriMesh(box().vertices, box().triangles[:, ::-1])]
    corners = np.concatenate([shell[0].vertices, shell[1].vertices])
    hollow = cg.TriMesh(corners, np.concatenate([shell[0].triangles, shell[1].triangles + 8]))
    with pytest.raises(cg.errors.InputError, match="no way outside"):
        cg.route(hollow, [0.0, 0.0, 0.0], [5.0, 0.0, 0.0])


def test_the_number_of_points_is_checked() -> None:
    with pytest.raises(cg.errors.InputError, match="whole number"):
        cg.route(BALL, *OVER_THE_BALL, points=3)


CHEST = cg.Body([cg.shapes.ellipsoid(axes=(1.15, 1.65, 2.1), centre=(0, 0, 1.5))], name="chest")
BELLY = cg.Body([cg.shapes.ellipsoid(axes=(1.2, 1.6, 1.4), centre=(0.1, 0, -0.6))], name="belly")
OVER_THE_TORSO = [-2.6, -1.7, 3.3], [-1.5, 2.3, -1.2], [[1.4, -0.4, 1.5], [1.5, 0.6, 0.0]]


def dense_length(bodies: list[cg.Body], points: np.ndarray, size: float) -> float:
    """Length of the shortest polyline outside bodies through grids in planes across `points`.

    Dynamic programming from plane to plane over grids of 7 × 7 nodes, which shrink about the
    best polyline, from `size` between their nodes on. Every segment is tried against the bodies.
    """
    obstacles, best = Obstacles(bodies), points.copy()
    steps = np.array([[a, b] for a in range(-3, 4) for b in range(-3, 4)])
    near = [np.flatnonzero(np.abs(steps - one).max(axis=1) <= 1) for one in steps]
    pairs = np.array([(i, j) for i, one in enumerate(near) for j in one])
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    u = np.cross(along, [0.3, -0.5, 0.8])
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(along, u)
    while size > 1e-4:
        nodes = best[:, None] + size * (steps @ np.stack([u, v], axis=1))
        nodes[0], nodes[-1] = points[0], points[-1]
        free = obstacles.clearances(nodes.reshape(-1, 3)).gap.reshape(nodes.shape[:2]) >= 0.0
        starts = nodes[:-1, pairs[:, 0]].reshape(-1, 3)
        ends = nodes[1:, pairs[:, 1]].reshape(-1, 3)
        cost = np.linalg.norm(ends - starts, axis=1)
        cost[obstacles.blocks(starts, ends, 0.0)] = np.inf
        cost = cost.reshape(len(nodes) - 1, len(pairs))
        way, total = [], np.zeros(len(steps))
        for k, row in enumerate(cost):
            table = np.full((len(steps), len(steps)), np.inf)
            table[pairs[:, 0], pairs[:, 1]] = row
            table += total[:, None]
            way.append(table.argmin(axis=0))
            total = np.where(free[k + 1], table.min(axis=0), np.inf)
        chosen = [int(total.argmin())]
        for back in way[::-1]:
            chosen.append(int(back[chosen[-1]]))
        chosen = chosen[::-1]
        best = nodes[np.arange(len(nodes)), chosen]
        if np.abs(steps[chosen[1:-1]]).max() < 3:
            size *= 0.6
    return float(total.min())


def test_the_length_is_that_of_a_dense_graph() -> None:
    """Two ellipsoids with a crease: none of this has a closed form."""
    path = cg.route([CHEST, BELLY], *OVER_THE_TORSO)
    arc = np.linspace(0.0, path.length, 161)
    # Off the path, so that the graph finds its own.
    start = path.outside(path.at(arc), 0.02)
    start[[0, -1]] = path.points[[0, -1]]
    assert abs(path.length / dense_length([CHEST, BELLY], start, 0.02) - 1.0) < 1e-4


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1e3])
def test_paths_are_the_same_at_any_size(size: float) -> None:
    for bodies, way in (([BALL], OVER_THE_BALL), ([box()], ([-3, 0, 0], [3, 0.2, 0], [[0, 0, 2]]))):
        one = cg.route(bodies, *way)
        ends = [size * np.asarray(points) for points in way]
        other = cg.route([body.scaled(size) for body in bodies], *ends)
        assert abs(other.length / (size * one.length) - 1.0) < 2e-5
        assert [wrap.body for wrap in other.wraps] == [wrap.body for wrap in one.wraps]


def test_a_string_in_a_crease_lies_on_the_body_that_it_came_along() -> None:
    other = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, 1.2))], name="other")
    path = cg.route([BALL, other], [-1.5, 2.0, 0.6], [-1.5, -2.0, 0.6], [[1.5, 0.0, 0.6]])
    (wrap,) = path.wraps
    assert wrap.angle > np.pi / 2
    crease = path.normal_at([0.5 * path.length])
    np.testing.assert_allclose(crease, [[1.0, 0.0, 0.0]], atol=1e-3)


@pytest.mark.full
@pytest.mark.parametrize("points", [100, 200])
def test_over_a_part_with_edges_and_holes(data_dir: Path, points: int) -> None:
    """Lengths are those of paths of 400 chords."""
    body = cg.read_cad(data_dir / "nist_ctc_02_asme1_ap242.stp")
    low, high = np.array(body.bounds())
    centre, size = 0.5 * (low + high), high - low
    via = [centre + np.array([0.0, 0.0, 320.0])]
    for start, end, exact in (
        ([-0.6, -0.6, 0.0], [0.6, 0.6, 0.2], 1394.478),
        ([-0.6, 0.6, -0.2], [0.6, -0.6, 0.1], 1436.148),
    ):
        path = cg.route(body, centre + start * size, centre + end * size, via, points=points)
        assert abs(path.length / exact - 1.0) < 2e-5
        assert body.project(path.points).gap.min() > -1e-6 * path.length
