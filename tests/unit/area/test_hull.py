"""Jarvis' march, the exact map, and HullArea."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.spatial import ConvexHull

import contiga as cg
from contiga.area.cluster import clusters_of
from contiga.area.hull import hull_of, unrolled
from contiga.area.polygon import area_over, closing, plane_area
from contiga.errors import InputError


@pytest.mark.interpreted
@pytest.mark.parametrize(
    ("points", "corners"),
    [
        ([], 0),
        ([[1, 2]], 1),
        ([[1, 2], [1, 2], [1, 2]], 1),
        ([[0, 0], [1, 1]], 2),
        ([[0, 0], [1, 1], [0.5, 0.5], [0.25, 0.25]], 2),
        ([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0], [0.5, 0.5], [1, 1]], 4),
    ],
)
def test_hull_of_few_or_degenerate_points(points, corners):
    hull = hull_of(np.array(points, dtype=float).reshape(-1, 2))
    assert len(hull) == corners
    assert plane_area(hull) == pytest.approx(1.0 if corners == 4 else 0.0)


def test_hull_is_that_of_qhull():
    rng = np.random.default_rng(1)
    for n in (5, 40, 300):
        points = rng.normal(size=(n, 2))
        own, other = hull_of(points), ConvexHull(points)
        assert plane_area(own) == pytest.approx(other.volume, rel=1e-13)
        assert len(own) == len(other.vertices)


@pytest.mark.interpreted
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_hull_of_a_grid_has_its_corners_only(turn):
    # Points on the sides, to rounding, and each point twice.
    grid = np.array([[x, y] for x in range(5) for y in range(4)] * 2, dtype=float)
    turned = grid @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    hull = hull_of(turned)
    assert plane_area(hull) == pytest.approx(12.0, rel=1e-14)
    assert len(hull) == 4 or turn > 0.0


def test_exact_map_of_a_skew_polygon_is_that_of_its_parts_by_quadpack():
    # z = (x² − y²)/4 over [−1, 1]², (u, v) the unit square: |S_u × S_v| = 4 √(1 + (x² + y²)/4).
    saddle = cg.shapes.saddle(width=2.0, length=2.0, height=0.25).insert_knots(u=[0.5], v=[0.3])
    polygon = np.array([[0.1, 0.1], [0.9, 0.3], [0.1, 0.8]])

    def jacobian(v, u):
        return 4.0 * np.sqrt(1.0 + 0.25 * ((2 * u - 1) ** 2 + (2 * v - 1) ** 2))

    exact = dblquad(
        jacobian,
        0.1,
        0.9,
        lambda u: 0.1 + 0.2 * (u - 0.1) / 0.8,
        lambda u: 0.8 - 0.5 * (u - 0.1) / 0.8,
        epsabs=1e-13,
        epsrel=1e-13,
    )[0]
    assert area_over(saddle, polygon, closing(saddle)) == pytest.approx(exact, rel=1e-10)


def test_exact_map_of_a_line_rounded_to_a_sliver_ends_at_nothing():
    ball = cg.shapes.sphere(radius=1.0)
    u = np.linspace(0.1, 0.9, 8)
    rng = np.random.default_rng(0)
    line = np.column_stack([u, 0.99 + 1e-13 * rng.normal(size=8)])
    assert 0.0 <= area_over(ball, hull_of(line), closing(ball)) < 1e-11


def test_exact_map_of_the_whole_domain_is_the_area():
    for surface in (
        cg.shapes.torus(major=2.0, minor=0.5),
        cg.shapes.saddle(width=2.0, length=1.0, height=0.4),
        cg.shapes.sphere(radius=3.0),
    ):
        (u0, u1), (v0, v1) = surface.domain
        square = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])
        assert area_over(surface, square, closing(surface)) == pytest.approx(
            surface.area(1e-13), rel=1e-10
        )


def test_exact_map_goes_on_over_a_seam():
    tube = cg.shapes.cylinder(radius=2.0, height=3.0)
    (u0, u1), _ = tube.domain
    band = np.array([[u0, 0.2], [u1, 0.2], [u1, 0.7], [u0, 0.7]])
    whole = area_over(tube, band, closing(tube))
    moved = area_over(tube, band + np.array([0.3 * (u1 - u0), 0.0]), closing(tube))
    assert whole == pytest.approx(2 * np.pi * 2.0 * 1.5, rel=1e-12)
    assert moved == pytest.approx(whole, rel=1e-12)


def test_feet_around_a_seam_are_unrolled():
    uv = np.array([[0.95, 0.5], [0.02, 0.5], [0.99, 0.1]])
    assert np.ptp(unrolled(uv, (1.0, 0.0))[:, 0]) == pytest.approx(0.07)
    assert np.array_equal(unrolled(uv, (0.0, 0.0)), uv)


def rows_of_points(gap):
    x = np.concatenate([np.arange(5.0), 4.0 + gap + np.arange(5.0)])
    return np.array([[a, b, 0.0] for a in x for b in range(8)])


@pytest.mark.parametrize("method", ["auto", "kmeans", "dbscan", "meanshift", "hdbscan"])
def test_every_method_parts_two_far_groups(method):
    label = clusters_of(rows_of_points(20.0), method, k=2, eps=1.5, min_points=3)
    assert label.max() == 1
    assert len(np.unique(label[:40])) == len(np.unique(label[40:])) == 1


def test_more_clusters_than_points_are_as_many_as_points():
    assert clusters_of(np.eye(3), "kmeans", k=7).tolist() == [0, 1, 2]
    assert clusters_of(np.zeros((4, 2)), "kmeans", k=3).tolist() == [0, 0, 0, 0]
    for method in ("auto", "kmeans", "dbscan", "meanshift", "hdbscan"):
        assert clusters_of(np.zeros((0, 2)), method).shape == (0,)
        assert clusters_of(np.zeros((1, 2)), method, min_points=1).tolist() == [0]


def test_dbscan_finds_fewer_clusters_the_wider_it_looks():
    points = rows_of_points(4.0)[:, :2]
    actual = [
        clusters_of(points, "dbscan", eps=eps, min_points=1).max() + 1 for eps in (0.5, 1.1, 4.5)
    ]
    assert actual == [80, 2, 1]


def test_hull_areas_add_up_and_noise_has_none():
    body = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])
    points = np.concatenate([rows_of_points(3.0) * 0.5, [[-8.0, -8.0, 0.0]]]) - [0, 0, 0.1]
    for mapping in ("linear", "exact"):
        area = cg.HullArea("dbscan", mapping=mapping, eps=0.05, min_points=3)
        contact = cg.Contact(
            body, cg.Slave(points), law=cg.PenaltyLaw(1), area=area, search="penetration"
        )
        state = contact.start(points)
        assert state.n_contact == 81
        assert state.n_clusters == 2
        assert state.clusters[-1] == -1
        assert state.area[-1] == 0.0
        assert state.total_area == pytest.approx(2 * 2.0 * 3.5, rel=1e-12)


def test_hulls_on_two_patches_are_added():
    halves = [cg.shapes.plane(width=2.0, length=4.0, centre=[x, 0, 0]) for x in (-1.0, 1.0)]
    x = np.linspace(-0.75, 0.75, 7) + 1e-3
    points = np.array([[a, b, -0.1] for a in x for b in x])
    contact = cg.Contact(
        cg.Body(halves),
        cg.Slave(points),
        law=cg.PenaltyLaw(1),
        area=cg.HullArea("auto", mapping="exact"),
        search="penetration",
    )
    state = contact.start(points)
    assert state.n_clusters == 1
    # Each patch misses half a spacing at the joint: 0.25 of the width of 1.5.
    assert state.total_area == pytest.approx(1.25 * 1.5)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"clusters": "spectral"}, "unknown method"),
        ({"clusters": 0}, "counted from 1"),
        ({"clusters": "kmeans", "k": 0}, "counted from 1"),
        ({"clusters": "dbscan", "eps": 0.0}, "must be positive"),
        ({"clusters": "dbscan", "eps": -1.0}, "must be positive"),
        ({"clusters": "dbscan", "min_points": 0}, "counted from 1"),
        ({"mapping": "cubic"}, "unknown mapping"),
        ({"tolerance": 0.0}, "must be positive"),
    ],
)
def test_options_that_cannot_be(options, says):
    with pytest.raises(InputError, match=says):
        cg.HullArea(**options)
